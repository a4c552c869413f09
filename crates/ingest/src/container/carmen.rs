//! CARMEN logs: laser lines and odometry, one a line.

use std::collections::{BTreeMap, VecDeque};
use std::f64::consts::{FRAC_PI_2, PI};
use std::mem;
use std::str::SplitWhitespace;

use crosscut_messages::{Endian, Header, LaserScan, Message as _, NS_PER_S, Odometry, Quaternion, Time};

use super::lines::{Line, LineFormat};
use super::{ChannelId, Message, Topic};
use crate::limits;

/// The first word of a line in a log.
const WORDS: &[&str] =
    &["FLASER", "RLASER", "ROBOTLASER1", "ROBOTLASER2", "RAWLASER1", "RAWLASER2", "ODOM", "PARAM", "SYNC", "TRUEPOS"];

/// The laser lines that are read; each kind is a topic of its own, named like it in small letters.
const LASERS: [&str; 6] = ["FLASER", "RLASER", "ROBOTLASER1", "ROBOTLASER2", "RAWLASER1", "RAWLASER2"];
const ODOMETRY: ChannelId = LASERS.len() as ChannelId;

/// The parameters that state the limit of FLASER and of RLASER lines.
const LIMITS: [(&str, &str); 2] = [("FLASER", "robot_front_laser_max"), ("RLASER", "robot_rear_laser_max")];

/// The largest range of a log without a stated limit is what beams report that met nothing, if it comes this often.
const LEAST_AT_LIMIT: u64 = 10;

/// Of a true limit, at least one range in this many is within.
const LEAST_WITHIN: u64 = 20;

/// Whether a text is a log.
pub(super) fn is_log(start: &str) -> bool {
    start.lines().filter_map(|line| line.split_whitespace().next()).any(|word| WORDS.contains(&word))
}

/// A log, as far as it was surveyed.
#[derive(Default)]
pub(super) struct Carmen {
    has_lasers: [bool; LASERS.len()],
    /// Otherwise the laser lines' own poses are the odometry.
    has_odometry_lines: bool,
    /// The limits of the range that parameters of the log state, as in [`LIMITS`].
    stated_max_m: [Option<f32>; 2],
    /// How many ranges are within that limit, and how many are beyond.
    within: [u64; 2],
    /// Largest range of the lines that do not state a limit, and how often it comes.
    largest_m: f32,
    at_largest: u64,
    /// The numbers of the laser lines, counted from 1.
    laser_lines: Vec<u64>,
    /// The time of the first of them.
    first_ns: Option<u64>,
    /// The last time of each kind of laser line, by the scan and by the logger.
    last_ns: [[Option<u64>; 2]; LASERS.len()],
    /// How many laser lines are later than the one of their kind before, by both times, and how many have one before.
    later: [u64; 2],
    following: u64,
    /// Scans a second, where no time tells the lines apart.
    rate_hz: f64,
}

/// Behind its time, a line has the logger's host and time.
const MOST_BEHIND: usize = 2;
/// The largest second of a stamp.
const LARGEST_NS: u64 = i32::MAX as u64 * 1_000_000_000;

/// What gives a line its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TimedBy {
    Scan,
    Logger,
    Count,
}

/// Why a line cannot be read.
type Cause = String;
/// The time in a line, nanoseconds, if a stamp can hold it.
type Stated = Option<u64>;

impl LineFormat for Carmen {
    const NAME: &'static str = "CARMEN log";
    const LAST_WORD_COUNTS: bool = false;

