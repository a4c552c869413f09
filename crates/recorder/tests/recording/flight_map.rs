//! The map of the flight, compared with what a mapper makes of the same frames.

use std::f64::consts::PI;

use crosscut_flight::{FlightAnswer, Here, HereKind, Map, Mapper, NoPlace, Steady, SteadyOpening, Way};
use crosscut_rrd::{Numbers, Value};
use crosscut_stage::Frame;
use nalgebra::{Isometry2, Point2};

use crate::drawings::{lines, points, texts, wholes};
use crate::frames::cloud_frame;
use crate::reading::{Recording, record};

/// The way of the vehicle from frame to frame: far enough for a new drawing.
const STEP_M: f64 = 3.0;

/// Gives a frame its pose and its place: it comes along a tee.
pub(crate) fn fly(frame: &mut Frame) {
    let seq = frame.revolution.seq as f64;
    let way = |bearing_rad: f64| Way { bearing_rad, width_m: 3.5, opening: None };
    let ways = [-PI / 2.0, PI / 2.0, PI].map(way).to_vec();
    let here = Here { kind: HereKind::Junction, look_m: 20.0, ways, is_middle: true, confidence: 1.0 };
    let pose = Some(Isometry2::new([STEP_M * seq, 0.5].into(), 0.1 * seq));
    let opening =
        |track: u64, seen_ns| SteadyOpening { track, bearing_rad: track as f64, width_m: 3.5, p: Some(0.6), seen_ns };
    let openings = vec![opening(0, None), opening(1, Some(frame.revolution.stamp_ns))];
    let steady = Some(Steady { junctions: 3, here: Some(here.clone()), openings, closed_rad: vec![0.5] });
    FlightAnswer { pose, doubt: None, here: Some(here), steady }.put(frame);
}

/// Whether a value in the recording is that of the frame.
type Comparison<'a> = Box<dyn Fn(&Value, &Frame) -> bool + 'a>;

