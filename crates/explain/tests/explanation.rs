//! Explanations of graphs small enough to be worked out by hand.

use crosscut_explain::{Edge, Event, Explanation, Watch, ways};
use crosscut_stage::NoteCode::N101;
use crosscut_stage::{
    Beam, Between, Cell, Dual, Evidence, Frame, Measured, Place, Point, Sweep, Verdict, Wall, Way, Weights,
};
use faer::Mat;

/// Returns along a line at these places, with W = exp(-σ d²), in walls.
fn gaussian(places_m: &[f64], walls: &[Option<u32>], sigma_per_m2: f64) -> Frame {
    let n = places_m.len();
    let weight = |i: usize, j: usize| (-sigma_per_m2 * (places_m[i] - places_m[j]).powi(2)).exp();
    let mut frame = Frame::default();
    frame.revolution.points_m = places_m.iter().map(|&x| Point::new(x, 0.0, 0.0)).collect();
    frame.junction.wall_of_return = walls.to_vec();
    *frame.affinity.weights.make_dense(n) = Mat::from_fn(n, n, weight);
    set_degrees(&mut frame);
    frame
}

fn set_degrees(frame: &mut Frame) {
    let mut degrees = vec![0.0; frame.affinity.weights.n()];
    frame.affinity.weights.for_each(|i, _, w| degrees[i] += w);
    frame.affinity.degrees = degrees;
}

/// The frame with W in sparse form, by its entries above `least`.
fn sparse(frame: &Frame, least: f64) -> Frame {
    let Weights::Dense(w) = &frame.affinity.weights else { panic!("dense") };
    let mut other = frame.clone();
    let entries = other.affinity.weights.make_sparse();
    for i in 0..w.nrows() {
        for j in (0..w.ncols()).filter(|&j| w[(i, j)] > least) {
            entries.push(j as u32, w[(i, j)]);
        }
        entries.end_row();
    }
    set_degrees(&mut other);
    other
}

/// Eigenvalues of L, computed by faer.
fn with_spectrum(mut frame: Frame, tolerance: f64) -> Frame {
    let (n, degrees) = (frame.affinity.weights.n(), frame.affinity.degrees.clone());
    let mut laplacian = Mat::<f64>::identity(n, n);
    frame.affinity.weights.for_each(|i, j, w| laplacian[(i, j)] -= w / (degrees[i] * degrees[j]).sqrt());
    let values = laplacian.self_adjoint_eigenvalues(faer::Side::Lower).expect("it converges");
    frame.spectrum.k = values.iter().filter(|&&value| value < tolerance).count();
    (frame.spectrum.eigenvalues, frame.spectrum.tolerance) = (values, tolerance);
    frame
}

/// Wall 0 at 0, 1, 2 and, after a gap of 1.5 m, 3.5; wall 1 from 6.5 on.
const PLACES_M: [f64; 7] = [0.0, 1.0, 2.0, 3.5, 6.5, 7.5, 8.6];
const WALLS: [Option<u32>; 7] = [Some(0), Some(0), Some(0), Some(0), Some(1), Some(1), Some(1)];

fn sorted(edge: Option<Edge>) -> Option<[usize; 2]> {
    edge.map(|edge| [edge.returns[0].min(edge.returns[1]), edge.returns[0].max(edge.returns[1])])
}

#[test]
fn the_weakest_edge_is_the_bottleneck_and_not_the_smallest_weight() {
    let dense = gaussian(&PLACES_M, &WALLS, 1.5);
    for frame in [dense.clone(), sparse(&dense, 1e-4)] {
        let explanation = Explanation::of(&frame);
        assert_eq!(sorted(explanation.walls[0].weakest), Some([2, 3]), "the gap, not the ends at 0 and 3.5 m");
        assert_eq!(explanation.walls[0].weakest.map(|edge| edge.weight), Some((-1.5f64 * 2.25).exp()));
        assert_eq!(explanation.walls[0].parts, 1);
    }
}

#[test]
fn dense_and_sparse_w_are_explained_alike() {
    let dense = gaussian(&PLACES_M, &WALLS, 0.3);
    let [a, b] = [Explanation::of(&dense), Explanation::of(&sparse(&dense, 0.0))];
    for (a, b) in a.walls.iter().zip(&b.walls) {
        assert_eq!((sorted(a.weakest), a.parts), (sorted(b.weakest), b.parts));
        assert_eq!(sorted(a.strongest.map(|s| s.1)), sorted(b.strongest.map(|s| s.1)));
        assert!((a.breaks_at - b.breaks_at).abs() < 1e-12 && (a.parts_at - b.parts_at).abs() < 1e-12);
    }
}

