//! The properties that the rest of the program relies on in an affinity. Each function panics and names the defect.

use crosscut_stage::{
    Affinity, AffinityStage, Invariance, Kind, Notes, Params, Point, Revolution, StageError, wrap_angle_rad,
};
use nalgebra::{Rotation3, Vector3};
use proptest::collection::vec;
use proptest::prelude::{Strategy, any, prop_oneof};

use crate::for_many;
use crate::revolutions::{cloud, scan};

type AffinityKind = Kind<dyn AffinityStage>;

/// Random inputs of a test.
const CASES: u32 = 100;

/// All that follows.
pub fn all(kind: &AffinityKind) {
    w_is_symmetric_with_entries_in_0_to_1_and_ones_on_the_diagonal(kind);
    a_used_stage_and_a_used_buffer_give_the_same_bits_as_new_ones(kind);
    few_returns_and_returns_in_one_place_have_defined_graphs(kind);
    w_is_blind_to_what_the_kind_states(kind);
}

fn build(kind: &AffinityKind) -> Box<dyn AffinityStage> {
    kind.build(&Params::defaults(kind.params))
}

/// The graph of a revolution; none of a cloud if the kind needs beams.
fn graph(kind: &AffinityKind, revolution: &Revolution) -> Option<Affinity> {
    let mut out = Affinity::default();
    match build(kind).affinity(revolution, &mut out, &mut Notes::default()) {
        Ok(()) => Some(out),
        Err(StageError::Unsupported(_)) if revolution.sweep.is_none() && kind.properties.needs_beams => None,
        Err(error) => panic!("{}: {error}", kind.name),
    }
}

/// How many rows W has: one for each return, or for each direction.
fn rows(affinity: &Affinity, revolution: &Revolution) -> usize {
    affinity.dual.as_ref().map_or(revolution.len(), |dual| dual.rows().count())
}

fn any_revolution() -> impl Strategy<Value = Revolution> {
    prop_oneof![4 => scan(0..80), 1 => scan(0..4), 4 => cloud(0..40)]
}

/// W is n×n, exactly symmetric, with 0 <= W_ij <= 1 and W_ii = 1.
pub fn w_is_symmetric_with_entries_in_0_to_1_and_ones_on_the_diagonal(kind: &AffinityKind) {
    for_many(kind.name, CASES, &any_revolution(), |revolution| {
        let Some(affinity) = graph(kind, &revolution) else { return };
        let w = affinity.weights.to_dense();
        let n = rows(&affinity, &revolution);
        assert_eq!((w.nrows(), w.ncols()), (n, n));
        for j in 0..w.ncols() {
            assert_eq!(w[(j, j)], 1.0, "diagonal at {j}");
            for i in 0..j {
                assert_eq!(w[(i, j)].to_bits(), w[(j, i)].to_bits(), "symmetry at {i}, {j}");
                assert!((0.0..=1.0).contains(&w[(i, j)]), "W[{i}, {j}] = {}", w[(i, j)]);
            }
        }
    });
}

/// Nothing is left over from one revolution to the next, nor from another kind's W, dense or sparse.
pub fn a_used_stage_and_a_used_buffer_give_the_same_bits_as_new_ones(kind: &AffinityKind) {
    for_many(kind.name, CASES, &(scan(40..80), scan(0..20)), |(big, small)| {
        let (mut stage, mut out) = (build(kind), Affinity::default());
        for (at, revolution) in [&big, &small, &big, &small].into_iter().enumerate() {
            match at {
                2 => out.weights.make_dense(3).fill(7.0),
                3 => out.weights.make_sparse().push_row(&[0, 5], &[7.0, 7.0]),
                _ => {}
            }
            stage.affinity(revolution, &mut out, &mut Notes::default()).expect("a scan is enough for every kind");
            let fresh = graph(kind, revolution).expect("a scan is enough for every kind");
            assert_eq!(format!("{:?}", out.weights.to_dense()), format!("{:?}", fresh.weights.to_dense()));
            assert_eq!((&out.degrees, &out.verdicts), (&fresh.degrees, &fresh.verdicts));
        }
    });
}

/// No return, one return, and several in one place have a graph, each return a degree from 1 to n.
pub fn few_returns_and_returns_in_one_place_have_defined_graphs(kind: &AffinityKind) {
    for n in [0, 1, 2, 5] {
        let revolution = Revolution { points_m: vec![Point::new(2.0, 1.0, 0.0); n], ..Revolution::default() };
        let Some(affinity) = graph(kind, &revolution) else { continue };
        let n = rows(&affinity, &revolution);
        assert_eq!((affinity.weights.n(), affinity.degrees.len()), (n, n), "{}", kind.name);
        assert!(affinity.degrees.iter().all(|d| (1.0..=n as f64).contains(d)), "{}: {affinity:?}", kind.name);
    }
}

/// Each [`Invariance`] that the kind states holds.
pub fn w_is_blind_to_what_the_kind_states(kind: &AffinityKind) {
    let motion = ([-20.0..20.0f64, -20.0..20.0f64, -20.0..20.0f64], [-3.0..3.0f64, -3.0..3.0f64, -3.0..3.0f64]);
    for_many(kind.name, CASES, &(any_revolution(), motion, vec(any::<u32>(), 80)), |(revolution, motion, keys)| {
        for &invariance in kind.properties.blind_to {
            let mut order: Vec<usize> = (0..revolution.len()).collect();
            if invariance == Invariance::Permutation {
                order.sort_by_key(|&i| keys[i]);
            }
            let changed = change(&revolution, invariance, motion, &order);
            let (Some(before), Some(after)) = (graph(kind, &revolution), graph(kind, &changed)) else { continue };
            let (before, after) = (before.weights.to_dense(), after.weights.to_dense());
            for (row, &i) in order.iter().enumerate() {
                for (column, &j) in order.iter().enumerate() {
                    let (was, is) = (before[(i, j)], after[(row, column)]);
                    assert!((was - is).abs() < 1e-10, "{invariance:?} changed W[{i}, {j}] from {was} to {is}");
                }
            }
        }
    });
}

/// The revolution changed: moved by the first or turned by the second half of `motion`, or its returns in `order`.
/// A change that no beam could follow takes the beams away.
fn change(
    revolution: &Revolution,
    invariance: Invariance,
    (shift_m, axis_angle_rad): ([f64; 3], [f64; 3]),
    order: &[usize],
) -> Revolution {
    let mut changed = revolution.clone();
    let turn_rad = axis_angle_rad[2];
    match invariance {
        Invariance::Translation | Invariance::Rotation | Invariance::Permutation => changed.sweep = None,
        Invariance::Turn | Invariance::Mirror => {
            for bearing_rad in changed.sweep.iter_mut().flat_map(|sweep| &mut sweep.bearings_rad) {
                let turned = if invariance == Invariance::Turn { *bearing_rad + turn_rad } else { -*bearing_rad };
                *bearing_rad = wrap_angle_rad(turned);
            }
        }
    }
    for (point, &from) in changed.points_m.iter_mut().zip(order) {
        let p = revolution.points_m[from];
        *point = match invariance {
            Invariance::Translation => p + Vector3::from(shift_m),
            Invariance::Rotation => Rotation3::new(Vector3::from(axis_angle_rad)) * p,
            Invariance::Turn => Rotation3::new(Vector3::z() * turn_rad) * p,
            Invariance::Mirror => Point::new(p.x, -p.y, p.z),
            Invariance::Permutation => p,
        };
    }
    changed
}
