//! What is drawn of a frame, compared with the frame: each drawing read back as a person would read it.

use crosscut_explain::Explanation;
use crosscut_flight::{FlightAnswer, SteadyOpening};
use crosscut_rrd::{Numbers, Value};
use crosscut_stage::{Beam, Frame, Point};
use faer::Mat;

use crate::every_entity::{dual, row_at, sweep};

/// What the charts span.
const REACH_M: f64 = 15.0;
const PROFILE: [f64; 2] = [100.0, 85.0];
const SMALLEST_DECADE: f64 = -17.3;
/// Rounding of drawn rows of U.
const STEP: f64 = 0.5 / 128.0 + 1e-6;

/// What a drawn component is compared with.
pub(crate) fn comparison(entity: &str, component: &str) -> Option<fn(&Value, &Frame) -> bool> {
    Some(match (entity, component) {
        ("/scan/returns", "Points3D:positions") => {
            |value, frame| points(value) == frame.revolution.points_m.iter().map(drawn).collect::<Vec<_>>()
        }
        ("/scan/returns" | "/spectral/embedding", "Points3D:class_ids") => |value, frame| {
            wholes(value).into_iter().eq(frame
                .junction
                .wall_of_return
                .iter()
                .map(|wall| wall.map_or(65_535, i64::from)))
        },
        ("/scan/walls", "LineStrips3D:strips") => |value, frame| {
            let returns: Vec<_> = frame.revolution.points_m.iter().map(drawn).collect();
            lines(value).iter().flatten().all(|vertex| returns.contains(vertex))
                && lines(value).len() >= frame.junction.walls.len()
        },
        ("/scan/walls", "LineStrips3D:class_ids") => |value, frame| {
            let mut classes = wholes(value);
            classes.sort_unstable();
            classes.dedup();
            classes.into_iter().eq(frame.junction.walls.iter().map(|wall| i64::from(wall.id)))
        },
        ("/scan/cloud", "Points3D:positions") => {
            |value, frame| points(value) == frame.revolution.cloud_m.iter().map(drawn).collect::<Vec<_>>()
        }
        // A point of the cloud lies in the direction of a return, whose wall is a way.
        ("/scan/cloud", "Points3D:class_ids") => |value, frame| {
            wholes(value).into_iter().eq(frame.junction.wall_of_return.iter().flatten().map(|way| i64::from(*way)))
        },
        ("/scan/ways", "Arrows3D:vectors" | "Points3D:positions") => |value, frame| {
            let tips = frame.junction.ways.iter().flatten().map(|way| (1.5 * dual(frame).cut_m * way.direction).into());
            points(value) == tips.map(|tip: Point| drawn(&tip)).collect::<Vec<_>>()
        },
        ("/scan/ways", "Arrows3D:class_ids" | "Points3D:class_ids") => {
            |value, frame| wholes(value).into_iter().eq(0..frame.junction.ways.as_ref().map_or(0, Vec::len) as i64)
        }
        ("/scan/ways", "Points3D:labels") => |value, frame| {
            texts(value)
                .iter()
                .zip(frame.junction.ways.iter().flatten())
                .all(|(label, way)| label.ends_with(&format!(": shaft up, {:.1} m", way.clearance_m)))
        },
        ("/scan/sphere", "EncodedDepthImage:blob") => {
            |value, _| matches!(value, Value::Numbers(array) if array.shape == [180, 360])
        }
        // The only ring of cells here lies over all elevations.
        ("/scan/sphere", "LineStrips2D:strips") => |value, frame| {
            let degrees: f64 = lines(value).iter().map(|bar| bar[0][0] - bar[1][0]).sum();
            let cells = dual(frame).cells.len() as f64;
            (degrees - 360.0 * frame.revolution.len() as f64 / cells).abs() < 1e-3
        },
        ("/scan/sphere", "LineStrips2D:class_ids") => {
            |value, frame| wholes(value).iter().all(|class| *class < dual(frame).ways.len() as i64)
        }
        ("/scan/sphere/marks", "Points2D:positions") => |value, frame| {
            let (points, between) = (points(value), &dual(frame).between);
            points.len() == dual(frame).ways.len() + between.len() && points.last() == Some(&vec![90.0, 90.0])
        },
        ("/scan/sphere/marks", "Points2D:labels") => {
            |value, _| texts(value).last().is_some_and(|label| label == "3.5 of 4.0 m")
        }
        ("/scan/sphere/marks", "Points2D:colors") => |value, frame| wholes(value).len() == dual(frame).ways.len() + 1,
        ("/scan/openings", "Arrows3D:origins") => |value, frame| {
            points(value)[frame.junction.openings.len()..] == vec![vec![0.0; 3]; steady_openings(frame).len()]
        },
        ("/scan/openings", "Arrows3D:colors") => |value, frame| {
            const PINK: i64 = 0xE830_8CFF;
            let is_pink = wholes(value).into_iter().map(|color| color == PINK);
            let seen = steady_openings(frame).iter().map(|opening| opening.seen_ns.is_some());
            is_pink.eq(frame.junction.openings.iter().map(|_| true).chain(seen))
        },
        ("/scan/openings", "Arrows3D:vectors") => |value, frame| {
            let across = |(vector, o): (&Vec<f64>, &crosscut_stage::Opening)| {
                let along = o.edge_m[1] - o.edge_m[0];
                (vector[0] * along.x + vector[1] * along.y).abs() < 1e-5 && vector[0].hypot(vector[1]) > 1.0
            };
            let towards = |(vector, o): (&Vec<f64>, &SteadyOpening)| {
                (vector[1].atan2(vector[0]) - o.bearing_rad).abs() < 1e-5 && vector[0].hypot(vector[1]) > 1.0
            };
            let (vectors, openings) = (points(value), &frame.junction.openings);
            let (of_scan, of_flight) = vectors.split_at(openings.len());
            of_scan.iter().zip(openings).all(across) && of_flight.iter().zip(steady_openings(frame)).all(towards)
        },
        ("/scan/openings", "LineStrips3D:strips") => |value, frame| {
            lines(value).into_iter().eq(frame
                .junction
                .openings
                .iter()
                .map(|o| o.edge_m.iter().map(drawn).collect::<Vec<_>>()))
        },
        ("/scan/openings", "Points3D:positions") => |value, frame| points(value).len() == frame.junction.openings.len(),
        ("/scan/openings", "Points3D:labels") => |value, frame| {
            texts(value).iter().eq(frame
                .junction
                .openings
                .iter()
                .map(|o| format!("{:.1} m", o.width_m))
                .collect::<Vec<_>>()
                .iter())
        },
        ("/scan/links", "LineStrips3D:strips") => |value, frame| lines(value) == links(frame),
        ("/scan/links", "LineStrips3D:colors" | "Points3D:colors") => {
            |value, frame| wholes(value).len() == links(frame).len()
        }
        ("/scan/links", "Points3D:positions") => |value, frame| points(value).len() == links(frame).len(),
        ("/scan/links", "Points3D:labels") => |value, frame| {
            let [nearest, others @ ..] = texts(value) else { return links(frame).is_empty() };
            let count = Explanation::of(frame).nearest.map_or(0, |near| near.count);
            nearest.starts_with(&format!("{count} wall")) && others.iter().all(|label| label.starts_with("k = "))
        },
        ("/scan/numbers", "Points3D:labels") => |value, frame| {
            texts(value).iter().eq(frame
                .junction
                .walls
                .iter()
                .map(|wall| wall.id.to_string())
                .collect::<Vec<_>>()
                .iter())
        },
        ("/scan/numbers", "Points3D:class_ids") => {
            |value, frame| wholes(value).into_iter().eq(frame.junction.walls.iter().map(|wall| i64::from(wall.id)))
        }
        ("/scan/numbers", "Points3D:positions") => |value, frame| points(value).len() == frame.junction.walls.len(),
        // A ring around both ends of the gap that is nearest to another count: its middle is between them.
        ("/scan/numbers", "LineStrips3D:strips") => |value, frame| {
            let explanation = Explanation::of(frame);
            let near = explanation.nearest.as_ref().filter(|_| explanation.may_be_none.is_none());
            near.map(|near| near.returns).is_none_or(|[i, j]| {
                let middle = nalgebra::center(&frame.revolution.points_m[i], &frame.revolution.points_m[j]);
                let ring = &lines(value)[0];
                let far = |p: &Vec<f64>| (p[0] - middle.x).hypot(p[1] - middle.y);
                ring.iter().all(|p| (far(p) - far(&ring[0])).abs() < 0.05)
            })
        },
        ("/affinity/links", "LineStrips3D:strips") => |value, frame| {
            let is_link = |edge: &[Vec<f64>]| {
                let mut found = false;
                frame.affinity.weights.for_each(|i, j, w| {
                    found |= w > 0.0 && [i, j].map(|i| drawn(&frame.revolution.points_m[i]))[..] == *edge;
                });
                found
            };
            !lines(value).is_empty()
                && lines(value).iter().step_by(20).flat_map(|line| line.windows(2)).step_by(5).all(is_link)
        },
        ("/affinity/links", "LineStrips3D:colors") => |value, _| !wholes(value).is_empty(),
        ("/spectral/chart/values", "LineStrips2D:strips") => |value, frame| {
            let (lines, values) = (lines(value), &frame.spectrum.eigenvalues);
            let columns = values.len().min(16);
            let height = |value: f64| -value.abs().log10().clamp(SMALLEST_DECADE, 2.0);
            let column = |(line, value): (&Vec<Vec<f64>>, &f64)| (line[1][1] - height(*value)).abs() < 1e-4;
            let tolerance_is_right = (lines[columns][0][1] - height(frame.spectrum.tolerance)).abs() < 1e-4;
            lines.len() == columns + 2 && lines[..columns].iter().zip(values).all(column) && tolerance_is_right
        },
        ("/spectral/chart/values", "LineStrips2D:colors") => |value, frame| {
            let (colors, k) = (wholes(value), frame.spectrum.k);
            colors[..k]
                .iter()
                .all(|color| color == &colors[0] && color != &colors[frame.spectrum.eigenvalues.len().min(16)])
        },
        ("/spectral/chart/values", "Points2D:labels") => |value, frame| {
            texts(value)[0].ends_with(&format!("k = {}", frame.spectrum.k))
                && texts(value)[1] == format!("τ {:.0e}", frame.spectrum.tolerance)
        },
        ("/spectral/chart/values", "Points2D:positions" | "Points2D:colors") => |_, _| true,
        ("/spectral/embedding", "Points3D:positions") => |value, frame| is_drawn(value, &frame.spectrum.u, frame),
        ("/kmeans/centroids", "Points3D:positions") => {
            |value, frame| is_drawn(value, &frame.partition.centroids, frame)
        }
        ("/kmeans/centroids", "Points3D:class_ids") => {
            |value, frame| wholes(value).into_iter().eq(0..frame.partition.clusters as i64)
        }
        ("/kmeans/labels", "LineStrips2D:strips") => |value, frame| {
            let bars: Vec<_> = lines(value).into_iter().step_by(2).map(|bar| bar[0][0]..bar[1][0]).collect();
            let mut places = (0..1024).filter(|place| row_at(frame, *place).is_some());
            places.all(|place| bars.iter().any(|bar| bar.contains(&(place as f64))))
        },
        ("/kmeans/labels", "LineStrips2D:class_ids") => {
            |value, frame| wholes(value).iter().all(|class| *class < frame.partition.clusters as i64)
        }
        ("/kmeans/blocks", "LineStrips2D:strips") => {
            |value, frame| lines(value).iter().all(|block| walls_between(frame, block[0][0], block[2][0]).len() == 1)
        }
        ("/kmeans/blocks", "LineStrips2D:class_ids") => {
            |value, frame| wholes(value).iter().all(|class| *class < frame.junction.walls.len() as i64)
        }
        ("/affinity/marks", "Points2D:positions") => |value, frame| {
            let beams = sweep(frame).beams.iter().enumerate().filter(|(_, beam)| matches!(beam, Beam::Return(_)));
            let beams: Vec<f64> = beams.map(|(place, _)| place as f64).collect();
            let is_edge = |mark: &Vec<f64>| mark[0] > mark[1] && mark.iter().all(|place| beams.contains(place));
            points(value).len() == links(frame).len() && points(value).iter().all(is_edge)
        },
        ("/affinity/marks", "Points2D:colors") => |value, frame| wholes(value).len() == links(frame).len(),
        ("/affinity/marks", "Points2D:labels") => |value, frame| texts(value).len() == links(frame).len(),
        ("/affinity/absent", "Points2D:labels") => |value, frame| {
            texts(value).iter().all(|text| text == "The scan has no return")
                && texts(value).is_empty() != frame.revolution.is_empty()
        },
        ("/affinity/absent", _) => |_, _| true,
        // A column for each verdict within the chart, of which the first frame has two: up for an opening.
        ("/affinity/gaps/values", "LineStrips2D:strips") => |value, frame| {
            let lines = lines(value);
            lines.len() == frame.affinity.verdicts.len().saturating_sub(1)
                && lines.iter().all(|column| column[0][1] == 0.0 && column[1][1] != 0.0)
                && lines.iter().filter(|column| column[1][1] < 0.0).count() == lines.len() / 2
        },
        ("/affinity/gaps/values", "Points2D:labels") => {
            |value, _| texts(value).iter().all(|label| label.ends_with(" m") || label.parse::<u32>().is_ok())
        }
        ("/affinity/gaps/values", _) => |_, _| true,
        ("/spectral/U/picture", "EncodedDepthImage:blob") => {
            |value, _| matches!(value, Value::Numbers(array) if array.shape[0] * 2 == array.shape[1])
        }
        ("/spectral/U/bars", "LineStrips2D:strips") => {
            |value, frame| lines(value).iter().all(|bar| walls_between(frame, bar[0][0], bar[1][0]).len() <= 1)
        }
        ("/spectral/U/bars", "Points2D:labels") => |value, frame| texts(value).len() == frame.spectrum.u.ncols(),
        ("/spectral/U/bars", "LineStrips2D:class_ids") => |value, _| wholes(value).iter().all(|class| *class >= 0),
        ("/spectral/U/bars", _) => |_, _| true,
        ("/kmeans/profile/axes", "LineStrips2D:strips") => |value, _| {
            lines(value)
                .iter()
                .map(|line| line[0][1])
                .eq([0.0, 5.0, 10.0, 15.0].map(|m| f64::from(-85.0 * (m / 15.0) as f32)))
        },
        ("/kmeans/profile/axes", "Points2D:labels") => |value, _| texts(value)[..4] == ["0 m", "5 m", "10 m", "15 m"],
        ("/kmeans/profile/axes", _) => |_, _| true,
        ("/kmeans/profile/lines", "LineStrips2D:strips") => {
            |value, frame| lines(value).iter().all(|line| is_of_ranges(line, frame))
        }
        ("/kmeans/profile/lines", "LineStrips2D:class_ids") => {
            |value, frame| wholes(value).iter().all(|class| *class < frame.junction.walls.len() as i64)
        }
        _ => return None,
    })
}