#[test]
fn the_strongest_edge_between_walls_joins_the_two_nearest_returns() {
    let explanation = Explanation::of(&gaussian(&PLACES_M, &WALLS, 1.5));
    let (to, edge) = explanation.walls[0].strongest.unwrap();
    assert_eq!((sorted(Some(edge)), to), (Some([3, 4]), 1));
    assert_eq!(edge.weight, (-1.5f64 * 9.0).exp());
    assert_eq!(explanation.closest, None, "given only where W has no edge");
}

#[test]
fn eigenvalues_beside_the_tolerance_are_attributed_to_their_edges() {
    let frame = with_spectrum(gaussian(&PLACES_M, &WALLS, 1.5), 1e-4);
    assert_eq!(frame.spectrum.k, 2);
    let explanation = Explanation::of(&frame);
    let fewer = explanation.changes.iter().find(|change| change.k == 1).unwrap();
    assert_eq!((sorted(fewer.edge), fewer.walls.len()), (Some([3, 4]), 2));
    assert_eq!(fewer.eigenvalue, frame.spectrum.eigenvalues[1]);
    let more = explanation.changes.iter().find(|change| change.k == 3).unwrap();
    assert_eq!((sorted(more.edge), more.walls.as_slice()), (Some([2, 3]), &[0][..]));
    assert!(explanation.changes[0].decades <= explanation.changes[1].decades, "the nearer first");
}

#[test]
fn the_sigma_that_is_named_changes_the_count() {
    let frame = with_spectrum(gaussian(&PLACES_M, &WALLS, 1.5), 1e-4);
    for change in Explanation::of(&frame).changes {
        let sigma = change.sigma_per_m2.unwrap();
        // "About": a tenth beyond it the count is the one that was named.
        let beyond = if change.k > frame.spectrum.k { 1.1 * sigma } else { sigma / 1.1 };
        assert_eq!(with_spectrum(gaussian(&PLACES_M, &WALLS, beyond), 1e-4).spectrum.k, change.k);
    }
}

#[test]
fn no_distant_sigma_is_named() {
    let frame = with_spectrum(gaussian(&PLACES_M, &WALLS, 1.5), 1e-5);
    let changes = Explanation::of(&frame).changes;
    assert!(changes.iter().all(|change| change.edge.is_some()), "{changes:?}");
    let named: Vec<(usize, bool)> = changes.iter().map(|change| (change.k, change.sigma_per_m2.is_some())).collect();
    assert_eq!(named, [(1, true), (3, false)], "to break a wall would take a σ of 5.2 per m²: {changes:?}");
}

#[test]
fn no_sigma_is_named_for_weights_that_are_not_gaussian() {
    let mut frame = gaussian(&PLACES_M, &WALLS, 1.5);
    let w = frame.affinity.weights.make_dense(7);
    *w = Mat::from_fn(7, 7, |i, j| 0.1f64.powi(i32::from(i.abs_diff(j) as u16)));
    set_degrees(&mut frame);
    let explanation = Explanation::of(&with_spectrum(frame, 0.05));
    assert!(!explanation.changes.is_empty());
    assert!(explanation.changes.iter().all(|change| change.sigma_per_m2.is_none()));
}

#[test]
fn no_tolerance_undoes_a_zero_of_rounding() {
    let apart = sparse(&gaussian(&PLACES_M, &WALLS, 1.5), 1e-3);
    let mut frame = with_spectrum(apart, 1e-4);
    let fewer = |eigenvalue: f64| {
        frame.spectrum.eigenvalues[1] = eigenvalue;
        let changes = Explanation::of(&frame).changes;
        assert!(changes.iter().any(|change| change.k > frame.spectrum.k), "τ may rise: {changes:?}");
        changes.iter().any(|change| change.k < frame.spectrum.k)
    };
    assert_eq!([1e-16, 1e-9].map(fewer), [false, true]);
}

