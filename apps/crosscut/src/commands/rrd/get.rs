//! `crosscut rrd get`: values of an entity as a file that other programs read.

use std::collections::BTreeSet;

use anyhow::Context;
use crosscut_detector::Registry;
use crosscut_rrd::{ReadError, Recording, Rows, Value, is_picture, schema};
use crosscut_stage::counted;

use super::args::RrdGetArgs;
use super::exact::{self, Recomputation};
use super::output::Output;
use super::selection::Selection;
use super::{entity_path, open, say_damages};
use crate::exit::{Outcome, UsageError};
use crate::input::refuse_empty_span;
use crate::output::{files, say};

/// Writes the values that were asked for. The exit code is 3 if the recording is damaged, or recomputed values disagree
/// with it.
pub(super) fn get(args: &RrdGetArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    refuse_empty_span(args.from, args.to)?;
    files::refuse(&[&args.out], std::slice::from_ref(&args.recording))?;
    let recording = open(&args.recording, args.id.as_deref())?;
    let selection = Selection::new(args, &recording)?;
    let (entity, component) = args.entity.split_once(':').map_or((&*args.entity, None), |(of, name)| (of, Some(name)));
    let entity = entity_path(entity);
    let (output, lost) = if args.exact {
        if let Some(component) = component {
            return Err(UsageError(format!("--exact recomputes the numbers of {entity}; leave out {component}")).into());
        }
        recompute(args, &recording, &entity, &selection, registry)?
    } else {
        (copy(args, &recording, (&entity, component), &selection)?, Vec::new())
    };
    if output.values == 0 {
        let revolutions = recording.entities().get(&entity).and_then(|entity| entity.revolutions);
        let has =
            revolutions.map_or_else(String::new, |[first, last]| format!("; it has revolutions {first} to {last}"));
        return Err(UsageError(format!("{entity} holds nothing at the revolutions asked for{has}")).into());
    }
    output.finish().with_context(|| format!("cannot write {}", args.out.display()))?;
    for loss in &lost {
        say(format_args!("lost: {loss}"));
    }
    let outcome = say_damages(&recording);
    Ok(if lost.is_empty() { outcome } else { Outcome::SomethingLost })
}

/// Recorded values. A value of the whole flight is written once, without a revolution.
fn copy(
    args: &RrdGetArgs,
    recording: &Recording,
    (entity, asked): (&str, Option<&str>),
    selection: &Selection,
) -> anyhow::Result<Output> {
    let rows = rows(recording, entity)?;
    let component = component(recording, entity, asked)?;
    if let Some(value) = recording.value_throughout(entity, &component)? {
        let mut output = Output::create(&args.out, true)?;
        output.add(None, &value)?;
        return Ok(output);
    }
    let is_picture = is_picture(&component);
    let without_picture = if is_picture { without_picture(recording, &component, selection)? } else { BTreeSet::new() };
    let mut output = Output::create(&args.out, selection.is_one())?;
    for row in rows {
        let row = row?;
        for value in row.values(&component).filter(|_| selection.holds(&row)) {
            if !without_picture.contains(&row.revolution) {
                output.add(Some(&row), &value?)?;
            }
        }
    }
    if !without_picture.is_empty() {
        let revolutions = counted(without_picture.len() as u64, "revolution");
        let none =
            format!("{entity} has no picture of {revolutions}: no returns, or more than 1024; --exact recomputes it");
        if output.values == 0 {
            return Err(UsageError(none).into());
        }
        say(format_args!("note: {none}"));
    }
    if is_picture {
        say(format_args!("note: {entity} is read from pictures, right to half a decade; --exact recomputes it"));
    }
    Ok(output)
}

/// The revolutions without pictures of W and L: the picture of W, whose diagonal is 1, is dark. L may be 0 everywhere.
fn without_picture(recording: &Recording, component: &str, selection: &Selection) -> anyhow::Result<BTreeSet<i64>> {
    let is_dark = |picture: &Value| matches!(picture, Value::Numbers(w) if w.to_f64().iter().all(|&x| x == 0.0));
    let mut found = BTreeSet::new();
    for row in rows(recording, schema::AFFINITY_W.path)? {
        let row = row?;
        for value in row.values(component).filter(|_| selection.holds(&row)) {
            if is_dark(&value?) {
                found.insert(row.revolution);
            }
        }
    }
    Ok(found)
}

/// Values recomputed from the recorded scans, and where they disagree with the recording.
fn recompute(
    args: &RrdGetArgs,
    recording: &Recording,
    entity: &str,
    selection: &Selection,
    registry: &Registry,
) -> anyhow::Result<(Output, Vec<String>)> {
    let recomputation = Recomputation::new(recording, entity, registry)?;
    let scans = rows(recording, schema::SCAN_RETURNS.path)?;
    let mut output = Output::create(&args.out, selection.is_one())?;
    let lost = recomputation.run(scans, selection, |row, value| output.add(Some(row), &value))?;
    Ok((output, lost))
}

fn rows<'a>(recording: &'a Recording, entity: &str) -> anyhow::Result<Rows<'a>> {
    recording.rows(entity).map_err(|error| match error {
        ReadError::NoSuchEntity { .. } => {
            let how = if exact::is_recomputable(entity) { "; --exact recomputes it" } else { "" };
            UsageError(format!("{error}{how}")).into()
        }
        error => error.into(),
    })
}

/// The component asked for, or the one with the values.
fn component(recording: &Recording, entity: &str, asked: Option<&str>) -> Result<String, UsageError> {
    let components = &recording.entities()[entity].components;
    let known = || components.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    let chosen = match asked {
        Some(name) => components.contains_key(name).then_some(name),
        None => recording.values_component(entity),
    };
    let asked = asked.unwrap_or("component");
    chosen.map(str::to_owned).ok_or_else(|| UsageError(format!("{entity} has no {asked}; it has {}", known())))
}
