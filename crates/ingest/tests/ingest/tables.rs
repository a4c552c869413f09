//! What the columns of a table are taken for.

use crosscut_ingest::{CSV_PARAMS, CsvGeometry, Found, IngestError, ReadOptions, Recording, describe};
use crosscut_stage::{Notes, Params, Revolution, Source as _, Value};
use nalgebra::Isometry2;

use crate::flight::{Folder, Read, drain, sensor};

const EPOCH: usize = 1_700_000_000;
const FIRST: [f32; 3] = [1.5, 2.5, 3.5];

/// Settings of a table; `columns` names its columns.
fn options(columns: &str) -> ReadOptions {
    let mut params = Params::defaults(CSV_PARAMS);
    for (name, value) in [("last_rad", 0.7), ("range_max_m", 50.0), ("rate_hz", 4.0)] {
        params.set(name, Value::Float(value)).expect("allowed");
    }
    params.set("columns", Value::String(columns.to_owned())).expect("allowed");
    ReadOptions { csv: CsvGeometry::new(&params), ..ReadOptions::default() }
}

fn opened(text: &str, options: &ReadOptions) -> Result<Read, IngestError> {
    let folder = Folder::new();
    let path = folder.add("table.csv", text.as_bytes());
    Ok(drain(&mut Recording::open(&[path], options, sensor(&[]))?))
}

fn scans_of(text: &str, columns: &str) -> Read {
    opened(text, &options(columns)).unwrap_or_else(|error| panic!("{error}: {text}"))
}

fn scans(text: &str) -> Read {
    scans_of(text, "")
}

fn ranges(read: &Read, row: usize) -> Vec<f32> {
    read.ranges[row].iter().map(|bits| f32::from_bits(*bits)).collect()
}

fn found(text: &str) -> Found {
    match opened(text, &options("")) {
        Err(IngestError::NotRecording { found, .. }) => found,
        other => panic!("{other:?}: {text}"),
    }
}

/// This many cells, each made of its number.
fn cells(count: usize, separator: &str, cell: impl Fn(usize) -> String) -> String {
    (0..count).map(cell).collect::<Vec<_>>().join(separator)
}

fn row(count: usize, separator: &str) -> String {
    cells(count, separator, |i| format!("{}.5", i % 3 + 1))
}

#[test]
fn rows_of_bare_ranges_are_a_scan_each() {
    let read = scans("1.5,nan,inf,1,2,1,2,1\n\n2,,4,1,2,1,2,1\n");
    assert_eq!((read.len(), read.stamps_ns[0]), (2, 250_000_000));
    assert_eq!((ranges(&read, 0)[0], ranges(&read, 1)[2]), (1.5, 4.0));
    assert!(ranges(&read, 0)[1].is_nan() && ranges(&read, 1)[1].is_nan(), "an empty cell is no measurement");
}

#[test]
fn a_header_tells_times_and_ranges_from_other_columns() {
    let read = scans("seq,stamp_ns,r0,r1,label\n7,1700000000000000001,1,2,3\n");
    assert_eq!((read.stamps_ns[0], ranges(&read, 0)), (1_700_000_000_000_000_001, vec![1.0, 2.0]), "to the nanosecond");
    let counted = format!("{}\n{}\n", cells(9, ",", |i| i.to_string()), row(9, ","));
    assert_eq!(scans(&counted).len(), 1, "numbers of columns are no row");
    let unordered = "r1,r10,r2,q1,q2,q10,angle1,angle2,angle10\n1,10,2,0,0,0,0,0,0\n";
    assert_eq!(ranges(&scans(unordered), 0), [1.0, 2.0, 10.0]);
    for (name, second) in
        [("/scan/ranges[{}]", 2.5), ("Range {} (mm)", 0.0025), ("dist_cm_{}", 0.025), ("beam{}_m", 2.5)]
    {
        let names = cells(4, ";", |i| name.replace("{}", &i.to_string()));
        let read = scans(&format!("Time (s);speed (m/s);{names}\n5;1;{}\n", row(4, ";")));
        assert_eq!((read.stamps_ns[0], ranges(&read, 0)[1]), (5_000_000_000, second), "{name}");
    }
}

#[test]
fn every_separator_is_read_with_a_header_and_without() {
    for (separator, decimal) in [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), (" ", "."), (" ", ",")] {
        let row = row(9, separator).replace('.', decimal);
        let names = cells(9, separator, |i| format!("r{i}"));
        for text in
            [format!("{row}\n{row}\n"), format!("{names}\n{row}\n{row}\n"), format!("# {names}\n{row}\n{row}\n")]
        {
            let read = scans(&text);
            assert_eq!((read.len(), &ranges(&read, 0)[..3]), (2, &FIRST[..]), "{text}");
        }
    }
}

