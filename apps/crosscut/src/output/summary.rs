//! The summary at the end of a run.

use crosscut_evaluate::tables::Table;
use crosscut_pipeline::{Answers, NoteCount, Summary};
use crosscut_stage::{KnownGaps, Step, Way, counted, degrees_words};

use crate::fly::Flown;
use crate::output::typeset;

/// The summary shows this many kinds of notes; the results hold all notes.
const NOTES_SHOWN: usize = 5;

/// How much was done, and how fast.
pub(crate) fn words(flown: &Flown) -> String {
    let Summary { revolutions, noted, .. } = flown.summary;
    let elapsed_s = flown.elapsed.as_secs_f64();
    let per_second = revolutions as f64 / elapsed_s.max(1e-9);
    let revolutions = counted(revolutions, "revolution");
    format!("{revolutions} in {elapsed_s:.2} s ({per_second:.0} a second), {noted} with notes")
}

/// Counts, time per stage, and notes, for a terminal; nothing without revolutions. `is_live`: scans were waited for.
pub(crate) fn tables(summary: &Summary, is_live: bool) -> String {
    if summary.revolutions == 0 {
        return String::new();
    }
    let mut text = typeset::plain(&counts(summary));
    text.extend(ways(summary).map(|ways| format!("\n\n{}", typeset::plain(&ways))));
    text.extend(gaps(summary.gaps).map(|line| format!("\n\n{line}")));
    text += &format!("\n\n{}\n", typeset::plain(&times(summary, is_live)));
    if summary.noted > 0 {
        let more = summary.notes.by_frequency().len().saturating_sub(NOTES_SHOWN) as u64;
        text += &format!("\n{}\n", typeset::plain(&notes(summary, NOTES_SHOWN)));
        if more > 0 {
            text += &format!(" and {} more, in the results (-o FILE.jsonl)\n", counted(more, "kind"));
        }
    }
    text
}

/// How the gaps of a run are known; `None` without a gap.
fn gaps(gaps: KnownGaps) -> Option<String> {
    let percent = |part: u64| 100.0 * part as f64 / gaps.all() as f64;
    let [seen, proved, judged] = [gaps.seen, gaps.proved, gaps.judged].map(percent);
    (gaps.all() > 0)
        .then(|| {
            format!(
                "gaps between walls: {judged:.1} % judged by their form, {seen:.1} % seen through, {proved:.1} % proved to be \
                 closed by a wall behind"
            )
        })
}

/// Revolutions by their number of walls, or of ways on.
pub(crate) fn counts(summary: &Summary) -> Table {
    let share = |part: u64, whole: u64| format!("{:.1} %", 100.0 * part as f64 / whole as f64);
    let row = |(count, answers): (&usize, &Answers)| {
        vec![
            count.to_string(),
            answers.revolutions.to_string(),
            share(answers.revolutions, summary.revolutions),
            if answers.rated == 0 { "-".to_owned() } else { share(answers.sure, answers.revolutions) },
        ]
    };
    let what = if summary.ways.is_some() { "ways on" } else { "walls" };
    table(&[what, "revolutions", "share", "confidence 0.9 or more"], summary.counts.iter().map(row).collect())
}

/// The ways on of the last revolution, where these are counted and there are any.
pub(crate) fn ways(summary: &Summary) -> Option<Table> {
    let row = |(number, way): (usize, &Way)| {
        let [bearing, elevation] = [way.bearing_rad(), way.elevation_rad()].map(degrees_words);
        let (kind, cut) = (way.kind().to_string().replace('_', " "), if way.cut_by_view { "yes" } else { "no" });
        let (clearance, p) = (format!("{:.1} m", way.clearance_m), format!("{:.2}", way.p));
        vec![number.to_string(), kind, bearing, elevation, clearance, p, cut.to_owned()]
    };
    let ways = summary.ways.as_ref().filter(|ways| !ways.is_empty())?;
    let header = ["way on (last scan)", "kind", "bearing", "elevation", "clearance", "p", "cut by view"];
    Some(table(&header, ways.iter().enumerate().map(row).collect()))
}

/// The `most` most frequent kinds of notes, each with its first instance.
pub(crate) fn notes(summary: &Summary, most: usize) -> Table {
    let kinds = summary.notes.by_frequency();
    let row = |kind: &&NoteCount| vec![kind.revolutions.to_string(), format!("{:?}", kind.code), kind.first.clone()];
    table(&["revolutions", "code", "note (first of its kind)"], kinds.iter().take(most).map(row).collect())
}

/// Times of the stages, of the flight, and from the arrival of a scan until its results are written, which is longer than
/// the stages where scans wait for each other. Of a live flight `ingest` is the wait for the next scan, which is left out.
pub(crate) fn times(summary: &Summary, is_live: bool) -> Table {
    let steps = Step::ALL.into_iter().filter(|step| !is_live || *step != Step::Ingest);
    let steps = steps.map(|step| (step.name(), summary.times.steps[step as usize].median_and_p99()));
    let flight = ("flight", summary.times.flight.median_and_p99());
    let latency = ("arrival to result", summary.times.latency.median_and_p99());
    let row = |(name, times): (&str, Option<(u64, u64)>)| {
        let ms = |ns: u64| format!("{:.3}", ns as f64 / 1e6);
        times.map(|(median_ns, p99_ns)| vec![name.to_owned(), ms(median_ns), ms(p99_ns)])
    };
    table(&["stage", "median ms", "p99 ms"], steps.chain([flight, latency]).filter_map(row).collect())
}

fn table(header: &[&str], rows: Vec<Vec<String>>) -> Table {
    Table { title: String::new(), header: header.iter().map(|&name| name.to_owned()).collect(), rows }
}
