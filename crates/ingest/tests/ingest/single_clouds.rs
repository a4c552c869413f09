//! Files with one point cloud, in every encoding, whole and damaged.

use std::collections::BTreeMap;
use std::io::Cursor;

use crosscut_ingest::{LossKind, ReadOptions, Recording, convert};
use crosscut_messages::{Fields, PointCloud2};
use crosscut_stage::{Notes, Revolution, Source as _};

use crate::flight::{Folder, open};

const POINTS: usize = 6;

/// x, y and z of a point.
fn point(i: usize) -> [f32; 3] {
    [1.5 + i as f32, -2.25 * i as f32, 0.125]
}

fn pcd_head(encoding: &str) -> String {
    format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS intensity x y z ring stamp\nSIZE 1 4 4 8 2 8\n\
         TYPE U F F F U U\nCOUNT 2 1 1 1 1 1\nWIDTH {POINTS}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {POINTS}\n\
         DATA {encoding}\n"
    )
}

/// The fields of a point as the head of a PCD declares them.
fn pcd_fields(i: usize) -> [Vec<u8>; 6] {
    let [x, y, z] = point(i);
    let ring = (i % 3) as u16;
    [
        vec![7, 8],
        x.to_le_bytes().to_vec(),
        y.to_le_bytes().to_vec(),
        f64::from(z).to_le_bytes().to_vec(),
        ring.to_le_bytes().to_vec(),
        vec![9; 8],
    ]
}

fn pcd(encoding: &str) -> Vec<u8> {
    let mut bytes = pcd_head(encoding).into_bytes();
    match encoding {
        "ascii" => {
            for i in 0..POINTS {
                let [x, y, z] = point(i);
                bytes.extend(format!("7 8 {x} {y} {z} {} 1700000000000000000\n", i % 3).bytes());
            }
        }
        "binary" => bytes.extend((0..POINTS).flat_map(pcd_fields).flatten()),
        _ => {
            let plain: Vec<u8> =
                (0..6).flat_map(|field| (0..POINTS).flat_map(move |i| pcd_fields(i)[field].clone())).collect();
            // Runs of up to 32 bytes, none of them copied.
            let packed: Vec<u8> = plain.chunks(32).flat_map(|run| [&[run.len() as u8 - 1], run].concat()).collect();
            bytes.extend([packed.len() as u32, plain.len() as u32].into_iter().flat_map(u32::to_le_bytes));
            bytes.extend(packed);
        }
    }
    bytes
}

/// Faces with lists stand before the points.
fn ply(encoding: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\ncomment made here\nelement face 2\nproperty uchar colour\n\
         property list uchar int vertex_indices\nproperty short flags\nelement vertex {POINTS}\nproperty double x\n\
         property float y\nproperty uchar red\nproperty float z\nend_header\n"
    )
    .into_bytes();
    if encoding == "ascii" {
        bytes.extend(b"1 3 0 1 2 5\n2 0 6\n");
        for i in 0..POINTS {
            let [x, y, z] = point(i);
            bytes.extend(format!("{x} {y} 255 {z}\n").bytes());
        }
        return bytes;
    }
    let is_big = encoding == "binary_big_endian";
    let mut put = |mut little: Vec<u8>| {
        if is_big {
            little.reverse();
        }
        bytes.extend(little);
    };
    for entries in [3, 0] {
        put(vec![1]);
        put(vec![entries]);
        (0..entries).for_each(|entry| put(i32::from(entry).to_le_bytes().to_vec()));
        put(vec![5, 0]);
    }
    for i in 0..POINTS {
        let [x, y, z] = point(i);
        put(f64::from(x).to_le_bytes().to_vec());
        put(y.to_le_bytes().to_vec());
        put(vec![255]);
        put(z.to_le_bytes().to_vec());
    }
    bytes
}

fn all() -> Vec<(String, Vec<u8>)> {
    let pcds = ["ascii", "binary", "binary_compressed"].map(|encoding| (format!("{encoding}.pcd"), pcd(encoding)));
    let plys = ["ascii", "binary_little_endian", "binary_big_endian"]
        .map(|encoding| (format!("{encoding}.ply"), ply(encoding)));
    pcds.into_iter().chain(plys).collect()
}

