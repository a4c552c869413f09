//! Recordings of different sensors through the program: parts of turns, blind sectors, clouds, topics without a schema.

use std::f32::consts::TAU;
use std::io::Cursor;
use std::path::Path;

use crosscut_messages::{
    CDR_ENCODING, Cloud, Endian, Header, LaserEcho, LaserScan, Message, MultiEchoLaserScan, NumberType, Odometry,
    PointCloud2, PointField, Quaternion, TfMessage, Time, Transform, TransformStamped, Vector3,
};
use mcap::records::MessageHeader;

use crate::flight::{PERIOD_NS, file, tunnel_scan};
use crate::program::{column, results_of, run};

/// An MCAP of messages on one topic, `interval_ns` apart; an empty `type_name` stands for no schema.
fn recorded(type_name: &str, interval_ns: u64, messages: impl Iterator<Item = Vec<u8>>) -> Vec<u8> {
    recorded_topics([("/seen", type_name, interval_ns, messages.collect())])
}

/// An MCAP of messages on several topics, each with its type and interval, topic after topic.
fn recorded_topics<const N: usize>(topics: [(&str, &str, u64, Vec<Vec<u8>>); N]) -> Vec<u8> {
    let mut writer = mcap::WriteOptions::new().create(Cursor::new(Vec::new())).expect("memory");
    for (topic, name, interval_ns, messages) in topics {
        let schema = if name.is_empty() { 0 } else { writer.add_schema(name, "ros2msg", b"").expect("memory") };
        let channel_id = writer.add_channel(schema, topic, CDR_ENCODING, &Default::default()).expect("memory");
        for (i, data) in messages.into_iter().enumerate() {
            let time = PERIOD_NS + i as u64 * interval_ns;
            let header = MessageHeader { channel_id, sequence: i as u32, log_time: time, publish_time: time };
            writer.write_to_known_channel(&header, &data).expect("memory");
        }
    }
    writer.finish().expect("memory");
    writer.into_inner().into_inner()
}

fn shown(flight: &Path, options: &[&str]) -> String {
    let arguments = ["info".as_ref(), flight.as_os_str()].into_iter().chain(options.iter().map(AsRef::as_ref));
    run(arguments).expect_code(0).stdout
}

fn stamp(time_ns: u64) -> Header {
    Header { stamp: Time::from_ns(time_ns), frame_id: "lidar".into() }
}

/// The tunnel seen in twelve messages a turn.
fn parts() -> Vec<u8> {
    let part_ns = PERIOD_NS / 12;
    let part = |i: u64| {
        let whole = tunnel_scan(i / 12);
        let beams = (i % 12 * 15) as usize..(i % 12 * 15 + 15) as usize;
        let angle_min = whole.angle_min + beams.start as f32 * whole.angle_increment;
        let angle_max = angle_min + 14.0 * whole.angle_increment;
        let ranges = whole.ranges[beams].to_vec();
        LaserScan { header: stamp(PERIOD_NS + i * part_ns), angle_min, angle_max, ranges, ..whole }
    };
    recorded(LaserScan::SCHEMA_NAME, part_ns, (0..240).map(|i| part(i).encode(Endian::Little)))
}

/// A closed room, of which the driver leaves out a quarter of the turn as zeros.
fn quarter_left_out() -> Vec<u8> {
    let scan = |i: u64| {
        let mut scan = tunnel_scan(i);
        let bearing = |beam: usize| scan.angle_min + beam as f32 * scan.angle_increment;
        let room = |beam: usize| 3.0 / bearing(beam).sin().abs().max(bearing(beam).cos().abs());
        scan.ranges = (0..180).map(|beam| if beam < 45 { 0.0 } else { room(beam) }).collect();
        scan
    };
    recorded(LaserScan::SCHEMA_NAME, PERIOD_NS, (0..20).map(|i| scan(i).encode(Endian::Little)))
}

