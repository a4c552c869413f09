//! Named families of scenes, for development and for reports.

use crate::cloud::{Cloud, Rings};
use crate::junction::Places;
use crate::lidar::Lidar;
use crate::presets;
use crate::scene::{FIRST_STAMP_NS, Flight, Scene};

/// Number of scenes in every family.
pub const SCENES: usize = 600;
/// Families of flights have every fifth scan: half a second apart.
const FLIGHT_STRIDE: usize = 5;

/// The seeds of the scenes: parameters are chosen on one split, and results reported on the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// For development.
    Dev,
    /// For reports; never looked at during development.
    Report,
}

/// A family of scenes.
#[derive(Clone, Copy, Debug)]
pub struct Suite {
    /// Name of the family.
    pub name: &'static str,
    /// Description in one line.
    pub doc: &'static str,
    scenes: Scenes,
}

#[derive(Clone, Copy, Debug)]
enum Scenes {
    Places(fn() -> Places),
    Flights(fn(seed: u64) -> Flight),
}

impl Split {
    fn first_seed(self) -> u64 {
        match self {
            Self::Dev => 0,
            Self::Report => 1_000_000,
        }
    }
}

impl Suite {
    /// The [`SCENES`] scenes, made one by one; the same at every call.
    pub fn scenes(&self, split: Split) -> Box<dyn Iterator<Item = Scene> + Send> {
        match self.scenes {
            Scenes::Places(places) => {
                let (places, first_seed) = (places(), self.first_seed(split));
                Box::new((0..SCENES as u64).map(move |index| {
                    let stamp_ns = FIRST_STAMP_NS + index * 100_000_000;
                    places.scene(1 + index as usize % 5, first_seed.wrapping_add(index), stamp_ns)
                }))
            }
            Scenes::Flights(fly) => Box::new(
                (split.first_seed()..)
                    .flat_map(move |seed| fly(seed).step_by(FLIGHT_STRIDE))
                    .take(SCENES)
                    .enumerate()
                    .map(|(index, scene)| scene.restamped(FIRST_STAMP_NS + index as u64 * 500_000_000)),
            ),
        }
    }

    /// The places of the scenes as clouds of a lidar of `rings`; `None` for flights.
    pub fn clouds(&self, split: Split, rings: Rings) -> Option<impl Iterator<Item = Cloud>> {
        let Scenes::Places(places) = self.scenes else { return None };
        let (places, first_seed) = (places(), self.first_seed(split));
        let seed = move |index: usize| first_seed.wrapping_add(index as u64);
        Some((0..SCENES).map(move |index| places.cloud(1 + index % 5, seed(index), rings)))
    }

    /// Each family of places has its own seeds, so that families share no scene.
    fn first_seed(&self, split: Split) -> u64 {
        let family = self.name.bytes().fold(0, |hash: u64, byte| hash.wrapping_mul(131) + u64::from(byte));
        (family << 32).wrapping_add(split.first_seed())
    }
}

/// All families.
pub fn suites() -> &'static [Suite] {
    const fn places(name: &'static str, doc: &'static str, scenes: fn() -> Places) -> Suite {
        Suite { name, doc, scenes: Scenes::Places(scenes) }
    }
    const fn flights(name: &'static str, doc: &'static str, scenes: fn(u64) -> Flight) -> Suite {
        Suite { name, doc, scenes: Scenes::Flights(scenes) }
    }
    const SUITES: &[Suite] = &[
        places("clean6", "5.5-6.5 m wide", || Places { width_m: [5.5, 6.5], ..CLEAN }),
        places("clean35", "3.2-3.8 m wide", || Places { width_m: [3.2, 3.8], ..CLEAN }),
        places("sparse", "3-4 m wide, 20 % of the beams lost", || Places {
            width_m: [3.0, 4.0],
            lidar: Lidar { loss: 0.2, ..CLEAN.lidar },
            ..CLEAN
        }),
        places("wet", "5-7 m wide, 20 % of the beams lost, and 15 % in patches of 3-18 beams", || Places {
            width_m: [5.0, 7.0],
            lidar: Lidar { loss: 0.2, patch_share: 0.15, ..CLEAN.lidar },
            ..CLEAN
        }),
        places("narrow", "1.2-2.4 m wide", || Places { width_m: [1.2, 2.4], bumps_m: [0.04, 0.8], ..CLEAN }),
        places("dust", "3-6 m wide, 4 % returns from dust within 6 m, 10 % of the beams lost", || Places {
            lidar: Lidar { loss: 0.1, dust: 0.04, ..CLEAN.lidar },
            ..CLEAN
        }),
        places("rough", "3-6 m wide, bumps of 0.3 m standard deviation and 1 m long, 10 % of the beams lost", || {
            Places { bumps_m: [0.3, 1.0], lidar: Lidar { loss: 0.1, ..CLEAN.lidar }, ..CLEAN }
        }),
        places("offcentre", "3-6 m wide, the lidar 0.4 widths off centre", || Places {
            off_centre: [0.4, 0.4],
            ..CLEAN
        }),
        places("dense720", "3-6 m wide, 720 beams", || Places { lidar: Lidar { beams: 720, ..CLEAN.lidar }, ..CLEAN }),
        places("view255", "3-6 m wide, a view of 255°, a beam per degree", || Places {
            lidar: Lidar { beams: 256, field_of_view_rad: 255_f64.to_radians(), ..CLEAN.lidar },
            ..CLEAN
        }),
        places("view180", "3-6 m wide, a view of 180°, a beam per degree", || Places {
            lidar: Lidar { beams: 181, field_of_view_rad: 180_f64.to_radians(), ..CLEAN.lidar },
            ..CLEAN
        }),
        places("pillars", "5-7 m wide, one to three pillars, 0.8-1.6 m across", || Places {
            width_m: [5.0, 7.0],
            pillars: [1, 3],
            ..CLEAN
        }),
        flights("flight_tunnel", "whole flights through tunnels of 3.5 m x 3 m, two scans a second", presets::tunnel),
        flights("flight_mine", "whole flights through wet mines of 6 m x 4 m, two scans a second", presets::mine),
    ];
    SUITES
}

/// The values that families have in common.
const CLEAN: Places = Places::CLEAN;
