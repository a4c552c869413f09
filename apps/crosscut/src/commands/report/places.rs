//! The places that the vehicle passed, each with the clearest of its scans.

use std::fmt::Write as _;

use crosscut_evaluate::chart::{Axis, COLOURS, Chart, INK, line, page, text};
use crosscut_evaluate::panel::{Panel, sheet};
use crosscut_flight::{FlightAnswer, Here, HereKind, Map, Steady};
use crosscut_stage::{Frame, counted, junction_of};

use crate::output::Look;
use crate::output::typeset::escaped;

/// At most this many places are shown.
const MOST_PLACES: usize = 60;

/// What the pictures of a card show.
const LEGEND: &str = "Left in each card: the returns, each wall in its colour, around the vehicle, which heads up, and a scale of 5 m; a dashed line \
    leads to each opening, and the bar across it is as wide as the opening. Right: the eigenvalues of L; the blue ones, below τ \
    (dashes), are counted in k, and exact zeros stand on the floor at 1e-18. The margin is how many decades τ may move \
    before k changes. k also counts pieces that are no wall: islands, and clusters of too few returns.";

/// Size of the picture of eigenvalues.
const SPECTRUM_PX: [f64; 2] = [198.0, 130.0];
/// Exponents at the ends of its axis.
const EXPONENTS: [i32; 2] = [-18, 0];

/// Stays at places other than passages, in order.
#[derive(Default)]
pub(super) struct Places {
    stays: Vec<Stay>,
    is_open: bool,
    has_more: bool,
}

/// Revolutions in a row at one place.
struct Stay {
    what: String,
    /// What its scans have to show.
    shown: Shows,
    seqs: [u64; 2],
    stamps_ns: [u64; 2],
    clearest: Scan,
}

/// What a scan has to show to agree with the name of its stay.
#[derive(Clone, Copy)]
enum Shows {
    Walls(usize),
    Ways(usize),
    Anything,
}

/// The scan of a stay that is shown.
struct Scan {
    walls: usize,
    seq: u64,
    confidence: Option<f64>,
    panel: Panel,
    eigenvalues: Vec<f64>,
    tolerance: f64,
    k: usize,
    margin_decades: Option<f64>,
    openings: Vec<[f64; 3]>,
    /// In words.
    ways: Vec<String>,
    notes: Vec<String>,
}

impl Places {
    /// Adds the next revolution of the flight.
    pub(super) fn take(&mut self, frame: &Frame) {
        let Some((what, shown)) = FlightAnswer::of(frame).steady.as_ref().and_then(name) else {
            self.is_open = false;
            return;
        };
        let (seq, stamp_ns) = (frame.revolution.seq, frame.revolution.stamp_ns);
        if let Some(stay) = self.stays.last_mut().filter(|stay| self.is_open && stay.what == what) {
            (stay.seqs[1], stay.stamps_ns[1]) = (seq, stamp_ns);
            stay.see(frame);
            return;
        }
        self.is_open = self.stays.len() < MOST_PLACES;
        if self.is_open {
            self.stays.push(Stay { what, shown, seqs: [seq; 2], stamps_ns: [stamp_ns; 2], clearest: Scan::of(frame) });
        } else {
            self.has_more = true;
        }
    }

    /// The places as HTML, with the number of each in the map.
    pub(super) fn html(&self, map: &Map, look: &Look) -> String {
        if self.stays.is_empty() {
            return "<p>The vehicle passed no junction, dead end or chamber.</p>\n".to_owned();
        }
        let visits = counted(self.stays.len() as u64, "visit");
        let record = look.record.as_ref().map_or_else(String::new, |record| {
            format!(
                " The command in a card opens its scan stage by stage; it needs <code>{}</code> first.",
                escaped(record)
            )
        });
        let mut html = format!(
            "<p>{visits}, a card each, in the order of the flight: a place that the vehicle came back to has several.{record}</p>\n\
             <p class=\"legend\">{LEGEND}</p>\n<div class=\"places\">\n"
        );
        for stay in &self.stays {
            html += &stay.html(map, look);
        }
        html += "</div>\n";
        if self.has_more {
            // Writing to a string cannot fail.
            let _ = writeln!(html, "<p>The first {MOST_PLACES} are shown; there are more.</p>");
        }
        html
    }
}

/// What a place is called, and what its scans show; `None` for passages.
fn name(steady: &Steady) -> Option<(String, Shows)> {
    match &steady.here {
        Some(Here { kind: HereKind::Junction, ways, .. }) => Some((junction_of(ways.len()), Shows::Ways(ways.len()))),
        Some(Here { kind: HereKind::DeadEnd, .. }) => Some(("dead end".to_owned(), Shows::Ways(1))),
        Some(Here { kind: HereKind::Chamber, .. }) => Some(("chamber".to_owned(), Shows::Anything)),
        Some(Here { kind: HereKind::Passage, .. }) => None,
        None => (steady.junctions != 2)
            .then(|| (format!("{} in view", counted(steady.junctions as u64, "wall")), Shows::Walls(steady.junctions))),
    }
}

impl Stay {
    /// Takes the scan if it shows the stay better: one that counts what the stay is called comes before any other, then
    /// the more confident one.
    fn see(&mut self, frame: &Frame) {
        let agrees = self.agrees(frame.junction.openings.len(), frame.junction.junctions);
        let better = frame.junction.confidence > self.clearest.confidence;
        let agreed = self.agrees(self.clearest.openings.len(), self.clearest.walls);
        if (agrees && !agreed) || (agrees == agreed && better) {
            self.clearest = Scan::of(frame);
        }
    }

