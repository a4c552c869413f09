//! Short pieces that stand free: pillars, legs of the vehicle, people. They are kept apart from the walls behind them.

use std::f64::consts::PI;

use crate::Lengths;
use crate::direction::direction;
use crate::pieces::{End, LEAST_WALL_RETURNS, Pieces};
use crate::ring::{Position, Ring};
use crate::roughness::Roughness;

/// The return seen past an end of an island is farther from the sensor than that end by at least this.
pub const BEHIND_M: f64 = 0.5;
/// The return seen past an end of an island is at most this far aside for each metre behind: 20° from the beam.
const STEEP: f64 = 0.363_970_234_266_202_36;
/// The return seen past an end of an island counts as at most this many beams away.
const STEP_BEAMS: usize = 3;
/// The return seen past an end of an island is farther from it than this many spacings of the island's own returns.
const SPACINGS: f64 = 2.0;
/// An island is off the line of a wall beside it by a passage and this many times the roughness of the walls: a vehicle
/// can pass between the two, and no bump stands out as far.
const BUMPS: f64 = 8.0;

/// The returns seen past both ends of a leg, of the vehicle or of a person, are at least this many times farther than the leg.
/// No bump of a wall stands out like that, so a leg may be nearer to the line of a wall than other islands.
const WELL_BEHIND: f64 = 1.5;
/// A leg is off the line of a wall by at least this.
const LEG_OFF_M: f64 = 0.3;
/// A leg is off the line of a wall by this many times the roughness of the walls more.
const LEG_BUMPS: f64 = 4.0;

/// An island is seen over less than this angle. What spans more of the view closes that side itself: what is seen past its
/// two ends is too far apart to be behind it.
pub const WIDEST_RAD: f64 = PI / 3.0;

/// The walls on both sides of a tip between two branches run towards it, and miss it by no more than this many times
/// the roughness of the walls, together. Such a tip hides its own walls.
const TIP_BUMPS: f64 = 120.0;
/// Two stretches on both sides of a shadow are of one wall if the cosine of the angle between them is more than this:
/// 36°.
const ALIKE: f64 = 0.809_016_994_374_947_5;
/// The line of a wall beside an island is taken over at most this many returns.
const LINE_RETURNS: usize = 14;
/// The line of a wall beside an island ends where two returns are farther from each other than this.
const LINE_STEP_M: f64 = 2.5;
/// At most this many islands stand beside each other.
const MOST_TOGETHER: usize = 2;

/// Whether nothing is seen beside the end `tip` of a piece, anticlockwise from one return to another, over more than a
/// vehicle of this width, so that it can pass there. The range reaches well behind the tip: nothing is there, and it is not
/// only too far to see.
pub fn faces_dark(ring: &Ring, tip: usize, [from, to]: [usize; 2], vehicle_m: f64) -> bool {
    let dark_rad = f64::from(ring.dark_between(from, to)) * ring.step_rad;
    dark_rad * ring.range_m(tip) > vehicle_m && ring.range_max_m > WELL_BEHIND * ring.range_m(tip)
}

/// The pieces of a scan that stand free.
#[derive(Clone, Debug, Default)]
pub struct Islands {
    /// The islands, nearest first.
    pub pieces: Pieces,
    /// For each return of the ring whether it is of an island.
    holds: Vec<bool>,
}

impl Islands {
    /// Takes the islands out of `pieces`, nearest first, so that one that another partly hides is found after that. Two
    /// that stand beside each other, neither of them behind the other, are found together.
    pub(crate) fn take(&mut self, ring: &Ring, roughness: &Roughness, pieces: &mut Pieces, lengths: &Lengths) {
        self.pieces.clear();
        self.holds.clear();
        self.holds.resize(ring.len(), false);
        while let Some((at, together)) = (PieceSearch { ring, roughness, pieces, islands: self, lengths }).nearest() {
            for _ in 0..together {
                // After the last piece comes the first.
                let at = if at < pieces.len() { at } else { 0 };
                for (k, i) in pieces.remove(at).enumerate() {
                    self.holds[i] = true;
                    self.pieces.push(i, k == 0);
                }
            }
        }
    }

