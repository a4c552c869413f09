//! `crosscut rrd ls`: entities, components, revolutions and sizes of a recording.

use crosscut_evaluate::tables::Table;
use crosscut_rrd::schema::Entity;
use crosscut_rrd::{ReadError, RecordedEntity, Recording};

use super::args::RrdLsArgs;
use super::{entity_path, open, say_damages};
use crate::exit::{Outcome, UsageError};
use crate::output::show;
use crate::output::typeset::plain;

/// Prints the content of a recording, or of each that the file holds. The exit code is 3 if one is damaged.
pub(super) fn ls(args: &RrdLsArgs) -> anyhow::Result<Outcome> {
    match Recording::open(&args.recording) {
        Ok(recording) => list(args, &recording),
        Err(ReadError::Several { ids, .. }) => {
            let mut opened = Vec::new();
            for id in &ids {
                opened.push((id, open(&args.recording, Some(id))?));
            }
            // Those with the entity that was asked for, or, so that it is refused, all.
            if let Some(entity) = path_of(args)
                && opened.iter().any(|(_, recording)| recording.entities().contains_key(&entity))
            {
                opened.retain(|(_, recording)| recording.entities().contains_key(&entity));
            }
            opened.iter().enumerate().try_fold(Outcome::Done, |outcome, (at, (id, recording))| {
                let heading = format!("{}recording   {id}\n", if at == 0 { "" } else { "\n" });
                show(heading)?;
                let of_this = list(args, recording)?;
                Ok(if of_this == Outcome::Done { outcome } else { of_this })
            })
        }
        Err(error) => Err(error.into()),
    }
}

/// The path of the entity that was asked for, if one was.
fn path_of(args: &RrdLsArgs) -> Option<String> {
    args.entity.as_deref().map(entity_path)
}

fn list(args: &RrdLsArgs, recording: &Recording) -> anyhow::Result<Outcome> {
    let entity = path_of(args);
    if let Some(entity) = &entity {
        recording.rows(entity).map_err(|error| UsageError(error.to_string()))?; // which names those that there are
    }
    let config = || recording.config_toml().unwrap_or_else(|| "# no /config\n".to_owned());
    let listed = || heading(recording) + "\n\n" + &plain(&entities(recording, entity.as_deref())) + "\n";
    show(match (&entity, args.config) {
        (None, true) => config(),
        (Some(_), true) => listed() + "\n" + &config(),
        (_, false) => listed(),
    })?;
    Ok(say_damages(recording))
}

fn heading(recording: &Recording) -> String {
    let paths: Vec<String> = recording.paths().map(|path| path.display().to_string()).collect();
    let mut lines = vec![
        format!("{}, {:.1} MB", paths.join(", "), recording.bytes() as f64 / 1e6),
        format!("written by  {}, Rerun {}", maker(recording), recording.rerun_version()),
    ];
    let ranges = |range: fn(&RecordedEntity) -> Option<[i64; 2]>| {
        let all = recording.entities().values().filter_map(range);
        all.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    };
    if let Some([first, last]) = ranges(|entity| entity.revolutions) {
        lines.push(format!("revolution  {first} to {last}"));
    }
    if let Some([first_ns, last_ns]) = ranges(|entity| entity.stamps_ns) {
        let span_s = (last_ns - first_ns) as f64 / 1e9;
        lines.push(format!("stamp       {first_ns} to {last_ns} ns: {span_s:.1} s"));
    }
    lines.join("\n")
}

/// Name and version of the program, from the first line of the configuration.
fn maker(recording: &Recording) -> String {
    let config = recording.config_toml().unwrap_or_default();
    let line = config.lines().next().and_then(|line| line.strip_prefix("# crosscut "));
    line.map_or_else(|| "an unnamed program".to_owned(), |version| format!("crosscut {version}"))
}

/// A line for each entity with the component that holds its values, or one for each component of `only`.
fn entities(recording: &Recording, only: Option<&str>) -> Table {
    let mut rows = Vec::new();
    // What has a look and no values was not drawn.
    let is_drawn = |path: &str, entity: &RecordedEntity| {
        Entity::of(path).is_none_or(|known| entity.components.contains_key(known.values))
    };
    let is_listed =
        |path: &str, entity: &RecordedEntity| only.map_or_else(|| is_drawn(path, entity), |only| only == path);
    for (path, entity) in recording.entities().iter().filter(|(path, entity)| is_listed(path, entity)) {
        let range = entity.revolutions.map_or_else(|| "all".to_owned(), |[first, last]| format!("{first}..{last}"));
        let kilobytes = format!("{:.1}", entity.bytes as f64 / 1e3);
        let mut start = [path.clone(), range, kilobytes];
        let shown = |name: &&String| only.is_some() || recording.values_component(path) == Some(name.as_str());
        for name in entity.components.keys().filter(shown) {
            let component = &entity.components[name];
            let [path, range, kilobytes] = std::mem::take(&mut start);
            let of_component = [component.rows.to_string(), range, kilobytes, name.clone(), component.first.clone()];
            rows.push([path].into_iter().chain(of_component).collect());
        }
    }
    let header = ["entity", "rows", "revolutions", "kB", "component", "the first"].map(str::to_owned).to_vec();
    Table { title: String::new(), header, rows }
}