    fn survey(&mut self, line: &Line) {
        let mut words = line.text.split_whitespace();
        match words.next() {
            Some("ODOM") => self.has_odometry_lines = true,
            Some("PARAM") => {
                let name = words.next().unwrap_or_default();
                if let Some(laser) = LIMITS.iter().position(|(_, limit)| *limit == name) {
                    let stated_m = &mut self.stated_max_m[laser];
                    *stated_m = words.next().and_then(|value| value.parse().ok()).or(*stated_m);
                }
            }
            Some(word) => {
                let Some(laser) = LASERS.iter().position(|laser| *laser == word) else { return };
                let has_one_before = mem::replace(&mut self.has_lasers[laser], true);
                let mut words = Words { words, is_ended: line.is_ended };
                let Ok((scan, _, time_ns)) = self.laser_line(word, &mut words) else { return };
                if word == "FLASER" || word == "RLASER" {
                    let limit_m = self.stated_max_m(word).unwrap_or(f32::INFINITY);
                    for range_m in scan.ranges {
                        self.within[usize::from(range_m > limit_m)] += 1;
                        if range_m > self.largest_m {
                            (self.largest_m, self.at_largest) = (range_m, 0);
                        }
                        self.at_largest += u64::from(range_m == self.largest_m);
                    }
                }
                self.laser_lines.push(line.number);
                self.first_ns = self.first_ns.or(time_ns);
                let times_ns = [time_ns, words.words.nth(1).and_then(nanoseconds)];
                let before_ns = mem::replace(&mut self.last_ns[laser], times_ns);
                self.following += u64::from(has_one_before);
                for (later, (before_ns, ns)) in self.later.iter_mut().zip(before_ns.into_iter().zip(times_ns)) {
                    *later += u64::from(before_ns.is_some_and(|before_ns| ns > Some(before_ns)));
                }
            }
            None => {}
        }
    }

    fn properties(&self) -> Vec<(&'static str, String)> {
        let times = match self.timed_by() {
            TimedBy::Scan => return Vec::new(),
            TimedBy::Logger => "those of the logger: those of the scans stand still".to_owned(),
            TimedBy::Count => format!("{} scans a second (csv.rate_hz): those of the lines stand still", self.rate_hz),
        };
        vec![("times", times)]
    }

    fn channels(&self) -> BTreeMap<ChannelId, Topic> {
        let there = (0..).zip(LASERS).zip(self.has_lasers).filter(|(_, is_there)| *is_there);
        let lasers = there
            .map(|((id, laser), _)| (id, Topic::in_cdr(&format!("/{}", laser.to_lowercase()), LaserScan::SCHEMA_NAME)));
        let has_poses = self.has_odometry_lines || self.has_own_poses();
        let odometry = has_poses.then(|| (ODOMETRY, Topic::in_cdr("/odom", Odometry::SCHEMA_NAME)));
        lasers.chain(odometry).collect()
    }

    fn read(&mut self, line: &Line, out: &mut VecDeque<Message>) -> Result<(), (ChannelId, Cause)> {
        let mut words = Words { words: line.text.split_whitespace(), is_ended: line.is_ended };
        let Some(word) = words.words.next() else { return Ok(()) };
        // Of a line whose own time is of no use, the pose in the very line is the odometry.
        let are_own = !self.has_odometry_lines || (self.timed_by() != TimedBy::Scan && self.has_own_poses());
        if word == "ODOM" {
            let of_line = |cause| (ODOMETRY, cause);
            let (pose, speeds, time_ns) = odometry_line(&mut words).map_err(of_line)?;
            if !are_own {
                let time_ns = self.time_ns(line, time_ns, &mut words).map_err(of_line)?;
                out.push_back(odometry(ODOMETRY, pose, speeds, time_ns));
            }
        } else if let Some((laser, _)) = (0..).zip(LASERS).find(|(_, laser)| *laser == word) {
            let of_line = |cause| (laser, cause);
            let (mut scan, pose, time_ns) = self.laser_line(word, &mut words).map_err(of_line)?;
            let log_time_ns = self.time_ns(line, time_ns, &mut words).map_err(of_line)?;
            scan.header.stamp = Time::from_ns(log_time_ns);
            let data = scan.encode(Endian::Little);
            let of_laser = Message { channel: laser, log_time_ns, data, damage: None };
            if let Some(pose) = pose.filter(|_| are_own) {
                out.push_back(odometry(ODOMETRY, pose, [0.0; 2], log_time_ns));
            }
            out.push_back(of_laser);
        }
        Ok(())
    }
}

impl Carmen {
    /// A log of which no time is known, if it has none, but `rate_hz` scans a second.
    pub(super) fn new(rate_hz: f64) -> Self {
        Self { rate_hz, ..Self::default() }
    }

    /// Whether laser lines state poses.
    fn has_own_poses(&self) -> bool {
        self.has_lasers[..4].contains(&true)
    }

    /// Times that stand still in most lines are not believed.
    fn timed_by(&self) -> TimedBy {
        match self.later.map(|later| 2 * later >= self.following) {
            [true, _] => TimedBy::Scan,
            [_, true] => TimedBy::Logger,
            _ => TimedBy::Count,
        }
    }