/// What an entity of the map is compared with.
pub(crate) fn comparison<'a>(entity: &'a str, component: &'a str, frames: &[Frame]) -> Option<Comparison<'a>> {
    let mut mapper = Mapper::default();
    let added = |frame: &Frame| {
        mapper.add(frame);
        mapper.map()
    };
    let maps: Vec<Map> = frames.iter().map(added).collect();
    let first = frames[0].revolution.seq;
    let confidences: Vec<Option<f64>> = frames.iter().map(|frame| frame.junction.confidence).collect();
    let map_at = move |frame: &Frame| maps[(frame.revolution.seq - first) as usize].clone();
    Some(match (entity, component) {
        ("/flight/pose", "Tensor:data") => Box::new(|value, frame| {
            let pose = FlightAnswer::of(frame).pose.expect("a pose");
            let Value::Numbers(array) = value else { return false };
            array.numbers == Numbers::F64(vec![pose.translation.x, pose.translation.y, pose.rotation.angle()])
        }),
        ("/flight/pose", "LineStrips2D:strips") => Box::new(|value, frame| {
            let at_m = FlightAnswer::of(frame).pose.expect("a pose").translation;
            lines(value)[0].iter().all(|place| (place[0] - at_m.x).hypot(place[1] + at_m.y) < 2.1)
        }),
        ("/flight/pose", "Points2D:positions") => Box::new(|value, frame| {
            let at_m = FlightAnswer::of(frame).pose.expect("a pose").translation.vector;
            points(value) == [drawn(&Point2::from(at_m))]
        }),
        ("/flight/pose", "Points2D:colors") => Box::new(|value, _| wholes(value).len() == 1),
        ("/flight/scale", "LineStrips2D:strips") => Box::new(|value, _| {
            let bar = &lines(value)[0];
            [1.0, 2.0, 5.0, 10.0, 20.0].contains(&(bar[1][0] - bar[0][0]).round())
        }),
        ("/flight/scale", "Points2D:labels") => Box::new(|value, _| texts(value)[0].ends_with(" m")),
        ("/flight/scale", _) => Box::new(|_, _| true),
        ("/flight/here", "StateChange:state") => Box::new(|value, _| texts(value) == ["junction"]),
        ("/flight/path", "LineStrips2D:strips") => Box::new(|value, frame| {
            let last = lines(value)[0].last().expect("a place").clone();
            last == drawn(&Point2::from(FlightAnswer::of(frame).pose.expect("a pose").translation.vector))
        }),
        ("/flight/unsure", "Points2D:positions") => Box::new(move |value, frame| {
            let so_far = &confidences[..=(frame.revolution.seq - first) as usize];
            // An answer without a confidence is as unsure as the one before.
            let unsure = (0..so_far.len()).filter(|at| so_far[..=*at].iter().rev().find_map(|of| *of) < Some(0.5));
            points(value)
                .into_iter()
                .eq(unsure.map(|at| drawn(&Point2::new(STEP_M * (first as usize + at) as f64, 0.5))))
        }),
        ("/flight/walls" | "/flight/walls/new", "Points2D:positions") => Box::new(|value, frame| {
            let far_m = STEP_M * frame.revolution.seq as f64 + 13.0;
            points(value).iter().all(|wall| wall[0].hypot(wall[1]) < far_m)
        }),
        ("/flight/nodes", "Points2D:positions") => Box::new(move |value, frame| {
            points(value).into_iter().eq(map_at(frame).nodes.iter().map(|node| drawn(&node.position_m)))
        }),
        ("/flight/nodes", "Points2D:labels") | ("/flight/graph", "GraphNodes:node_ids") => {
            Box::new(move |value, frame| {
                let numbers = (0..map_at(frame).nodes.len()).map(|id| id.to_string());
                texts(value).iter().cloned().eq(numbers)
            })
        }
        ("/flight/nodes", "Arrows2D:vectors" | "Arrows2D:origins") => {
            Box::new(move |value, frame| points(value).len() == 3 * map_at(frame).nodes.len())
        }
        ("/flight/nodes", "Arrows2D:colors") => {
            Box::new(move |value, frame| wholes(value).len() == 3 * map_at(frame).nodes.len())
        }
        ("/flight/nodes", "Points2D:colors") | ("/flight/graph", "GraphNodes:colors") => {
            Box::new(move |value, frame| wholes(value).len() == map_at(frame).nodes.len())
        }
        ("/flight/passages", "LineStrips2D:strips") => {
            Box::new(move |value, frame| lines(value).len() == map_at(frame).passages.len())
        }
        ("/flight/graph", "GraphNodes:positions") => Box::new(move |value, frame| {
            points(value).into_iter().eq(map_at(frame).nodes.iter().map(|node| {
                let [x, y] = [node.position_m.x, -node.position_m.y].map(|along_m| f64::from(along_m as f32 * 8.0));
                vec![x, y]
            }))
        }),
        ("/flight/graph", "GraphNodes:labels") => {
            Box::new(move |value, frame| texts(value).len() == map_at(frame).nodes.len())
        }
        ("/flight/graph", "GraphEdges:edges") => Box::new(move |value, frame| {
            texts(value).iter().cloned().eq(map_at(frame).passages.iter().map(|of| format!("{} {}", of.from, of.to)))
        }),
        ("/flight/graph", "GraphEdges:graph_type") => Box::new(|_, _| true),
        ("/flight/summary", "TextDocument:text") => Box::new(move |value, frame| {
            let title = NoPlace::default().reason(&map_at(frame)).unwrap_or_else(|| map_at(frame).summary());
            let known = title.split(':').next().expect("a title");
            texts(value)[0].starts_with(&format!("## {known}"))
        }),
        _ => return None,
    })
}

fn drawn(place_m: &Point2<f64>) -> Vec<f64> {
    [place_m.x, -place_m.y].map(|along_m| f64::from(along_m as f32)).to_vec()
}

#[test]
fn what_is_drawn_grows_with_the_way_not_with_its_square() {
    let folder = tempfile::tempdir().unwrap();
    let drawings = |revolutions: u64| {
        let path = folder.path().join("flight.rrd");
        let mut frames: Vec<Frame> = (0..revolutions).map(|seq| cloud_frame(seq, 4)).collect();
        frames.iter_mut().for_each(fly);
        record(&path, &frames);
        Recording::read(&path).revolutions("/flight/path").len()
    };
    let [first, all] = [200, 400].map(drawings);
    assert!(first > 50 && all > first && all < first + 60, "{first} of 200, {all} of 400");
}
