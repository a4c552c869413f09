//! The answer over the last revolutions, and openings that are followed from one to the next.

use crosscut_stage::{Frame, Junction, wrap_angle_rad};
use nalgebra::Isometry2;

use crate::belief::{Answered, Belief, Since, elapsed_s};
use crate::beyond::KnownOpening;
use crate::{FlightAnswer, Here, HereKind, Steady, SteadyOpening, Way};

/// The way of a vehicle whose pose is not known, in a second.
const USUAL_SPEED_M_S: f64 = 1.0;

/// A turn of a radian shows as much as this way.
const WAY_M_PER_RAD: f64 = 0.5;

/// Between two revolutions no more time is taken to have passed: the recording has a hole, or its stamps jump.
const LONGEST_S: f64 = 1.0;

/// An opening is the one seen before if its bearing, in fixed axes, differs by no more than this.
const MOST_TURNED_RAD: f64 = 0.35;

/// A track ends if its opening is missing in more revolutions than this.
const MOST_MISSED: u32 = 10;

/// Follows the answers of a flight.
#[derive(Clone, Debug, Default)]
pub(crate) struct Steadier {
    /// That of the last pose.
    stretch: u32,
    before: Before,
    junctions: Belief<usize>,
    place: Belief<(HereKind, usize)>,
    tracks: Vec<Track>,
    next_track: u64,
    /// The tracks of the openings of the last revolution whose count held.
    shown: Vec<u64>,
    /// The place of the last revolution whose place held, its ways in fixed axes, and the track of each of them.
    here: Option<(Here, Vec<Option<u64>>)>,
}

/// The last revolutions that answered.
#[derive(Clone, Copy, Debug, Default)]
struct Before {
    count: Option<TakenAt>,
    place: Option<TakenAt>,
}

/// When and where a revolution was taken.
#[derive(Clone, Copy, Debug)]
struct TakenAt {
    stamp_ns: u64,
    pose: Option<Isometry2<f64>>,
}

impl TakenAt {
    fn since(&self, before: Option<Self>) -> Since {
        let Some(before) = before else { return Since { way_m: 0.0, time_s: LONGEST_S } };
        let time_s = elapsed_s(before.stamp_ns, self.stamp_ns).min(LONGEST_S);
        let way_m = before.pose.zip(self.pose).map_or(USUAL_SPEED_M_S * time_s, |(before, pose)| {
            let step = before.inv_mul(&pose);
            step.translation.vector.norm() + WAY_M_PER_RAD * step.rotation.angle().abs()
        });
        Since { way_m, time_s }
    }
}

/// An opening that is followed.
#[derive(Clone, Debug)]
struct Track {
    /// As it was seen last, its bearing in fixed axes.
    opening: SteadyOpening,
    /// Revolutions since it was seen.
    missed: u32,
}

impl Steadier {
    /// The steady answer at the next revolution, whose pose and place `flown` holds, with its openings by all that was seen; `None` until a
    /// revolution has returns.
    pub(crate) fn add(&mut self, frame: &Frame, flown: &FlightAnswer, known: &[KnownOpening]) -> Option<Steady> {
        // Revolutions of a new stretch do not go with those before.
        let stretch = flown.doubt.map(|doubt| doubt.stretch);
        if let Some(stretch) = stretch.filter(|stretch| *stretch != self.stretch) {
            *self = Self { stretch, next_track: self.next_track, ..Self::default() };
        }
        let now = TakenAt { stamp_ns: frame.revolution.stamp_ns, pose: flown.pose };
        let yaw_rad = flown.pose.map_or(0.0, |pose| pose.rotation.angle());
        // A scan without returns, such as one that cannot be decoded, shows nothing.
        if !frame.revolution.is_empty() {
            let junction = &frame.junction;
            let since = now.since(self.before.count.replace(now));
            let (answer, confidence) = (count(junction, known), junction.confidence.unwrap_or(0.0));
            let tracks = self.follow(known, yaw_rad);
            self.junctions.add(Answered { answer, confidence, since });
            if self.junctions.holds() == Some(answer) {
                self.shown.clone_from(&tracks);
            }
            if let Some(here) = &flown.here {
                let since = now.since(self.before.place.replace(now));
                let answer = (here.kind, here.ways.len());
                self.place.add(Answered { answer, confidence: here.confidence, since });
                if self.place.holds() == Some(answer) {
                    let track_of = |index| {
                        let at = known.iter().position(|opening| opening.index == Some(index));
                        at.map(|at| tracks[at])
                    };
                    let of_ways = here.ways.iter().map(|way| way.opening.and_then(track_of)).collect();
                    let fixed = |way: &Way| Way { bearing_rad: way.bearing_rad + yaw_rad, ..*way };
                    let ways = here.ways.iter().map(fixed).collect();
                    self.here = Some((Here { ways, ..*here }, of_ways));
                }
            }
            self.tracks.retain(|track| track.missed <= MOST_MISSED || self.shown.contains(&track.opening.track));
        }
        let junctions = self.junctions.holds()?;
        let openings = self.openings(yaw_rad);
        let here = self.place(&openings, yaw_rad, now.since(self.before.place));
        let is_known = |index: usize| known.iter().any(|opening| opening.index == Some(index));
        let closed = frame.junction.openings.iter().enumerate().filter(|(index, _)| !is_known(*index));
        let closed_rad = closed.map(|(_, opening)| opening.bearing_rad).collect();
        Some(Steady { junctions, here, openings, closed_rad })
    }

