//! Nothing is recorded that is not compared with what the pipeline made: an entity or a component that is new fails
//! here until it is.

use std::collections::BTreeSet;

use crosscut_explain::{Explanation, Watch};
use crosscut_recorder::RecorderOptions;
use crosscut_recorder::schema::{ENTITIES, Entity, When};
use crosscut_rrd::{Array, Numbers, Recording, Value};
use crosscut_stage::NoteCode::N101;
use crosscut_stage::{Beam, Cell, Frame, Step, Verdict, Way};
use rerun::external::arrow::datatypes::{ArrowPrimitiveType, Float16Type};

use crate::reading::{self, record_with};
use crate::{drawings, flight_map, frames};

type F16 = <Float16Type as ArrowPrimitiveType>::Native;

/// What only says how something looks, and type names of texts and pictures.
const LOOK: [&str; 6] = [":show_labels", ":radii", ":media_type", ":colormap", ":depth_range", "BarChart:color"];
/// What Rerun itself records.
const RERUNS_OWN: &str = "/__properties";
/// Colours of the walls by their class, which here is the number of the wall.
const COLOURS: [&str; 3] = ["blue", "orange", "green"];

/// The true number of walls at every revolution.
const TRUTH: usize = 3;
const TRUTH_JSON: &str = r#"{"walls":3}"#;

/// A flight with everything that can be recorded: an answer that is unsure, an empty revolution, notes, a sparse W, a cloud with
/// ways on.
fn flight() -> Vec<Frame> {
    let mut frames: Vec<Frame> = (0..6).map(frames::frame).collect();
    frames[1].junction.confidence = Some(0.2);
    frames[2] = frames::empty_frame(2);
    frames[3].notes.add(N101, "3 beams masked");
    frames::make_sparse(&mut frames[4].affinity);
    frames.iter_mut().for_each(flight_map::fly);
    for frame in &mut frames {
        frame.timings.flight_ns = Some(250_000);
        frame.revolution.odometry = Some(nalgebra::Isometry2::new([1.5, -2.5].into(), 0.7));
    }
    let verdict = |is_opening, room_ratio| Verdict {
        returns: [0, 9],
        is_opening,
        room_ratio,
        reason: "width",
        p: None,
        measured: None,
    };
    frames::make_ways(&mut frames[5]);
    frames[4].revolution.entries = vec![1, -1, 0]; // of a cloud
    frames[0].affinity.verdicts = vec![verdict(true, 3.0), verdict(false, 0.5), verdict(false, 0.0)];
    frames
}

/// Whether a value is the one that the frame holds.
type Compare<'a> = Box<dyn Fn(&Value, &Frame) -> bool + 'a>;

/// What a component is compared with.
fn comparison<'a>(entity: &'a str, component: &'a str, frames: &'a [Frame]) -> Option<Compare<'a>> {
    if entity.starts_with("/flight/") {
        return flight_map::comparison(entity, component, frames);
    }
    if let Some(step) = Step::ALL.into_iter().find(|step| entity == format!("/timing/{step}")) {
        return Some(Box::new(move |value, frame| is_number(value, frame.timings.ns(step) as f64 * 1e-6)));
    }
    match (entity, component) {
        ("/log", "TextLog:text") => {
            let mut watch = Watch::default();
            let events: Vec<_> = frames.iter().map(|frame| watch.events(frame, Some(TRUTH))).collect();
            let of_index = |frame: &Frame| (frame.revolution.seq - frames[0].revolution.seq) as usize;
            let said = move |frame: &Frame| -> Vec<String> {
                let events = events[of_index(frame)].iter().map(ToString::to_string);
                events.chain(frame.notes.iter().map(str::to_owned)).collect()
            };
            Some(Box::new(move |value, frame| matches!(value, Value::Texts(texts) if said(frame).contains(&texts[0]))))
        }
        ("/log", "TextLog:level") => Some(Box::new(
            |value, _| matches!(value, Value::Texts(texts) if ["INFO", "WARN", "ERROR", "UNSURE"].contains(&texts[0].as_str())),
        )),
        ("/report/doubt", "StateChange:state") => {
            let mut watch = Watch::default();
            let doubts: Vec<&str> = frames
                .iter()
                .map(|frame| {
                    watch.events(frame, Some(TRUTH));
                    watch.doubt().name()
                })
                .collect();
            let first = frames[0].revolution.seq;
            Some(Box::new(move |value, frame| {
                let doubt = doubts[(frame.revolution.seq - first) as usize];
                matches!(value, Value::Texts(texts) if texts[..] == [doubt])
            }))
        }
        ("/timing/total", _) => Some(Box::new(|value, frame| {
            let total_ms = Step::ALL.iter().map(|step| frame.timings.ns(*step)).sum::<u64>() as f64 * 1e-6;
            let Value::Numbers(array) = value else { return false };
            let period_is_right = array.to_f64()[1] == 100.0 || frame.revolution.seq == frames[0].revolution.seq;
            array.shape == [2] && array.to_f64()[0] == total_ms && period_is_right
        })),
        _ => number_comparison(entity, component)
            .or_else(|| text_comparison(entity, component))
            .or_else(|| drawings::comparison(entity, component))
            .map(|compare| Box::new(compare) as Compare),
    }
}