    /// When a line was taken that states `time_ns` itself; the logger's time is the second of the words that are left.
    fn time_ns(&self, line: &Line, time_ns: Stated, words: &mut Words) -> Result<u64, Cause> {
        let counted = || self.laser_lines.partition_point(|number| *number <= line.number);
        let time_ns = match self.timed_by() {
            TimedBy::Scan => time_ns,
            TimedBy::Logger => words.words.nth(1).and_then(nanoseconds).or(time_ns),
            TimedBy::Count => {
                let since_ns = (counted() as f64 * NS_PER_S / self.rate_hz).round() as u64;
                Some(self.first_ns.unwrap_or(0).saturating_add(since_ns))
            }
        };
        time_ns.ok_or_else(|| "no stamp can hold its time".to_owned())
    }

    /// A scan without its stamp, the pose of the vehicle by its odometry (x, y in metres and yaw in radians), and the
    /// time that the line states.
    fn laser_line(&self, word: &str, words: &mut Words) -> Result<(LaserScan, Option<[f64; 3]>, Stated), Cause> {
        let is_plain = word == "FLASER" || word == "RLASER";
        let mut scan = LaserScan::default();
        if !is_plain {
            let [_, first_rad, _, step_rad, range_max_m, _, _] = words.numbers("geometry")?;
            scan.angle_min = first_rad as f32;
            scan.angle_increment = step_rad as f32;
            scan.range_max = range_max_m as f32;
        }
        words.f32s("ranges", &mut scan.ranges)?;
        let beams = scan.ranges.len();
        if is_plain {
            // These lines state no geometry: SICK lidars see half a turn, with a beam at its end if the number is odd.
            let steps = if beams.is_multiple_of(2) { beams } else { beams - 1 };
            scan.angle_min = -FRAC_PI_2 as f32;
            scan.angle_increment = if steps == 0 { 0.0 } else { (PI / steps as f64) as f32 };
            scan.range_max = self.range_max_m(word);
        } else {
            words.f32s("remissions", &mut scan.intensities)?;
        }
        scan.angle_max = scan.angle_min + beams.saturating_sub(1) as f32 * scan.angle_increment;
        let pose = if is_plain {
            let [_, _, _, x_m, y_m, yaw_rad] = words.numbers("poses")?;
            Some([x_m, y_m, yaw_rad])
        } else if word.starts_with("ROBOT") {
            let [_, _, _, x_m, y_m, yaw_rad, _, _, _, _, _] = words.numbers("poses")?;
            Some([x_m, y_m, yaw_rad])
        } else {
            None
        };
        scan.header.frame_id = word.to_lowercase();
        Ok((scan, pose, words.time_ns()?))
    }

    /// The limit of the range in lines of this kind, which do not state it.
    fn range_max_m(&self, word: &str) -> f32 {
        let seen_m = || Some(self.largest_m).filter(|_| self.at_largest >= LEAST_AT_LIMIT);
        let is_limit = |_: &f32| LEAST_WITHIN * self.within[0] >= self.within[1];
        self.stated_max_m(word).filter(is_limit).or_else(seen_m).unwrap_or(f32::INFINITY)
    }

    fn stated_max_m(&self, word: &str) -> Option<f32> {
        LIMITS.iter().zip(self.stated_max_m).find(|((laser, _), _)| *laser == word)?.1
    }
}

/// The pose, the speeds and the time of a line of odometry.
fn odometry_line(words: &mut Words) -> Result<([f64; 3], [f64; 2], Stated), Cause> {
    let [x_m, y_m, yaw_rad, speed_mps, turn_radps, _] = words.numbers("pose")?;
    Ok(([x_m, y_m, yaw_rad], [speed_mps, turn_radps], words.time_ns()?))
}