#[test]
fn walls_without_edges_between_them_name_their_closest_returns() {
    let frame = sparse(&gaussian(&PLACES_M, &WALLS, 1.5), 1e-3);
    let explanation = Explanation::of(&frame);
    assert!(explanation.walls.iter().all(|wall| wall.strongest.is_none()));
    assert_eq!(explanation.closest, Some(([0, 1], [3, 4])));
}

#[test]
fn a_wall_that_w_splits_is_reported_in_parts() {
    let dense = gaussian(&PLACES_M, &[Some(0); 7], 1.5);
    let mut cut = dense.clone();
    let w = cut.affinity.weights.make_dense(7);
    *w = Mat::from_fn(7, 7, |i, j| f64::from(u8::from((i < 4) == (j < 4))));
    set_degrees(&mut cut);
    for frame in [cut, sparse(&dense, 1e-3)] {
        let explanation = Explanation::of(&frame);
        assert_eq!((explanation.walls[0].parts, explanation.walls[0].weakest), (2, None));
        let text = explanation.to_markdown(&frame, &|_| "blue");
        assert!(text.contains("2 parts without an edge"), "{text}");
    }
}

#[test]
fn the_text_names_beams_distances_weights_and_notes() {
    let mut frame = with_spectrum(gaussian(&PLACES_M, &WALLS, 1.5), 1e-4);
    let mut beams: Vec<Beam> = (0..7).map(Beam::Return).collect();
    beams.insert(3, Beam::NoReturn);
    frame.revolution.sweep = Some(Sweep { beams, ..Sweep::default() });
    frame.notes.add(N101, "3 beams masked");
    frame.junction.junctions = 2;
    let wall = |id, returns| Wall { id, returns, bearing_rad: [0.0; 2], island: false };
    frame.junction.walls = vec![wall(0, 4), wall(1, 3)];
    let text = Explanation::of(&frame).to_markdown(&frame, &|wall| ["blue", "orange"][wall as usize]);
    for expected in [
        "## 2 walls.\n\n**Without wall 1 (orange), which has 3 returns, there would be 1 wall. There would be 1 wall if wall 1 \
         (orange) and wall 0 (blue) were one: their ends are 3.0 m apart.**",
        "k = 2 zeros of L",
        "beams 4, 5: 3.00 m",
        "beams 2, 4: 1.50 m",
        "wall 0 (blue)**, 4 returns: ",
        "- 3 beams masked",
        "1 have no return",
    ] {
        assert!(text.contains(expected), "{expected} is missing:\n{text}");
    }
}

#[test]
fn empty_and_inconsistent_frames_are_explained_without_a_panic() {
    let empty = Frame::default();
    assert!(Explanation::of(&empty).to_markdown(&empty, &|_| "").starts_with("## No wall: the scan has no return."));
    let mut torn = gaussian(&PLACES_M, &WALLS, 1.5);
    torn.junction.wall_of_return.pop();
    assert_eq!(Explanation::of(&torn).walls, []);
    let single = gaussian(&[0.0], &[Some(0)], 1.5);
    assert_eq!(Explanation::of(&single).walls[0].weakest, None);
}

#[test]
fn a_changed_count_and_a_new_low_margin_are_reported_once() {
    let frame = |junctions: usize, margin: f64| {
        let mut frame = Frame::default();
        (frame.junction.junctions, frame.junction.place) = (junctions, Place::Tee);
        frame.spectrum.margin_decades = Some(margin);
        frame
    };
    let mut watch = Watch::default();
    let flight = [(3, 2.0), (3, 0.4), (3, 0.2), (4, 0.7), (4, 0.3), (4, 1.5), (4, 0.1)];
    let reported: Vec<Vec<String>> = flight
        .map(|(junctions, margin)| watch.events(&frame(junctions, margin), None).iter().map(Event::to_string).collect())
        .to_vec();
    assert_eq!(reported[1], ["low margin: k = 0 holds by 0.40 decades"]);
    assert_eq!(reported[3], ["3 → 4 walls (tee)"]);
    assert_eq!(reported[6], ["low margin: k = 0 holds by 0.10 decades"]);
    assert!([0, 2, 4, 5].iter().all(|&i| reported[i].is_empty()), "{reported:?}");
}

