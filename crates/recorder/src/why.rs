//! Why the count is what it is: as text and drawn on the scan; and which revolutions are worth a look.

use crosscut_explain::{Change, Edge, Event, Explanation, Watch};
use crosscut_stage::{Frame, Point, Revolution, Weights};
use rerun::{
    AsComponents, LineStrips3D, Points3D, Radius, RecordingStream, RecordingStreamResult, TextDocument, TextLog,
    TextLogLevel,
};

use crate::beam_order::LARGEST_SIDE;
use crate::colors::{BORDER, EDGE, STRONGEST, TOLERANCE, WEAK_EDGE, WEAKEST, color, name_of};
use crate::rows::Rows;
use crate::scan::{within_view, xyz};
use crate::schema::{AFFINITY_LINKS, LOG, REPORT_WHY, SCAN_LINKS, SCAN_LINKS_EDGES};
use crate::tracks::{Classes, Tracks};

/// Edges of a sparse W that are drawn for each return at most; of more of them, every m-th is drawn.
const DRAWN_A_RETURN: usize = 4;
/// How far below the edges that decide the count their dark borders lie; the views look down.
const BORDER_BELOW_M: f32 = 0.05;
/// A mark fits into the view if its middle is no farther out than these shares of the view's reach: ahead or behind, and
/// to either side.
const MARK_ROOM: [f64; 2] = [1.08, 0.78];
/// Width of a mark, as a share of the view's reach.
const MARK_WIDTH: f64 = 0.85;
/// Height of a mark, as a share of the view's reach.
const MARK_HEIGHT: f64 = 0.18;
/// Edges of a sparse W with a smaller weight are highlighted.
const WEAK: f64 = 0.1;

/// Look of the entities.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    let marks = Points3D::update_fields().with_radii([ui(0.0)]).with_colors([color(TOLERANCE)]);
    let lines = LineStrips3D::update_fields().with_radii([ui(2.0)]);
    rec.log_static(SCAN_LINKS.path, &[&lines as &dyn AsComponents, &marks])?;
    let edges = LineStrips3D::update_fields().with_radii([ui(3.0)]).with_colors([color(BORDER)]);
    rec.log_static(SCAN_LINKS_EDGES.path, &edges)
}

/// The text of `/report/why` for a finished frame, as a recording has it that begins with this revolution.
pub fn why(frame: &Frame) -> String {
    text(&Explanation::of(frame), frame, &Tracks::default().classes_of(frame))
}

fn text(explanation: &Explanation, frame: &Frame, classes: &Classes) -> String {
    explanation.to_markdown(frame, &|wall| name_of(classes.of_wall(Some(wall))))
}

/// The explanation of one revolution, drawn in views that reach `reach_m`, and whether it is worth a look.
pub(crate) fn log(rows: &mut Rows, frame: &Frame, classes: &Classes, reach_m: f64, watch: &mut Watch) {
    let explanation = Explanation::of(frame);
    rows.log(&REPORT_WHY, &TextDocument::from_markdown(text(&explanation, frame, classes)));
    log_decisive_links(rows, &frame.revolution, &explanation, reach_m);
    for event in watch.events(frame) {
        let level = match event {
            Event::LowMargin { .. } => TextLogLevel::WARN,
            _ => TextLogLevel::INFO,
        };
        rows.log(&LOG, &TextLog::new(event.to_string()).with_level(level));
    }
}

/// The weakest edge inside each wall and the strongest between two, with a mark at those that would change the count.
fn log_decisive_links(rows: &mut Rows, revolution: &Revolution, explanation: &Explanation, reach_m: f64) {
    let weakest = explanation.walls.iter().filter_map(|wall| Some((wall.weakest?, WEAKEST)));
    let links = weakest.chain(explanation.strongest().map(|(_, link)| (link, STRONGEST)));
    let (lines, colors): (Vec<_>, Vec<_>) =
        links.map(|(link, rgba)| (line(revolution, link.returns), color(rgba))).unzip();
    let (at, labels): (Vec<_>, Vec<_>) =
        explanation.changes.iter().filter_map(|change| Some(mark(revolution, change, change.edge?))).unzip();
    let at = readable(at, reach_m);
    let below = |line: &[[f32; 3]; 2]| line.map(|[x, y, z]| [x, y, z - BORDER_BELOW_M]);
    rows.log(&SCAN_LINKS_EDGES, &LineStrips3D::new(lines.iter().map(below)));
    let lines = LineStrips3D::new(lines).with_colors(colors);
    let marks = Points3D::new(at.iter().map(xyz)).with_labels(labels).with_show_labels(true);
    rows.log(&SCAN_LINKS, &[&lines as &dyn AsComponents, &marks]);
}

