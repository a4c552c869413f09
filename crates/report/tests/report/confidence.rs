//! What the confidence of a scene rests on, on scenes computed by hand.

use crate::scenes::{Segment, scan, tee, tunnel};
use crosscut_report::confidence::{BETA, Grounds};
use crosscut_report::{PARAMS, Reporter, VEHICLE_PARAMS};
use crosscut_stage::{Affinity, Beam, Frame, Junction, Params, Partition, Revolution, Verdict};

const VEHICLE_WIDTH_M: f64 = 0.6;

/// The odds of every opening of [`answer`].
const P: f64 = 0.99;

/// The answer of the settings of preset `default` to clusters that are the walls, which leave no doubt at the openings.
fn answer(scan: (Revolution, Vec<Option<u32>>)) -> (Revolution, Junction) {
    answer_with_margin(scan, None)
}

fn answer_with_margin(
    (revolution, walls): (Revolution, Vec<Option<u32>>),
    margin_decades: Option<f64>,
) -> (Revolution, Junction) {
    let verdicts = verdicts(&revolution, &walls);
    answer_by(&[], (revolution, walls), margin_decades, &verdicts)
}

fn answer_by(
    settings: &[(&str, f64)],
    (revolution, walls): (Revolution, Vec<Option<u32>>),
    margin_decades: Option<f64>,
    verdicts: &[Verdict],
) -> (Revolution, Junction) {
    let mut params = Params::defaults(PARAMS);
    settings.iter().for_each(|(name, value)| params.set(name, *value).expect("allowed"));
    params.set("island_m", 2.0).expect("allowed");
    params.set("openings", "between_walls").expect("allowed");
    params.set("confidence", "scene").expect("allowed");
    let clusters = walls.iter().flatten().max().map_or(0, |last| *last as usize + 1);
    let mut frame = Frame { revolution, ..Frame::default() };
    frame.spectrum.margin_decades = margin_decades;
    frame.partition = Partition { clusters, labels: walls, ..Partition::default() };
    let Frame { revolution, spectrum, partition, junction, notes, .. } = &mut frame;
    let mut reporter = Reporter::new(&params, &Params::defaults(VEHICLE_PARAMS));
    let affinity = Affinity { verdicts: verdicts.to_vec(), ..Affinity::default() };
    reporter.report(revolution, &affinity, spectrum, partition, junction, notes).expect("as many labels as returns");
    (frame.revolution, frame.junction)
}

/// An opening from each wall to the next.
fn verdicts(revolution: &Revolution, walls: &[Option<u32>]) -> Vec<Verdict> {
    let of_walls: Vec<u32> = (0..).zip(walls).filter_map(|(number, wall)| wall.map(|_| number)).collect();
    let mut pairs: Vec<[u32; 2]> = of_walls.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    if revolution.sweep.is_some() {
        pairs.extend(of_walls.last().map(|&last| [last, of_walls[0]]));
    }
    pairs.retain(|pair| walls[pair[0] as usize] != walls[pair[1] as usize]);
    let opening =
        |returns| Verdict { returns, is_opening: true, room_ratio: 2.0, reason: "width", p: Some(P), measured: None };
    pairs.into_iter().map(opening).collect()
}

#[test]
fn openings_beyond_the_range_that_is_set_are_left_out_and_nothing_else_changes() {
    let (revolution, walls) = scan(&tee(), 360, |_| false);
    let verdicts = verdicts(&revolution, &walls);
    let by = |settings: &[(&str, f64)]| answer_by(settings, (revolution.clone(), walls.clone()), None, &verdicts).1;
    let (all, near) = (by(&[]), by(&[("max_range_m", 5.0)]));
    assert_eq!((all.openings.len(), near.openings.len()), (3, 1), "the ends of the tunnel are farther");
    assert_eq!((near.junctions, near.place, near.confidence), (all.junctions, all.place, all.confidence));
    assert_eq!(near.openings[0], *all.openings.iter().min_by(|a, b| a.range_m().total_cmp(&b.range_m())).expect("3"));
}

fn grounds(segments: &[(Segment, u32)]) -> (Grounds, f64) {
    grounds_of(scan(segments, 360, |_| false))
}

