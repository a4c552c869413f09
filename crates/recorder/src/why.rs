//! Why the count is what it is: as text and drawn on the scan; and which revolutions are worth a look.

use crosscut_explain::{Doubt, Event, Explanation, Watch};
use crosscut_flight::FlightAnswer;
use crosscut_stage::{Frame, Point, Revolution, Weights, counted};
use rerun::{
    AsComponents, Color, LineStrips3D, MediaType, Points2D, Points3D, Radius, RecordingStream, RecordingStreamResult,
    StateChange, StateConfiguration, TextDocument, TextLog, TextLogLevel,
};

use crate::beam_order::{BeamOrder, LARGEST_SIDE};
use crate::colors::{DOUBTS, EDGE, NAMED, OTHER, WEAK_EDGE, color};
use crate::matrices::is_drawn;
use crate::rows::Rows;
use crate::scan::{within_view, xyz};
use crate::schema::{AFFINITY_LINKS, AFFINITY_MARKS, LOG, REPORT_DOUBT, REPORT_WHY, SCAN_LINKS};
use crate::tracks::{Classes, Tracks};

/// Edges of a sparse W that are drawn for each return at most; of more of them, every m-th is drawn.
const DRAWN_A_RETURN: usize = 4;
/// A mark fits into the view if its middle is no farther out than these shares of the view's reach: ahead or behind, and
/// to either side.
const MARK_ROOM: [f64; 2] = [1.08, 0.78];
/// Width of a mark, as a share of the view's reach.
const MARK_WIDTH: f64 = 0.85;
/// Height of a mark, as a share of the view's reach.
const MARK_HEIGHT: f64 = 0.18;
/// Edges of a sparse W with a smaller weight are highlighted.
const WEAK: f64 = 0.1;

/// The level of the log for answers that are right or wrong by chance.
pub(crate) const UNSURE: &str = "UNSURE";

/// Look of the entities.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    let marks = Points3D::update_fields().with_radii([ui(0.0)]).with_show_labels(true);
    let lines = LineStrips3D::update_fields().with_radii([ui(2.0)]);
    rec.log_static(SCAN_LINKS.path, &[&lines as &dyn AsComponents, &marks])?;
    rec.log_static(REPORT_WHY.path, &TextDocument::update_fields().with_media_type(MediaType::MARKDOWN))?;
    let names = Doubt::ALL.map(Doubt::name);
    let doubts = StateConfiguration::new().with_values(names).with_colors(DOUBTS.map(color));
    rec.log_static(REPORT_DOUBT.path, &doubts)
}

/// A doubt lasts until this many revolutions in a row are less doubtful: in a long flight shorter stretches cannot be seen.
const LASTING: u32 = 10;

/// What is doubtful, if it is not what was logged before.
#[derive(Default)]
pub(crate) struct Doubts {
    shown: Option<Doubt>,
    /// Revolutions in a row that were less doubtful than that.
    less: u32,
    /// A new file has to say what is shown.
    is_due: bool,
}

impl Doubts {
    pub(crate) fn log(&mut self, rows: &mut Rows, doubt: Doubt) {
        let is_due = std::mem::take(&mut self.is_due);
        if (self.is_new(doubt) || is_due)
            && let Some(shown) = self.shown
        {
            rows.log(&REPORT_DOUBT, &StateChange::single(shown.name()));
        }
    }

    /// What is shown is logged at the next revolution, whether it changes or not.
    pub(crate) fn repeat(&mut self) {
        self.is_due = true;
    }

    /// Whether `doubt` is shown from here on.
    fn is_new(&mut self, doubt: Doubt) -> bool {
        let is_less = self.shown.is_some_and(|shown| doubt > shown);
        self.less = if is_less { self.less + 1 } else { 0 };
        if is_less && self.less < LASTING {
            return false;
        }
        self.less = 0;
        self.shown.replace(doubt) != Some(doubt)
    }
}

/// The text of `/report/why` for a finished frame, as a recording has it that begins with this revolution; without the file, the
/// preset and the truth, which a frame does not know.
pub fn why(frame: &Frame) -> String {
    let classes = Tracks::default().classes_of(frame);
    Explanation::of(frame).to_markdown(frame, &|number| classes.name(number))
}

/// The explanation of one revolution, and whether it is worth a look.
pub(crate) fn log(rows: &mut Rows, frame: &Frame, explanation: &Explanation, told: &Told, watch: &mut Watch) {
    let color_of = |number| told.classes.name(number);
    let mut paragraphs = vec![explanation.title(frame, &color_of)];
    paragraphs.extend(told.changed.clone());
    let legend = if frame.affinity.dual.is_some() { LEGEND_OF_WAYS } else { LEGEND };
    paragraphs.push(told.context(frame));
    let steady = FlightAnswer::of(frame).steady.as_ref().map(|steady| steady.words(frame.revolution.stamp_ns));
    paragraphs.extend(
        steady.map(|words| format!("Steady: {words} In **7** they are arrows from the sensor, *yellow* if judged.")),
    );
    paragraphs.extend([legend.into(), explanation.details(frame, &color_of)]);
    rows.log(&REPORT_WHY, &TextDocument::new(paragraphs.join("\n\n")));
    for event in watch.events(frame, told.truth) {
        let level = match event {
            Event::Wrong { .. } => TextLogLevel::ERROR,
            Event::Unsure { .. } | Event::LowMargin { .. } => UNSURE,
            _ => TextLogLevel::WARN,
        };
        rows.log(&LOG, &TextLog::new(event.to_string()).with_level(level));
    }
}