/// The points of each revolution.
fn points_in(recording: &mut Recording) -> Vec<Vec<[f32; 3]>> {
    let (mut revolution, mut revolutions) = (Revolution::default(), Vec::new());
    while recording.next(&mut revolution, &mut Notes::default()).expect("the source goes on") {
        let points = revolution.points_m.iter().map(|point| [point.x as f32, point.y as f32, point.z as f32]);
        revolutions.push(points.collect());
    }
    revolutions
}

#[test]
fn every_encoding_of_a_cloud_gives_the_same_points() {
    let folder = Folder::new();
    let expected: Vec<_> = (0..POINTS).map(point).collect();
    for (name, bytes) in all() {
        let mut recording = open(&folder.add(&name, &bytes)).expect(&name);
        assert_eq!(points_in(&mut recording), std::slice::from_ref(&expected), "{name}");
        assert_eq!(recording.losses(), [], "{name}");
    }
}

#[test]
fn a_converted_cloud_keeps_points_and_their_other_fields() {
    let folder = Folder::new();
    let expected: Vec<_> = (0..POINTS).map(point).collect();
    for (name, bytes) in all() {
        let mut mcap = Cursor::new(Vec::new());
        let converted = convert(&[folder.add(&name, &bytes)], &ReadOptions::default(), &mut mcap).expect(&name);
        assert_eq!(converted.messages, BTreeMap::from([("/points".to_owned(), 1)]), "{name}");
        let mcap = mcap.into_inner();
        let message = mcap::MessageStream::new(&mcap).expect("an MCAP").next().expect("a message").expect("whole");
        let cloud = PointCloud2::read(&mut Fields::cdr(&message.data).expect("CDR")).expect("a cloud");
        let other = if name.ends_with("pcd") { "intensity" } else { "red" };
        assert!(cloud.fields.iter().any(|field| field.name == other), "{name}: {:?}", cloud.fields);
        let read = points_in(&mut open(&folder.add("f.mcap", &mcap)).expect("clouds"));
        assert_eq!(read, std::slice::from_ref(&expected), "{name}");
    }
}

#[test]
fn a_cloud_cut_at_any_byte_keeps_its_whole_points() {
    let folder = Folder::new();
    for (name, bytes) in all() {
        let mut most = 0;
        for cut in 0..bytes.len() {
            let Ok(mut recording) = open(&folder.add("cut", &bytes[..cut])) else { continue };
            let revolutions = points_in(&mut recording);
            let [points] = &revolutions[..] else { panic!("{name} cut at {cut}: {revolutions:?}") };
            assert!(points.len() >= most, "{name} cut at {cut}: fewer points than in a shorter file");
            most = points.len();
            // The last number of the last line may be cut short, which is reported.
            let [loss] = recording.losses() else { panic!("{name} cut at {cut}: {:?}", recording.losses()) };
            let sure = if matches!(loss.kind, LossKind::LastLine { .. }) { POINTS - 1 } else { points.len() };
            assert!(
                points[..sure].iter().zip(0..).all(|(found, i)| *found == point(i)),
                "{name} cut at {cut}: {points:?}"
            );
        }
        let needs_all = name.starts_with("binary_compressed");
        assert_eq!(
            most,
            if needs_all {
                0
            } else if name.starts_with("ascii") {
                POINTS
            } else {
                POINTS - 1
            },
            "{name}"
        );
    }
}

#[test]
fn altered_bytes_of_a_cloud_never_panic() {
    let folder = Folder::new();
    for (name, bytes) in all() {
        for at in 0..bytes.len() {
            for value in [bytes[at] ^ 1, b'9', 0xff] {
                let mut altered = bytes.clone();
                altered[at] = value;
                if let Ok(mut recording) = open(&folder.add("altered", &altered)) {
                    let mut revolution = Revolution::default();
                    while recording.next(&mut revolution, &mut Notes::default()).unwrap_or(false) {
                        assert!(revolution.len() <= bytes.len(), "{name} byte {at}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_folder_of_clouds_is_a_flight_in_the_order_of_their_names() {
    let folder = Folder::new();
    for number in [10, 9] {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n{number} 0\n"
        );
        folder.add(&format!("cloud_{number}.ply"), text.as_bytes());
    }
    let mut recording = open(folder.path()).expect("a flight");
    assert_eq!(points_in(&mut recording), [[[9.0, 0.0, 0.0]], [[10.0, 0.0, 0.0]]]);
}
