//! Short pieces that stand free: pillars. Here they are kept from being tied to walls; whether what is tied together in the
//! end is called an island, the report says, by rules that hold for any affinity.

use super::Limits;
use super::joining::LEAST_RETURNS;
use super::pieces::{End, Pieces};
use super::ring::{Position, Ring};
use super::tangent::tangent;

/// What is seen past an end of an island lies at least this much farther.
const BEHIND_M: f64 = 0.5;
/// And so steeply behind it: how far aside for each metre behind, 20° from the beam, over at most [`STEP_BEAMS`] beams.
const STEEP: f64 = 0.363_970_234_266_202_36;
const STEP_BEAMS: usize = 3;
/// And so many times farther than the island's own spacing.
const SPACINGS: f64 = 2.0;
/// Between a wall and an island a vehicle can pass, so the island is as far off the line of the wall, and so many times
/// the roughness of the walls more, by which bumps may stand out.
const BUMPS: f64 = 8.0;
/// What is seen past both ends of a leg of the vehicle, or of somebody beside it, is so many times farther. No bump of a wall
/// stands before it like that, so it need not be as far off the line.
const WELL_BEHIND: f64 = 1.5;
const LEG_OFF_M: f64 = 0.3;
const LEG_BUMPS: f64 = 4.0;
/// The tip between two branches hides its own walls, and the more so the rougher they are: both run towards it, and
/// miss it by so many times their roughness, or less, together.
const TIP_BUMPS: f64 = 120.0;
/// Two stretches on both sides of a shadow are of one wall if the cosine of the angle between them is more than this: 36°.
const ALIKE: f64 = 0.809_016_994_374_947_5;
/// Lines of walls are taken over at most so many returns, none farther from the next than this.
const LINE_RETURNS: usize = 14;
const LINE_STEP_M: f64 = 2.5;
/// So many islands may stand beside each other.
const MOST_TOGETHER: usize = 2;

/// Takes the islands out of `pieces` into `islands`, nearest first, so that one that is partly hidden by another is
/// found after it. Two beside each other, neither of them behind the other, are found together.
pub(super) fn take(ring: &mut Ring, pieces: &mut Pieces, limits: &Limits, islands: &mut Pieces) {
    islands.clear();
    loop {
        let nearest = |together: usize| {
            let nearest_m = |first: usize| {
                let run = (0..together).flat_map(|step| &pieces[(first + step) % pieces.len()]);
                run.map(|&i| ring.range_m(i)).fold(f64::INFINITY, f64::min)
            };
            (0..pieces.len())
                .filter(|&at| stand_free(ring, pieces, at, together, limits))
                .min_by(|&a, &b| nearest_m(a).total_cmp(&nearest_m(b)))
        };
        let found = (1..=MOST_TOGETHER).find_map(|together| Some((nearest(together)?, together)));
        let Some((at, together)) = found else { return };
        for _ in 0..together {
            // After the last piece comes the first.
            let at = if at < pieces.len() { at } else { 0 };
            for (at, i) in pieces.remove(at).enumerate() {
                ring.take_for_island(i);
                islands.push(i, at == 0);
            }
        }
    }
}

/// Whether so many pieces that follow each other, from `first` on, stand free.
fn stand_free(ring: &Ring, pieces: &Pieces, first: usize, together: usize, limits: &Limits) -> bool {
    let n = pieces.len();
    let piece = |step: usize| &pieces[(first + step) % n];
    let of_vehicle = || (0..together).flat_map(piece).all(|&i| ring.range_m(i) < limits.passage_m);
    let [at_first, at_last] = [first == 0, first + together >= n].map(|is_last| is_last && !ring.full_turn);
    // What an end of the view cuts may be of a wall, unless it is nearer than a vehicle lets a wall come.
    if n <= together || ((at_first || at_last) && !of_vehicle()) {
        return false;
    }
    let run = [first, (first + together - 1) % n];
    let is_short = |piece: &[usize]| {
        let ends = [piece[0], piece[piece.len() - 1]];
        piece.iter().all(|&i| ends.iter().all(|&end| !ring.are_apart(end, i, limits.island_m)))
    };
    (0..together).all(|step| piece(step).len() >= LEAST_RETURNS)
        && (at_first || hides(ring, piece(0), End::First, piece(n - 1)))
        && (at_last || hides(ring, piece(together - 1), End::Last, piece(together)))
        && (0..together).all(|step| is_short(piece(step)))
        && (1..together).all(|step| {
            let (a, b) = (piece(step - 1), piece(step));
            !hides(ring, a, End::Last, b) && !hides(ring, b, End::First, a)
        })
        && (0..together).all(|step| !is_of_wall_beside(ring, pieces, run, piece(step), limits))
}