/// A tunnel 6 m wide, 3 m high, seen by a rotating lidar of 16 rings 1 m above the floor.
fn clouds() -> Vec<u8> {
    let mut data = Vec::new();
    for (ring, azimuth) in (0..16u16).flat_map(|ring| (0..360u16).map(move |azimuth| (ring, azimuth))) {
        let elevation = (f32::from(ring) * 2.0 - 15.0).to_radians();
        let (sin, cos) = (TAU * (f32::from(azimuth) + 0.5) / 360.0).sin_cos();
        let limit = if elevation < 0.0 { 1.0 } else { 2.0 };
        let level_m = (3.0 / sin.abs()).min(limit / elevation.tan().abs());
        let point =
            if level_m < 12.0 { [level_m * cos, level_m * sin, level_m * elevation.tan()] } else { [f32::NAN; 3] };
        data.extend(point.into_iter().flat_map(f32::to_le_bytes));
    }
    let field = |(name, offset): (&str, u32)| PointField::new(name, offset, NumberType::F32);
    let cloud = |i: u64| PointCloud2 {
        header: stamp(PERIOD_NS + i * PERIOD_NS),
        height: 16,
        width: 360,
        fields: [("x", 0), ("y", 4), ("z", 8)].into_iter().map(field).collect(),
        point_step: 12,
        row_step: 12 * 360,
        data: data.as_slice().into(),
        ..PointCloud2::default()
    };
    recorded(PointCloud2::SCHEMA_NAME, PERIOD_NS, (0..5).map(|i| cloud(i).encode(Endian::Little)))
}

#[test]
fn info_shows_a_whole_turn_of_segmented_scans() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "parts.mcap", &parts());
    let shown = shown(&flight, &[]);
    assert!(shown.contains("180 beams") && shown.contains("all the way round"), "{shown}");
    assert!(shown.contains("a revolution joined of 12 messages"), "{shown}");
    let (ran, lines) = results_of(&flight, &["--quiet"]);
    ran.expect_code(0);
    assert_eq!(column(&lines, "junctions"), [2; 20]);
}

#[test]
fn info_names_the_setting_that_masks_a_blind_sector() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "quarter.mcap", &quarter_left_out());
    let seen = shown(&flight, &[]);
    let masks = "ingest.masked_sectors_rad = [[3.141, -1.571]]";
    assert!(seen.contains("45 beams never returned") && seen.contains(masks), "{seen}");
    let named = "ingest.masked_sectors_rad=[[3.141, -1.571]]";
    assert!(
        shown(&flight, &["--set", named]).contains("45 beams in masked sectors"),
        "{}",
        shown(&flight, &["--set", named])
    );
    assert!(!shown(&flight, &["--set", "ingest.find_blind_sectors=false"]).contains("never returned"));
    let (ran, lines) = results_of(&flight, &["--quiet"]);
    ran.expect_code(0);
    assert!(lines.iter().all(|line| line["openings"] == serde_json::json!([])), "{:?}", lines[0]["openings"]);
}

#[test]
fn info_says_how_a_topic_without_a_schema_is_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scans = (0..5).map(|i| tunnel_scan(i).encode(Endian::Little));
    let flight = file(folder.path(), "bare.mcap", &recorded("", PERIOD_NS, scans));
    assert!(shown(&flight, &[]).ends_with("no schema states the type of /seen; for laser scans add: --as LaserScan\n"));
    let told = shown(&flight, &["--as", "LaserScan"]);
    assert!(told.contains("next: crosscut run") && told.ends_with("LaserScan\n"), "{told}");
    let (ran, lines) = results_of(&flight, &["--quiet", "--as", "LaserScan"]);
    ran.expect_code(0);
    assert_eq!(lines.len(), 5);
    let out = folder.path().join("converted.mcap");
    let convert = ["convert".as_ref(), flight.as_os_str(), "--out".as_ref(), out.as_os_str()];
    run(convert.into_iter().chain(["--as".as_ref(), "LaserScan".as_ref()])).expect_code(0);
    assert_eq!(results_of(&out, &["--quiet"]).1, lines);
}

#[test]
fn the_echo_that_is_asked_for_is_converted() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let echoes = |i: u64| {
        let geometry = tunnel_scan(i);
        let beam = |near: &f32| LaserEcho { echoes: vec![*near, near + 1.0] };
        let ranges = geometry.ranges.iter().map(beam).collect();
        MultiEchoLaserScan { geometry: LaserScan { ranges: Vec::new(), ..geometry }, ranges, intensities: Vec::new() }
    };
    let messages = (0..3).map(|i| echoes(i).encode(Endian::Little));
    let flight = file(folder.path(), "echoes.mcap", &recorded(MultiEchoLaserScan::SCHEMA_NAME, PERIOD_NS, messages));
    let out = folder.path().join("converted.mcap");
    let convert = |more: &[&str]| {
        let fixed = ["convert".as_ref(), flight.as_os_str(), "--out".as_ref(), out.as_os_str()];
        run(fixed.into_iter().chain(more.iter().map(AsRef::as_ref)))
    };
    let last = ["--set", "ingest.echo=last"];
    convert(&last).expect_code(0);
    assert_eq!(results_of(&out, &[]).1, results_of(&flight, &last).1);
    for without_effect in [["--set", "ingest.yaw_rad=1"], ["--preset", "paper"]] {
        convert(&without_effect).expect_code(2);
    }
}