    /// Whether at least half of the beams after a return and before another one, anticlockwise, end at islands.
    #[inline]
    pub fn shade(&self, ring: &Ring, from: usize, to: usize) -> bool {
        if to == from || to == from + 1 {
            return false; // The most common case: no return is between them.
        }
        let between = (from + 1..ring.len()).chain(0..from).take_while(|&i| i != to);
        let shaded = between.filter(|&i| self.holds[i]).count();
        2 * shaded >= ring.beams_from(from, to)
    }
}

/// One look for islands among pieces.
#[derive(Clone, Copy)]
struct PieceSearch<'a> {
    ring: &'a Ring,
    roughness: &'a Roughness,
    pieces: &'a Pieces,
    /// The islands that were found before.
    islands: &'a Islands,
    lengths: &'a Lengths,
}

impl PieceSearch<'_> {
    /// The nearest piece that stands free, and how many stand free together from there on: one, or as many as need be.
    fn nearest(&self) -> Option<(usize, usize)> {
        let range_m = |first: usize, together: usize| {
            let run = (0..together).flat_map(|step| &self.pieces[(first + step) % self.pieces.len()]);
            run.map(|&i| self.ring.range_m(i)).fold(f64::INFINITY, f64::min)
        };
        (1..=MOST_TOGETHER).find_map(|together| {
            let free = (0..self.pieces.len()).filter(|&at| self.stand_free(at, together));
            let nearest = free.min_by(|&a, &b| range_m(a, together).total_cmp(&range_m(b, together)))?;
            Some((nearest, together))
        })
    }

    /// Whether `together` neighbouring pieces, from `first` on, stand free.
    fn stand_free(&self, first: usize, together: usize) -> bool {
        let (ring, n) = (self.ring, self.pieces.len());
        let piece = |step: usize| &self.pieces[(first + step) % n];
        let are_of_vehicle = || (0..together).flat_map(piece).all(|&i| ring.range_m(i) < self.lengths.passage_m);
        let [begins_view, ends_view] = [first == 0, first + together >= n].map(|is_last| is_last && !ring.full_turn);
        // A piece at the end of the view may continue as a wall, unless it is nearer than a vehicle lets a wall come.
        if n <= together || ((begins_view || ends_view) && !are_of_vehicle()) {
            return false;
        }
        let run = [first, (first + together - 1) % n];
        let is_short = |piece: &[usize]| {
            let ends = [piece[0], piece[piece.len() - 1]];
            piece.iter().all(|&i| ends.iter().all(|&end| !ring.are_apart(end, i, self.lengths.island_m)))
        };
        let seen_at_rad = |piece: &[usize]| ring.span_rad(piece[0], piece[piece.len() - 1]);
        let is_before = |piece: &[usize], end: End, next: &[usize]| {
            self.hides(piece, end, next) || self.stands_in_dark(piece, end, next)
        };
        (0..together).all(|step| piece(step).len() >= LEAST_WALL_RETURNS)
            && (begins_view || is_before(piece(0), End::First, piece(n - 1)))
            && (ends_view || is_before(piece(together - 1), End::Last, piece(together)))
            && (0..together).all(|step| is_short(piece(step)) && seen_at_rad(piece(step)) < WIDEST_RAD)
            && (1..together).all(|step| {
                let (a, b) = (piece(step - 1), piece(step));
                !self.hides(a, End::Last, b) && !self.hides(b, End::First, a)
            })
            && (0..together).all(|step| !self.is_of_wall_beside(run, piece(step)))
    }

    /// Whether a piece of a run of pieces, from the first to the last of these, is the end of a wall beside the run, or
    /// the tip between two branches.
    fn is_of_wall_beside(&self, [first, last]: [usize; 2], piece: &[usize]) -> bool {
        let (ring, stretch_m) = (self.ring, self.lengths.stretch_m);
        let ends = [(first, End::First), (last, End::Last)];
        let offs_m = ends.map(|(at, end)| {
            let (tip, outer) = (end.at(&self.pieces[at], 0), self.beside(at, end).next()?);
            let (from, to) = if end == End::First { (outer, tip) } else { (tip, outer) };
            let line = self.line_beside(at, end, end.at(piece, 0))?;
            // Beyond the shadow of another island a line counts only if the piece runs as that wall does.
            let runs_alike = || {
                let along = direction(ring, self.roughness, piece, end, stretch_m);
                line.onward.dot(&if end == End::First { along } else { -along }) > ALIKE
            };
            (!self.islands.shade(ring, from, to) || runs_alike()).then_some(line.off_m)
        });
        let stands_well_before = |(at, end): (usize, End)| {
            let outer = self.beside(at, end).next();
            outer.is_none_or(|outer| ring.range_m(outer) >= WELL_BEHIND * ring.range_m(end.at(&self.pieces[at], 0)))
        };
        let rough_m = self.roughness.sd_m;
        let near_m = if ends.into_iter().all(stands_well_before) {
            LEG_OFF_M + LEG_BUMPS * rough_m
        } else {
            self.lengths.passage_m + BUMPS * rough_m
        };
        match offs_m {
            [Some(before_m), Some(after_m)] => {
                before_m.min(after_m) < near_m || before_m + after_m < TIP_BUMPS * rough_m
            }
            [one, other] => one.or(other).is_some_and(|off_m| off_m < near_m),
        }
    }

    /// Whether an end of a piece stands in front of the next piece there.
    fn hides(&self, piece: &[usize], end: End, next: &[usize]) -> bool {
        let (ring, tip, inner) = (self.ring, end.at(piece, 0), end.at(piece, 1));
        let outer = if end == End::First { next[next.len() - 1] } else { next[0] };
        let apart = ring.beams_apart(tip, outer).min(STEP_BEAMS) as f64;
        let behind_m = ring.range_m(outer) - ring.range_m(tip);
        let aside_m = ring.range_m(tip) * apart * ring.step_rad;
        behind_m > BEHIND_M
            && aside_m < STEEP * behind_m
            && ring.distance_m(tip, outer) > SPACINGS * ring.spacing_m(tip, inner) * apart
    }

    /// Whether a piece that is smaller than the vehicle ends beside the dark, where the vehicle can pass it.
    fn stands_in_dark(&self, piece: &[usize], end: End, next: &[usize]) -> bool {
        let (ring, vehicle_m) = (self.ring, self.lengths.passage_m);
        let (first, last) = (piece[0], piece[piece.len() - 1]);
        let beside = if end == End::First { [next[next.len() - 1], first] } else { [last, next[0]] };
        let is_small = || piece.iter().all(|&i| !ring.are_apart(first, i, vehicle_m));
        faces_dark(ring, end.at(piece, 0), beside, vehicle_m) && is_small()
    }

    /// The line of the wall beside one end of a piece, if that wall runs towards the return `target`.
    fn line_beside(&self, at: usize, end: End, target: usize) -> Option<LineBeside> {
        let ring = self.ring;
        let mut wall: Vec<usize> = Vec::with_capacity(LINE_RETURNS);
        for i in self.beside(at, end).take(LINE_RETURNS) {
            if wall.last().is_some_and(|&last| ring.distance_m(last, i) > LINE_STEP_M) {
                break;
            }
            wall.push(i);
        }
        if wall.len() < LEAST_WALL_RETURNS {
            return None;
        }
        let tip = wall[0];
        wall.reverse();
        let onward = direction(ring, self.roughness, &wall, End::Last, self.lengths.stretch_m);
        let towards = ring.position_m(target) - ring.position_m(tip);
        (onward.dot(&towards) > 0.0).then(|| LineBeside { onward, off_m: onward.perp(&towards).abs() })
    }

    /// The returns of the other pieces, walking away from one end of a piece.
    fn beside(&self, at: usize, end: End) -> impl Iterator<Item = usize> {
        let (pieces, n, backwards) = (self.pieces, self.pieces.len(), end == End::First);
        let count = match (self.ring.full_turn, backwards) {
            (true, _) => n - 1,
            (false, true) => at,
            (false, false) => n - 1 - at,
        };
        (1..=count).flat_map(move |step| {
            let piece = &pieces[if backwards { at + n - step } else { at + step } % n];
            (0..piece.len()).map(move |k| piece[if backwards { piece.len() - 1 - k } else { k }])
        })
    }
}

/// The line of a wall that runs towards a return.
struct LineBeside {
    onward: Position,
    /// The distance of the return from it.
    off_m: f64,
}