fn line(revolution: &Revolution, returns: [usize; 2]) -> [[f32; 3]; 2] {
    returns.map(|i| xyz(&revolution.points_m[i]))
}

/// A mark in the middle of the edge, such as "k = 4 if broken: 3e-5".
fn mark(revolution: &Revolution, change: &Change, link: Edge) -> (Point, String) {
    let [a, b] = link.returns.map(|i| revolution.points_m[i]);
    let what = if change.walls.len() == 1 { "broken" } else { "joined" };
    (nalgebra::center(&a, &b), format!("k = {} if {what}: {:.0e}", change.k, link.weight))
}

/// The marks, moved into the view and away from marks that they would cover.
fn readable(marks: Vec<Point>, reach_m: f64) -> Vec<Point> {
    let mut placed: Vec<Point> = Vec::new();
    for mark in marks {
        let mut at = within_view(mark, MARK_ROOM, reach_m);
        let covers = |a: &Point, b: &Point| {
            (a.x - b.x).abs() < MARK_HEIGHT * reach_m && (a.y - b.y).abs() < MARK_WIDTH * reach_m
        };
        while let Some(other) = placed.iter().find(|other| covers(&at, other)) {
            at.x = other.x - 1.01 * MARK_HEIGHT * reach_m;
        }
        placed.push(at);
    }
    placed
}

/// The edges of a sparse W, the weak ones highlighted. Of the edges of weight 1 only each return's to the next is drawn:
/// the others would lie upon them.
pub(crate) fn log_graph(rows: &mut Rows, frame: &Frame) {
    let (weights, n) = (&frame.affinity.weights, frame.revolution.len());
    if !matches!(weights, Weights::Sparse(_)) || weights.n() != n || n > LARGEST_SIDE {
        return;
    }
    let mut links = Vec::new();
    let mut linked = 0; // returns before this one have their edge to the next
    weights.for_each(|i, j, w| {
        if i < j && w > 0.0 && (w < 1.0 || i >= linked) {
            links.push(([i, j], w));
            linked = i + 1;
        }
    });
    let every = links.len().div_ceil(DRAWN_A_RETURN * n.max(1)).max(1);
    let (lines, colors): (Vec<_>, Vec<_>) = (links.into_iter().step_by(every))
        .map(|(returns, w)| (line(&frame.revolution, returns), color(if w < WEAK { WEAK_EDGE } else { EDGE })))
        .unzip();
    let lines = LineStrips3D::new(lines).with_colors(colors).with_radii([Radius::new_ui_points(0.5)]);
    rows.log(&AFFINITY_LINKS, &lines);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_stay_in_the_view_without_covering_each_other() {
        let reach_m = 10.0;
        let at = |x: f64, y: f64| Point::new(x, y, 0.0);
        assert_eq!(
            readable(vec![at(3.0, 0.0), at(-3.0, 1.0)], reach_m),
            [at(3.0, 0.0), at(-3.0, 1.0)],
            "marks that fit are not moved"
        );
        for marks in [vec![at(0.0, -10.0), at(0.5, 10.0)], vec![at(2.0, 1.0); 3], vec![at(-12.0, 0.0), at(12.0, 0.0)]] {
            let placed = readable(marks.clone(), reach_m);
            assert!(placed.iter().all(|at| at.y.abs() < 7.9 && at.x.abs() < 10.9), "{placed:?}");
            for (i, a) in placed.iter().enumerate() {
                let apart = |b: &Point| (a.x - b.x).abs() >= 1.8 || (a.y - b.y).abs() >= 8.5;
                assert!(placed[..i].iter().all(apart), "{marks:?} are placed at {placed:?}");
            }
        }
    }
}
