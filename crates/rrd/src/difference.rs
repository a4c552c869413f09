//! Two recordings compared row by row, whatever the chunks that they were written in.
//!
//! The results of each revolution are compared. Times (`/timing`), values for the whole flight (configuration, colours,
//! explanations), the layout and part numbers are not. Entities that are logged when they change, and again where a
//! file begins, are compared by the value that is valid at each revolution. U is compared by its span, and drawings in
//! its coordinates are not compared.

use std::iter::Peekable;

use crosscut_stage::Step;

use crate::cell::Cell;
use crate::rows::Rows;
use crate::schema::{self, Entity, Precision, When};
use crate::value::Array;
use crate::{ReadError, Recording, Row, Value, span};

/// Entities that ingest makes, with those below them; the other entities of `/scan` are made by the report.
const MADE_BY_INGEST: [Entity; 6] = [
    schema::SCAN_RANGES,
    schema::SCAN_SEEN,
    schema::SCAN_BEAMS,
    schema::SCAN_RETURNS,
    schema::SCAN_ODOMETRY,
    schema::SCAN_NOTES,
];

/// Drawings in the coordinates of U: other eigenvectors of the same span look different.
const DRAWN_FROM_U: [(Entity, &str); 3] = [
    (schema::SPECTRAL_EMBEDDING, "Points3D:positions"),
    (schema::SPECTRAL_U_PICTURE, "EncodedDepthImage:blob"),
    (schema::KMEANS_CENTROIDS, "Points3D:positions"),
];

/// Whether the rows of an entity are results of revolutions. The explanation names the file and the settings as well; what it
/// explains is compared.
fn is_compared(entity: &str) -> bool {
    let is_text = entity == schema::REPORT_WHY.path;
    !entity.starts_with("/timing/") && !is_text && Entity::of(entity).is_none_or(|entity| entity.when != When::File)
}

fn is_drawing(entity: &str, component: &str) -> bool {
    let is_drawing = |entity: &Entity| entity.values != component || entity.precision == Precision::Drawing;
    Entity::of(entity).is_some_and(is_drawing)
}

/// How two recordings differ.
#[derive(Debug, Default)]
pub struct Differences {
    /// The first difference: the earliest step at the earliest revolution.
    pub first: Option<Difference>,
    /// Every component that differs, in the order of the steps.
    pub components: Vec<Difference>,
    /// How many rows both have.
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

/// Compares all rows. Numbers are equal when they differ by `tolerance` at most; NaN equals NaN. U is compared
/// by its span, centroids by their inner products (`span.rs`). Rows that a damaged recording lacks are no difference.
///
/// # Errors
/// When a file cannot be read again.
pub fn differences(a: &Recording, b: &Recording, tolerance: f64) -> Result<Differences, ReadError> {
    let mut found = Differences::default();
    let names = a.entities().keys().chain(b.entities().keys().filter(|name| !a.entities().contains_key(*name)));
    let is_whole = [a, b].map(|recording| recording.damages().is_empty());
    for entity in names.filter(|name| is_compared(name)) {
        let rows = [rows_of(a, entity)?, rows_of(b, entity)?];
        EntityComparison { entity, tolerance, is_whole, found: &mut found }.compare(rows)?;
    }
    found.components.sort_by_key(|d| (d.step as usize, d.revolution, is_drawing(&d.entity, &d.component)));
    found.first = found.components.iter().min_by_key(|d| (d.revolution, d.step as usize)).cloned();
    Ok(found)
}

/// The rows of an entity; `None` if there is no such entity.
fn rows_of<'a>(recording: &'a Recording, entity: &str) -> Result<Option<Rows<'a>>, ReadError> {
    recording.entities().contains_key(entity).then(|| recording.rows(entity)).transpose()
}

struct EntityComparison<'a> {
    entity: &'a str,
    tolerance: f64,
    /// Whether the first and the second recording are complete.
    is_whole: [bool; 2],
    found: &'a mut Differences,
}

impl EntityComparison<'_> {
    /// Goes through both recordings by revolution.
    fn compare(&mut self, [a, b]: [Option<Rows>; 2]) -> Result<(), ReadError> {
        let [mut a, mut b] = [a, b].map(|rows| rows.into_iter().flatten().peekable());
        let is_logged_on_change = Entity::of(self.entity).is_some_and(|entity| entity.when == When::Change);
        let stays_valid = self.is_whole.map(|is_whole| is_whole && is_logged_on_change);
        let mut latest: [Option<Row>; 2] = [None, None];
        while let Some(revolution) = next(&mut a).into_iter().chain(next(&mut b)).min() {
            let rows = [take(&mut a, revolution)?, take(&mut b, revolution)?];
            let is_there = [0, 1].map(|side| rows[side].is_some() || stays_valid[side]);
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
        if a.stamp_ns != b.stamp_ns && self.entity == schema::SCAN_RETURNS.path {
            let stamp = |row: &Row| row.stamp_ns.map_or_else(|| "none".to_owned(), |ns| format!("{ns} ns"));
            self.note("stamp", revolution, format!("{} and {}", stamp(a), stamp(b)));
        }
        let mut names: Vec<&str> = a.components().chain(b.components()).collect();
        names.sort_unstable();
        names.dedup();
        names
            .retain(|name| !DRAWN_FROM_U.iter().any(|(entity, drawing)| entity.path == self.entity && drawing == name));
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

/// The revolution of the next row. An error comes before all rows.
fn next<'a>(rows: &mut Peekable<impl Iterator<Item = Result<Row<'a>, ReadError>>>) -> Option<i64> {
    rows.peek().map(|row| row.as_ref().map_or(i64::MIN, |row| row.revolution))
}

/// The row of this revolution, if it is the next; an error at any revolution.
fn take<'a>(
    rows: &mut Peekable<impl Iterator<Item = Result<Row<'a>, ReadError>>>,
    revolution: i64,
) -> Result<Option<Row<'a>>, ReadError> {
    rows.next_if(|row| row.as_ref().map_or(true, |row| row.revolution == revolution)).transpose()
}

/// The step whose result a component is. Colours are those of the walls, so they belong to the report.
fn step_of(entity: &str, component: &str) -> Step {
    if component.ends_with(":class_ids") {
        return Step::Report;
    }
    let is_of_ingest = MADE_BY_INGEST.iter().any(|made| entity.starts_with(made.path));
    let is_its = |step: &Step| entity.strip_prefix('/').and_then(|path| path.strip_prefix(step.name())).is_some();
    match Step::ALL.into_iter().find(is_its) {
        None if is_of_ingest => Step::Ingest,
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
        return Some(format!("logged {} and {} times", stored_a.len(), stored_b.len()));
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

/// Of two texts that differ, what fits in a line around the first difference.
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
    fn texts_are_shown_around_their_first_difference() {
        let shown = |a: &str, b: &str| super::around_first_difference([&a.to_owned(), &b.to_owned()]);
        assert_eq!(shown("3 walls", "4 walls"), ["3 walls", "4 walls"]);
        let long = "é".repeat(100);
        let [a, b] = shown(&format!("{long}3 walls"), &format!("{long}4 walls"));
        assert!(a.starts_with('…') && a.ends_with("é3 walls") && b.ends_with("é4 walls"), "{a}, {b}");
    }
}
