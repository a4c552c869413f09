//! How often the ways on of a 3D cloud are right, by places whose truth comes from a mesh alone (`crosscut_lab::solid`).
//!
//! ```text
//! lab/run ways own 100 2                            networks of tubes, and a seed
//! lab/run ways mesh 60 2 MINE.stl                   places in each mesh; those from which a beam leaves it are left out
//! lab/run ways tiles 6 2 TILE.obj...                tiles whose passages are cut off at the end, in feet
//! ```
//!
//! The second table is of lidars that stand low: 0.6 to 1 m above the ground, below places in the middle as those of the first.
//!
//! An answer is right if it has as many ways as are true, and for each of these one within 20° whose clearance is within
//! 30 %. Of lidars that do not look everywhere, the true ways are the parts in view. Places are left out at which their number
//! hangs on the edge of the view: it is another one 4° inside of it, or outside. "Kind" is the share of true ways, of those that have
//! an answer within 20°, whose kind is right, by the slope of the answer and by its elevation as seen from the lidar; the true slope is that
//! of the line between the means of what is cut at 2 and at 3 local radii, of the whole way.

use std::f64::consts::PI;
use std::path::Path;
use std::time::Instant;

use anyhow::Context;
use crosscut_affinity::directions::Sky;
use crosscut_detector::{Detector, Preset, Settings};
use crosscut_lab::solid::lidar::Lidar;
use crosscut_lab::solid::mesh::Mesh;
use crosscut_lab::solid::truth::{RADII, Space, TrueWay};
use crosscut_lab::solid::tubes::Network;
use crosscut_messages::Cloud;
use crosscut_stage::{Way, WayKind};
use nalgebra::{Point3, Rotation3, UnitQuaternion, Vector3};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;

/// Diameter of the vehicle's ball.
const BALL_M: f64 = 0.6;
const VOXEL_M: f64 = 0.2;
/// The number of ways in view must not hang on so much of it.
const EDGE_DEG: f64 = 4.0;
const MOST_OFF_DEG: f64 = 20.0;
const TILT_DEG: f64 = 15.0;
/// How high above the ground a lidar stands that stands low.
const LOW_M: std::ops::Range<f64> = 0.6..1.0;
/// A shaft is steeper than that of `Way::kind`, degrees.
const SHAFT_DEG: f64 = 50.0;

struct Place {
    place_m: Point3<f64>,
    /// Those in the view of each lidar, if their number is clear.
    ways: [Option<Vec<TrueWay>>; Lidar::ALL.len()],
    /// The direction and the slope of all ways, radians.
    slopes: Vec<(Vector3<f64>, f64)>,
}

impl Place {
    /// The kind of the way that a part of a way is of.
    fn kind(&self, part: &TrueWay) -> Option<WayKind> {
        let dot = |of: &&(Vector3<f64>, f64)| of.0.dot(&part.direction);
        self.slopes.iter().max_by(|a, b| dot(a).total_cmp(&dot(b))).map(|(_, slope_rad)| WayKind::of_slope(*slope_rad))
    }
}

/// An answer: of each way its direction, its clearance, and how sure it is.
type Answer = Vec<(Vector3<f64>, f64, f64)>;