/// Marks of the edges that decide the count on the picture of W, with their weights where W is sparse.
pub(crate) fn log_marks(rows: &mut Rows, frame: &Frame, order: &BeamOrder, decisive: &[Decisive]) {
    let is_sparse = matches!(frame.affinity.weights, Weights::Sparse(_));
    let drawn = decisive.iter().filter(|_| is_drawn(frame)).map(|Decisive { returns, rgba, .. }| {
        let [i, j] = returns.map(|i| order.places[i] as f32);
        ([i.max(j), i.min(j)], (color(*rgba), format!("{:.0e}", weight(&frame.affinity.weights, *returns))))
    });
    let (at, (colors, weights)): (Vec<_>, (Vec<_>, Vec<_>)) = drawn.unzip();
    let marks = Points2D::new(at).with_colors(colors);
    let marks = if is_sparse { marks.with_labels(weights) } else { marks };
    rows.log(&AFFINITY_MARKS, &marks);
}

/// A gap that decides the count.
pub(crate) struct Decisive {
    returns: [usize; 2],
    rgba: u32,
    /// What there would be: "4 walls if joined".
    label: String,
}

/// The gap that the sentence names, then the edges of other changes of k.
pub(crate) fn decisive(explanation: &Explanation) -> Vec<Decisive> {
    let what = |walls: &[u32]| if walls.len() == 1 { "broken" } else { "joined" };
    let nearest = explanation.nearest.as_ref().map(|near| {
        let label = format!("{} if {}", counted(near.count as u64, "wall"), what(&near.walls));
        Decisive { returns: near.returns, rgba: NAMED, label }
    });
    let sorted = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
    let named = nearest.as_ref().map(|near| sorted(near.returns));
    let changes = explanation.changes.iter().filter_map(|change| {
        let edge = change.edge.filter(|edge| Some(sorted(edge.returns)) != named)?;
        let label = format!("k = {} if {}: {:.0e}", change.k, what(&change.walls), edge.weight);
        Some(Decisive { returns: edge.returns, rgba: OTHER, label })
    });
    nearest.into_iter().chain(changes).collect()
}

/// W_ij; 0 where a sparse W has no entry.
fn weight(weights: &Weights, [i, j]: [usize; 2]) -> f64 {
    match weights {
        Weights::Dense(w) => w[(i, j)],
        Weights::Sparse(w) => {
            let (columns, values) = w.row(i);
            columns.binary_search(&(j as u32)).map_or(0.0, |at| values[at])
        }
        _ => 0.0,
    }
}

/// What the text of a revolution says beside its explanation.
pub(crate) struct Told<'a> {
    pub(crate) classes: &'a Classes,
    /// The file and the preset.
    pub(crate) source: &'a str,
    /// The stamp of the first revolution.
    pub(crate) first_ns: u64,
    /// The true number of walls.
    pub(crate) truth: Option<usize>,
    /// What became of the walls of the revolution before, if the count is another one.
    pub(crate) changed: Option<String>,
}

impl Told<'_> {
    /// "tee.mcap, preset paper · revolution 107 · 10.7 s · truth: 3 walls".
    fn context(&self, frame: &Frame) -> String {
        let revolution = &frame.revolution;
        let seconds = revolution.stamp_ns.saturating_sub(self.first_ns) as f64 * 1e-9;
        let mut parts = vec![format!("revolution {}", revolution.seq), format!("{seconds:.1} s")];
        if !self.source.is_empty() {
            parts.insert(0, self.source.to_owned());
        }
        parts.extend(self.truth.map(|truth| {
            let verdict = if truth == frame.junction.junctions { "as counted" } else { "**the count is wrong**" };
            format!("truth: {}, {verdict}", counted(truth as u64, "wall"))
        }));
        parts.join(" · ")
    }
}

/// The file and the preset that a text of a revolution names: "tee.mcap, preset paper".
pub(crate) fn source_in(text: &str) -> Option<&str> {
    let line = text.lines().find(|line| line.contains("revolution ") && line.contains(" · "))?;
    line.split(" · ").next().filter(|part| !part.starts_with("revolution "))
}

/// What the colours of edges and labels mean.
const LEGEND: &str = "In **1** and **2**, the *pink* line is the gap named here, a *yellow* one another edge that would change k; the \
    *pink* ring is around what tips the count first. In **7**, *pink* arrows are openings with their free width; it is less than \
    the length from end to end.";