/// A message of odometry: x, y in metres and yaw in radians, speeds in m/s and rad/s.
pub(super) fn odometry(
    channel: ChannelId,
    [x_m, y_m, yaw_rad]: [f64; 3],
    [speed_mps, turn_radps]: [f64; 2],
    log_time_ns: u64,
) -> Message {
    let mut odometry = Odometry { child_frame_id: "base_link".to_owned(), ..Odometry::default() };
    odometry.header = Header { stamp: Time::from_ns(log_time_ns), frame_id: "odom".to_owned() };
    odometry.pose.pose.position.x = x_m;
    odometry.pose.pose.position.y = y_m;
    odometry.pose.pose.orientation = Quaternion::from_yaw_rad(yaw_rad);
    odometry.twist.twist.linear.x = speed_mps;
    odometry.twist.twist.angular.z = turn_radps;
    Message { channel, log_time_ns, data: odometry.encode(Endian::Little), damage: None }
}

/// The words of a line that are left.
struct Words<'a> {
    words: SplitWhitespace<'a>,
    is_ended: bool,
}

impl Words<'_> {
    fn number(&mut self, what: &str) -> Result<f64, Cause> {
        let word = self.words.next().ok_or_else(|| format!("it ends in its {what}"))?;
        word.parse().map_err(|_| format!("`{word:.20}` among its {what} is no number"))
    }

    fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N], Cause> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number(what)?;
        }
        Ok(numbers)
    }

    /// A count, and that many numbers.
    fn f32s(&mut self, what: &str, out: &mut Vec<f32>) -> Result<(), Cause> {
        let count = self.number(what)?;
        if !(0.0..=limits::BEAMS as f64).contains(&count) {
            return Err(format!("it claims {count} {what}"));
        }
        for _ in 0..count as usize {
            out.push(self.number(what)? as f32);
        }
        Ok(())
    }

    /// The time, in seconds in the line: programs that correct a log write negative times, and times that are almost nothing.
    /// Where the line has no end it may be cut short, unless another word follows.
    fn time_ns(&mut self) -> Result<Stated, Cause> {
        let word = self.words.next().ok_or("it ends before its time")?;
        if !self.is_ended && self.words.clone().next().is_none() {
            return Err("it ends in its time".to_owned());
        }
        let left = self.words.clone().count();
        if left > MOST_BEHIND {
            return Err(format!("{left} words behind its time: a count in it does not fit"));
        }
        word.parse::<f64>().map_err(|_| format!("`{word:.20}` is no time"))?;
        Ok(nanoseconds(word).filter(|ns| *ns < LARGEST_NS))
    }
}

