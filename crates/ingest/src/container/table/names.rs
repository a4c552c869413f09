//! What the names of columns say: `field.ranges12`, `ranges_12`, `/scan/ranges[12]`, `r12 (mm)`.

/// Nanoseconds in a second.
pub(super) const NS_PER_S: f64 = 1e9;

/// Names of columns that hold a time.
const TIMES: [&str; 10] =
    ["stamp", "timestamp", "time", "t", "secs", "time_stamp", "log_time", "rosbagtimestamp", "datetime", "date"];
/// The whole seconds of a time, and its nanoseconds.
const SECONDS: [&str; 3] = ["sec", "secs", "seconds"];
const NANOSECONDS: [&str; 4] = ["nsec", "nsecs", "nanosec", "nanosecs"];
/// Names of ranges.
const RANGES: [&str; 9] = ["r", "range", "ranges", "d", "dist", "distance", "distances", "beam", "laser"];
/// Names of columns that come with an index and are no ranges.
const NO_RANGES: [&str; 31] = [
    "intensities",
    "intensity",
    "quality",
    "q",
    "rssi",
    "remission",
    "remissions",
    "strength",
    "signal",
    "reflectivity",
    "confidence",
    "amplitude",
    "snr",
    "angle",
    "angles",
    "theta",
    "bearing",
    "azimuth",
    "phi",
    "flag",
    "flags",
    "valid",
    "covariance",
    "data",
    "x",
    "y",
    "z",
    "vx",
    "vy",
    "orientation",
    "label",
];
/// Names of angles; `angule` is written by the frame grabber of RPLIDAR.
const ANGLES: [&str; 9] = ["angle", "angles", "angule", "theta", "bearing", "azimuth", "phi", "angle_deg", "angle_rad"];

/// The name of a column, taken apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Name {
    /// Its last part, in small letters, without its unit and its number.
    pub(super) stem: String,
    /// What stands before that.
    parent: String,
    /// The number at its end.
    pub(super) index: Option<u64>,
    unit: String,
    /// Written by `rostopic echo -p`.
    is_of_rostopic: bool,
}

/// Parts of the geometry of a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)] // the fields of a LaserScan
pub(super) enum Geometry {
    AngleMin,
    AngleMax,
    AngleIncrement,
    TimeIncrement,
    ScanTime,
    RangeMin,
    RangeMax,
}

/// What the name of a column without a number stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    Time,
    Seconds,
    Nanoseconds,
    Geometry(Geometry),
    Frame,
    Angle,
    Range,
    Coordinate,
    Other,
}

impl Name {
    pub(super) fn of(text: &str) -> Self {
        let text = text.trim().to_lowercase();
        let is_of_rostopic = text == "%time" || text.starts_with("field.");
        let (rest, in_brackets) = match text.rfind(['(', '[']) {
            Some(at) if text.ends_with([')', ']']) => (&text[..at], text[at + 1..text.len() - 1].trim()),
            _ => (&text[..], ""),
        };
        let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let (rest, unit) = if is_number(in_brackets) { (&text[..], "") } else { (rest, in_brackets) };
        let (rest, unit) = without_unit(rest.trim_end(), unit);
        let numbered = rest.trim_end_matches([']', ')', ' ']);
        let stem = numbered.trim_end_matches(|c: char| c.is_ascii_digit());
        let index = numbered[stem.len()..].parse().ok();
        let rest = if index.is_some() { stem.trim_end_matches(['[', '(', '_', '-', '.', ' ', '#']) } else { rest };
        let (rest, unit) = without_unit(rest, unit);
        let (parent, stem) = rest.rsplit_once(['.', '/', ':']).unwrap_or(("", rest));
        let stem = stem.trim_matches(|c: char| "%#_ ".contains(c)).replace(' ', "_");
        let (parent, unit) = (parent.to_owned(), unit.to_owned());
        Self { stem, parent, index, unit, is_of_rostopic }
    }

    pub(super) fn meaning(&self) -> Meaning {
        let stem = self.stem.as_str();
        let is_in_time = self.parent.is_empty() || self.parent.contains("stamp") || self.parent.contains("time");
        match stem {
            _ if self.index.is_some() => Meaning::Other,
            _ if NANOSECONDS.contains(&stem) && is_in_time => Meaning::Nanoseconds,
            _ if SECONDS.contains(&stem) && is_in_time => Meaning::Seconds,
            _ if TIMES.contains(&stem) => Meaning::Time,
            "angle_min" | "anglemin" | "start_angle" => Meaning::Geometry(Geometry::AngleMin),
            "angle_max" | "anglemax" | "end_angle" => Meaning::Geometry(Geometry::AngleMax),
            "angle_increment" | "angleincrement" => Meaning::Geometry(Geometry::AngleIncrement),
            "time_increment" => Meaning::Geometry(Geometry::TimeIncrement),
            "scan_time" => Meaning::Geometry(Geometry::ScanTime),
            "range_min" | "rangemin" => Meaning::Geometry(Geometry::RangeMin),
            "range_max" | "rangemax" => Meaning::Geometry(Geometry::RangeMax),
            "frame_id" | "frame" => Meaning::Frame,
            "x" | "y" | "z" => Meaning::Coordinate,
            _ if ["ns", "us", "ms", "s"].contains(&self.unit.as_str()) => Meaning::Time,
            _ if ANGLES.contains(&stem) => Meaning::Angle,
            _ if RANGES.contains(&stem) => Meaning::Range,
            _ => Meaning::Other,
        }
    }