/// Numbers to the last bit, or rounded as it is stated.
fn number_comparison(entity: &str, component: &str) -> Option<fn(&Value, &Frame) -> bool> {
    Some(match (entity, component) {
        ("/scan/ranges", _) => |value, frame| {
            let ranges_m = &sweep(frame).ranges_m;
            is(value, &[ranges_m.len()], Numbers::F32(ranges_m.clone()))
        },
        ("/scan/beams/sweep", _) => |value, frame| {
            let Value::Numbers(array) = value else { return false };
            let (stored, sweep) = (array.to_f64(), sweep(frame));
            stored[..4] == [sweep.step_rad, sweep.range_max_m, 1.0, 0.0] && stored[4..].iter().all(|x| x.is_nan())
        },
        ("/scan/returns/exact", _) => |value, frame| {
            let points = frame.revolution.points_m.iter().flat_map(|p| [p.x, p.y, p.z]);
            is_f64s(value, &[frame.revolution.len(), 3], points.collect())
        },
        ("/scan/odometry", _) => |value, frame| {
            let pose = frame.revolution.odometry.expect("every frame has one");
            let (at, turned) = (pose.translation.vector, pose.rotation);
            is_f64s(value, &[4], vec![at.x, at.y, turned.re, turned.im])
        },
        ("/scan/seen", _) => |value, frame| {
            let seen = sweep(frame).beams.iter().map(|beam| match beam {
                Beam::Return(_) => 2,
                Beam::NoReturn => 1,
                Beam::Unknown => 0,
            });
            is(value, &[sweep(frame).len()], Numbers::I64(seen.collect()))
        },
        ("/scan/beams", _) => |value, frame| is_f64s(value, &[sweep(frame).len()], sweep(frame).bearings_rad.clone()),
        ("/scan/beams/wire", _) => |value, frame| is(value, &[4], Numbers::F32(sweep(frame).wire_geometry.to_vec())),
        ("/recording/part", _) => |value, _| is_f64s(value, &[2], vec![1.0, 0.0]), // the first, and none follows
        ("/scan/entries", _) => |value, frame| {
            let entries: Vec<i64> = frame.revolution.entries.iter().copied().map(i64::from).collect();
            is(value, &[entries.len()], Numbers::I64(entries))
        },
        ("/scan/count", _) => |value, frame| is_number(value, frame.revolution.len() as f64),
        ("/scan/openings", "Tensor:data") => |value, frame| {
            let openings = &frame.junction.openings;
            is_f64s(value, &[openings.len(), 2], openings.iter().flat_map(|o| [o.bearing_rad, o.width_m]).collect())
        },
        ("/scan/cloud/tilt", _) => {
            |value, frame| is_f64s(value, &[4], frame.revolution.cloud_tilt.coords.iter().copied().collect())
        }
        ("/scan/ways", "Tensor:data") => |value, frame| {
            let row = |way: &Way| {
                let ([x, y, z], cut): ([f64; 3], _) = (way.direction.into(), f64::from(u8::from(way.cut_by_view)));
                [x, y, z, way.clearance_m, way.p, cut]
            };
            let ways = frame.junction.ways.iter().flatten();
            is_f64s(value, &[ways.clone().count(), 6], ways.flat_map(row).collect())
        },
        ("/scan/sphere", "Tensor:data") => |value, frame| {
            let row = |cell: &Cell| {
                let ([x, y, z], way): ([f64; 3], _) = (cell.direction.into(), cell.way.map_or(-1.0, f64::from));
                [x, y, z, cell.range_m, cell.reach_m, way].map(|value| value as f32)
            };
            let cells = &dual(frame).cells;
            is(value, &[cells.len(), 6], Numbers::F32(cells.iter().flat_map(row).collect()))
        },
        ("/affinity/degrees", _) => |value, frame| {
            let degrees: Vec<f32> = frame.affinity.degrees.iter().map(|&d| d as f32).collect();
            is(value, &[degrees.len()], Numbers::F32(degrees))
        },
        ("/affinity/W", "EncodedDepthImage:blob") => {
            |value, frame| is_picture(value, frame, &frames::dense(&frame.affinity))
        }
        ("/spectral/L", "EncodedDepthImage:blob") => {
            |value, frame| is_picture(value, frame, &frames::laplacian(&frame.affinity))
        }
        ("/affinity/W/exact", _) => |value, frame| {
            let (w, n) = (frames::dense(&frame.affinity), frame.revolution.len());
            is_f64s(
                value,
                &[n, n],
                (0..n * n).map(|at| if at / n <= at % n { w[(at / n, at % n)] } else { 0.0 }).collect(),
            )
        },
        ("/spectral/eigenvalues", _) => |value, frame| {
            let eigenvalues = &frame.spectrum.eigenvalues;
            is_f64s(value, &[eigenvalues.len()], eigenvalues.clone())
        },
        ("/spectral/tolerance", _) => |value, frame| is_number(value, frame.spectrum.tolerance),
        ("/spectral/k", _) => |value, frame| is_number(value, frame.spectrum.k as f64),
        ("/spectral/margin", _) => |value, frame| match frame.spectrum.margin_decades {
            Some(decades) => is_number(value, decades),
            None => is_f64s(value, &[0], vec![]),
        },
        ("/spectral/U", _) => |value, frame| {
            let u = &frame.spectrum.u;
            let rounded = rows(u).into_iter().map(|x| f32::from(F16::from_f64(x)));
            is(value, &[u.nrows(), u.ncols()], Numbers::F32(rounded.collect()))
        },
        ("/spectral/U/exact", _) => |value, frame| {
            let u = &frame.spectrum.u;
            is_f64s(value, &[u.nrows(), u.ncols()], rows(u))
        },
        ("/kmeans/labels", "Tensor:data") => |value, frame| {
            let labels = frame.partition.labels.iter().map(|label| label.map_or(-1, i64::from));
            is(value, &[frame.revolution.len()], Numbers::I64(labels.collect()))
        },
        ("/kmeans/centroids", "Tensor:data") => |value, frame| {
            let centroids = &frame.partition.centroids;
            is_f64s(value, &[centroids.nrows(), centroids.ncols()], rows(centroids))
        },
        ("/truth/walls", _) => |value, _| is_number(value, TRUTH as f64),
        ("/timing/flight", _) => {
            |value, frame| is_number(value, frame.timings.flight_ns.expect("a time") as f64 * 1e-6)
        }
        ("/report/axis", _) => |value, _| is_f64s(value, &[2], vec![0.0, 5.0]),
        ("/report/junctions", _) => |value, frame| is_number(value, frame.junction.junctions as f64),
        ("/report/confidence", _) => |value, frame| match frame.junction.confidence {
            Some(confidence) => is_number(value, confidence),
            None => is_f64s(value, &[0], vec![]),
        },
        ("/report/labels", _) => |value, frame| {
            let wall_of = |beam: &Beam| match beam {
                Beam::Return(i) => frame.junction.wall_of_return[*i as usize].map_or(-2, i64::from),
                Beam::NoReturn | Beam::Unknown => -1,
            };
            let of_entry = |&entry: &i32| u32::try_from(entry).map_or(i64::from(entry), |i| wall_of(&Beam::Return(i)));
            let entries = &frame.revolution.entries;
            let labels: Vec<i64> = match entries.is_empty() {
                true => sweep(frame).beams.iter().map(wall_of).collect(),
                false => entries.iter().map(of_entry).collect(),
            };
            is(value, &[labels.len()], Numbers::I64(labels))
        },
        ("/report/walls", _) => |value, frame| {
            let walls = frame.junction.walls.iter().flat_map(|wall| {
                let [from, to] = wall.bearing_rad;
                [
                    f64::from(wall.id),
                    wall.returns as f64,
                    from,
                    to,
                    f64::from(u8::from(wall.island)),
                    f64::from(wall.id),
                ]
            });
            is_f64s(value, &[frame.junction.walls.len(), 6], walls.collect())
        },
        _ => return None,
    })
}