#[test]
fn a_wrong_count_is_reported_when_it_begins() {
    let mut watch = Watch::default();
    let flight = [(3, Some(3)), (4, Some(3)), (4, Some(3)), (3, Some(3)), (3, None), (2, Some(3))];
    let is_wrong = |(junctions, truth)| {
        let mut frame = Frame::default();
        frame.junction.junctions = junctions;
        watch.events(&frame, truth).iter().map(Event::to_string).find(|event| event.starts_with("wrong"))
    };
    let reported = flight.map(is_wrong);
    assert_eq!(reported[1].as_deref(), Some("wrong: 4 counted, 3 in truth"));
    assert_eq!(reported[5].as_deref(), Some("wrong: 2 counted, 3 in truth"));
    assert!([0, 2, 3, 4].iter().all(|&i| reported[i].is_none()), "{reported:?}");
}

#[test]
fn the_sentence_goes_by_the_verdict_that_is_nearest_to_another_one() {
    let mut frame = with_spectrum(gaussian(&PLACES_M, &WALLS, 1.5), 1e-4);
    frame.junction.junctions = 2;
    let colors = |wall: u32| ["blue", "orange"][wall as usize];
    let verdict = |returns, is_opening, room_ratio| Verdict {
        returns,
        is_opening,
        room_ratio,
        reason: "width",
        p: None,
        measured: None,
    };
    let mut sentence = |verdicts| {
        frame.affinity.verdicts = verdicts;
        Explanation::of(&frame).sentence(&frame, &colors)[1].clone()
    };
    let opening = verdict([3, 4], true, 3.0);
    assert_eq!(
        sentence(vec![opening]),
        "There would be 1 wall if wall 0 (blue) and wall 1 (orange) were one: their ends are 3.0 m apart."
    );
    let inside = verdict([2, 3], false, 0.8);
    assert_eq!(
        sentence(vec![opening, inside]),
        "There would be 3 walls if wall 0 (blue) were two: neighbours in it are 1.5 m apart."
    );
    assert_eq!(sentence(vec![verdict([2, 3], false, 0.0)]), sentence(vec![]), "a gap without room is not near");
}

#[test]
fn a_wall_inside_a_gap_may_be_none() {
    let walls = [Some(0), Some(0), Some(0), Some(0), Some(2), Some(1), Some(1)];
    let mut frame = with_spectrum(gaussian(&PLACES_M, &walls, 1.5), 1e-4);
    let wall = |id, returns| Wall { id, returns, bearing_rad: [0.0; 2], island: false };
    frame.junction.walls = vec![wall(0, 40), wall(1, 20), wall(2, 10)];
    frame.junction.junctions = 3;
    let judged =
        Verdict { returns: [3, 5], is_opening: true, room_ratio: 40.0, reason: "width", p: None, measured: None };
    frame.affinity.verdicts = vec![judged];
    let explanation = Explanation::of(&frame);
    assert_eq!(explanation.may_be_none, Some(2));
    let [_, nearest] = explanation.sentence(&frame, &|_| "");
    assert!(
        nearest.starts_with("Without wall 2, which stands free inside a gap, there would be 2 walls."),
        "{nearest}"
    );
}

#[test]
fn a_place_with_fewer_openings_than_walls_says_where_there_is_none() {
    let mut frame = with_spectrum(gaussian(&PLACES_M, &WALLS, 1.5), 1e-4);
    (frame.junction.junctions, frame.junction.place) = (2, Place::DeadEnd);
    let text = || Explanation::of(&frame).to_markdown(&frame, &|_| "");
    assert!(
        text().contains("Place: dead end, by its 0 openings; there is none between wall 0 and wall 1. k = 2"),
        "{}",
        text()
    );
}

#[test]
fn a_count_that_no_edge_explains_is_told_by_the_spectrum() {
    let mut frame = with_spectrum(gaussian(&PLACES_M, &WALLS, 1.5), 1e-4);
    frame.junction.junctions = 2;
    *frame.affinity.weights.make_dense(7) = Mat::from_fn(7, 7, |i, j| if i == j { 1.0 } else { 0.5 });
    set_degrees(&mut frame);
    (frame.spectrum.eigenvalues, frame.spectrum.tolerance) = (vec![0.0, 9e-5, 2e-2], 1e-4);
    let explanation = Explanation { closest: None, ..Explanation::of(&frame) };
    let [_, nearest] = explanation.sentence(&frame, &|_| "");
    let expected = "1 eigenvalue would count as zero, not 2, with a tolerance below 9.0e-5 (λ2), 0.0 decades from τ";
    assert!(nearest.starts_with(expected) && nearest.ends_with("No single edge decides that."), "{nearest}");
}

