//! A recording in the colours of another one: the classes of its drawings, and the names of colours in its texts.

use std::collections::BTreeMap;
use std::sync::Arc;

use rerun::external::arrow::array::{
    Array as _, ArrayRef, Int64Array, ListArray, RecordBatch, StringArray, UInt16Array,
};

use crate::colors::name_of;

/// By revolution the new class of each old one.
pub(super) type Colors = BTreeMap<i64, BTreeMap<u16, u16>>;

/// The rows with new classes; a batch without classes and texts of revolutions is returned unchanged.
pub(super) fn recolored(batch: &RecordBatch, colors: &Colors) -> RecordBatch {
    let revolutions =
        batch.column_by_name("revolution").and_then(|column| column.as_any().downcast_ref::<Int64Array>());
    let Some(revolutions) = revolutions else { return batch.clone() };
    let fields = batch.schema_ref().fields().iter().zip(batch.columns());
    let columns = fields.map(|(field, column)| {
        let new = match column.as_any().downcast_ref::<ListArray>() {
            Some(rows) if field.name().ends_with(":class_ids") => new_classes(rows, revolutions, colors),
            Some(rows) if field.name().ends_with("TextDocument:text") => new_texts(rows, revolutions, colors),
            _ => None,
        };
        new.unwrap_or_else(|| Arc::clone(column))
    });
    RecordBatch::try_new(batch.schema(), columns.collect()).unwrap_or_else(|_| batch.clone())
}

/// For each value of a list of rows the new classes of its revolution.
fn by_value<'a>(
    rows: &'a ListArray,
    revolutions: &'a Int64Array,
    colors: &'a Colors,
) -> impl Iterator<Item = (usize, Option<&'a BTreeMap<u16, u16>>)> {
    let spans = rows.offsets().windows(2).zip(revolutions.values().iter());
    spans.flat_map(move |(span, seq)| {
        let new = colors.get(seq);
        (span[0] as usize..span[1] as usize).map(move |at| (at, new))
    })
}

fn new_classes(rows: &ListArray, revolutions: &Int64Array, colors: &Colors) -> Option<ArrayRef> {
    let mut classes = rows.values().as_any().downcast_ref::<UInt16Array>()?.values().to_vec();
    for (at, new) in by_value(rows, revolutions, colors) {
        classes[at] = new.and_then(|new| new.get(&classes[at])).copied().unwrap_or(classes[at]);
    }
    with_values(rows, Arc::new(UInt16Array::from(classes)))
}

fn new_texts(rows: &ListArray, revolutions: &Int64Array, colors: &Colors) -> Option<ArrayRef> {
    let old = rows.values().as_any().downcast_ref::<StringArray>()?;
    let mut texts: Vec<String> = (0..old.len()).map(|at| old.value(at).to_owned()).collect();
    for (at, new) in by_value(rows, revolutions, colors) {
        texts[at] = new.map_or_else(|| texts[at].clone(), |new| renamed(&texts[at], new));
    }
    with_values(rows, Arc::new(StringArray::from(texts)))
}

fn with_values(rows: &ListArray, values: ArrayRef) -> Option<ArrayRef> {
    let (field, offsets, _, nulls) = rows.clone().into_parts();
    ListArray::try_new(field, offsets, values, nulls).ok().map(|rows| Arc::new(rows) as ArrayRef)
}

/// The text with the new name of each colour in "3 (vermilion)" and "| 3 | vermilion |".
fn renamed(text: &str, classes: &BTreeMap<u16, u16>) -> String {
    let names: BTreeMap<&str, &str> = classes.iter().map(|(old, new)| (name_of(*old), name_of(*new))).collect();
    let ends = |c: char| matches!(c, '(' | ')' | '|');
    let mut before = "";
    let parts = text.split_inclusive(ends).map(|part| {
        let word = part.trim_end_matches(ends);
        let name = word.trim();
        let is_of_wall = part.ends_with(if before.ends_with('(') { ')' } else { '|' }) && !before.is_empty();
        before = part;
        names.get(name).filter(|_| is_of_wall).map_or_else(|| part.to_owned(), |new| part.replacen(name, new, 1))
    });
    parts.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_walls_are_renamed_and_no_other_words() {
        let classes = BTreeMap::from([(0, 1), (1, 2), (2, 0)]);
        let text = "if 1 (orange) and 11 (blue) were one; blue is drawn (islands)\n| 2 (island) | green | 4 |\n| 3 | blue | 5 |";
        let expected = "if 1 (green) and 11 (orange) were one; blue is drawn (islands)\n| 2 (island) | blue | 4 |\n| 3 | orange | 5 |";
        assert_eq!(renamed(text, &classes), expected);
    }
}