/// What the colours of arrows, cells and labels mean where ways on are counted.
const LEGEND_OF_WAYS: &str = "In **1**, arrows are ways on, and points in their directions have their colours. In **6**, *pink* is what parts \
    two ways: how far the vehicle gets there, of the distance with which they would be one. In **7**, *pink* arrows are openings of the \
    level view.";

/// Lines across the gaps that decide the count, each with a mark.
pub(crate) fn log_decisive(rows: &mut Rows, revolution: &Revolution, decisive: &[Decisive], reach_m: f64) {
    let (lines, colors): (Vec<_>, Vec<_>) =
        decisive.iter().map(|link| (line(revolution, link.returns), color(link.rgba))).unzip();
    let at = readable(decisive.iter().map(|link| beneath(revolution, link.returns)).collect(), reach_m);
    let labels = decisive.iter().map(|link| link.label.as_str());
    let lines = LineStrips3D::new(lines).with_colors(colors.iter().copied());
    let marks = Points3D::new(at.iter().map(xyz)).with_colors(colors).with_labels(labels);
    rows.log(&SCAN_LINKS, &[&lines as &dyn AsComponents, &marks]);
}

fn line(revolution: &Revolution, returns: [usize; 2]) -> [[f32; 3]; 2] {
    returns.map(|i| xyz(&revolution.points_m[i]))
}

/// The place of a mark beneath a gap. A label hangs below its point.
fn beneath(revolution: &Revolution, returns: [usize; 2]) -> Point {
    let [a, b] = returns.map(|i| revolution.points_m[i]);
    let middle = nalgebra::center(&a, &b);
    Point::new(a.x.min(b.x), middle.y, middle.z)
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
    let is_of_returns = frame.affinity.dual.is_none() && weights.n() == n;
    if !matches!(weights, Weights::Sparse(_)) || !is_of_returns || n > LARGEST_SIDE {
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
    let (lines, colors): (Vec<_>, Vec<_>) =
        chains(&frame.revolution, links.into_iter().step_by(every)).into_iter().unzip();
    let lines = LineStrips3D::new(lines).with_colors(colors).with_radii([Radius::new_ui_points(0.5)]);
    rows.log(&AFFINITY_LINKS, &lines);
}

/// Lines along the edges, each with its colour. Strong edges that begin where another one ends continue its line, which
/// takes half of the space.
fn chains(revolution: &Revolution, links: impl Iterator<Item = ([usize; 2], f64)>) -> Vec<(Vec<[f32; 3]>, Color)> {
    let mut lines: Vec<(Vec<[f32; 3]>, Color)> = Vec::new();
    let mut last = None; // the line of the last strong edge, and the return that it ends at
    for ([i, j], w) in links {
        match last {
            Some((at, end)) if w >= WEAK && end == i => {
                let (line, _): &mut (Vec<_>, _) = &mut lines[at];
                line.push(xyz(&revolution.points_m[j]));
                last = Some((at, j));
            }
            _ => {
                if w >= WEAK {
                    last = Some((lines.len(), j));
                }
                lines.push((line(revolution, [i, j]).to_vec(), color(if w < WEAK { WEAK_EDGE } else { EDGE })));
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strong_edges_in_a_row_are_one_line_and_weak_ones_a_line_each() {
        let points_m = (0..6).map(|x| Point::new(f64::from(x), 0.0, 0.0)).collect();
        let revolution = Revolution { points_m, ..Revolution::default() };
        let links = [([0, 1], 1.0), ([0, 3], 0.01), ([1, 2], 0.5), ([3, 4], 1.0), ([4, 5], 1.0)];
        let lines = chains(&revolution, links.into_iter());
        let along = |line: &(Vec<[f32; 3]>, Color)| line.0.iter().map(|[x, ..]| *x).collect::<Vec<f32>>();
        let expected = [vec![0.0, 1.0, 2.0], vec![0.0, 3.0], vec![3.0, 4.0, 5.0]];
        assert_eq!(lines.iter().map(along).collect::<Vec<_>>(), expected);
        assert!(lines[1].1 == color(WEAK_EDGE) && lines[2].1 == color(EDGE));
    }

    #[test]
    fn a_doubt_begins_at_once_and_ends_after_a_while() {
        let mut doubts = Doubts::default();
        assert!(doubts.is_new(Doubt::None) && doubts.is_new(Doubt::Unsure) && doubts.is_new(Doubt::Wrong));
        for _ in 0..3 {
            assert!((1..LASTING).all(|_| !doubts.is_new(Doubt::None)) && !doubts.is_new(Doubt::Wrong), "it lasts");
        }
        assert!((1..LASTING).all(|_| !doubts.is_new(Doubt::None)) && doubts.is_new(Doubt::None));
        assert!(!doubts.is_new(Doubt::None) && doubts.is_new(Doubt::Wrong));
    }

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