/// The gap that the sentence names, then the edges of other changes, as lines.
pub(crate) fn links(frame: &Frame) -> Vec<Vec<Vec<f64>>> {
    let explanation = Explanation::of(frame);
    let nearest = explanation.nearest.as_ref().map(|near| near.returns);
    let sorted = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
    let changes = explanation.changes.iter().filter_map(|change| Some(change.edge?.returns));
    let changes = changes.filter(|returns| nearest.map(sorted) != Some(sorted(*returns)));
    let links = nearest.into_iter().chain(changes);
    links.map(|returns| returns.iter().map(|&i| drawn(&frame.revolution.points_m[i])).collect()).collect()
}

/// Whether points are the first three columns of `rows`, with the scale that brings the farthest row of U to 1.
fn is_drawn(value: &Value, rows: &Mat<f64>, frame: &Frame) -> bool {
    let row = |m: &Mat<f64>, i: usize| [0, 1, 2].map(|j| if j < m.ncols() { m[(i, j)] } else { 0.0 });
    let norm = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let u = &frame.spectrum.u;
    let reach = (0..u.nrows()).map(|i| norm(row(u, i))).fold(0.0, f64::max);
    let drawn = points(value);
    let is_near =
        |(i, point): (usize, &Vec<f64>)| point.iter().zip(row(rows, i)).all(|(p, x)| (p - x / reach).abs() <= STEP);
    drawn.len() == rows.nrows() && drawn.iter().enumerate().all(is_near)
}