    /// The track of each opening. The nearest in bearing are joined first.
    fn follow(&mut self, openings: &[KnownOpening], yaw_rad: f64) -> Vec<u64> {
        let direction_rad = |opening: &KnownOpening| wrap_angle_rad(opening.bearing_rad + yaw_rad);
        let turned_rad =
            |track: &Track, opening: &KnownOpening| wrap_angle_rad(direction_rad(opening) - track.opening.bearing_rad);
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (at, track) in self.tracks.iter().enumerate() {
            let near =
                openings.iter().enumerate().map(|(index, opening)| (turned_rad(track, opening).abs(), at, index));
            pairs.extend(near.filter(|(turned_rad, ..)| *turned_rad <= MOST_TURNED_RAD));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.tracks.iter_mut().for_each(|track| track.missed = track.missed.saturating_add(1));
        let mut track_of: Vec<Option<usize>> = vec![None; openings.len()];
        for (_, at, index) in pairs {
            if self.tracks[at].missed > 0 && track_of[index].is_none() {
                (track_of[index], self.tracks[at].missed) = (Some(at), 0);
            }
        }
        let followed = |(before, opening): (Option<usize>, &KnownOpening)| {
            let before = before.map(|at| self.tracks[at].opening);
            let new = || {
                self.next_track += 1;
                self.next_track - 1
            };
            let track = before.map_or_else(new, |before| before.track);
            SteadyOpening {
                track,
                bearing_rad: direction_rad(opening),
                width_m: opening.width_m,
                p: opening.p,
                // Of a gap that neither this scan nor the cells see through, nothing is carried on: what was seen may lie elsewhere.
                seen_ns: opening.seen_ns.and(opening.seen_ns.max(before.and_then(|before| before.seen_ns))),
            }
        };
        let seen: Vec<SteadyOpening> = track_of.iter().copied().zip(openings).map(followed).collect();
        for (at, &opening) in track_of.iter().zip(&seen) {
            match at {
                Some(at) => self.tracks[*at].opening = opening,
                None => self.tracks.push(Track { opening, missed: 0 }),
            }
        }
        seen.iter().map(|opening| opening.track).collect()
    }

    /// The openings that are shown, in the present heading.
    fn openings(&self, yaw_rad: f64) -> Vec<SteadyOpening> {
        let shown = self.tracks.iter().map(|track| track.opening).filter(|opening| self.shown.contains(&opening.track));
        let turned = |opening: SteadyOpening| SteadyOpening {
            bearing_rad: wrap_angle_rad(opening.bearing_rad - yaw_rad),
            ..opening
        };
        let mut openings: Vec<_> = shown.map(turned).collect();
        openings.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
        openings
    }

    /// The last confirmed place, turned to the current heading; its confidence decays with `since`, the way and the time since the
    /// last revolution that showed a place.
    fn place(&self, openings: &[SteadyOpening], yaw_rad: f64, since: Since) -> Option<Here> {
        let (here, tracks) = self.here.as_ref()?;
        let confidence = self.place.confidence((here.kind, here.ways.len()), since);
        let index = |id: u64| openings.iter().position(|opening| opening.track == id);
        let way = |(way, track): (&Way, &Option<u64>)| Way {
            bearing_rad: wrap_angle_rad(way.bearing_rad - yaw_rad),
            opening: track.and_then(index),
            ..*way
        };
        let mut ways: Vec<Way> = here.ways.iter().zip(tracks).map(way).collect();
        ways.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
        Some(Here { confidence, ways, ..*here })
    }
}

/// The number of walls, with other openings than those of the scan: as many more or fewer, and never less than one.
fn count(junction: &Junction, openings: &[KnownOpening]) -> usize {
    let walls = |openings: usize| openings.max(1);
    (junction.junctions + walls(openings.len())).saturating_sub(walls(junction.openings.len()))
}
