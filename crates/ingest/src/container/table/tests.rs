//! What the columns of a table are taken for.

use super::*;

/// Lines of a file, the last with its end.
fn lines(text: &str) -> Vec<Line> {
    text.lines().zip(1..).map(|(text, number)| Line { number, text: text.to_owned(), is_ended: true }).collect()
}

fn table(text: &str) -> Result<Table, Found> {
    let settings = CsvGeometry { range_max_m: 50.0, rate_hz: 4.0, ..CsvGeometry::default() };
    let (comments, rows): (Vec<Line>, Vec<Line>) =
        lines(text).into_iter().filter(|line| !line.text.is_empty()).partition(|line| is_comment(&line.text));
    Table::of(Sample::of_lines(comments.into_iter().last().map(|line| line.text), rows), settings).expect("a line")
}

fn scans(text: &str) -> Vec<LaserScan> {
    let table = table(text).unwrap_or_else(|found| panic!("{found}: {text}"));
    let mut out = VecDeque::new();
    for line in lines(text) {
        table.read(&line, &mut out).expect("a row");
    }
    out.iter().map(|message| LaserScan::decode(&message.data).expect("a scan")).collect()
}

/// This many cells, each made of its number.
fn cells(count: usize, separator: &str, cell: impl Fn(usize) -> String) -> String {
    (0..count).map(cell).collect::<Vec<_>>().join(separator)
}

fn ranges(count: usize, separator: &str) -> String {
    cells(count, separator, |i| format!("{}.5", i % 3 + 1))
}

const FIRST: [f32; 3] = [1.5, 2.5, 3.5];

#[test]
fn rows_of_bare_ranges_are_a_scan_each() {
    let read = scans("1.5,nan,inf,1,2,1,2,1\n\n2,,4,1,2,1,2,1\n");
    assert_eq!((read.len(), read[0].ranges[0], read[0].ranges[2]), (2, 1.5, f32::INFINITY));
    assert!(read[0].ranges[1].is_nan() && read[1].ranges[1].is_nan(), "an empty cell is no measurement");
    assert_eq!((read[0].range_max, read[0].header.stamp.to_ns()), (50.0, Some(250_000_000)));
}

#[test]
fn a_header_tells_times_and_ranges_from_other_columns() {
    let read = scans("seq,stamp_ns,r0,r1,label\n7,1700000000000000001,1,2,3\n");
    assert_eq!(read[0].header.stamp.to_ns(), Some(1_700_000_000_000_000_001), "to the nanosecond");
    assert_eq!(read[0].ranges, [1.0, 2.0]);
    let counted = format!("{}\n{}\n", cells(9, ",", |i| i.to_string()), ranges(9, ","));
    assert_eq!(scans(&counted).len(), 1, "numbers of columns are no row");
    let unordered = "r1,r10,r2,q1,q2,q10,angle1,angle2,angle10\n1,10,2,0,0,0,0,0,0\n";
    assert_eq!(scans(unordered)[0].ranges, [1.0, 2.0, 10.0]);
}

#[test]
fn every_separator_is_read_with_a_header_and_without() {
    for (separator, decimal) in [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), (" ", "."), (" ", ",")] {
        let row = ranges(9, separator).replace('.', decimal);
        let names = cells(9, separator, |i| format!("r{i}"));
        for text in
            [format!("{row}\n{row}\n"), format!("{names}\n{row}\n{row}\n"), format!("# {names}\n{row}\n{row}\n")]
        {
            let read = scans(&text);
            assert_eq!((read.len(), &read[0].ranges[..3]), (2, &FIRST[..]), "{text}");
        }
    }
}

#[test]
fn columns_that_count_up_are_no_beams() {
    let rows = |first: &dyn Fn(usize) -> String| -> String {
        (0..6).map(|i| format!("{},{}\n", first(i), cells(8, ",", |j| format!("{}", (i * j) % 5 + 1)))).collect()
    };
    for (text, second_ns) in [
        (rows(&|i| i.to_string()), 500_000_000),
        (rows(&|i| format!("{}.5", 1_700_000_000 + i)), 1_700_000_001_500_000_000),
        (rows(&|i| format!("{:.1}", i as f64 * 0.2)), 200_000_000),
    ] {
        let read = scans(&text);
        assert_eq!((read[1].ranges.len(), read[1].header.stamp.to_ns()), (8, Some(second_ns)), "{text}");
    }
    let leaving = rows(&|i| format!("{}.5", i + 1));
    assert_eq!(scans(&leaving)[0].ranges.len(), 9, "a wall that is left behind is a beam");
}

