//! How far the pose is off, and how far the odometry that it is given is off by itself, as a table in Markdown:
//! `cargo run --release -p crosscut-flight --example poses -- [LOG.clf|SCENARIO|PLAN.json|hall|corridor]... FIRST_SEED COUNT`.
//!
//! Each flight of the simulator is followed with odometry that drifts by 0 to 20 %, with scans up to 1.5 m apart, and with each
//! of the [`FAULTS`]. A CARMEN log is followed with its own odometry; its true poses stand first in its laser lines. The error is
//! the root mean square distance from the true positions after the best rigid fit; beside `sd_m`, the distance in the frame of the
//! first pose. The property: it is never more than 1.1 times
//! that of the odometry, or 5 cm and 0.2 % of the way where that is more.
#![allow(clippy::print_stdout)] // the table is the output

use std::error::Error;
use std::time::Instant;

use crosscut_flight::{PARAMS, PoseTracker};
use crosscut_messages::LaserScan;
use crosscut_sensor::Sensor;
use crosscut_simulator::{Flight as Scenes, Plan, scenarios};
use crosscut_stage::{Notes, Params, Revolution};
use nalgebra::{Isometry2, Point2, Vector2};

const DRIFTS: [f64; 5] = [0.0, 0.02, 0.05, 0.1, 0.2];
const SPACINGS_M: [f64; 4] = [0.0, 0.4, 0.8, 1.5];
const PROPERTY: f64 = 1.1;
const LEAST_M: f64 = 0.05;
const LEAST_SHARE: f64 = 0.002;

/// What happens to a flight, besides the drift, from its middle on.
const FAULTS: [(&str, f64); 6] = [
    ("pause", 0.02),
    ("slip", 0.02),
    ("slips for 10 m", 0.02),
    ("stands still for 20 m", 0.02),
    ("0.3 s late", 0.02),
    ("no stamps", 0.02),
];

/// A plan of smooth walls: halls of 40 m, or a corridor of 250 m.
const HALL: &str = r#"{"nodes":[{"id":0,"x_m":0,"y_m":0},{"id":1,"x_m":60,"y_m":0},{"id":2,"x_m":60,"y_m":60},{"id":3,"x_m":0,"y_m":60}],
    "edges":[{"from":0,"to":1,"width_m":20},{"from":1,"to":2,"width_m":20},{"from":2,"to":3,"width_m":20}],"roughness_m":0.02}"#;
const CORRIDOR: &str = r#"{"nodes":[{"id":0,"x_m":0,"y_m":0},{"id":1,"x_m":100,"y_m":0},{"id":2,"x_m":250,"y_m":0},{"id":3,"x_m":100,"y_m":20},{"id":4,"x_m":250,"y_m":60}],
    "edges":[{"from":0,"to":1,"width_m":3},{"from":1,"to":2,"width_m":3},{"from":1,"to":3,"width_m":3},{"from":2,"to":4,"width_m":3}],"roughness_m":0.02}"#;

/// A scan of a flight, with its true pose and its odometry.
struct Taken {
    scan: LaserScan,
    pose: Isometry2<f64>,
    odometry: Option<Isometry2<f64>>,
}

/// What became of a flight.
struct Flown {
    off_m: f64,
    odometry_off_m: f64,
    way_m: f64,
    /// Revolutions that are farther off than three standard deviations, of those that have any.
    beyond: f64,
    unknown: f64,
    stretches: usize,
    us: f64,
}

