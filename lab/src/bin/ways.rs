//! How often the ways on of a 3D cloud are right.

use std::path::{Path, PathBuf};

use crosscut_affinity::directions::{Cut, Sky, WayFound as Way};
use crate::solid::lidar::Lidar;
use crate::solid::mesh::Mesh;
use crate::solid::random::Random;
use crate::solid::truth::{RADII, Space, TrueWay};
use crate::solid::tubes::Network;
use nalgebra::{Point3, Rotation3, Vector3};

const BALL_M: f64 = 0.6;

struct Place {
    place_m: Point3<f64>,
    room_m: f64,
    ways: Vec<TrueWay>,
}

/// Places of a mesh: clear ones, and how many were not.
fn places(mesh: &Mesh, voxel_m: f64, count: usize, most_leave: usize, random: &mut Random) -> (Vec<Place>, usize) {
    let space = Space::new(mesh, voxel_m);
    let (mut found, mut unclear) = (Vec::new(), 0);
    for _ in 0..2_000_000 {
        if found.len() == count {
            break;
        }
        let place_m = space.place_m(random.below(space.count()));
        let clear_m = space.clear_m(&place_m);
        if !(0.4..10.0).contains(&clear_m) {
            continue;
        }
        let leaves = (0..200)
            .filter(|at| {
                let z = 1.0 - (f64::from(*at) + 0.5) / 100.0;
                let turn = f64::from(*at) * 2.399_963;
                let out = (1.0 - z * z).sqrt();
                !mesh.range_m(&place_m, &Vector3::new(out * turn.cos(), out * turn.sin(), z)).is_finite()
            })
            .count();
        if leaves > most_leave {
            continue;
        }
        let room_m = space.room_m(&place_m);
        if clear_m < 0.7 * room_m || room_m < 0.6 {
            continue;
        }
        let mut at = space.ways(&place_m, 0.5 * BALL_M, &RADII.map(|radii| radii * room_m));
        if at.iter().all(|ways| ways.len() == at[0].len()) && !at[0].is_empty() {
            found.push(Place { place_m, room_m, ways: at.swap_remove(2) });
        } else {
            unclear += 1;
        }
    }
    (found, unclear)
}

fn is_right(truth: &[&TrueWay], found: &[Way]) -> [bool; 3] {
    let count = truth.len() == found.len();
    let fits = |cos: f64, share: f64| {
        count
            && truth.iter().all(|true_way| {
                let of = found.iter().filter(|way| {
                    way.direction.dot(&true_way.direction) > cos
                        && (way.clearance_m / true_way.clearance_m - 1.0).abs() <= share
                });
                of.count() == 1
            })
    };
    [count, fits(f64::cos(20_f64.to_radians()), f64::INFINITY), fits(f64::cos(20_f64.to_radians()), 0.3)]
}

pub fn main() -> anyhow::Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let (set, count, seed) = (args[0].as_str(), args[1].parse::<usize>()?, args[2].parse::<u64>()?);
    let verbose = args.iter().any(|arg| arg == "-v");
    let mut random = Random::new(seed);
    let mut all: Vec<(Mesh, Vec<Place>)> = Vec::new();
    let mut unclear = 0;
    match set {
        "own" => {
            for world in 0..count as u64 {
                let mesh = Network::new(seed * 1000 + world).mesh();
                let (found, not) = places(&mesh, 0.2, 5, 0, &mut random);
                unclear += not;
                all.push((mesh, found));
            }
        }
        _ => {
            for path in args[3..].iter().filter(|arg| *arg != "-v").map(PathBuf::from) {
                let mesh = Mesh::read(Path::new(&path), if path.display().to_string().contains("typea") { 0.09375 } else if set == "tiles" { 0.3048 } else { 1.0 })?;
                let (found, not) = places(&mesh, 0.2, count, if set == "tiles" { 40 } else { 0 }, &mut random);
                eprintln!("{} {:?}: {} places, {not} unclear", path.display(), mesh.bounds_m(), found.len());
                unclear += not;
                all.push((mesh, found));
            }
        }
    }
    let places_count: usize = all.iter().map(|(_, places)| places.len()).sum();
    println!("{places_count} places, {unclear} not clear");
    let mut histogram = [0; 8];
    all.iter().flat_map(|(_, places)| places).for_each(|place| histogram[place.ways.len().min(7)] += 1);
    println!("ways {histogram:?}");
    let clouds: Vec<_> = Lidar::ALL
        .into_iter()
        .map(|lidar| {
            let mut dual = Sky::default();
            let looked: Vec<_> = all
                .iter()
                .flat_map(|(mesh, places)| places.iter().map(move |place| (mesh, place)))
                .map(|(mesh, place)| {
                    let cloud_m = lidar.cloud_m(mesh, &place.place_m, &Rotation3::identity(), &mut random);
                    (place, cloud_m)
                })
                .collect();
            (lidar, std::mem::take(&mut dual), looked)
        })
        .collect();
    for cells in [2000] {
        for (lidar, _, looked) in &clouds {
            let mut dual = Sky::default();
            let mut duals = Vec::new();
            let mut rooms = 0.0;
            let start = std::time::Instant::now();
            for (place, cloud_m) in looked {
                dual.look(cloud_m, BALL_M);
                rooms += (dual.room_m / place.room_m - 1.0).abs();
                duals.push((place, dual.clone()));
            }
            let ms = start.elapsed().as_secs_f64() * 1e3 / looked.len() as f64;
            println!("{} {cells}: room off by {:.2}, {ms:.1} ms", lidar.name(), rooms / looked.len() as f64);
            for apart in [1.75, 2.0, 2.25, 2.5] {
                for on in [1.0, 1.15, 1.3] {
                    let cut = Cut { apart, on: apart * on, cells: 1 };
                    let (mut right, mut in_view) = ([0; 3], 0);
                    for (place, dual) in &duals {
                        let [low, high] = lidar.view_deg();
                        let elevation = |way: &TrueWay| way.direction.z.asin().to_degrees();
                        let truth: Vec<&TrueWay> =
                            place.ways.iter().filter(|way| (low..=high).contains(&elevation(way))).collect();
                        if place.ways.iter().any(|way| *lidar != Lidar::Full && [low, high].iter().any(|edge| (elevation(way) - edge).abs() < 8.0)) {
                            continue;
                        }
                        in_view += 1;
                        let found = dual.ways(cut);
                        let got = is_right(&truth, &found);
                        if verbose && apart == 2.0 && on == 1.15 && !got[2] && cells == 2000 {
                            println!("  {} room {:.2} {:.2} at {:?}", lidar.name(), place.room_m, dual.room_m, place.place_m);
                            let degrees = |d: &Vector3<f64>| (d.y.atan2(d.x).to_degrees().round(), d.z.asin().to_degrees().round());
                            for way in &truth {
                                println!("    true {:?} {:.2}", degrees(&way.direction), way.clearance_m);
                            }
                            for way in &found {
                                println!("    got  {:?} {:.2} reach {:.2} cells {}", degrees(&way.direction), way.clearance_m, way.reach_m, way.cells.len());
                            }
                        }
                        (0..3).for_each(|at| right[at] += usize::from(got[at]));
                    }
                    let share = |count: usize| 100.0 * count as f64 / in_view as f64;
                    println!("  apart {apart} on {on}: {in_view} places, count {:.1} direction {:.1} width {:.1}", share(right[0]), share(right[1]), share(right[2]));
                }
            }
        }
    }
    Ok(())
}