#[test]
fn a_first_column_of_times_or_of_row_numbers_is_no_beam() {
    let rows = |first: &dyn Fn(usize) -> String| -> String {
        (0..9)
            .map(|i| format!("{},{}\n", first(i), cells(8, ",", |j| ["inf", "1e30", "2", "3"][(i * j) % 4].to_owned())))
            .collect()
    };
    for (text, last_ns) in [
        (rows(&|i| i.to_string()), 2_250_000_000),
        (rows(&|i| (EPOCH + i / 5).to_string()), 1_700_000_001_000_000_000),
        (rows(&|i| format!("{}.5", EPOCH - i)), 1_699_999_992_500_000_000),
        (rows(&|i| format!("{},{}00000000", EPOCH, i + 1)), 1_700_000_000_900_000_000),
        (rows(&|i| format!("{:.1}", i as f64 * 0.5)), 4_000_000_000),
    ] {
        let read = scans(&text);
        assert_eq!((read.ranges[8].len(), read.stamps_ns[8]), (8, last_ns), "{text}");
    }
    let leaving = scans(&rows(&|i| format!("{}.5", i + 1)));
    assert_eq!(leaving.ranges[0].len(), 9, "a wall that is left behind is a beam");
    let sentinel = scans(&rows(&|_| "4294967295,4294967295,4294967295".to_owned()));
    assert_eq!(sentinel.ranges[0].len(), 11, "how some write that there is no return");
}

#[test]
fn settings_name_the_columns_of_any_table() {
    let rows = format!("a wall,5.5,{},8\nnone,6.5,{},8\n", row(4, ","), row(4, ","));
    for text in [rows.clone(), format!("label,when,a,b,c,d,n\n{rows}")] {
        let read = scans_of(&text, "label, stamp_s, r*_cm, n");
        assert_eq!((read.stamps_ns[1], ranges(&read, 1)), (6_500_000_000, vec![0.015, 0.025, 0.035, 0.015]), "{text}");
    }
    let unknown = found("time,speed,yaw\n1,2,3\n");
    assert_eq!(unknown, Found::OtherTable("`time`, `speed`, `yaw`".to_owned()));
    assert!(unknown.to_string().contains("--set csv.columns=time,r*"), "{unknown}");
}

#[test]
fn names_in_degrees_are_bearings() {
    for (names, rows, turned_rad) in [
        (format!("time,{}", cells(9, ",", |i| format!("{}", i as f64 * 0.5 - 2.0))), format!("5,{}", row(9, ",")), 4.0),
        (cells(9, ",", |i| format!("{}", i * 10)), row(9, ","), 80f64.to_radians()),
    ] {
        let folder = Folder::new();
        let path = folder.add("table.csv", format!("{names}\n{rows}\n").as_bytes());
        let description = describe(&path, &sensor(&[]), &ReadOptions::default()).expect("a table");
        let scan = description.topics[0].first_scan.as_ref().expect("a scan");
        assert!(scan.beams == 9 && (scan.field_of_view_rad - turned_rad).abs() < 1e-6, "{scan:?}");
    }
}

/// As `rostopic echo -p` writes it, with another number of ranges in the last rows.
#[test]
fn rows_of_rostopic_state_their_stamps_and_geometry() {
    let fixed = "field.header.seq,field.header.stamp,field.header.frame_id,field.angle_min,field.angle_max,\
                 field.angle_increment,field.time_increment,field.scan_time,field.range_min,field.range_max";
    let names = format!(
        "%time,{fixed},{},{}",
        cells(9, ",", |i| format!("field.ranges{i}")),
        cells(9, ",", |i| format!("field.intensities{i}"))
    );
    let row = |count| {
        let fixed = "3500000000,7,2500000000,laser,-0.4,0.4,0.1,0.0,0.2,0.1,30.0";
        format!("{fixed},{},{}", row(count, ","), cells(count, ",", |_| "47.0".to_owned()))
    };
    let read = opened(&format!("{names}\n{}\n{}\n{}\n", row(9), row(11), row(2)), &ReadOptions::default());
    let read = read.expect("it states its geometry");
    assert_eq!((read.len(), read.stamps_ns[0]), (3, 2_500_000_000));
    assert_eq!([0, 1, 2].map(|row| read.ranges[row].len()), [9, 11, 0], "two beams do not fit the angles");
    assert_eq!(ranges(&read, 1)[10], 2.5);
}