/// Clear places of a mesh, in the middle or low, and how many were not.
fn places(
    mesh: &Mesh,
    space: &Space,
    count: usize,
    most_leave: usize,
    is_low: bool,
    random: &mut Pcg64,
) -> (Vec<Place>, usize) {
    let (mut found, mut unclear) = (Vec::new(), 0);
    for _ in 0..2_000_000 {
        if found.len() == count {
            break;
        }
        let mut place_m = space.place_m(random.random_range(0..space.count()));
        let clear_m = space.clear_m(&place_m);
        if !(0.4..10.0).contains(&clear_m) {
            continue;
        }
        let leaves = |at: &i32| {
            let z = 1.0 - (f64::from(*at) + 0.5) / 100.0;
            let (sin, cos) = (f64::from(*at) * 2.399_963).sin_cos();
            let out = (1.0 - z * z).sqrt();
            mesh.range_m(&place_m, &Vector3::new(out * cos, out * sin, z)).is_infinite()
        };
        if (0..200).filter(leaves).count() > most_leave {
            continue;
        }
        // Where flights come by: not much nearer to a wall than to the middle.
        let room_m = space.room_m(&place_m);
        if clear_m < 0.7 * room_m || room_m < 0.6 {
            continue;
        }
        if is_low {
            let (high_m, low_m) = (mesh.range_m(&place_m, &-Vector3::z()), random.random_range(LOW_M));
            place_m.z -= high_m - low_m;
            if low_m >= high_m || space.clear_m(&place_m) < 0.4 {
                continue;
            }
        }
        let ways = |lidar: Lidar, reached: &[(usize, f64)], radii: &[f64]| {
            let views_deg = lidar.views_deg(EDGE_DEG);
            let cut = |radii: &f64| -> Vec<_> {
                views_deg.iter().map(|view_deg| space.ways(&place_m, radii * room_m, *view_deg, reached)).collect()
            };
            let mut at: Vec<_> = radii.iter().flat_map(cut).collect();
            let is_clear = at.iter().all(|ways| ways.len() == at[0].len());
            is_clear.then(|| at.swap_remove(at.len() / 2))
        };
        // Most places that are not clear show it nearby, where it costs least to see.
        let is_clear = |radii: &[f64]| {
            let reached = space.reached(&place_m, 0.5 * BALL_M, 1.5 * radii[radii.len() - 1] * room_m);
            let all = ways(Lidar::Full, &reached, radii).filter(|ways| !ways.is_empty());
            all.map(|_| reached)
        };
        if let Some(reached) = is_clear(&RADII[..2]).and_then(|_| is_clear(&RADII)) {
            let ways = Lidar::ALL.map(|lidar| ways(lidar, &reached, &RADII));
            let cut = |radius: f64| space.ways(&place_m, radius * room_m, Lidar::Full.view_deg(), &reached);
            let [near, far] = [RADII[0], RADII[RADII.len() - 1]].map(cut);
            let slope = |way: &TrueWay| {
                let dot = |other: &&TrueWay| other.direction.dot(&way.direction);
                let nearest =
                    |ways: &[TrueWay]| ways.iter().max_by(|a, b| dot(a).total_cmp(&dot(b))).map(|way| way.middle_m);
                Some((way.direction, elevation_rad(&(nearest(&far)? - nearest(&near)?))))
            };
            let slopes = ways[Lidar::Full as usize].iter().flatten().filter_map(slope).collect();
            found.push(Place { place_m, ways, slopes });
        } else {
            unclear += 1;
        }
    }
    (found, unclear)
}

fn elevation_rad(towards: &Vector3<f64>) -> f64 {
    towards.z.atan2(towards.xy().norm())
}

