//! What a table of ranges, such as CSV, does not state of its sensor.

use std::f64::consts::TAU;

use crosscut_stage::{Number, ParamSpec, Params, Word};

const FIRST_RAD: Number = Number::new("first_rad", "rad", 0.0)
    .from(-TAU)
    .to(TAU)
    .doc("tables of ranges: bearing of the first range of a row, in the sensor's frame, anticlockwise");

const LAST_RAD: Number = Number::new("last_rad", "rad", 0.0)
    .from(-TAU)
    .to(TAU)
    .doc("tables of ranges: bearing of the last range of a row; equal to first_rad if it is not known");

const RANGE_MAX_M: Number = Number::new("range_max_m", "m", f64::INFINITY)
    .above(0.0)
    .to(f64::INFINITY)
    .doc("tables of ranges: the sensor's limit; ranges at or beyond it are no returns");

const RATE_HZ: Number = Number::new("rate_hz", "1/s", 10.0)
    .from(1e-3)
    .to(1e6)
    .doc("tables of ranges: rows a second, if no column holds the time");

const COLUMNS: Word = Word::any("columns", "").doc(
    "tables of ranges: names of the columns, in place of those in the table or where there are none; `*` stands for numbers: `time,r*`, `r*_mm,label`",
);

/// The `csv` section of the configuration.
pub const CSV_PARAMS: &[ParamSpec] = &[FIRST_RAD.spec, LAST_RAD.spec, RANGE_MAX_M.spec, RATE_HZ.spec, COLUMNS.spec];

/// What a table of ranges does not say of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct CsvGeometry {
    /// Bearing of the first range of a row, in the sensor's frame, anticlockwise.
    pub first_rad: f64,
    /// Bearing of the last one; equal to the first if it is not known.
    pub last_rad: f64,
    /// Ranges at or beyond it are no returns, metres.
    pub range_max_m: f64,
    /// Rows a second, if no column holds the time.
    pub rate_hz: f64,
    /// Names of the columns between commas, in place of those in the table; empty if the table's are to be taken. A `*` in a name
    /// stands for the numbers from 0 on that the other columns leave.
    pub columns: String,
}

impl CsvGeometry {
    /// From checked values of [`CSV_PARAMS`].
    pub fn new(params: &Params) -> Self {
        Self {
            first_rad: params.get(FIRST_RAD),
            last_rad: params.get(LAST_RAD),
            range_max_m: params.get(RANGE_MAX_M),
            rate_hz: params.get(RATE_HZ),
            columns: params.get(COLUMNS),
        }
    }

    /// Whether it says where the beams look.
    pub fn is_known(&self) -> bool {
        self.first_rad != self.last_rad
    }
}

impl Default for CsvGeometry {
    fn default() -> Self {
        Self::new(&Params::defaults(CSV_PARAMS))
    }
}