#[test]
fn rows_of_ros2_topic_echo_are_messages() {
    let row = |rest: &str| format!("1700000000,5,,-0.4,0.4,0.1,0.0,0.1,0.05,30.0,{},{rest}\n", row(9, ","));
    let text = row("") + &row(&cells(9, ",", |_| "47.0".to_owned()));
    let read = opened(&text, &ReadOptions::default()).expect("it states its geometry");
    assert_eq!((read.len(), read.ranges[0].len(), read.ranges[1].len()), (2, 9, 9));
    assert_eq!(read.stamps_ns[0], 1_700_000_000_000_000_005);
    let shortened = format!(
        "1700000000,5,laser,-3.14,3.14,0.0175,0.0,0.1,0.05,30.0,{},...\n",
        cells(128, ",", |_| "1.5".to_owned())
    );
    assert_eq!(found(&shortened), Found::ShortenedEcho);
    let odometry = "1700000000,5,odom,base_link,1.0,2.0,0.0,0.0,0.0,0.0,1.0,0.1,0.0,0.0\n";
    assert_eq!(found(odometry), Found::OtherTable(String::new()));
}

#[test]
fn a_list_in_a_cell_is_ranges() {
    let read = scans("time,angle_min,angle_max,ranges\n5,-0.1,0.1,\"(1.5, 2.5, inf)\"\n");
    assert_eq!(ranges(&read, 0)[..2], FIRST[..2]);
}

#[test]
fn tables_without_ranges_are_named() {
    for (text, expected) in [
        ("angle,distance\n180.0,0\n", Found::AngleTable),
        ("scan,quality,angle,distance\n0,15,180.0,0\n", Found::AngleTable),
        ("theta;range\n0,5;1,2\n", Found::AngleTable),
        ("0.0 1.5\n0.5 1.6\n", Found::AngleTable),
        ("#COUNT=2\n#Angule\tDistance\tQuality\n0.5\t1500.0\t47\n1.5\t1501.0\t47\n", Found::AngleTable),
        ("x,y,z,intensity\n1,2,3,4\n", Found::PointTable),
        ("1.0 2.0 3.0\n1.0 2.0 3.0\n", Found::PointTable),
        ("Dear reader, all is well\nAll is well, dear reader\n", Found::Text),
        (
            "It reads logs, tables of ranges, what a robot sends, and whatever else there is\nin 2026 or so\n",
            Found::Text,
        ),
        (
            "\u{eeff}stamp,\u{e9}r0\u{eeff},r1 (\u{b5})\n1,2,3\n",
            Found::OtherTable("`\u{eeff}stamp`, `\u{e9}r0\u{eeff}`, `r1 (\u{b5})`".to_owned()),
        ),
        ("MIT License\n\nCopyright (c) 2026 whoever\n", Found::Text),
    ] {
        assert_eq!(found(text), expected, "{text}");
    }
}

/// A list of turns of a tunnel: an angle in degrees and a distance in millimetres, of which some are left out in each
/// turn.
fn list(turns: usize, row: impl Fn(usize, f64, f64) -> String) -> String {
    let of_turn =
        |turn: usize| (0..360).filter(move |i| !(i * 7 + turn * 3).is_multiple_of(11)).map(move |i| (turn, i as f64));
    let range = |deg: f64| (1.6 / deg.to_radians().sin().abs()).min(9.0);
    (0..turns).flat_map(of_turn).map(|(turn, deg)| row(turn, deg, range(deg)) + "\n").collect()
}