    /// Whether a scan with this many openings and walls shows what the stay is called.
    fn agrees(&self, openings: usize, walls: usize) -> bool {
        match self.shown {
            Shows::Walls(of) => walls == of,
            Shows::Ways(of) => openings == of,
            Shows::Anything => true,
        }
    }

    fn html(&self, map: &Map, look: &Look) -> String {
        let is_visit = |[from_ns, to_ns]: &[u64; 2]| *from_ns <= self.stamps_ns[1] && self.stamps_ns[0] <= *to_ns;
        let node = map.nodes.iter().position(|node| node.visits.iter().any(is_visit));
        let stretch = |node: usize| match map.stretches_from_ns.len() {
            0 | 1 => String::new(),
            _ => format!(", stretch {}", map.stretch_of(&map.nodes[node]) + 1),
        };
        let node = node.map(|node| format!(" · node {node} of the map{}", stretch(node))).unwrap_or_default();
        let [from, to] = self.seqs;
        let Scan { seq, confidence, k, margin_decades, .. } = self.clearest;
        let margin = margin_decades.map(|decades| format!(", margin {decades:.1} decades")).unwrap_or_default();
        let confidence = confidence.map_or("unknown".to_owned(), |confidence| format!("{confidence:.2}"));
        let openings = self.clearest.openings.iter().map(|[bearing_rad, width_m, range_m]| {
            format!("<li>{:+.0}°, {width_m:.1} m wide, {range_m:.1} m away</li>", bearing_rad.to_degrees())
        });
        let ways = self.clearest.ways.iter().map(|way| format!("<li>way on: {way}</li>"));
        let notes = self.clearest.notes.iter().map(|note| format!("<li>{}</li>", escaped(note)));
        let shown = &self.clearest;
        let disagrees = (!self.agrees(shown.openings.len(), shown.walls)).then(|| {
            format!(
                "<br>No single scan here shows this: it is what several scans say together. This one has {} and {}.",
                counted(shown.walls as u64, "wall"),
                counted(shown.openings.len() as u64, "opening")
            )
        });
        format!(
            "<figure>\n<figcaption><b>{}</b>{node}<br><a href=\"#over-time\">revolutions {from} to {to}</a>; scan {seq} is shown: confidence \
             {confidence}, k = {k}{margin}{}<br><code>{}</code></figcaption>\n<div>{}{}</div>\n<ul>{}</ul>\n<ul class=\"notes\">{}</ul>\n</figure>\n",
            escaped(&self.what),
            disagrees.unwrap_or_default(),
            escaped(&look.at(seq)),
            sheet(std::slice::from_ref(&self.clearest.panel), 1),
            self.clearest.spectrum(),
            openings.chain(ways).collect::<String>(),
            notes.collect::<String>(),
        )
    }
}

impl Scan {
    fn of(frame: &Frame) -> Self {
        let Frame { revolution, spectrum, junction, notes, .. } = frame;
        let openings =
            junction.openings.iter().map(|opening| [opening.bearing_rad, opening.width_m, opening.range_m()]);
        Self {
            walls: junction.junctions,
            seq: revolution.seq,
            confidence: junction.confidence,
            panel: Panel::of_answer(counted(junction.junctions as u64, "wall"), frame),
            eigenvalues: spectrum.eigenvalues.iter().take(spectrum.k + 6).copied().collect(),
            tolerance: spectrum.tolerance,
            k: spectrum.k,
            margin_decades: spectrum.margin_decades,
            openings: openings.collect(),
            ways: junction.ways.iter().flatten().map(|way| format!("{}, p = {:.2}", way.words(), way.p)).collect(),
            notes: notes.iter().map(str::to_owned).collect(),
        }
    }

    /// The smallest eigenvalues, and the tolerance below which they count as zero.
    fn spectrum(&self) -> String {
        let [width_px, height_px] = SPECTRUM_PX;
        let x = Axis::linear([0.0, self.eigenvalues.len().max(1) as f64], [40.0, width_px - 6.0]);
        let mut chart = Chart::new(x, Axis::powers_of_ten(EXPONENTS, [height_px - 22.0, 8.0]));
        for exponent in (EXPONENTS[0]..=EXPONENTS[1]).step_by(6) {
            chart.y_tick(10f64.powi(exponent), &format!("1e{exponent}"));
        }
        let [left_px, tolerance_px] = chart.px([0.0, self.tolerance]);
        let dashed = line([left_px, tolerance_px], [width_px - 6.0, tolerance_px], COLOURS[3]);
        chart.add(dashed.set("stroke-dasharray", "4 3"));
        let places = self.eigenvalues.iter().enumerate().map(|(i, value)| [i as f64 + 0.5, value.max(0.0)]);
        let (zeros, others): (Vec<_>, Vec<_>) = places.partition(|[at, _]| (*at as usize) < self.k);
        chart.dots(zeros, COLOURS[0], 6.0, 1.0);
        chart.dots(others, INK, 5.0, 1.0);
        let caption = text("eigenvalues λ, and τ", [40.0, height_px - 6.0], "start");
        page(width_px, height_px, 10.0).add(chart).add(caption).to_string()
    }
}