    /// Whether a column of this name holds the stamp of the scan, and not the time at which it was recorded.
    pub(super) fn is_stamp(&self) -> bool {
        self.stem.contains("stamp") && !self.stem.contains("rosbag") || self.parent.contains("stamp")
    }

    /// Whether columns of this name and a number are ranges: surely, surely not, or perhaps.
    pub(super) fn are_ranges(&self) -> Option<bool> {
        let stem = self.stem.as_str();
        let is = |names: &[&str]| names.contains(&stem);
        if is(&RANGES) || stem.starts_with("range") || stem.starts_with("dist") {
            Some(true)
        } else if is(&NO_RANGES) || TIMES.contains(&stem) && stem != "t" {
            Some(false)
        } else {
            None
        }
    }

    /// Metres in the unit of ranges that the name states.
    pub(super) fn unit_m(&self) -> Option<f64> {
        match self.unit.as_str() {
            "mm" | "millimeter" | "millimeters" => Some(1e-3),
            "cm" => Some(1e-2),
            "m" | "meter" | "meters" => Some(1.0),
            _ => None,
        }
    }

    /// Nanoseconds in the unit of the times in this column. Without one in the name, `first`, a time of it, shows it: it
    /// lies in this century, or it is in seconds.
    pub(super) fn unit_ns(&self, first: f64) -> f64 {
        match self.unit.as_str() {
            "ns" => 1.0,
            "us" => 1e3,
            "ms" => 1e6,
            "s" | "sec" | "secs" => NS_PER_S,
            _ if self.is_of_rostopic || first >= 1e17 => 1.0,
            _ if first >= 1e14 => 1e3,
            _ if first >= 1e11 => 1e6,
            _ => NS_PER_S,
        }
    }
}

/// A name without the unit at its end.
fn without_unit<'a>(name: &'a str, known: &'a str) -> (&'a str, &'a str) {
    let units = ["ns", "us", "ms", "s", "mm", "cm", "m"];
    match name.rsplit_once(['_', ' ']) {
        Some((name, unit)) if known.is_empty() && units.contains(&unit) => (name, unit),
        _ => (name, known),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_known_by_every_way_to_number_them() {
        for name in [
            "r12",
            "field.ranges12",
            "ranges_12",
            "/scan/ranges[12]",
            "Range 12 (mm)",
            "ranges.12",
            "range(12)",
            "dist_mm_12",
            "beam12_m",
        ] {
            let found = Name::of(name);
            assert_eq!((found.index, found.are_ranges()), (Some(12), Some(true)), "{name}: {found:?}");
        }
        assert_eq!(Name::of("range_12_mm").unit_m(), Some(1e-3));
        assert_eq!(Name::of("Range 12 (mm)").unit_m(), Some(1e-3));
        assert_eq!(Name::of("field.intensities7").are_ranges(), Some(false));
    }

    #[test]
    fn times_and_geometry_are_known_by_the_names_of_ros() {
        for (name, meaning) in [
            ("%time", Meaning::Time),
            ("field.header.stamp", Meaning::Time),
            ("header.stamp.nsecs", Meaning::Nanoseconds),
            ("/scan/header/stamp/sec", Meaning::Seconds),
            ("stamp_ns", Meaning::Time),
            ("Time (s)", Meaning::Time),
            ("field.angle_min", Meaning::Geometry(Geometry::AngleMin)),
            ("range_max", Meaning::Geometry(Geometry::RangeMax)),
            ("__time", Meaning::Time),
            ("Zeit (s)", Meaning::Time),
            ("speed (m/s)", Meaning::Other),
        ] {
            assert_eq!(Name::of(name).meaning(), meaning, "{name}: {:?}", Name::of(name));
        }
        assert_eq!((Name::of("stamp_ns").unit_ns(1.0), Name::of("%time").unit_ns(5.0)), (1.0, 1.0));
        assert_eq!((Name::of("time").unit_ns(1.7e12), Name::of("time").unit_ns(12.5)), (1e6, 1e9));
    }
}