/// The components of far cells at one radius: 5° cells whose mean range is 2.5 times the least.
fn at_one_radius(cloud_m: &[Point3<f64>]) -> Answer {
    const COLUMNS: usize = 72;
    const ROWS: usize = 36;
    let mut cells = vec![(0.0, 0.0); COLUMNS * ROWS];
    for point_m in cloud_m.iter().filter(|point_m| point_m.coords.norm() > 0.5 * BALL_M) {
        let range_m = point_m.coords.norm();
        let row = ((point_m.z / range_m).clamp(-1.0, 1.0).asin() / PI + 0.5) * ROWS as f64;
        let column = (point_m.y.atan2(point_m.x) / std::f64::consts::TAU + 0.5) * COLUMNS as f64;
        let cell = &mut cells[(row as usize).min(ROWS - 1) * COLUMNS + (column as usize).min(COLUMNS - 1)];
        *cell = (cell.0 + range_m, cell.1 + 1.0);
    }
    let means_m: Vec<f64> = cells.iter().map(|(sum_m, count)| if *count > 0.0 { sum_m / count } else { 0.0 }).collect();
    let least_m = means_m.iter().copied().filter(|mean_m| *mean_m > 0.0).fold(f64::INFINITY, f64::min);
    let mut open: Vec<bool> = means_m.iter().map(|mean_m| *mean_m > 2.5 * least_m).collect();
    let mut answer = Vec::new();
    for first in 0..open.len() {
        let (mut part, mut at) = (vec![first], 0);
        while let Some(&cell) = part.get(at) {
            at += 1;
            if !std::mem::take(&mut open[cell]) {
                continue;
            }
            let (row, column) = (cell / COLUMNS, cell % COLUMNS);
            part.extend([row * COLUMNS + (column + 1) % COLUMNS, row * COLUMNS + (column + COLUMNS - 1) % COLUMNS]);
            part.extend([cell.wrapping_sub(COLUMNS), cell + COLUMNS].into_iter().filter(|cell| *cell < COLUMNS * ROWS));
        }
        let towards = |cell: &usize| {
            let elevation_rad = ((*cell / COLUMNS) as f64 + 0.5) / ROWS as f64 * PI;
            let bearing_rad = ((*cell % COLUMNS) as f64 + 0.5) / COLUMNS as f64 * std::f64::consts::TAU;
            let (down, out) = (elevation_rad.cos(), elevation_rad.sin());
            Vector3::new(-out * bearing_rad.cos(), -out * bearing_rad.sin(), -down)
        };
        if part.len() > 12 {
            let sum: Vector3<f64> = part.iter().map(towards).sum();
            answer.push((sum.normalize(), f64::NAN, 0.0));
        }
    }
    answer
}

fn of_ways<'a>(ways: impl IntoIterator<Item = &'a Way>) -> Answer {
    ways.into_iter().map(|way| (way.direction, way.clearance_m, way.p)).collect()
}

/// Whether the count is right, and whether directions and clearances are as well.
fn is_right(truth: &[&TrueWay], answer: &Answer) -> [bool; 2] {
    let fits = |way: &TrueWay, (direction, clearance_m, _): &(Vector3<f64>, f64, f64)| {
        direction.dot(&way.direction) > MOST_OFF_DEG.to_radians().cos()
            && (clearance_m / way.clearance_m - 1.0).abs() <= 0.3
    };
    let count = truth.len() == answer.len();
    let each = truth.iter().all(|way| answer.iter().filter(|found| fits(way, found)).count() == 1);
    [count, count && each]
}

#[derive(Default)]
struct Figures {
    places: usize,
    count: [usize; 3],
    right: [usize; 3],
    sure: [usize; 2],
    shafts: [usize; 2],
    /// Right by slope, and by elevation; and all.
    kinds: [usize; 3],
    by_p: std::collections::BTreeMap<u64, [usize; 2]>,
    ms: f64,
}

impl Figures {
    fn row(&self, name: &str) -> String {
        let share = |of: usize, all: usize| {
            if all == 0 { "-".to_owned() } else { format!("{:.0} %", 100.0 * of as f64 / all as f64) }
        };
        let of_places = |of: usize| share(of, self.places);
        let [level, radius, dual] = self.count.map(of_places);
        format!(
            "| {name} | {} | {level} | {radius} | {dual} | {} | {} of {} | {} of {} | {} | {} | {:.1} |",
            self.places,
            of_places(self.right[2]),
            share(self.sure[0], self.sure[1]),
            self.sure[1],
            self.shafts[0],
            self.shafts[1],
            share(self.kinds[0], self.kinds[2]),
            share(self.kinds[1], self.kinds[2]),
            self.ms / self.places.max(1) as f64,
        )
    }
}

