//! `crosscut rrd get`: values of an entity as a file that other programs read.

use std::collections::BTreeSet;

use anyhow::Context;
use crosscut_recorder::{Entity, ReadError, Recording, Rows, Value, is_picture};
use crosscut_stage::counted;

use super::exact::{self, Recomputation};
use super::output::Output;
use super::say_damages;
use super::selection::Selection;
use crate::cli::RrdGetArgs;
use crate::exit::{Outcome, UsageError};
use crate::say::say;
use crate::{flight, outputs};

/// Writes what was asked for; what is damaged, or was made by another version, makes the exit code 3.
pub(super) fn get(args: &RrdGetArgs) -> anyhow::Result<Outcome> {
    flight::refuse_nothing(args.from, args.to)?;
    outputs::refuse(&[&args.out], std::slice::from_ref(&args.recording))?;
    let recording = Recording::open(&args.recording)?;
    let selection = Selection::new(args, &recording);
    let entity = format!("/{}", args.entity.trim_start_matches('/'));
    let (output, lost) = if args.exact {
        recompute(args, &recording, &entity, &selection)?
    } else {
        (copy(args, &recording, &entity, &selection)?, Vec::new())
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

/// Recorded values. One that holds for the whole flight is there once, at no revolution.
fn copy(args: &RrdGetArgs, recording: &Recording, entity: &str, selection: &Selection) -> anyhow::Result<Output> {
    let rows = rows(recording, entity)?;
    let component = component(args, &recording.entities()[entity])?;
    if let Some(value) = recording.value_throughout(entity, &component)? {
        let mut output = Output::create(&args.out, true)?;
        output.add(None, &value)?;
        return Ok(output);
    }
    let is_picture = is_picture(&component);
    let not_drawn = if is_picture { not_drawn(recording, &component, selection)? } else { BTreeSet::new() };
    let mut output = Output::create(&args.out, selection.is_one())?;
    for row in rows {
        let row = row?;
        for value in row.values(&component).filter(|_| selection.holds(&row)) {
            if !not_drawn.contains(&row.revolution) {
                output.add(Some(&row), &value?)?;
            }
        }
    }
    if !not_drawn.is_empty() {
        let revolutions = counted(not_drawn.len() as u64, "revolution");
        let none =
            format!("{entity} is not drawn of {revolutions}: no returns, or more than 1024; --exact makes it anew");
        if output.values == 0 {
            return Err(UsageError(none).into());
        }
        say(format_args!("note: {none}"));
    }
    if is_picture {
        say(format_args!("note: {entity} is read from pictures, right to half a decade; --exact makes it anew"));
    }
    Ok(output)
}

/// The revolutions of which no matrix is drawn: W is dark, whose diagonal is 1. L may be 0 everywhere.
fn not_drawn(recording: &Recording, component: &str, selection: &Selection) -> anyhow::Result<BTreeSet<i64>> {
    let is_dark = |picture: &Value| matches!(picture, Value::Numbers(w) if w.to_f64().iter().all(|&x| x == 0.0));
    let mut not_drawn = BTreeSet::new();
    for row in rows(recording, "/affinity/W")? {
        let row = row?;
        for value in row.values(component).filter(|_| selection.holds(&row)) {
            if is_dark(&value?) {
                not_drawn.insert(row.revolution);
            }
        }
    }
    Ok(not_drawn)
}

/// Values made anew from the recorded ranges, and what does not agree with the recording.
fn recompute(
    args: &RrdGetArgs,
    recording: &Recording,
    entity: &str,
    selection: &Selection,
) -> anyhow::Result<(Output, Vec<String>)> {
    let recomputation = Recomputation::new(recording, entity)?;
    let ranges = rows(recording, "/scan/ranges")?;
    let mut output = Output::create(&args.out, selection.is_one())?;
    let lost = recomputation.run(ranges, selection, |row, value| output.add(Some(row), &value))?;
    Ok((output, lost))
}

fn rows<'a>(recording: &'a Recording, entity: &str) -> anyhow::Result<Rows<'a>> {
    recording.rows(entity).map_err(|error| match error {
        ReadError::NoSuchEntity { .. } => {
            let how = if exact::can_be(entity) { "; --exact makes it anew" } else { "" };
            UsageError(format!("{error}{how}")).into()
        }
        error => error.into(),
    })
}

/// The component asked for, or the one with the values.
fn component(args: &RrdGetArgs, entity: &Entity) -> Result<String, UsageError> {
    let known = || entity.components.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    let chosen = match &args.component {
        Some(name) => entity.components.contains_key(name).then_some(name.as_str()),
        None => entity.values_component(),
    };
    let asked = args.component.as_deref().unwrap_or("component");
    chosen.map(str::to_owned).ok_or_else(|| UsageError(format!("{} has no {asked}; it has {}", args.entity, known())))
}
