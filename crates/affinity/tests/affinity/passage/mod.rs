//! The graph of passages on scenes computed by hand: straight walls, one ray per degree and a range limit of 15 m
//! unless a test says otherwise.

mod closing_wall;
mod dead_ends;
mod pillars;
mod promises;
mod verdicts;
mod ways;
mod widths;

use std::f64::consts::{PI, TAU};

use crosscut_affinity::passage::KIND;
use crosscut_stage::{Affinity, Beam, Notes, Point, Revolution, StageError, Sweep, Value, wrap_angle_rad};

/// A wall from one end to the other.
pub(crate) type Segment = [[f64; 2]; 2];

/// Edges between walls are weaker.
pub(crate) const LEAK: f64 = 1e-5;

/// Both walls of a tunnel along x, 4 m wide.
pub(crate) const TUNNEL: [Segment; 2] = [[[-30.0, 2.0], [30.0, 2.0]], [[-30.0, -2.0], [30.0, -2.0]]];

/// Where a ray from the origin meets a segment.
fn hit_m([a, b]: &Segment, bearing_rad: f64) -> Option<f64> {
    let ((dy, dx), (ex, ey)) = (bearing_rad.sin_cos(), (b[0] - a[0], b[1] - a[1]));
    let det = ex * dy - ey * dx;
    let (range_m, along) = ((ex * a[1] - ey * a[0]) / det, (dx * a[1] - dy * a[0]) / det);
    (range_m > 0.0 && (0.0..=1.0).contains(&along)).then_some(range_m)
}

/// 360 beams from -π; `report` may change what a beam of this number reports.
pub(crate) fn scan(segments: &[Segment], report: impl Fn(usize, Option<f64>) -> Option<f64>) -> Revolution {
    scan_by(360, segments, report)
}

/// [`scan`] with this number of beams.
pub(crate) fn scan_by(
    beams: usize,
    segments: &[Segment],
    report: impl Fn(usize, Option<f64>) -> Option<f64>,
) -> Revolution {
    scan_as_far_as(15.0, beams, segments, report)
}

/// [`scan_by`] with another range limit.
pub(crate) fn scan_as_far_as(
    range_max_m: f64,
    beams: usize,
    segments: &[Segment],
    report: impl Fn(usize, Option<f64>) -> Option<f64>,
) -> Revolution {
    let step_rad = TAU / beams as f64;
    let (mut points_m, mut sweep) = (Vec::new(), Sweep { step_rad, range_max_m, full_turn: true, ..Sweep::default() });
    for beam in 0..beams {
        let bearing_rad = wrap_angle_rad(-PI + (beam as f64 + 0.5) * step_rad);
        let seen_m = segments.iter().filter_map(|segment| hit_m(segment, bearing_rad)).min_by(f64::total_cmp);
        sweep.bearings_rad.push(bearing_rad);
        sweep.beams.push(match report(beam, seen_m.filter(|range_m| *range_m < range_max_m)) {
            Some(range_m) => {
                points_m.push(Point::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin(), 0.0));
                Beam::Return(points_m.len() as u32 - 1)
            }
            None => Beam::NoReturn,
        });
    }
    Revolution { points_m, sweep: Some(sweep), ..Revolution::default() }
}

/// As reported.
pub(crate) fn all(_: usize, range_m: Option<f64>) -> Option<f64> {
    range_m
}

/// As reported, but these beams tell a range between those of the two beside them, by this share from the one before.
pub(crate) fn mixed(segments: &[Segment], beams: &[usize], share: f64) -> Revolution {
    let seen = scan(segments, all);
    let seen_m = |beam: usize| {
        let Beam::Return(i) = seen.beams()?.beams[beam % 360] else { return None };
        Some(seen.points_m[i as usize].coords.norm())
    };
    scan(segments, |beam, range_m| {
        let between_m = || Some((1.0 - share) * seen_m(beam + 359)? + share * seen_m(beam + 1)?);
        if beams.contains(&beam) { between_m() } else { range_m }
    })
}

/// With bumps of this height in and out of the walls, along the beams: over several of them, or they would be inexact
/// ranges.
pub(crate) fn bumps(height_m: f64) -> impl Fn(usize, Option<f64>) -> Option<f64> {
    move |beam, range_m| range_m.map(|range_m| range_m + height_m * (TAU * beam as f64 / 12.0).sin())
}

/// The tunnel with a side branch of that width, of which the far wall is seen and none of the near one.
pub(crate) fn with_branch(width_m: f64) -> Vec<Segment> {
    with_branch_at(3.0, width_m)
}

/// [`with_branch`], its near side this many metres ahead.
pub(crate) fn with_branch_at(near_m: f64, width_m: f64) -> Vec<Segment> {
    let far_m = near_m + width_m;
    let left = [[[-30.0, 2.0], [near_m, 2.0]], [[near_m, 2.0], [near_m, 30.0]], [[far_m, 30.0], [far_m, 2.0]]];
    [&left[..], &[[[far_m, 2.0], [30.0, 2.0]], TUNNEL[1]]].concat()
}