/// A time in seconds, to the nanosecond: a number of 64 bits is not that exact today. Streams of C++ write six digits and an
/// exponent; less than a nanosecond is what such a program made of a damaged time.
fn nanoseconds(word: &str) -> Option<u64> {
    if word.contains('e') {
        let seconds: f64 = word.parse().ok()?;
        return (1e-9..1e10).contains(&seconds).then(|| (seconds * 1e9).round() as u64);
    }
    let (whole, fraction) = word.split_once('.').unwrap_or((word, ""));
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || !is_digits(whole) || !is_digits(fraction) {
        return None;
    }
    let fraction = &fraction[..fraction.len().min(9)];
    let rest_ns = format!("{fraction:0<9}").parse::<u64>().ok()?;
    whole.parse::<u64>().ok()?.checked_mul(1_000_000_000)?.checked_add(rest_ns)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(log: &str) -> Vec<Message> {
        let mut carmen = Carmen::new(10.0);
        let lines: Vec<_> =
            log.lines().zip(1..).map(|(text, number)| Line { number, text: text.to_owned(), is_ended: true }).collect();
        lines.iter().for_each(|line| carmen.survey(line));
        let mut out = VecDeque::new();
        lines.iter().for_each(|line| carmen.read(line, &mut out).expect("a line that can be read"));
        out.into()
    }

    fn scan_of(message: &Message) -> LaserScan {
        LaserScan::decode(&message.data).expect("a scan")
    }

    #[test]
    fn plain_laser_lines_are_half_a_turn_wide_whatever_their_number_of_beams() {
        let log = "FLASER 4 1 2 3 4 0 0 0 5 6 0 10.5 host 0.1\nFLASER 5 1 2 3 4 5 0 0 0 5 6 0 10.75 host 0.3\n";
        let scans: Vec<_> = messages(log).iter().filter(|message| message.channel == 0).map(scan_of).collect();
        let steps: Vec<f32> = scans.iter().map(|scan| scan.angle_increment).collect();
        assert_eq!(steps, [std::f32::consts::FRAC_PI_4; 2]);
        assert_eq!((scans[1].angle_min, scans[1].ranges.len()), (-std::f32::consts::FRAC_PI_2, 5));
        assert_eq!(scans[1].header.stamp.to_ns(), Some(10_750_000_000));
        assert_eq!(scans[0].range_max, f32::INFINITY, "nothing tells the limit");
    }

    #[test]
    fn the_largest_range_that_comes_often_is_the_limit() {
        let line = format!("FLASER 12{} 1 2 0 0 0 0 0 0 1.0 host 0\n", " 81.91".repeat(10));
        assert_eq!(scan_of(&messages(&line)[1]).range_max, 81.91);
        let other =
            "PARAM simulator_laser_probability_of_random_max .0001 host 0\nPARAM robot_rear_laser_max 5 host 0\n";
        let stated = format!("PARAM robot_front_laser_max 50.0 host 0\n{other}{line}");
        assert_eq!(scan_of(&messages(&stated)[1]).range_max, 50.0);
    }

    #[test]
    fn laser_lines_with_a_geometry_keep_it() {
        let line = "ROBOTLASER1 0 -1.5 3 0.5 30 0.01 0 3 1 2 3 2 7 8 0 0 0 4 5 0.5 0 0 0 0 0 1232658478.25 host 0\n";
        let found = messages(line);
        let (odometry, scan) = (Odometry::decode(&found[0].data).expect("a pose"), scan_of(&found[1]));
        assert_eq!((scan.angle_min, scan.angle_increment, scan.range_max), (-1.5, 0.5, 30.0));
        assert_eq!((scan.ranges, scan.intensities), (vec![1.0, 2.0, 3.0], vec![7.0, 8.0]));
        assert_eq!((odometry.pose.pose.position.x, odometry.pose.pose.position.y), (4.0, 5.0));
        assert_eq!(found[1].log_time_ns, 1_232_658_478_250_000_000);
    }

    #[test]
    fn a_count_that_does_not_fit_shifts_no_field() {
        for count in [1, 2, 4, 5] {
            let text = format!("FLASER {count} 1 2 3 0.1 0.2 0.3 0.4 0.5 0.6 10.5 host 0.1");
            let line = Line { number: 1, text, is_ended: true };
            let mut out = VecDeque::new();
            assert!(Carmen::new(10.0).read(&line, &mut out).is_err() && out.is_empty(), "{count}");
        }
    }

    #[test]
    fn a_time_with_an_exponent_is_read_unless_it_is_nothing() {
        assert_eq!(nanoseconds("1.13486e+09"), Some(1_134_860_000_000_000_000));
        assert_eq!(nanoseconds("2481.25"), Some(2_481_250_000_000));
        for wrong in ["1.08499e-42", "1e300", "1e", "-1e3", "nane"] {
            assert_eq!(nanoseconds(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn lines_whose_times_are_none_are_counted_and_have_their_own_poses() {
        let line =
            |time: &str| format!("ODOM 9 9 0 0 0 0 {time} host 0\nFLASER 2 1 2 0 0 0 5 6 0 {time} host {time}\n");
        let log: String = ["-0.042", "4.29497e+09", "3.44361e-86", "-1", "0"].map(line).concat();
        let found = messages(&log);
        assert_eq!(found.iter().map(|message| message.channel).collect::<Vec<_>>(), [ODOMETRY, 0].repeat(5));
        assert_eq!(found[9].log_time_ns, 500_000_000, "the fifth of ten a second");
        let timed = line("1.5") + &line("2.5") + &line("3.5");
        assert_eq!(messages(&timed).iter().filter(|message| message.log_time_ns == 3_500_000_000).count(), 2);
    }

    #[test]
    fn odometry_is_that_of_its_own_lines_where_there_are_any() {
        let log = "ODOM 1 2 0 0.5 0.1 0 9.5 host 0\nFLASER 2 1 2 0 0 0 5 6 0 10.5 host 0.1\n";
        let found = messages(log);
        assert_eq!(found.iter().map(|message| message.channel).collect::<Vec<_>>(), [ODOMETRY, 0]);
        let odometry = Odometry::decode(&found[0].data).expect("a pose");
        assert_eq!((odometry.pose.pose.position.x, odometry.twist.twist.linear.x), (1.0, 0.5));
    }
}