#[test]
fn each_cloud_of_a_rotating_lidar_is_a_revolution() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "clouds.mcap", &clouds());
    assert!(shown(&flight, &[]).contains("next: crosscut run"));
    let (ran, lines) = results_of(&flight, &["--quiet"]);
    ran.expect_code(0);
    assert_eq!(column(&lines, "seq"), [0, 1, 2, 3, 4]);
    assert_eq!(column(&lines, "junctions"), [2; 5]);
}

#[test]
fn the_ways_of_a_cloud_stand_in_the_results_where_they_are_asked_for() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "clouds.mcap", &clouds());
    let (ran, lines) = results_of(&flight, &["--quiet", "--preset", "3d"]);
    ran.expect_code(0);
    assert_eq!((column(&lines, "ways_flyer"), column(&lines, "ways_ground")), (vec![2; 5], vec![2; 5]));
    assert_eq!((column(&lines, "k"), column(&lines, "junctions")), (vec![2; 5], vec![2; 5]));
    for line in &lines {
        let ways = line["ways"].as_array().expect("a list");
        assert!(ways.iter().all(|way| way["kind"] == "level" && way["cut_by_view"] == true), "{ways:?}");
        assert_eq!(line["openings"].as_array().map(Vec::len), Some(2), "level ways are openings");
        let [low_rad, high_rad] = [0, 1].map(|at| line["ways_view_rad"][at].as_f64().expect("a number"));
        assert!(low_rad > -0.5 && high_rad < 0.5, "the lidar sees no shaft, and says so: {low_rad} to {high_rad}");
    }
    assert!(results_of(&flight, &["--quiet"]).1.iter().all(|line| line.get("ways").is_none()));
    let path = flight.display().to_string();
    let summary = run(["run", &path, "--preset", "3d"]).stdout;
    assert!(summary.contains("cut by view") && summary.matches("  level  ").count() == 2, "{summary}");
    // Beside presets that do not take clouds.
    let confidence = |with: &[&str]| {
        let with = with.iter().flat_map(|with| ["--with", with]);
        let csv = run(["compare", &path, "--csv", "-"].into_iter().chain(with)).stdout;
        let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
        let column = rows[0].iter().position(|name| *name == "mean_confidence").expect("a column");
        rows.last().expect("a row")[column].to_owned()
    };
    assert_eq!(confidence(&["default", "3d"]), confidence(&["paper", "3d"]));
}

/// A level gallery along x, from which a ramp leads up to the left, seen all around by a lidar that is turned so in the gallery.
fn at_a_ramp(turned_back: impl Fn(Vector3) -> Vector3) -> Cloud {
    let (rise, run) = RAMP_RAD.sin_cos();
    let is_inside = |[x, y, z]: [f64; 3]| {
        let (along, over) = (y * run + z * rise, z * run - y * rise);
        y.abs() < 2.0 && z.abs() < 1.5 || along > 0.0 && x.abs() < 1.6 && over.abs() < 1.4
    };
    let point = |at: usize| {
        let (up, out) =
            (((at / 256) as f64 + 0.5) / 128.0 * std::f64::consts::PI - 0.5 * std::f64::consts::PI).sin_cos();
        let (sin, cos) = (f64::from(TAU) * (at % 256) as f64 / 256.0).sin_cos();
        let at_m = |range_m: f64| [out * cos * range_m, out * sin * range_m, up * range_m];
        let [x, y, z] = at_m((1..800).map(|step| 0.05 * f64::from(step)).find(|range_m| !is_inside(at_m(*range_m)))?);
        let Vector3 { x, y, z } = turned_back(Vector3 { x, y, z });
        Some([x, y, z])
    };
    Cloud { header: stamp(PERIOD_NS), points_m: (0..128 * 256).filter_map(point).collect(), ..Cloud::default() }
}

const RAMP_RAD: f64 = 0.45;

/// 1.1 rad to the left, nose down, and to the side.
const OF_VEHICLE: Quaternion = Quaternion { x: -0.16, y: 0.1, z: 0.51, w: 0.84 };
/// 22° nose down, as lidars are mounted that look at the floor.
const OF_MOUNT: Quaternion = Quaternion { x: 0.0, y: 0.19, z: 0.0, w: 0.98 };
/// The turn by the mount, then that by the vehicle.
const OF_LIDAR: Quaternion = Quaternion { x: -0.2537, y: 0.2576, z: 0.4694, w: 0.8042 };