#[test]
fn stamps_that_repeat_or_go_back_are_no_beams() {
    const EPOCH: usize = 1_700_000_000;
    let rows = |stamp: &dyn Fn(usize) -> String| -> String {
        (0..30)
            .map(|i| format!("{},{}\n", stamp(i), cells(8, ",", |j| ["inf", "1e30", "2", "3"][(i * j) % 4].to_owned())))
            .collect()
    };
    for (text, last_ns) in [
        (rows(&|i| (EPOCH + i / 10).to_string()), 1_700_000_002_000_000_000),
        (rows(&|_| EPOCH.to_string()), 1_700_000_000_000_000_000),
        (rows(&|i| format!("{}.5", EPOCH - i)), 1_699_999_971_500_000_000),
        (rows(&|i| format!("{},{}00000000", EPOCH + i / 10, i % 10)), 1_700_000_002_900_000_000),
        (rows(&|i| (i / 10).to_string()), 2_000_000_000),
        (rows(&|i| format!("{:.1}", if i < 20 { i } else { i - 20 } as f64 * 0.1)), 900_000_000),
    ] {
        let read = scans(&text);
        let last = &read[29];
        assert_eq!((last.ranges.len(), last.header.stamp.to_ns()), (8, Some(last_ns)), "{text}");
    }
    let behind = rows(&|i| format!("{}.5", i % 3 + 1)).replace('\n', &format!(",{EPOCH}\n"));
    assert_eq!(scans(&behind)[0].ranges.len(), 9, "a stamp behind the ranges");
    let sentinel = rows(&|_| "4294967295,4294967295,4294967295".to_owned());
    assert_eq!(scans(&sentinel)[0].ranges.len(), 11, "how some write that there is no return");
}

#[test]
fn names_in_degrees_are_bearings() {
    let names = cells(9, ",", |i| format!("{}", i as f64 * 0.5 - 2.0));
    let read = scans(&format!("time,{names}\n5,{}\n", ranges(9, ",")));
    assert_eq!((read[0].angle_min, read[0].angle_increment, read[0].ranges.len()), (-2.0, 0.5, 9));
    let names = cells(9, ",", |i| format!("{}", i * 10));
    let read = scans(&format!("{names}\n{}\n", ranges(9, ",")));
    assert!((read[0].angle_max - 80f32.to_radians()).abs() < 1e-6);
}

#[test]
fn units_in_names_are_taken() {
    let names = cells(9, ";", |i| format!("range {i} (mm)"));
    let row = cells(9, ";", |i| format!("{}500", i % 3 + 1));
    assert_eq!(scans(&format!("{names}\n{row}\n"))[0].ranges[..3], FIRST);
}

/// As `rostopic echo -p` writes it, with another number of ranges in the last row.
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
        format!("{fixed},{},{}", ranges(count, ","), cells(count, ",", |_| "47.0".to_owned()))
    };
    let read = scans(&format!("{names}\n{}\n{}\n", row(9), row(11)));
    let [first, second] = &read[..] else { panic!("{read:?}") };
    assert_eq!((first.header.stamp.to_ns(), first.header.frame_id.as_str()), (Some(2_500_000_000), "laser"));
    assert_eq!((first.angle_min, first.angle_increment, first.range_max), (-0.4, 0.1, 50.0), "settings win");
    assert_eq!((first.ranges.len(), second.ranges.len(), second.ranges[10]), (9, 11, 2.5));
}

#[test]
fn rows_of_ros2_topic_echo_are_messages() {
    let row = |rest: &str| format!("1700000000,5,,-0.4,0.4,0.1,0.0,0.1,0.05,30.0,{},{rest}\n", ranges(9, ","));
    let read = scans(&(row("") + &row(&cells(9, ",", |_| "47.0".to_owned()))));
    assert_eq!((read.len(), read[0].ranges.len(), read[1].ranges.len()), (2, 9, 9));
    assert_eq!((read[1].intensities.len(), read[0].header.stamp.to_ns()), (9, Some(1_700_000_000_000_000_005)));
    let shortened = format!("1700000000,5,laser,-3.14,3.14,0.0175,0.0,0.1,0.05,30.0,{},...\n", ranges(128, ","));
    assert_eq!(table(&shortened).err(), Some(Found::ShortenedEcho));
    let odometry = "1700000000,5,odom,base_link,1.0,2.0,0.0,0.0,0.0,0.0,1.0,0.1,0.0,0.0\n";
    assert_eq!(table(odometry).err(), Some(Found::OtherTable(String::new())));
}

#[test]
fn a_list_in_a_cell_is_ranges() {
    let read = scans("time,angle_min,angle_max,ranges\n5,-0.1,0.1,\"(1.5, 2.5, inf)\"\n");
    assert_eq!((&read[0].ranges[..], read[0].angle_max), (&[1.5, 2.5, f32::INFINITY][..], 0.1));
}

#[test]
fn tables_without_ranges_are_named() {
    for (text, found) in [
        ("angle,distance\n180.0,0\n", Found::AngleTable),
        ("scan,quality,angle,distance\n0,15,180.0,0\n", Found::AngleTable),
        ("theta;range\n0,5;1,2\n", Found::AngleTable),
        ("0.0 1.5\n0.5 1.6\n", Found::AngleTable),
        ("#COUNT=2\n#Angule\tDistance\tQuality\n0.5\t1500.0\t47\n1.5\t1501.0\t47\n", Found::AngleTable),
        ("x,y,z,intensity\n1,2,3,4\n", Found::PointTable),
        ("1.0 2.0 3.0\n1.0 2.0 3.0\n", Found::PointTable),
        ("time,speed,yaw\n1,2,3\n", Found::OtherTable("`time`, `speed`, `yaw`".to_owned())),
    ] {
        assert_eq!(table(text).err(), Some(found), "{text}");
    }
}