fn text_comparison(entity: &str, component: &str) -> Option<fn(&Value, &Frame) -> bool> {
    Some(match (entity, component) {
        ("/report/place", "StateChange:state") => |value, frame| is_text(value, &frame.junction.place.to_string()),
        ("/truth/json", _) => |value, _| is_text(value, TRUTH_JSON),
        ("/scan/notes", _) => |value, frame| {
            is_text(
                value,
                &frame
                    .notes
                    .of_revolution()
                    .iter()
                    .map(|(code, note)| format!("{code:?} {note}"))
                    .collect::<Vec<_>>()
                    .join("\n"),
            )
        },
        ("/report/why", _) => |value, frame| {
            let (why, color_of) = (Explanation::of(frame), |wall: u32| COLOURS[wall as usize]);
            let context = format!("tee.mcap, preset paper · revolution {}", frame.revolution.seq);
            let Value::Texts(texts) = value else { return false };
            texts[0].starts_with(&why.title(frame, &color_of))
                && texts[0].contains(&context)
                && texts[0].contains(&format!("truth: {TRUTH} walls"))
                && texts[0].ends_with(&why.details(frame, &color_of))
        },
        ("/report/summary", _) => |value, frame| {
            let openings = frame
                .junction
                .openings
                .iter()
                .map(|o| format!("| {:+.0}° | {:.1} m |", o.bearing_rad.to_degrees(), o.width_m));
            let walls = frame
                .junction
                .walls
                .iter()
                .map(|wall| format!("| {} | {} | {} |", wall.id, COLOURS[wall.id as usize], wall.returns));
            let ways = frame
                .junction
                .ways
                .as_ref()
                .map_or(String::new(), |ways| format!("{} ways on · level view: ", ways.len()));
            let rows = frame.junction.ways.iter().flatten().zip(COLOURS);
            let rows = rows.map(|(way, colour)| format!("| {colour} | {} | {:.2} |", way.words(), way.p));
            let count = format!("# {ways}{} walls · ", frame.junction.junctions);
            let Value::Texts(texts) = value else { return false };
            texts[0].starts_with(&count) && rows.chain(openings).chain(walls).all(|row| texts[0].contains(&row))
        },
        ("/timing/summary", _) => |value, frame| {
            let now = Step::ALL.map(|step| format!("| {step} | {:.2} |", frame.timings.ns(step) as f64 * 1e-6));
            matches!(value, Value::Texts(texts) if now.iter().all(|row| texts[0].contains(row)))
        },
        _ => return None,
    })
}