impl Flown {
    fn keeps(&self) -> bool {
        self.off_m <= (PROPERTY * self.odometry_off_m).max(LEAST_M + LEAST_SHARE * self.way_m)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [names @ .., first, count] = &args[..] else { return Err("NAME... FIRST_SEED COUNT".into()) };
    let (first, count): (u64, u64) = (first.parse()?, count.parse()?);
    println!(
        "| flights | kept | off, mean m | odometry | worst, of the odometry | beyond 3 sd | sd null | stretches | us |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for name in names {
        if name.ends_with(".clf") {
            say(name, &[follow(&log(name)?)]);
            continue;
        }
        let flights = (first..first + count)
            .map(|seed| Ok((seed, scenes(name, seed)?.collect::<Vec<_>>())))
            .collect::<Result<Vec<_>, Box<dyn Error>>>()?;
        let of = |drift: f64, spacing_m: f64, fault: &str| -> Vec<Flown> {
            let follow = |(seed, scenes): &(u64, Vec<_>)| follow(&taken(scenes, drift, spacing_m, fault, *seed));
            flights.iter().map(follow).collect()
        };
        for drift in DRIFTS {
            say(&format!("{name}, drift {:.0} %", 100.0 * drift), &of(drift, 0.0, ""));
        }
        for spacing_m in &SPACINGS_M[1..] {
            say(&format!("{name}, {spacing_m} m a scan"), &of(0.05, *spacing_m, ""));
        }
        for (fault, drift) in FAULTS {
            say(&format!("{name}, {fault}"), &of(drift, 0.0, fault));
        }
    }
    Ok(())
}

/// The flight through a scenario's mine, or through that of a plan.
fn scenes(name: &str, seed: u64) -> Result<Scenes, Box<dyn Error>> {
    let plan = match name {
        "hall" => Some(HALL.to_owned()),
        "corridor" => Some(CORRIDOR.to_owned()),
        _ if name.ends_with(".json") => Some(std::fs::read_to_string(name)?),
        _ => None,
    };
    if let Some(plan) = plan {
        return Ok(Plan::from_json(&plan)?.fly(seed)?);
    }
    let scenario = scenarios().iter().find(|scenario| scenario.name == name).ok_or("no such scenario")?;
    Ok((scenario.fly)(seed))
}

/// The scans of a flight, at least so far apart, with odometry.
fn taken(scenes: &[crosscut_simulator::Scene], drift: f64, spacing_m: f64, fault: &str, seed: u64) -> Vec<Taken> {
    let (mut before, mut odometry, mut way_m) = (None, Isometry2::identity(), 0.0);
    let (mut taken, mut last_m, mut odometries): (Vec<Taken>, f64, Vec<Isometry2<f64>>) =
        (Vec::new(), -1.0, Vec::new());
    let sign = if seed.is_multiple_of(2) { 1.0 } else { -1.0 };
    let half = scenes.len() / 2;
    let mut half_m = f64::INFINITY;
    for (at, scene) in scenes.iter().enumerate() {
        let Some(pose) = scene.pose else { continue };
        let pose = Isometry2::new(pose.position_m.coords, pose.heading_rad);
        let step = before.replace(pose).map_or(Isometry2::identity(), |before: Isometry2<f64>| before.inv_mul(&pose));
        way_m += step.translation.vector.norm();
        if at == half {
            half_m = way_m;
        }
        let since_m = way_m - half_m;
        let slipped = match fault {
            "slip" if at == half => Isometry2::translation(1.0, 0.0),
            "slips for 10 m" if (0.0..10.0).contains(&since_m) => Isometry2::from(step.translation.vector * 0.3),
            "stands still for 20 m" if (0.0..20.0).contains(&since_m) => step.inverse(),
            _ => Isometry2::identity(),
        };
        let moved = step.translation.vector * (1.0 + sign * drift);
        odometry *= Isometry2::new(moved, step.rotation.angle() + sign * drift * 0.1 * moved.norm()) * slipped;
        odometries.push(odometry);
        let is_paused = fault == "pause" && (half..half + 60).contains(&at);
        if way_m - last_m < spacing_m || is_paused {
            continue;
        }
        last_m = way_m;
        let mut scan = scene.scan.clone();
        if fault == "no stamps" {
            scan.header.stamp = Default::default();
        }
        let odometry = if fault == "0.3 s late" { odometries[at.saturating_sub(3)] } else { odometry };
        taken.push(Taken { scan, pose, odometry: Some(odometry) });
    }
    taken
}

/// The scans of a CARMEN log whose laser lines have the true pose, then the odometry.
fn log(path: &str) -> Result<Vec<Taken>, Box<dyn Error>> {
    let mut taken = Vec::new();
    for line in std::fs::read_to_string(path)?.lines() {
        let mut words = line.split_whitespace();
        if words.next() != Some("FLASER") {
            continue;
        }
        let count: usize = words.next().ok_or("no count")?.parse()?;
        let numbers = words.take(count + 7).map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        let steps = if count.is_multiple_of(2) { count } else { count - 1 };
        let angle_min = -std::f32::consts::FRAC_PI_2;
        let angle_increment = std::f32::consts::PI / steps as f32;
        let mut scan = LaserScan {
            ranges: numbers[..count].iter().map(|range_m| *range_m as f32).collect(),
            angle_min,
            angle_increment,
            angle_max: angle_min + (count - 1) as f32 * angle_increment,
            range_max: 81.0,
            ..LaserScan::default()
        };
        scan.header.stamp = crosscut_messages::Time::from_ns((numbers[count + 6] * 1e9) as u64);
        let pose = |at: usize| Isometry2::new(Vector2::new(numbers[at], numbers[at + 1]), numbers[at + 2]);
        taken.push(Taken { scan, pose: pose(count), odometry: Some(pose(count + 3)) });
    }
    Ok(taken)
}

fn follow(taken: &[Taken]) -> Flown {
    let (mut tracker, sensor) = (PoseTracker::new(&Params::defaults(PARAMS)), Sensor::default());
    let mut revolution = Revolution::default();
    let (mut found, mut judged, mut true_m, mut by_odometry) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut sds_m, mut stretches, mut ns) = (Vec::new(), 0, 0);
    // Brings true poses into the frame in which poses are found.
    let mut frame: Option<Isometry2<f64>> = None;
    for of in taken {
        sensor.revolution(&of.scan, &mut revolution, &mut Notes::default());
        revolution.odometry = of.odometry;
        let start = Instant::now();
        let tracked = tracker.add(&revolution, &mut Notes::default());
        ns += start.elapsed().as_nanos();
        let place_m =
            tracked.map_or_else(|| found.last().copied().unwrap_or_default(), |of| of.pose.translation.vector);
        let sd_m = tracked.and_then(|of| of.doubt.from_start_sd_m(Point2::from(place_m)));
        stretches = tracked.map_or(stretches, |of| of.doubt.stretch);
        found.push(place_m);
        // Of some logs not each pose is known.
        if of.pose.translation.vector.x.is_finite() {
            judged.push(place_m);
            let frame =
                frame.get_or_insert_with(|| tracked.map_or_else(Isometry2::identity, |of| of.pose) * of.pose.inverse());
            let off_m = (place_m - (*frame * of.pose).translation.vector).norm();
            sds_m.push(sd_m.map(|sd_m| (off_m, sd_m)));
            true_m.push(of.pose.translation.vector);
            by_odometry.push(of.odometry.map_or_else(Vector2::zeros, |odometry| odometry.translation.vector));
        }
    }
    let (off_m, odometry_off_m) = (apart_m(&judged, &true_m), apart_m(&by_odometry, &true_m));
    let known = sds_m.iter().flatten().count();
    let beyond = sds_m.iter().flatten().filter(|(off_m, sd_m)| *off_m > 3.0 * sd_m + LEAST_M);
    Flown {
        off_m: root_mean_square(&off_m),
        odometry_off_m: root_mean_square(&odometry_off_m),
        way_m: true_m.windows(2).map(|two| (two[1] - two[0]).norm()).sum(),
        beyond: beyond.count() as f64 / known.max(1) as f64,
        unknown: 1.0 - known as f64 / sds_m.len() as f64,
        stretches: stretches as usize,
        us: ns as f64 / 1000.0 / taken.len() as f64,
    }
}