/// The walls of the returns at these places along the beams.
fn walls_between(frame: &Frame, from: f64, to: f64) -> std::collections::BTreeSet<u32> {
    let rows = (from as usize..to as usize).filter_map(|place| row_at(frame, place));
    rows.filter_map(|row| frame.junction.wall_of_return[row]).collect()
}

/// Whether a line of the profile is a bar above it, or passes ranges of the scan.
fn is_of_ranges(line: &[Vec<f64>], frame: &Frame) -> bool {
    let [width, height] = PROFILE;
    let along = width / sweep(frame).len() as f64;
    line.iter().all(|vertex| {
        let near = [-1.0, 0.0, 1.0].map(|side| ((vertex[0] + 0.1 * side * along) / along).floor());
        let range = |place: f64| sweep(frame).ranges_m.get(place as usize).map_or(f64::NAN, |m| f64::from(*m));
        vertex[1] < -height - 1.0
            || near.iter().any(|&place| (vertex[1] + height * range(place) / REACH_M).abs() < 0.01)
    })
}

/// A point with the precision that it is drawn with.
fn drawn(p: &crosscut_stage::Point) -> Vec<f64> {
    p.iter().map(|&x| f64::from(x as f32)).collect()
}

fn steady_openings(frame: &Frame) -> &[SteadyOpening] {
    FlightAnswer::of(frame).steady.as_ref().map_or(&[], |steady| &steady.openings)
}

pub(crate) fn points(value: &Value) -> Vec<Vec<f64>> {
    let Value::Numbers(array) = value else { return Vec::new() };
    array.to_f64().chunks(array.shape[1].max(1)).map(<[f64]>::to_vec).collect()
}

pub(crate) fn lines(value: &Value) -> Vec<Vec<Vec<f64>>> {
    let Value::Lists(lists) = value else { return Vec::new() };
    lists.iter().map(|list| points(&Value::Numbers(list.clone()))).collect()
}

pub(crate) fn wholes(value: &Value) -> Vec<i64> {
    match value {
        Value::Numbers(array) => match &array.numbers {
            Numbers::I64(numbers) => numbers.clone(),
            _ => Vec::new(),
        },
        _ => Vec::new(),
    }
}

pub(crate) fn texts(value: &Value) -> &[String] {
    match value {
        Value::Texts(texts) => texts,
        _ => &[],
    }
}
