//! What the columns of a table are taken for.

use crosscut_ingest::{CSV_PARAMS, CsvGeometry, Found, IngestError, ReadOptions, Recording, describe};
use crosscut_stage::{Params, Value};

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