#[test]
fn verdicts_closest_to_the_threshold_come_first() {
    let mut frame = with_spectrum(gaussian(&PLACES_M, &WALLS, 1.0), 1e-3);
    let verdict = |returns, is_opening, room_ratio| Verdict {
        returns,
        is_opening,
        room_ratio,
        reason: "width",
        p: Some(0.25),
        measured: None,
    };
    let narrow = Measured::metres("what is seen on its two sides leaves", 0.35, "the vehicle needs", 0.6);
    let slit = Verdict { measured: Some(narrow), reason: "a slit", ..verdict([1, 2], false, 0.0) };
    frame.affinity.verdicts =
        vec![verdict([0, 1], false, 0.01), slit, verdict([3, 4], true, 1.1), verdict([2, 3], false, 0.8)];
    let text = Explanation::of(&frame).to_markdown(&frame, &|_| "grey");
    let reported: Vec<_> =
        text.lines().filter(|line| line.starts_with("- an o") || line.starts_with("- the w")).collect();
    assert_eq!(
        reported,
        [
            "- an opening between wall 0 (grey) and wall 1 (grey) (returns 3, 4: 3.00 m): **1.10** times the room that an opening needs (width), \
             p = 0.25, overruled by the rule",
            "- the wall continues in wall 0 (grey) (returns 2, 3: 1.50 m): **0.80** times the room that an opening needs (width), p = 0.25",
            "- the wall continues in wall 0 (grey) (returns 0, 1: 1.00 m): **0.01** times the room that an opening needs (width), p = 0.25",
            "- the wall continues in wall 0 (grey) (returns 1, 2: 1.00 m): **what is seen on its two sides leaves 0.35 m; the vehicle needs 0.60 m** \
             (a slit; 0.00), p = 0.25",
        ]
    );
}

#[test]
fn ways_say_in_metres_what_parts_them_by_the_numbers_of_the_report() {
    let to = |x, y, z| Point::new(x, y, z).coords;
    let way = |[x, y, z]: [f64; 3], clearance_m, p, is_wide| Way {
        direction: to(x, y, z),
        slope_rad: z.asin(),
        clearance_m,
        p,
        evidence: Evidence::SeenThrough,
        cut_by_view: is_wide,
        is_wide,
    };
    let [raise, left] = [way([0.0, 0.0, 1.0], 2.44, 0.98, false), way([0.0, 1.0, 0.0], 3.0, 0.6, true)];
    let cell = |direction, reach_m, way| Cell { direction, range_m: reach_m, reach_m, way };
    let mut frame = Frame::default();
    frame.affinity.dual = Some(Dual {
        cells: vec![cell(to(0.0, 1.0, 0.0), 14.2, Some(1)), cell(to(0.0, 0.0, 1.0), f64::INFINITY, Some(0))],
        ways: vec![raise, left],
        between: vec![Between { ways: [0, 1], direction: to(0.0, 0.6, 0.8), reach_m: 2.94 }],
        tilt: Default::default(),
        view_rad: [-1.0, 1.5],
        room_m: 1.87,
        cut_m: 4.2,
        on_m: 4.6,
    });
    frame.junction.ways = Some(vec![left, raise]); // by bearing
    let parted = "Between way 1 (red) and way 0 (red), at +90°, 53° up, the vehicle gets 2.9 m far; with 4.2 m they would be one.";
    assert_eq!(
        ways(&frame, &|_| "red"),
        [
            "**way 0 (red)**, level at +90°, 0° up: 3.0 m, p = 0.60: the vehicle gets 14.2 m far in it, and 4.6 m make a way. It goes \
             on beyond the view: this is of the part in view. It takes up half a turn, or a third of all directions, as in a place that \
             is wide for its height: it may be several ways.",
            "**way 1 (red)**, shaft up at +0°, 90° up: 2.4 m, p = 0.98: the vehicle gets as far as the sensor sees in it, and 4.6 m \
             make a way.",
            parted
        ]
    );
    let [title, reason] = Explanation::of(&frame).sentence(&frame, &|_| "red");
    assert_eq!(title, "2 ways on. Level view: no wall.");
    assert!(
        reason.starts_with(
            "R is 1.9 m: the radius of the largest ball that holds the sensor. The least sure is level at"
        ) && reason.ends_with(parted),
        "{reason}"
    );
}