/// Whether a picture holds both triangles of `m` to half a decade, and nothing where there is no return.
fn is_picture(value: &Value, frame: &Frame, m: &faer::Mat<f64>) -> bool {
    let Value::Numbers(Array { shape, numbers: Numbers::F64(read), .. }) = value else { return false };
    let return_at = |place: usize| row_at(frame, place);
    read.iter().enumerate().all(|(at, &value)| match return_at(at / shape[1]).zip(return_at(at % shape[1])) {
        None => value == 0.0,
        Some((i, j)) if value == 0.0 => m[(i, j)].abs() < 1e-15,
        Some((i, j)) => (m[(i, j)].abs() / value).log10().abs() <= 0.502,
    })
}

/// The row of W at a pixel of its picture: a return at that of its beam; directions share the largest side.
pub(crate) fn row_at(frame: &Frame, place: usize) -> Option<usize> {
    if frame.affinity.dual.is_some() {
        let n = frame.affinity.weights.n();
        return Some(place / (1024 / n)).filter(|row| *row < n);
    }
    match sweep(frame).beams.get(place) {
        Some(Beam::Return(i)) => Some(*i as usize),
        _ => None,
    }
}

pub(crate) fn dual(frame: &Frame) -> &crosscut_stage::Dual {
    frame.affinity.dual.as_ref().expect("directions")
}