#[test]
fn lists_of_angles_and_distances_are_turns() {
    let mm = |range_m: f64| range_m * 1e3;
    for (text, turns) in [
        (format!("Angle,Distance\n{}", list(6, |_, deg, m| format!("{deg},{}", mm(m)))), 6),
        (
            format!(
                "quality;theta (rad);range_cm\n{}",
                list(4, |_, deg, m| format!("9;{};{}", -deg.to_radians(), m * 1e2))
            ),
            4,
        ),
        (list(5, |_, deg, m| format!("15\t{deg:.2}\t{:.1}\tok", mm(m))), 5),
        (format!("scan,label,angle,distance\n{}", list(3, |turn, deg, m| format!("{turn},tee,{deg},{m}"))), 3),
        (list(5, |_, deg, m| format!("{} {:.3}", (180.0 - deg).to_radians(), m)), 5),
        (format!("deg,mm\n{}", list(4, |_, deg, m| format!("{deg},{}", mm(m)))), 4),
        (format!("Ranges,Angles\n{}", list(4, |_, deg, m| format!("{m},{}", deg.to_radians()))), 4),
        (
            list(4, |_, deg, m| {
                format!("{} theta: {deg:06.2} Dist: {:08.2} Q: 47", if deg < 2.0 { "S" } else { "" }, mm(m))
            }),
            4,
        ),
        (list(4, |_, deg, m| format!("(15, {deg:.1}, {:.1})", mm(m))), 4),
        (
            list(4, |turn, deg, m| {
                format!("{}{deg} {:.1}", if deg < 2.0 { format!("Scan {turn}\n") } else { String::new() }, mm(m))
            }),
            4,
        ),
        (list(4, |_, deg, m| format!("{}{deg},{:.1}", if deg < 2.0 { "--- new scan\n" } else { "" }, mm(m))), 4),
    ] {
        let read = scans(&text);
        assert_eq!(read.len(), turns, "{}", &text[..60]);
        for row in 0..turns {
            let ranges = ranges(&read, row);
            let near = ranges.iter().filter(|m| (1.5..1.7).contains(*m)).count();
            assert!(
                ranges.len() > 300 && (30..100).contains(&near),
                "{} beams, {near} near: {}",
                ranges.len(),
                &text[..60]
            );
        }
    }
    let with_one =
        |odd: &str| list(6, |_, deg, m| format!("{deg},{}", mm(m))).replacen("\n40,", &format!("\n{odd},"), 1);
    for odd in ["9000", "-1e9", "1e308"] {
        assert_eq!(scans(&format!("Angle,Distance\n{}", with_one(odd))).len(), 6, "one angle of {odd} changes no unit");
    }
    let inches = scans(&format!("angle_deg,distance_in\n{}", list(3, |_, deg, m| format!("{deg},{}", m / 0.0254))));
    assert!(ranges(&inches, 0).iter().any(|m| (1.5..1.7).contains(m)), "inches");
    let swing = |turn: usize, i: i32| if turn.is_multiple_of(2) { i } else { -i };
    let row = |(turn, i): (usize, i32)| format!("{},{}\n", swing(turn, i), 2 + (i - 20).abs() / 9);
    let swings = (0..6).flat_map(|turn| (-60..=60).map(move |i| (turn, i))).map(row).collect::<String>();
    assert_eq!(scans(&format!("angle,distance_m\n{swings}")).len(), 6, "a sensor that swings");
    let stamped =
        list(3, |turn, deg, m| format!("{},{deg},{m}", 1_700_000_000_000 + turn as u64 * 100 + deg as u64 / 4));
    let read = scans(&format!("timestamp,angle,distance\n{stamped}"));
    assert_eq!(read.stamps_ns[1], 1_700_000_000_100_000_000, "by its first row");
}

#[test]
fn rows_of_x_and_y_are_points_unless_they_are_a_way() {
    let xy = |turn: usize, deg: f64, m: f64| {
        let (sin, cos) = deg.to_radians().sin_cos();
        format!("{turn};{:.0};{:.0}", m * cos * 1e3, m * sin * 1e3)
    };
    let read = scans(&format!("scan;x;y\n{}", list(4, xy)));
    assert!(read.len() == 4 && read.ranges[0].len() > 200, "{}", read.ranges[0].len());
    let way: String = (0..50).map(|i| format!("{i},{},{}\n", i * 2, i % 3)).collect();
    assert_eq!(found(&format!("time_s,x,y\n{way}")), Found::PointTable);
}

#[test]
fn times_that_stand_or_leap_are_not_believed() {
    let table = |names: &str, time: &dyn Fn(usize) -> String| {
        let rows: String = (0..9).map(|i| format!("{},{}\n", time(i), row(4, ","))).collect();
        scans(&format!("{names},r0,r1,r2,r3\n{rows}")).stamps_ns[8]
    };
    for (names, time, last_ns) in [
        ("seq,stamp", &(|i| format!("{i},0")) as &dyn Fn(usize) -> String, 2_250_000_000),
        ("stamp,time_s", &|i| format!("{},{}.5", [5, 900_000_000, 3][i % 3], i + 1), 9_500_000_000),
        ("rosbagTimestamp,secs,nsecs", &|i| format!("{}00000000,112,{}00000000", 1120 + i, i), 112_800_000_000),
        ("time", &|i| format!("{}00000000", 1120 + i), 112_800_000_000),
        ("timestamp", &|i| format!("{}", 52_300 + 100 * i), 53_100_000_000),
        ("header_stamp_sec,header_stamp_nanosec", &|i| format!("{},{i}00000000", 112 + i), 120_800_000_000),
        ("timestamp", &|i| format!("2025-03-23 15:42:3{i}.5"), 1_742_744_558_500_000_000),
        ("time", &|i| format!("2025-03-23T17:42:3{i}.5+02:00"), 1_742_744_558_500_000_000),
        ("time", &|i| format!("13:12:5{i}.25"), 47_578_250_000_000),
    ] {
        assert_eq!(table(names, time), last_ns, "{names}");
    }
}