/// Whether a piece of a run, from the first to the last, is the end of a wall beside the run, or the tip between two.
/// Beyond the shadow of an island that was found before, nothing says so.
fn is_of_wall_beside(
    ring: &Ring,
    pieces: &Pieces,
    [first, last]: [usize; 2],
    piece: &[usize],
    limits: &Limits,
) -> bool {
    let ends = [(first, End::First), (last, End::Last)];
    let offs_m = ends.map(|(at, end)| {
        let (tip, outer) = (end.at(&pieces[at], 0), beside(ring, pieces, at, end).next()?);
        let (from, to) = if end == End::First { (outer, tip) } else { (tip, outer) };
        let line = line_beside(ring, beside(ring, pieces, at, end), end.at(piece, 0), limits.stretch_m)?;
        // What lies in a shadow says nothing, but that a wall goes on which runs as the one before it does.
        let runs_alike = || {
            let along = tangent(ring, piece, end, limits.stretch_m);
            line.onward.dot(&if end == End::First { along } else { -along }) > ALIKE
        };
        (!ring.is_shaded(from, to) || runs_alike()).then_some(line.off_m)
    });
    let stands_well_before = |(at, end): (usize, End)| {
        let outer = beside(ring, pieces, at, end).next();
        outer.is_none_or(|outer| ring.range_m(outer) >= WELL_BEHIND * ring.range_m(end.at(&pieces[at], 0)))
    };
    let near_m = if ends.into_iter().all(stands_well_before) {
        LEG_OFF_M + LEG_BUMPS * ring.roughness.off_m
    } else {
        limits.passage_m + BUMPS * ring.roughness.off_m
    };
    let is_tip = |[before_m, after_m]: [f64; 2]| before_m + after_m < TIP_BUMPS * ring.roughness.off_m;
    match offs_m {
        [Some(before_m), Some(after_m)] => before_m.min(after_m) < near_m || is_tip([before_m, after_m]),
        [one, other] => one.or(other).is_some_and(|off_m| off_m < near_m),
    }
}

/// Whether an end of a piece stands in front of the piece next to it there.
fn hides(ring: &Ring, piece: &[usize], end: End, next: &[usize]) -> bool {
    let (tip, inner) = (end.at(piece, 0), end.at(piece, 1));
    let outer = if end == End::First { next[next.len() - 1] } else { next[0] };
    let apart = ring.beams_apart(tip, outer);
    let behind_m = ring.range_m(outer) - ring.range_m(tip);
    let aside_m = ring.range_m(tip) * apart.min(STEP_BEAMS) as f64 * ring.step_rad;
    behind_m > BEHIND_M
        && aside_m < STEEP * behind_m
        && ring.distance_m(tip, outer) > SPACINGS * ring.spacing_m(tip, inner) * apart.min(STEP_BEAMS) as f64
}

/// The line of a wall that runs towards a return.
struct LineBeside {
    onward: Position,
    /// How far the return lies off it.
    off_m: f64,
}

/// The line of the wall of which these are the returns `beside` another one, nearest first, if that runs towards it.
fn line_beside(ring: &Ring, beside: impl Iterator<Item = usize>, target: usize, stretch_m: f64) -> Option<LineBeside> {
    let mut wall: Vec<usize> = Vec::with_capacity(LINE_RETURNS);
    for i in beside.take(LINE_RETURNS) {
        if wall.last().is_some_and(|&last| ring.distance_m(last, i) > LINE_STEP_M) {
            break;
        }
        wall.push(i);
    }
    if wall.len() < LEAST_RETURNS {
        return None;
    }
    let tip = wall[0];
    wall.reverse();
    let onward = tangent(ring, &wall, End::Last, stretch_m);
    let towards = ring.position_m(target) - ring.position_m(tip);
    (onward.dot(&towards) > 0.0).then(|| LineBeside { onward, off_m: onward.perp(&towards).abs() })
}

/// The returns of the other pieces, walking away from one end of a piece.
fn beside(ring: &Ring, pieces: &Pieces, at: usize, end: End) -> impl Iterator<Item = usize> {
    let (n, backwards) = (pieces.len(), end == End::First);
    let count = match (ring.full_turn, backwards) {
        (true, _) => n - 1,
        (false, true) => at,
        (false, false) => n - 1 - at,
    };
    (1..=count).flat_map(move |step| {
        let piece = &pieces[if backwards { at + n - step } else { at + step } % n];
        (0..piece.len()).map(move |k| piece[if backwards { piece.len() - 1 - k } else { k }])
    })
}