#[test]
fn a_cloud_of_a_tilted_lidar_on_a_tilted_vehicle_has_level_ways_and_ramps_as_they_are() {
    let inverse = |of: Quaternion| Quaternion { w: -of.w, ..of };
    let cloud = at_a_ramp(|point_m| inverse(OF_MOUNT).turn(inverse(OF_VEHICLE).turn(point_m)));
    let points = vec![PointCloud2::from(&cloud).encode(Endian::Little)];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let noted = |of_frame: &str, orientation: Quaternion| {
        let mut odometry =
            Odometry { child_frame_id: of_frame.into(), header: stamp(PERIOD_NS), ..Odometry::default() };
        odometry.pose.pose.orientation = orientation;
        let header = Header { frame_id: "base_link".into(), ..Header::default() };
        let transform = Transform { rotation: OF_MOUNT, ..Transform::default() };
        let transforms = vec![TransformStamped { header, child_frame_id: "lidar".into(), transform }];
        let topics = [
            ("/tf_static", TfMessage::SCHEMA_NAME, 1, vec![TfMessage { transforms }.encode(Endian::Little)]),
            ("/odom", Odometry::SCHEMA_NAME, 1, vec![odometry.encode(Endian::Little)]),
            ("/points", PointCloud2::SCHEMA_NAME, 1, points.clone()),
        ];
        let flight = file(folder.path(), "tilted.mcap", &recorded_topics(topics));
        let (ran, mut lines) = results_of(&flight, &["--quiet", "--preset", "3d"]);
        ran.expect_code(0);
        lines.swap_remove(0)
    };
    for (of_frame, orientation) in [("base_link", OF_VEHICLE), ("lidar", OF_LIDAR)] {
        let line = noted(of_frame, orientation);
        let notes = line["notes"].to_string();
        assert!(notes.contains("vehicle is tilted by"), "{notes}");
        assert_eq!(notes.contains("sensor is tilted by 21.9°"), of_frame == "base_link", "{notes}");
        // Clockwise from the heading of the frame.
        let heading_rad = orientation.yaw_rad();
        let quarter_rad = std::f64::consts::FRAC_PI_2;
        let mut wanted =
            vec![("level", 0.0, 0.0), ("ramp_up", quarter_rad, RAMP_RAD), ("level", 2.0 * quarter_rad, 0.0)];
        for way in line["ways"].as_array().expect("ways") {
            let [bearing_rad, elevation_rad] =
                ["bearing_rad", "elevation_rad"].map(|name| way[name].as_f64().expect("rad"));
            let fits = |(kind, towards_rad, up_rad): &(&str, f64, f64)| {
                let off_rad = (bearing_rad + heading_rad - towards_rad).rem_euclid(f64::from(TAU));
                let off_rad = off_rad.min(f64::from(TAU) - off_rad);
                way["kind"] == *kind && off_rad < MOST_OFF_RAD && (elevation_rad - up_rad).abs() < MOST_OFF_RAD
            };
            let at = wanted.iter().position(fits).unwrap_or_else(|| panic!("{way} is none of {wanted:?}"));
            wanted.remove(at);
        }
        assert!(wanted.is_empty(), "{wanted:?} are not found");
    }
    let of_zeros = noted("base_link", Quaternion { w: 0.0, ..Quaternion::default() });
    assert!(of_zeros["notes"].to_string().contains("taken to be level"), "{}", of_zeros["notes"]);
    let flight =
        file(folder.path(), "alone.mcap", &recorded_topics([("/points", PointCloud2::SCHEMA_NAME, 1, points)]));
    let (_, lines) = results_of(&flight, &["--quiet", "--preset", "3d"]);
    assert!(lines[0]["notes"].to_string().contains("taken to be level"), "{}", lines[0]["notes"]);
}

/// Cells of directions are 4.5° wide.
const MOST_OFF_RAD: f64 = 0.09;

#[test]
fn info_finds_a_frame_that_begins_late() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scan = |i: u64| {
        let mut scan = tunnel_scan(i);
        scan.header.frame_id = if i < 150 { "front".into() } else { "rear".into() };
        scan.encode(Endian::Little)
    };
    let flight = file(folder.path(), "late.mcap", &recorded(LaserScan::SCHEMA_NAME, PERIOD_NS, (0..160).map(scan)));
    assert!(shown(&flight, &["--set", "ingest.frame_id=rear"]).contains("frame \"rear\""));
}
