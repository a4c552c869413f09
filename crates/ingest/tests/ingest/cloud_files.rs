//! Files with one point cloud, PCD and PLY, in every encoding.

/// How many points each file has.
pub(crate) const POINTS: usize = 6;

/// x, y and z of a point.
pub(crate) fn point(i: usize) -> [f32; 3] {
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

/// A PCD with the points as `ascii`, `binary` or `binary_compressed`.
pub(crate) fn pcd(encoding: &str) -> Vec<u8> {
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
pub(crate) fn ply(encoding: &str) -> Vec<u8> {
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

/// A file in every encoding, by name.
pub(crate) fn all() -> Vec<(String, Vec<u8>)> {
    let pcds = ["ascii", "binary", "binary_compressed"].map(|encoding| (format!("{encoding}.pcd"), pcd(encoding)));
    let plys = ["ascii", "binary_little_endian", "binary_big_endian"]
        .map(|encoding| (format!("{encoding}.ply"), ply(encoding)));
    pcds.into_iter().chain(plys).collect()
}
