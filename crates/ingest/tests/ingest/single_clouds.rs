//! Files with one point cloud, in every encoding, whole and damaged.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::PathBuf;

use crosscut_ingest::{Loss, LossKind, ReadOptions, convert};
use crosscut_messages::{Echo, Fields, PointCloud2, ScanDecoder, ScanMessage};
use crosscut_stage::{Notes, Revolution, Source as _};

use crate::cloud_files::{POINTS, all, point};
use crate::flight::{Folder, open};

/// The points of each cloud, converted; none if nothing can be read.
fn points_in(path: PathBuf) -> Vec<Vec<[f32; 3]>> {
    let mut mcap = Cursor::new(Vec::new());
    if convert(&[path], &ReadOptions::default(), Echo::First, &mut mcap, || ()).is_err() {
        return Vec::new();
    }
    points_of(&mcap.into_inner())
}

fn points_of(mcap: &[u8]) -> Vec<Vec<[f32; 3]>> {
    let decoder = ScanDecoder::for_schema(PointCloud2::SCHEMA_NAME, "", "cdr").expect("clouds");
    let messages = mcap::MessageStream::new(mcap).expect("an MCAP").map(|message| message.expect("whole"));
    let points = |message: mcap::Message<'_>| {
        let mut decoded = ScanMessage::default();
        decoder.decode_into(&message.data, &mut decoded).expect("a cloud");
        let ScanMessage::Cloud(cloud) = decoded else { panic!("no cloud: {decoded:?}") };
        cloud.points_m.iter().map(|point| point.map(|x| x as f32)).collect()
    };
    messages.map(points).collect()
}

/// What is lost of a recording.
fn losses_of(path: PathBuf) -> Vec<Loss> {
    let mut recording = open(&path).expect("clouds");
    while recording.next(&mut Revolution::default(), &mut Notes::default()).expect("the source goes on") {}
    recording.losses().to_vec()
}

#[test]
fn every_encoding_of_a_cloud_gives_the_same_points() {
    let folder = Folder::new();
    let expected: Vec<_> = (0..POINTS).map(point).collect();
    for (name, bytes) in all() {
        let path = folder.add(&name, &bytes);
        assert_eq!(losses_of(path.clone()), [], "{name}");
        assert_eq!(points_in(path), std::slice::from_ref(&expected), "{name}");
    }
}

#[test]
fn a_converted_cloud_keeps_points_and_their_other_fields() {
    let folder = Folder::new();
    let expected: Vec<_> = (0..POINTS).map(point).collect();
    for (name, bytes) in all() {
        let mut mcap = Cursor::new(Vec::new());
        let converted =
            convert(&[folder.add(&name, &bytes)], &ReadOptions::default(), Echo::First, &mut mcap, || ()).expect(&name);
        assert_eq!(converted.messages, BTreeMap::from([("/points".to_owned(), 1)]), "{name}");
        let mcap = mcap.into_inner();
        let message = mcap::MessageStream::new(&mcap).expect("an MCAP").next().expect("a message").expect("whole");
        let cloud = PointCloud2::read(&mut Fields::cdr(&message.data).expect("CDR")).expect("a cloud");
        let other = if name.ends_with("pcd") { "intensity" } else { "red" };
        assert!(cloud.fields.iter().any(|field| field.name == other), "{name}: {:?}", cloud.fields);
        assert_eq!(points_of(&mcap), std::slice::from_ref(&expected), "{name}");
    }
}

#[test]
fn a_cloud_cut_at_any_byte_keeps_its_whole_points() {
    let folder = Folder::new();
    for (name, bytes) in all() {
        let mut most = 0;
        for cut in 0..bytes.len() {
            let path = folder.add("cut", &bytes[..cut]);
            if open(&path).is_err() {
                continue;
            }
            let losses = losses_of(path.clone());
            let clouds = points_in(path);
            let [points] = &clouds[..] else { panic!("{name} cut at {cut}: {clouds:?}") };
            assert!(points.len() >= most, "{name} cut at {cut}: fewer points than in a shorter file");
            most = points.len();
            // The last number of the last line may be cut short, which is reported.
            let [loss] = &losses[..] else { panic!("{name} cut at {cut}: {losses:?}") };
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
    assert_eq!(points_in(folder.path().to_owned()), [[[9.0, 0.0, 0.0]], [[10.0, 0.0, 0.0]]]);
}

#[test]
fn the_time_in_the_name_of_a_file_is_the_stamp_of_its_cloud() {
    let folder = Folder::new();
    let (_, bytes) = all().into_iter().next().expect("a cloud");
    folder.add("1700000000.250.pcd", &bytes);
    folder.add("1700000000.350.pcd", &bytes);
    let mut recording = open(folder.path()).expect("a flight");
    let (mut revolution, mut stamps_ns) = (Revolution::default(), Vec::new());
    while recording.next(&mut revolution, &mut Notes::default()).expect("the source goes on") {
        stamps_ns.push(revolution.stamp_ns);
    }
    assert_eq!(stamps_ns, [1_700_000_000_250_000_000, 1_700_000_000_350_000_000]);
}
