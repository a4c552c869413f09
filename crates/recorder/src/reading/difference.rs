//! Two recordings compared row by row, whatever the chunks that they were written in.
//!
//! Compared is what was made of each revolution. Left out are the time that it took (`/timing`), what holds for the
//! whole flight (configuration, colours, explanations), the layout, and which file it is. What is logged when it
//! changes, and again where a file begins, is compared as it holds. U is compared by its span, and what is drawn from
//! it is left out.

use std::iter::Peekable;

use crosscut_stage::Step;

use super::recording::is_drawing;
use super::rows::{Cell, Rows};
use super::value::Array;
use super::{ReadError, Recording, Row, Value, span};
use crate::parts::MARK;

/// Entities of ingest that lie beside those of the report.
const SCANNED: [&str; 3] = ["/scan/ranges", "/scan/seen", "/scan/beams"];

/// Entities that are not made of revolutions.
const LEFT_OUT: [&str; 3] = ["/timing", "/report/axis", MARK];

/// Entities that are logged when they change, and where a file begins.
const HOLDING: [&str; 3] = ["/scan/beams", "/scan/beams/wire", "/kmeans/profile/axes"];

/// Drawings of what stands in the coordinates of U, which other eigenvectors of the same span draw otherwise.
const DRAWN_FROM_U: [(&str, &str); 2] =
    [("/spectral/embedding", "Points3D:positions"), ("/kmeans/centroids", "Points3D:positions")];

/// How two recordings differ.
#[derive(Debug, Default)]
pub struct Differences {
    /// Where they differ first: the earliest revolution, and at it the earliest step.
    pub first: Option<Difference>,
    /// Every component that differs, by step.
    pub components: Vec<Difference>,
    /// Rows that both have.
    pub compared: u64,
}

/// A component that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The step that made it.
    pub step: Step,
    /// The entity.
    pub entity: String,
    /// The component.
    pub component: String,
    /// The first revolution at which it differs.
    pub revolution: i64,
    /// At how many revolutions it differs.
    pub revolutions: u64,
    /// How it differs at the first of them.
    pub how: String,
}

/// Compares all rows. Numbers are the same when they differ by `tolerance` at most; NaN is the same as NaN. A dense U
/// is the same when it spans the same, and centroids when their inner products are the same (`span.rs`). What a damaged
/// recording lacks is no difference.
///
/// # Errors
/// When a file cannot be read again.
pub fn differences(a: &Recording, b: &Recording, tolerance: f64) -> Result<Differences, ReadError> {
    let mut found = Differences::default();
    let names = a.entities().keys().chain(b.entities().keys().filter(|name| !a.entities().contains_key(*name)));
    let is_whole = [a, b].map(|recording| recording.damages().is_empty());
    for entity in names.filter(|name| !LEFT_OUT.iter().any(|left_out| name.starts_with(left_out))) {
        let rows = [of(a, entity)?, of(b, entity)?];
        EntityComparison { entity, tolerance, is_whole, found: &mut found }.compare(rows)?;
    }
    found.components.sort_by_key(|d| (d.step as usize, d.revolution, is_drawing(&d.component)));
    found.first = found.components.iter().min_by_key(|d| (d.revolution, d.step as usize)).cloned();
    Ok(found)
}

/// The rows of an entity, also if there is none.
fn of<'a>(recording: &'a Recording, entity: &str) -> Result<Option<Rows<'a>>, ReadError> {
    recording.entities().contains_key(entity).then(|| recording.rows(entity)).transpose()
}

struct EntityComparison<'a> {
    entity: &'a str,
    tolerance: f64,
    /// Whether the first and the second recording lack nothing.
    is_whole: [bool; 2],
    found: &'a mut Differences,
}

impl EntityComparison<'_> {
    /// Goes through both by revolution.
    fn compare(&mut self, [a, b]: [Option<Rows>; 2]) -> Result<(), ReadError> {
        let [mut a, mut b] = [a, b].map(|rows| rows.into_iter().flatten().peekable());
        let is_held = self.is_whole.map(|is_whole| is_whole && HOLDING.contains(&self.entity));
        let mut latest: [Option<Row>; 2] = [None, None];
        while let Some(revolution) = next(&mut a).into_iter().chain(next(&mut b)).min() {
            let rows = [take(&mut a, revolution)?, take(&mut b, revolution)?];
            let is_there = [0, 1].map(|side| rows[side].is_some() || is_held[side]);
            for (latest, row) in latest.iter_mut().zip(rows) {
                *latest = row.or(latest.take());
            }
            match [0, 1].map(|side| latest[side].as_ref().filter(|_| is_there[side])) {
                [Some(a), Some(b)] => self.compare_rows(revolution, a, b),
                [Some(row), None] if self.is_whole[1] => self.note_missing(row, "second"),
                [None, Some(row)] if self.is_whole[0] => self.note_missing(row, "first"),
                _ => {}
            }
        }
        Ok(())
    }

    fn compare_rows(&mut self, revolution: i64, a: &Row, b: &Row) {
        self.found.compared += 1;
        if a.stamp_ns != b.stamp_ns && self.entity == "/scan/returns" {
            let [a_ns, b_ns] = [a, b].map(|row| row.stamp_ns.unwrap_or_default());
            self.note("stamp", revolution, format!("{a_ns} and {b_ns} ns"));
        }
        let mut names: Vec<&str> = a.components().chain(b.components()).collect();
        names.sort_unstable();
        names.dedup();
        names.retain(|name| !DRAWN_FROM_U.contains(&(self.entity, name)));
        for name in names {
            if let Some(how) = difference([a, b], name, self.tolerance) {
                self.note(name, revolution, how);
            }
        }
    }

    fn note_missing(&mut self, row: &Row, which: &str) {
        let mut names: Vec<&str> = row.components().collect();
        names.dedup();
        for name in names {
            self.note(name, row.revolution, format!("missing in the {which}"));
        }
    }

    fn note(&mut self, component: &str, revolution: i64, how: String) {
        let known = self.found.components.iter_mut().find(|d| d.entity == self.entity && d.component == component);
        match known {
            Some(known) => known.revolutions += 1,
            None => self.found.components.push(Difference {
                step: step_of(self.entity, component),
                entity: self.entity.to_owned(),
                component: component.to_owned(),
                revolution,
                revolutions: 1,
                how,
            }),
        }
    }
}