/// How far each place is off after the rigid motion that fits best.
fn apart_m(found: &[Vector2<f64>], true_m: &[Vector2<f64>]) -> Vec<f64> {
    let mean = |of: &[Vector2<f64>]| of.iter().sum::<Vector2<f64>>() / of.len() as f64;
    let (found_mean, true_mean) = (mean(found), mean(true_m));
    let (mut dot, mut cross) = (0.0, 0.0);
    for (a, b) in found.iter().zip(true_m).map(|(a, b)| (a - found_mean, b - true_mean)) {
        dot += a.dot(&b);
        cross += a.perp(&b);
    }
    let turn = nalgebra::Rotation2::new(cross.atan2(dot));
    found.iter().zip(true_m).map(|(a, b)| (turn * (a - found_mean) - (b - true_mean)).norm()).collect()
}

fn root_mean_square(of: &[f64]) -> f64 {
    (of.iter().map(|off_m| off_m * off_m).sum::<f64>() / of.len() as f64).sqrt()
}

fn say(name: &str, flown: &[Flown]) {
    let mean = |of: fn(&Flown) -> f64| flown.iter().map(of).sum::<f64>() / flown.len() as f64;
    let kept = flown.iter().filter(|flown| flown.keeps()).count();
    let worst = flown.iter().map(|of| of.off_m / of.odometry_off_m).fold(0.0, f64::max);
    println!(
        "| {name} | {kept} of {} | {:.2} | {:.2} | {worst:.2} | {:.0} % | {:.0} % | {:.1} | {:.0} |",
        flown.len(),
        mean(|of| of.off_m),
        mean(|of| of.odometry_off_m),
        100.0 * mean(|of| of.beyond),
        100.0 * mean(|of| of.unknown),
        mean(|of| of.stretches as f64),
        mean(|of| of.us),
    );
}