fn grounds_of(scan: (Revolution, Vec<Option<u32>>)) -> (Grounds, f64) {
    let (revolution, junction) = answer(scan);
    (
        Grounds::of(&revolution, &[], VEHICLE_WIDTH_M, None, &junction).expect("it has walls"),
        junction.confidence.expect("calibrated"),
    )
}

/// A tunnel along x whose left wall opens between x = 1 and x = 1 + `mouth_m` into a pocket 4 m deep, all of one wall.
fn pocket(mouth_m: f64) -> Vec<(Segment, u32)> {
    let far = 1.0 + mouth_m;
    vec![
        (Segment([-30.0, 1.75], [1.0, 1.75]), 0),
        (Segment([1.0, 1.75], [1.0, 5.75]), 0),
        (Segment([1.0, 5.75], [far, 5.75]), 0),
        (Segment([far, 5.75], [far, 1.75]), 0),
        (Segment([far, 1.75], [30.0, 1.75]), 0),
        (Segment([-30.0, -1.75], [30.0, -1.75]), 1),
    ]
}

#[test]
fn plain_places_are_surer_than_those_with_a_gap_that_a_vehicle_might_pass() {
    let (plain, sure) = grounds(&tunnel());
    let (with_gap, unsure) = grounds(&pocket(1.2));
    assert!(plain.most_within_walls_m < 1e-9, "the walls are lines: {plain:?}");
    assert!(plain.least_at_openings_m > 2.0, "{plain:?}");
    // From the corner (1, 1.75) the far side of the pocket is seen 1.2 m away.
    assert!((with_gap.most_within_walls_m - 1.2).abs() < 0.2, "{with_gap:?}");
    assert!(sure > 0.9 && unsure < sure, "{sure} and {unsure}");
}

#[test]
fn no_answer_is_sure_while_a_dark_gap_may_be_a_doorway() {
    let with_gap = |half_m: f64| {
        let left = [(Segment([-30.0, 1.75], [-half_m, 1.75]), 0), (Segment([half_m, 1.75], [30.0, 1.75]), 0)];
        grounds(&left.into_iter().chain([(Segment([-30.0, -1.75], [30.0, -1.75]), 1)]).collect::<Vec<_>>()).1
    };
    assert!(with_gap(0.2) > 0.9, "too narrow for the vehicle");
    assert!(with_gap(0.6) < 0.7, "it may pass");
}

#[test]
fn openings_close_together_and_pillars_speak_against_an_answer() {
    let (plain, _) = grounds(&tee());
    assert!((plain.apart_rad.to_degrees() - 30.0).abs() < 2.0, "past the corner (3, 1.75): {plain:?}");
    let mut with_pillar = tee();
    with_pillar.push((Segment([-4.0, -0.3], [-4.0, 0.3]), 3));
    let (with_pillar, _) = grounds(&with_pillar);
    assert_eq!(plain.longest_island_m, 0.0);
    assert!((0.45..0.6).contains(&with_pillar.longest_island_m), "{with_pillar:?}");
    let log_odds =
        |grounds: Grounds| BETA.iter().zip(grounds.inputs(VEHICLE_WIDTH_M)).map(|(beta, x)| beta * x).sum::<f64>();
    let sure = log_odds(plain);
    assert!(log_odds(Grounds { longest_island_m: with_pillar.longest_island_m, ..plain }) < sure);
    assert!(log_odds(Grounds { apart_rad: 0.5 * plain.apart_rad, ..plain }) < sure);
}

#[test]
fn a_stray_return_in_the_way_out_of_a_dead_end_makes_no_doubtful_gap_of_half_of_it() {
    let dead_end = [
        (Segment([-30.0, 1.75], [4.0, 1.75]), 0),
        (Segment([4.0, 1.75], [4.0, -1.75]), 0),
        (Segment([4.0, -1.75], [-30.0, -1.75]), 0),
        (Segment([-12.0, -0.2], [-12.0, 0.0]), 0),
    ];
    let (grounds, _) = grounds(&dead_end);
    assert!(grounds.most_within_walls_m < 0.1 && grounds.least_at_openings_m.is_finite(), "{grounds:?}");
}