/// The revolution of the next row; an error is met at once.
fn next<'a>(rows: &mut Peekable<impl Iterator<Item = Result<Row<'a>, ReadError>>>) -> Option<i64> {
    rows.peek().map(|row| row.as_ref().map_or(i64::MIN, |row| row.revolution))
}

/// The row of this revolution, if it is the next; an error in any case.
fn take<'a>(
    rows: &mut Peekable<impl Iterator<Item = Result<Row<'a>, ReadError>>>,
    revolution: i64,
) -> Result<Option<Row<'a>>, ReadError> {
    rows.next_if(|row| row.as_ref().map_or(true, |row| row.revolution == revolution)).transpose()
}

/// The step whose result it is. Colours are those of the walls.
fn step_of(entity: &str, component: &str) -> Step {
    if component.ends_with(":class_ids") {
        return Step::Report;
    }
    let is_scanned = SCANNED.iter().any(|scanned| entity.starts_with(scanned)) || entity == "/scan/returns";
    let mine = |step: &Step| entity.strip_prefix('/').and_then(|path| path.strip_prefix(step.name())).is_some();
    match Step::ALL.into_iter().find(mine) {
        None if is_scanned => Step::Ingest,
        None => Step::Report,
        Some(step) => step,
    }
}

/// How a component of two rows differs; `None` if it does not.
fn difference([a, b]: [&Row; 2], component: &str, tolerance: f64) -> Option<String> {
    let stored =
        |row: &Row| -> Vec<Cell> { row.cells.iter().filter(|cell| cell.component == component).cloned().collect() };
    let (stored_a, stored_b) = (stored(a), stored(b));
    if stored_a.len() != stored_b.len() {
        return Some(format!("there {} and {} times", stored_a.len(), stored_b.len()));
    }
    if stored_a.iter().zip(&stored_b).all(|(a, b)| *a.values == *b.values) {
        return None; // by far the most frequent case, and nothing to decode
    }
    let mut pairs = a.values(component).zip(b.values(component));
    pairs.find_map(|pair| match pair {
        (Ok(a), Ok(b)) => value_difference(&a, &b, tolerance),
        (Err(error), _) | (_, Err(error)) => Some(error.to_string()),
    })
}

fn value_difference(a: &Value, b: &Value, tolerance: f64) -> Option<String> {
    match (a, b) {
        (Value::Numbers(a), Value::Numbers(b)) => array_difference(a, b, tolerance),
        (Value::Lists(a), Value::Lists(b)) if a.len() == b.len() => {
            a.iter().zip(b).find_map(|(a, b)| array_difference(a, b, tolerance))
        }
        (Value::Texts(a), Value::Texts(b)) if a.len() == b.len() => {
            let (a, b) = a.iter().zip(b).find(|(a, b)| a != b)?;
            let [a, b] = around_first_difference([a, b]);
            Some(format!("{a:?} and {b:?}"))
        }
        (a, b) => Some(format!("{a} and {b}")),
    }
}

fn array_difference(a: &Array, b: &Array, tolerance: f64) -> Option<String> {
    if a.shape != b.shape {
        return Some(format!("shapes {:?} and {:?}", a.shape, b.shape));
    }
    if let Some(compared) = span::difference(a, b, tolerance) {
        return compared.err();
    }
    let off = |(a, b): (f64, f64)| match (a - b).abs() {
        _ if a == b || (a.is_nan() && b.is_nan()) => 0.0,
        off if off.is_nan() => f64::INFINITY,
        off => off,
    };
    let largest = a.to_f64().into_iter().zip(b.to_f64()).map(off).fold(0.0, f64::max);
    (largest > tolerance).then(|| format!("by {largest:.1e} at most"))
}

/// Of two texts that differ, as much as a line holds around the place where they do first.
fn around_first_difference(texts: [&String; 2]) -> [String; 2] {
    const BEFORE: usize = 20;
    const LENGTH: usize = 60;
    let [a, b] = texts;
    let same = a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count();
    let start = if same < LENGTH { 0 } else { same - BEFORE };
    texts.map(|text| {
        let cut = if start > 0 { "…" } else { "" };
        cut.chars().chain(text.chars().skip(start).take(LENGTH)).collect()
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn texts_are_shown_where_they_differ_and_not_only_where_they_begin() {
        let shown = |a: &str, b: &str| super::around_first_difference([&a.to_owned(), &b.to_owned()]);
        assert_eq!(shown("3 walls", "4 walls"), ["3 walls", "4 walls"]);
        let long = "é".repeat(100);
        let [a, b] = shown(&format!("{long}3 walls"), &format!("{long}4 walls"));
        assert!(a.starts_with('…') && a.ends_with("é3 walls") && b.ends_with("é4 walls"), "{a}, {b}");
    }
}