pub(crate) fn sweep(frame: &Frame) -> &crosscut_stage::Sweep {
    frame.revolution.sweep.as_ref().expect("a sweep")
}

fn rows(m: &faer::Mat<f64>) -> Vec<f64> {
    (0..m.nrows() * m.ncols()).map(|at| m[(at / m.ncols(), at % m.ncols())]).collect()
}

fn is(value: &Value, shape: &[usize], numbers: Numbers) -> bool {
    matches!(value, Value::Numbers(array) if array.shape == shape && array.numbers == numbers)
}

fn is_f64s(value: &Value, shape: &[usize], numbers: Vec<f64>) -> bool {
    is(value, shape, Numbers::F64(numbers))
}

fn is_number(value: &Value, number: f64) -> bool {
    is_f64s(value, &[], vec![number])
}

fn is_text(value: &Value, text: &str) -> bool {
    matches!(value, Value::Texts(texts) if texts[..] == [text])
}

#[test]
fn every_component_of_every_entity_holds_what_the_pipeline_made() {
    let folder = tempfile::tempdir().unwrap();
    let (frames, path) = (flight(), folder.path().join("flight.rrd"));
    let options = reading::options(&path);
    frames.iter().for_each(|frame| options.truth.tell(frame.revolution.seq, TRUTH, TRUTH_JSON.to_owned()));
    record_with(RecorderOptions { source: "tee.mcap, preset paper".to_owned(), ..options }, &frames);
    let recording = Recording::open(&path).unwrap();
    let mut compared = BTreeSet::new();
    let in_schema = |entity: &str| Entity::of(entity).unwrap_or_else(|| panic!("{entity} is not in the schema"));
    for (path, holds) in recording.entities().iter().filter(|(path, _)| *path != RERUNS_OWN) {
        let entity = in_schema(path);
        assert_eq!(holds.revolutions.is_none(), entity.when == When::Once, "{path}");
        assert!(holds.components.contains_key(entity.values), "{path} has no {}", entity.values);
    }
    let of_revolutions = |(path, _): &(&String, _)| *path != RERUNS_OWN && in_schema(path).when != When::Once;
    for (entity, _) in recording.entities().iter().filter(of_revolutions) {
        for row in recording.rows(entity).unwrap().map(Result::unwrap) {
            let frame = &frames[row.revolution as usize];
            assert_eq!(row.stamp_ns, Some(frame.revolution.stamp_ns as i64), "{entity}");
            let is_look = |component: &&str| LOOK.iter().any(|look| component.ends_with(look));
            for component in row.components().filter(|component| !is_look(component)) {
                let compare = comparison(entity, component, &frames)
                    .unwrap_or_else(|| panic!("{entity}, {component} is compared with nothing"));
                for value in row.values(component).map(Result::unwrap) {
                    if component == "Tensor:data"
                        && let Value::Numbers(array) = &value
                    {
                        assert_eq!(array.dims, in_schema(entity).dims, "{entity}");
                    }
                    assert!(compare(&value, frame), "{entity}, {component} at {}: {value:?}", row.revolution);
                }
                compared.insert((entity.clone(), component.to_owned()));
            }
        }
    }
    assert!(compared.len() >= 50, "{} components", compared.len());
    for entity in ENTITIES {
        assert!(recording.entities().contains_key(entity.path), "{} is never written", entity.path);
    }
}