/// Of a lidar that is tilted, with that tilt known to the program or not.
fn measure(
    lidar: Lidar,
    (tilt_deg, is_told): (f64, bool),
    all: &[(&Mesh, &Vec<Place>)],
    level: &mut Detector,
    seed: u64,
) -> anyhow::Result<Figures> {
    let (mut figures, mut sky, mut random) = (Figures::default(), Sky::default(), Pcg64::seed_from_u64(seed));
    let most_off = MOST_OFF_DEG.to_radians().cos();
    for (mesh, places) in all {
        for place in *places {
            let Some(ways) = &place.ways[lidar as usize] else { continue };
            let bearing_rad = random.random_range(-PI..PI);
            let axis = nalgebra::Unit::new_unchecked(Vector3::new(bearing_rad.cos(), bearing_rad.sin(), 0.0));
            let turned = Rotation3::from_axis_angle(&axis, tilt_deg.to_radians());
            let mut cloud_m = lidar.cloud_m(mesh, &place.place_m, &turned, &mut random);
            let (mut tilt, mut seen_as) = (UnitQuaternion::default(), turned.inverse());
            if is_told {
                cloud_m.iter_mut().for_each(|point_m| *point_m = turned * *point_m);
                (tilt, seen_as) = (UnitQuaternion::from_rotation_matrix(&turned), Rotation3::identity());
            }
            let seen: Vec<TrueWay> =
                ways.iter().map(|way| TrueWay { direction: seen_as * way.direction, ..*way }).collect();
            let truth: Vec<&TrueWay> = seen.iter().collect();
            let started = Instant::now();
            sky.look(&cloud_m, &tilt, BALL_M);
            let answer: Vec<Way> = sky.ways().into_iter().map(|found| found.way).collect();
            figures.ms += started.elapsed().as_secs_f64() * 1e3;
            let found = of_ways(&answer);
            let message = Cloud {
                points_m: cloud_m.iter().map(|point| [point.x, point.y, point.z]).collect(),
                ..Cloud::default()
            };
            let frame =
                level.detect_with(|sensor, frame| sensor.cloud(&message, &mut frame.revolution, &mut frame.notes))?;
            let openings = frame.junction.openings.iter();
            let sliced =
                openings.map(|o| (Vector3::new(o.bearing_rad.cos(), o.bearing_rad.sin(), 0.0), o.width_m, 0.0));
            // As the confidence of the results: without a way, 0.5.
            let least = found.iter().map(|(.., p)| *p).reduce(f64::min).unwrap_or(0.5);
            let answers = [sliced.collect(), at_one_radius(&cloud_m), found];
            figures.places += 1;
            for (at, answer) in answers.iter().enumerate() {
                let [count, right] = is_right(&truth, answer);
                figures.count[at] += usize::from(count);
                figures.right[at] += usize::from(right);
            }
            let [count, _] = is_right(&truth, &answers[2]);
            let of_p = figures.by_p.entry((100.0 * least) as u64).or_default();
            (of_p[0], of_p[1]) = (of_p[0] + usize::from(count), of_p[1] + 1);
            if least >= 0.9 {
                figures.sure = [figures.sure[0] + usize::from(count), figures.sure[1] + 1];
            }
            for (way, of_mesh) in seen.iter().zip(ways) {
                let dot = |of: &&Way| of.direction.dot(&way.direction);
                let nearest = answer.iter().filter(|of| dot(of) > most_off).max_by(|a, b| dot(a).total_cmp(&dot(b)));
                if let Some((nearest, kind)) = nearest.zip(place.kind(of_mesh)) {
                    let is_right = [nearest.kind() == kind, WayKind::of_slope(nearest.elevation_rad()) == kind, true];
                    figures.kinds.iter_mut().zip(is_right).for_each(|(count, is)| *count += usize::from(is));
                }
            }
            let is_shaft = |of_mesh: &TrueWay| of_mesh.direction.z.abs() > SHAFT_DEG.to_radians().sin();
            for (way, _) in seen.iter().zip(ways).filter(|(_, of_mesh)| is_shaft(of_mesh)) {
                let is_found = answers[2].iter().any(|(d, ..)| d.dot(&way.direction) > most_off);
                figures.shafts = [figures.shafts[0] + usize::from(is_found), figures.shafts[1] + 1];
            }
        }
    }
    Ok(figures)
}

