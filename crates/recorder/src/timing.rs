//! Time of each stage, of all stages beside the sensor's period, and a table of the last revolutions.

use std::collections::VecDeque;

use crosscut_stage::{Frame, Step};
use rerun::{RecordingStream, RecordingStreamResult, Scalars, SeriesLines, TextDocument};

use crate::colors::{GREY, REPORTED, STEPS, VEHICLE, color, series};
use crate::rows::Rows;
use crate::schema::{TIMING, TIMING_FLIGHT, TIMING_SUMMARY, TIMING_TOTAL};

/// Number of revolutions in the table.
const WINDOW: usize = 200;
/// The table is written once in this many revolutions.
const TABLE_EVERY: u64 = 10;

/// Names and colours of the lines over time.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    for ((step, entity), rgba) in Step::ALL.into_iter().zip(TIMING).zip(STEPS) {
        rec.log_static(entity.path, &series(step.name(), rgba, 2.0))?;
    }
    rec.log_static(TIMING_FLIGHT.path, &series("flight", VEHICLE, 2.0))?;
    let lines = SeriesLines::new()
        .with_names(["all stages", "from scan to scan"])
        .with_colors([color(REPORTED), color(GREY)])
        .with_widths([2.0, 1.5]);
    rec.log_static(TIMING_TOTAL.path, &lines)
}

/// The times of the last revolutions.
#[derive(Default)]
pub(crate) struct Times {
    stamp_ns: Option<u64>,
    seen: u64,
    /// Milliseconds of each step, of the flight (NaN without one), of all, and since the revolution before (NaN at the first).
    last: VecDeque<[f64; ROWS]>,
}

/// The row of the flight, behind those of the steps.
const FLIGHT: usize = Step::ALL.len();
/// Each step, the flight, all steps, and the sensor's period.
const ROWS: usize = Step::ALL.len() + 3;

impl Times {
    /// The times of one revolution, and the table so far.
    pub(crate) fn log(&mut self, rows: &mut Rows, frame: &Frame) {
        let ms = |ns: u64| ns as f64 * 1e-6;
        let mut row = [f64::NAN; ROWS];
        for (at, (step, entity)) in Step::ALL.into_iter().zip(&TIMING).enumerate() {
            row[at] = ms(frame.timings.ns(step));
            rows.log(entity, &Scalars::single(row[at]));
        }
        if let Some(flight_ns) = frame.timings.flight_ns {
            row[FLIGHT] = ms(flight_ns);
            rows.log(&TIMING_FLIGHT, &Scalars::single(row[FLIGHT]));
        }
        let total = Step::ALL.iter().map(|step| frame.timings.ns(*step)).sum();
        row[ROWS - 2] = ms(total);
        if let Some(before_ns) = self.stamp_ns.replace(frame.revolution.stamp_ns) {
            row[ROWS - 1] = ms(frame.revolution.stamp_ns.saturating_sub(before_ns));
        }
        rows.log(&TIMING_TOTAL, &Scalars::new([row[ROWS - 2], row[ROWS - 1]]));
        self.add(row);
        if self.seen % TABLE_EVERY == 1 {
            rows.log(&TIMING_SUMMARY, &TextDocument::from_markdown(self.table()));
        }
    }

    fn add(&mut self, row: [f64; ROWS]) {
        if self.last.len() == WINDOW {
            self.last.pop_front();
        }
        self.last.push_back(row);
        self.seen += 1;
    }

    fn table(&self) -> String {
        let names = Step::ALL.map(Step::name).into_iter().chain(["flight", "**all stages**", "scan to scan"]);
        let mut lines = vec![
            format!("The last {} revolutions, milliseconds:\n", self.last.len()),
            "| stage | now | median | 99 % below | most |\n|---|---|---|---|---|".to_owned(),
        ];
        for (at, name) in names.enumerate() {
            let mut sorted: Vec<f64> = self.last.iter().map(|row| row[at]).filter(|ms| !ms.is_nan()).collect();
            sorted.sort_by(f64::total_cmp);
            if let (Some(now), Some(most)) = (self.last.back(), sorted.last()) {
                let below = |share: f64| sorted[((sorted.len() as f64 * share).ceil() as usize).max(1) - 1];
                let (now, median, p99) = (now[at], below(0.5), below(0.99));
                lines.push(format!("| {name} | {now:.2} | {median:.2} | {p99:.2} | {most:.2} |"));
            }
        }
        lines.push(
            "\nThe stages run in parallel, each in its own thread. The slowest stage limits the rate of answers; an \
            answer is as old as all stages take together."
                .to_owned(),
        );
        lines.join("\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_median_and_maximum_of_a_moving_window() {
        let mut times = Times::default();
        (0..WINDOW + 50).for_each(|ms| times.add([ms as f64; ROWS]));
        let table = times.table();
        assert!(table.contains("| ingest | 249.00 | 149.00 | 247.00 | 249.00 |"), "{table}");
    }
}