#[test]
fn numbers_of_beams_tell_directions_that_nothing_states() {
    let table = |beams: usize, range: &dyn Fn(f64) -> f64| {
        cells(beams, ",", |i| format!("{:.3}", range(i as f64 / beams as f64))) + "\n"
    };
    let round = |share: f64| 3.0 + (std::f64::consts::TAU * share).sin();
    for (beams, range, expected) in [
        (360, &round as &dyn Fn(f64) -> f64, Some("from 0° to 359°")),
        (360, &|share| 1.0 + share, None),
        (1081, &|share| 1.0 + share, Some("from -135° to 135°")),
        (361, &|share| 1.0 + share, Some("from -90° to 90°")),
        (361, &round, None),
        (726, &round, None),
    ] {
        let folder = Folder::new();
        let path = folder.add("table.csv", table(beams, range).repeat(3).as_bytes());
        let described = describe(&path, &sensor(&[]), &ReadOptions::default());
        let taken = described.ok().map(|found| found.properties[0].1.clone());
        let fits = taken.as_ref().zip(expected).is_some_and(|(taken, expected)| taken.contains(expected));
        assert!(fits || (taken.is_none() && expected.is_none()), "{beams}: {taken:?}");
    }
    let of_day: String = (0..3).map(|i| format!("13:12:5{i}.25,{}\n", row(9, ","))).collect();
    let read = scans(&of_day);
    assert_eq!((ranges(&read, 0).len(), read.stamps_ns[2]), (9, 47_572_250_000_000), "a first column of times of day");
}

#[test]
fn columns_of_words_are_left_out_aloud() {
    let rows: String = (0..3).map(|_| format!("7.5,wall,{}\n", row(8, ","))).collect();
    let folder = Folder::new();
    let path = folder.add("table.csv", rows.as_bytes());
    let description = describe(&path, &sensor(&[]), &options("")).expect("a table");
    let columns = &description.properties[0].1;
    assert!(columns.contains("with 9 ranges; column 2 (words) is not used"), "{columns}");
    let label = |i: usize| ["tee", "cross", "bend", "tee", "end", "bend", "bend"][i % 7];
    let rows: String = (0..21).map(|i| format!("{},{}\n", label(i), row(8, ","))).collect();
    assert_eq!(scans(&rows).len(), 21, "a label that changes is no line between rows");
}

/// The pose by odometry of each scan of a table.
fn odometry(text: &str) -> Vec<Option<Isometry2<f64>>> {
    let folder = Folder::new();
    let path = folder.add("table.csv", text.as_bytes());
    let mut recording = Recording::open(&[path], &options(""), sensor(&[])).expect("a table");
    let (mut poses, mut revolution) = (Vec::new(), Revolution::default());
    while recording.next(&mut revolution, &mut Notes::default()).expect("it goes on") {
        poses.push(revolution.odometry);
    }
    poses
}

#[test]
fn columns_of_a_pose_are_the_odometry() {
    let ranges = row(8, ",");
    let rows = |i: i32| format!("{},{ranges},{}\n", f64::from(i) * 0.5, 90);
    let text: String = (0..9).map(|i| format!("{i},{}", rows(i))).collect();
    let names: String = (0..8).map(|i| format!("r{i},")).collect();
    let without_y = odometry(&format!("time_s,robot_x,{names}heading_deg\n{text}"));
    assert!(without_y.len() == 9 && without_y.iter().all(Option::is_none));
    let poses = odometry(&format!("time_s,x,{names}heading_deg,y\n{}", text.replace('\n', ",2\n")));
    let pose = poses[4].expect("a pose");
    assert!((pose.translation.x - 2.0).abs() < 1e-6 && (pose.translation.y - 2.0).abs() < 1e-6, "{pose:?}");
    assert!((pose.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-6, "{pose:?}");
    let of_list = list(4, |turn, deg, m| format!("{},{turn},1,0.5,{deg},{m}", 100 * turn));
    let poses = odometry(&format!("time_ms,pose_x,pose_y,pose_theta,angle,distance\n{of_list}"));
    assert_eq!(poses.iter().flatten().count(), 4);
}