fn main() -> anyhow::Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let usage = "ways own|mesh|tiles COUNT SEED [MESH...]";
    let [set, count, seed] = args.first_chunk().context(usage)?;
    let (count, seed): (usize, u64) = (count.parse().context(usage)?, seed.parse().context(usage)?);
    // Places in the middle, and low ones.
    let mut randoms = [seed, !seed].map(Pcg64::seed_from_u64);
    let (mut all, mut unclear) = (Vec::new(), [0; 2]);
    let mut add = |mesh: Mesh, count: usize, most_leave: usize| {
        let space = Space::new(&mesh, VOXEL_M);
        let found = [0, 1].map(|low| {
            let (found, not) = places(&mesh, &space, count, most_leave, low == 1, &mut randoms[low]);
            unclear[low] += not;
            found
        });
        all.push((mesh, found));
    };
    match set.as_str() {
        "own" => (0..count.div_ceil(5) as u64).for_each(|world| add(Network::new(1000 * seed + world).mesh(), 5, 0)),
        "mesh" => args[3..].iter().try_for_each(|path| anyhow::Ok(add(Mesh::read(Path::new(path), 1.0)?, count, 0)))?,
        "tiles" => {
            args[3..].iter().try_for_each(|path| anyhow::Ok(add(Mesh::read(Path::new(path), 0.3048)?, count, 40)))?
        }
        _ => anyhow::bail!(usage),
    }
    for (low, name) in ["in the middle", "0.6 to 1 m above the ground"].iter().enumerate() {
        let all: Vec<_> = all.iter().map(|(mesh, places)| (mesh, &places[low])).collect();
        print_table(name, &all, unclear[low], seed)?;
    }
    Ok(())
}

fn print_table(name: &str, all: &[(&Mesh, &Vec<Place>)], unclear: usize, seed: u64) -> anyhow::Result<()> {
    let found: usize = all.iter().map(|(_, places)| places.len()).sum();
    let mut by_ways = [0; 6];
    let ways = all.iter().flat_map(|(_, places)| *places).filter_map(|place| place.ways[Lidar::Full as usize].as_ref());
    ways.for_each(|ways| by_ways[ways.len().min(5)] += 1);
    let by_ways = &by_ways[1..];
    println!("{found} clear places {name}, {unclear} left out; with 1, 2, 3, 4, more ways: {by_ways:?}\n");
    println!(
        "| lidar | places | level slice | one radius | directions | also direction, width | sure, right | shafts | kind | \
         kind by elevation | ms |"
    );
    println!("|{}", "---|".repeat(11));
    let mut level = Settings::new(Preset::Default).build()?;
    let mut by_p = std::collections::BTreeMap::<u64, [usize; 2]>::new();
    for lidar in Lidar::ALL {
        let figures = measure(lidar, (0.0, false), all, &mut level, seed)?;
        println!("{}", figures.row(lidar.name()));
        for (p, of) in figures.by_p {
            let sum = by_p.entry(p).or_default();
            *sum = [sum[0] + of[0], sum[1] + of[1]];
        }
    }
    for (is_told, told) in [(false, "not told"), (true, "told")] {
        let tilted = measure(Lidar::Full, (TILT_DEG, is_told), all, &mut level, seed)?;
        println!("{}", tilted.row(&format!("{}, tilted by {TILT_DEG}°, {told}", Lidar::Full.name())));
    }
    println!();
    eprintln!("right of answers by their least p in %: {by_p:?}");
    Ok(())
}