#[test]
fn an_answer_of_which_most_beams_are_lost_is_not_sure() {
    let of_each = |each: usize| {
        let (mut revolution, walls) = scan(&tunnel(), 360, |_| false);
        let sweep = revolution.sweep.as_mut().expect("a sweep");
        let (mut points_m, mut labels) = (Vec::new(), Vec::new());
        for (at, beam) in sweep.beams.iter_mut().enumerate() {
            if let Beam::Return(i) = *beam {
                *beam = if at % each == 0 { Beam::Return(points_m.len() as u32) } else { Beam::NoReturn };
                if at % each == 0 {
                    points_m.push(revolution.points_m[i as usize]);
                    labels.push(walls[i as usize]);
                }
            }
        }
        revolution.points_m = points_m;
        answer((revolution, labels)).1.confidence.expect("calibrated")
    };
    assert!(of_each(1) > 0.9 && of_each(3) > 0.9, "{} and {}", of_each(1), of_each(3));
    assert!(of_each(10) < 0.3, "{}", of_each(10));
}

#[test]
fn beams_far_apart_speak_against_any_answer() {
    let with_beams = |beams: usize| grounds_of(scan(&tunnel(), beams, |_| false)).1;
    assert!(with_beams(90) > 0.9, "{}", with_beams(90));
    assert!(with_beams(24) < 0.15, "{}", with_beams(24));
}

#[test]
fn a_small_margin_makes_an_answer_less_sure_and_more_than_a_decade_no_surer() {
    let sure = |margin| answer_with_margin(scan(&tunnel(), 360, |_| false), margin).1.confidence;
    assert!(sure(Some(0.1)) < sure(Some(0.5)) && sure(Some(0.5)) < sure(Some(1.0)));
    assert_eq!([sure(Some(3.0)), sure(None)], [sure(Some(1.0)); 2]);
}

#[test]
fn an_opening_has_the_odds_of_its_gap() {
    let (_, answer) = answer(scan(&tee(), 360, |_| false));
    assert_eq!(answer.openings.iter().map(|opening| opening.p).collect::<Vec<_>>(), [Some(P); 3]);
}

/// The confidence of a tunnel, and p of its openings, with these verdicts.
fn of_tunnel(verdicts: &dyn Fn(&[Verdict]) -> Vec<Verdict>) -> (f64, Vec<Option<f64>>) {
    let (revolution, labels) = scan(&tunnel(), 360, |_| false);
    let verdicts = verdicts(&self::verdicts(&revolution, &labels));
    let (_, answer) = answer_by(&[], (revolution, labels), None, &verdicts);
    (answer.confidence.expect("calibrated"), answer.openings.iter().map(|opening| opening.p).collect())
}

#[test]
fn odds_against_an_opening_or_for_a_gap_in_a_wall_make_no_answer_sure() {
    let (plain, _) = of_tunnel(&|openings| openings.to_vec());
    let (doubtful, _) = of_tunnel(&|openings| vec![Verdict { p: Some(0.1), ..openings[0] }, openings[1]]);
    let within = |p: f64| {
        // Two neighbours of one wall.
        let returns = [within_wall(), within_wall() + 1];
        of_tunnel(&|openings| [openings, &[Verdict { returns, p: Some(p), is_opening: false, ..openings[0] }]].concat())
            .0
    };
    assert!(plain > 0.9 && doubtful < plain, "{plain} and {doubtful}");
    assert!(within(0.9) < within(0.1) && within(0.1) < plain, "{} and {}", within(0.9), within(0.1));
}

/// The number of a return in the middle of a wall of [`tunnel`].
fn within_wall() -> u32 {
    let (_, labels) = scan(&tunnel(), 360, |_| false);
    let middle = labels.windows(3).position(|three| three[0].is_some() && three.windows(2).all(|two| two[0] == two[1]));
    middle.expect("a wall of three returns") as u32
}

#[test]
fn of_openings_without_a_verdict_nothing_is_known() {
    let ((known, _), (unknown, odds)) = (of_tunnel(&|openings| openings.to_vec()), of_tunnel(&|_| Vec::new()));
    assert!(unknown < known, "{unknown} and {known}");
    assert_eq!(odds, [None; 2]);
}