/// Sizes of the components of the graph without its leaks, largest first.
pub(crate) fn components(revolution: &Revolution, settings: &[(&'static str, Value)]) -> Vec<usize> {
    let mut affinity = Affinity::default();
    let mut stage = KIND.with(settings).expect("allowed");
    stage.affinity(revolution, &mut affinity, &mut Notes::default()).expect("a scan");
    let component = crate::components(&affinity, LEAK);
    let size = |root: usize| component.iter().filter(|c| **c == root).count();
    let mut sizes: Vec<usize> = (0..revolution.len()).map(size).filter(|size| *size > 0).collect();
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes
}

/// How many of those are of more than one return.
pub(crate) fn walls(revolution: &Revolution) -> usize {
    components(revolution, &[]).iter().filter(|size| **size > 1).count()
}

#[test]
fn a_tunnel_is_two_walls_a_dead_end_one_and_a_crossing_four() {
    let n = scan(&TUNNEL, all).len();
    assert_eq!(components(&scan(&TUNNEL, all), &[]), [n / 2, n / 2]);
    let dead_end = [TUNNEL[0], TUNNEL[1], [[6.0, -2.0], [6.0, 2.0]]];
    assert_eq!(components(&scan(&dead_end, all), &[]).len(), 1);
    let corner =
        |x: f64, y: f64| [[[x * 2.0, y * 2.0], [x * 2.0, y * 30.0]], [[x * 2.0, y * 2.0], [x * 30.0, y * 2.0]]];
    let crossing = [corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)].concat();
    assert_eq!(components(&scan(&crossing, all), &[]).len(), 4);
}

#[test]
fn a_piece_too_small_for_a_wall_is_one_if_the_end_of_the_view_cuts_it() {
    let in_view_from_behind = |stub: Segment| {
        let mut revolution = scan_by(1200, &[[[3.0, -2.0], [3.0, 2.0]], stub], all);
        revolution.sweep.as_mut().expect("a sweep").full_turn = false;
        components(&revolution, &[])
    };
    // A wall has 10 returns: as many beams as there are in 3°.
    assert_eq!(in_view_from_behind([[-3.0, -0.08], [-3.0, 0.0]])[1..], [5]);
    assert_eq!(in_view_from_behind([[-3.0, -0.24], [-3.0, -0.16]])[1], 1, "seen whole");
}

#[test]
fn a_few_returns_amid_a_limited_view_are_no_wall_though_the_view_ends_without_a_lost_beam() {
    let corners = [[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0], [-3.0, -3.0]];
    let room: Vec<Segment> = corners.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    let mut revolution = scan_by(1200, &[&room[..], &[[[1.2, -0.02], [1.2, 0.02]]]].concat(), all);
    revolution.sweep.as_mut().expect("a sweep").full_turn = false;
    assert_eq!(components(&revolution, &[("island_m", Value::Float(0.0))]), [1200]);
}

#[test]
fn a_wall_nearer_than_half_the_vehicle_is_a_wall() {
    let near = [TUNNEL[0], [[-30.0, -0.25], [30.0, -0.25]]];
    assert_eq!(components(&scan(&near, all), &[]).len(), 2, "beside a vehicle narrower than the default");
    let mast = |beam: usize, range_m| if (85..95).contains(&beam) { Some(0.2) } else { range_m };
    assert_eq!(components(&scan(&TUNNEL, mast), &[])[2..], [1; 10], "what stands before a wall is of the vehicle");
}

#[test]
fn dust_and_the_vehicle_itself_have_no_edges() {
    let dusty = |beam: usize, range_m| if beam % 45 == 10 { Some(0.4 + 0.003 * beam as f64) } else { range_m };
    let sizes = components(&scan(&TUNNEL, dusty), &[]);
    assert_eq!((sizes.len(), sizes.iter().filter(|size| **size == 1).count()), (2 + 8, 8), "{sizes:?}");
    let own_rig = |beam: usize, range_m| if (80..100).contains(&beam) { Some(0.1) } else { range_m };
    let hidden = scan(&TUNNEL, own_rig);
    let sizes = components(&hidden, &[]);
    assert_eq!((sizes.len(), sizes.iter().filter(|size| **size == 1).count()), (2 + 20, 20), "{sizes:?}");
    let mut notes = Notes::default();
    let narrow = [("width_m", Value::Float(0.5))];
    KIND.with(&narrow).expect("allowed").affinity(&hidden, &mut Affinity::default(), &mut notes).expect("a scan");
    let told = "passage: 20 returns within the vehicle, nearer than 0.25 m (half of vehicle.width_m), ignored";
    assert_eq!(notes.iter().collect::<Vec<_>>(), [told]);
}

#[test]
fn beams_that_do_not_match_the_returns_are_an_error_whichever_way_the_message_runs() {
    let mut clockwise = scan(&TUNNEL, all);
    let sweep = clockwise.sweep.as_mut().expect("a sweep");
    sweep.bearings_rad.iter_mut().for_each(|bearing_rad| *bearing_rad = -*bearing_rad);
    clockwise.points_m.iter_mut().for_each(|point_m| point_m.y = -point_m.y);
    for right in [scan(&TUNNEL, all), clockwise] {
        let taken = |spoil: fn(&mut Revolution)| {
            let mut revolution = right.clone();
            spoil(&mut revolution);
            KIND.with(&[]).expect("allowed").affinity(&revolution, &mut Affinity::default(), &mut Notes::default())
        };
        taken(|_| {}).expect("as it is");
        let spoilt: [fn(&mut Revolution); 4] = [
            |revolution| revolution.points_m.truncate(9),
            |revolution| revolution.points_m.push(Point::origin()),
            |revolution| revolution.sweep.as_mut().expect("a sweep").beams.reverse(),
            |revolution| revolution.sweep.as_mut().expect("a sweep").beams.rotate_left(30),
        ];
        for spoil in spoilt {
            assert!(matches!(taken(spoil), Err(StageError::Mismatch(_))));
        }
    }
}

#[test]
fn a_number_out_of_range_is_refused_by_its_name() {
    for (name, bad) in [("width_m", 0.0), ("leak", 1.5), ("island_m", f64::NAN)] {
        let refused = KIND.with(&[(name, Value::Float(bad))]).err().expect("must be refused");
        assert_eq!(refused.name, name);
    }
}
