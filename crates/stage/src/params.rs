//! Parameters of a stage, described once: name, unit, range, default and meaning.
//!
//! The same description checks a value, prints the configuration and documents the stage.

use std::fmt::{self, Write as _};

/// The description of one parameter.
#[derive(Clone, Copy, Debug)]
pub struct ParamSpec {
    /// Its key in the configuration, with the unit as its ending (`sigma_per_m2`).
    pub name: &'static str,
    /// The unit in words, empty for a plain number.
    pub unit: &'static str,
    /// Type, range and default.
    pub shape: Shape,
    /// What it means, in one sentence.
    pub doc: &'static str,
}

/// Type, range and default of a parameter.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// True or false.
    Flag {
        /// Value when nothing is said.
        default: bool,
    },
    /// A whole number.
    Integer {
        /// Value when nothing is said.
        default: i64,
        /// Smallest allowed value.
        min: i64,
        /// Largest allowed value.
        max: i64,
    },
    /// A real number.
    Number {
        /// Value when nothing is said.
        default: f64,
        /// Allowed values.
        range: Interval,
    },
    /// One of a few words.
    Choice {
        /// Value when nothing is said.
        default: &'static str,
        /// The words.
        of: &'static [&'static str],
    },
    /// Any text.
    Text {
        /// Value when nothing is said.
        default: &'static str,
    },
    /// A list of `[from, to]` pairs, empty when nothing is said.
    Pairs {
        /// Allowed values of both ends.
        range: Interval,
    },
}

/// The allowed values of a real number. Infinity is allowed only where the end says so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    low: f64,
    low_open: bool,
    high: f64,
}

impl Interval {
    /// From `low` to `high`, both allowed.
    pub const fn closed(low: f64, high: f64) -> Self {
        Self { low, low_open: false, high }
    }

    /// Larger than `low`, up to and with `high`.
    pub const fn above(low: f64, high: f64) -> Self {
        Self { low, low_open: true, high }
    }

    /// Whether `x` is allowed. NaN never is.
    pub fn contains(&self, x: f64) -> bool {
        (if self.low_open { x > self.low } else { x >= self.low }) && x <= self.high
    }
}

impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{:?}, {:?}]", if self.low_open { '(' } else { '[' }, self.low, self.high)
    }
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // each is the shape of the same name
pub enum Value {
    Flag(bool),
    Integer(i64),
    Number(f64),
    Text(String),
    Pairs(Vec<[f64; 2]>),
}

/// A value that its parameter does not allow.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value} is not allowed: {expected}")]
pub struct ParamError {
    /// The parameter.
    pub name: &'static str,
    /// The value, as written.
    pub value: String,
    /// What is allowed.
    pub expected: String,
}

impl ParamSpec {
    /// The value when nothing is said.
    pub fn default_value(&self) -> Value {
        match self.shape {
            Shape::Flag { default } => Value::Flag(default),
            Shape::Integer { default, .. } => Value::Integer(default),
            Shape::Number { default, .. } => Value::Number(default),
            Shape::Choice { default, .. } | Shape::Text { default } => Value::Text(default.to_owned()),
            Shape::Pairs { .. } => Value::Pairs(Vec::new()),
        }
    }

    /// The allowed values, in words.
    pub fn expected(&self) -> String {
        match self.shape {
            Shape::Flag { .. } => "true or false".to_owned(),
            Shape::Integer { min, max, .. } if max == i64::MAX => format!("a whole number, at least {min}"),
            Shape::Integer { min, max, .. } => format!("a whole number in [{min}, {max}]"),
            Shape::Number { range, .. } => format!("a number in {range}"),
            Shape::Choice { of, .. } => format!("one of {}", of.join(", ")),
            Shape::Text { .. } => "a text; one that looks like a number in quotes of its own: '\"5\"'".to_owned(),
            Shape::Pairs { range } => format!("a list of [from, to] pairs, each in {range}"),
        }
    }

    /// `value` if it is allowed here; a whole number serves where a real one is asked for.
    ///
    /// # Errors
    /// When its type or its size is not allowed.
    pub fn check(&self, value: Value) -> Result<Value, ParamError> {
        let value = match (self.shape, value) {
            (Shape::Number { .. }, Value::Integer(i)) => Value::Number(i as f64),
            (_, value) => value,
        };
        let allowed = match (self.shape, &value) {
            (Shape::Flag { .. }, Value::Flag(_)) | (Shape::Text { .. }, Value::Text(_)) => true,
            (Shape::Integer { min, max, .. }, Value::Integer(i)) => (min..=max).contains(i),
            (Shape::Number { range, .. }, Value::Number(x)) => range.contains(*x),
            (Shape::Choice { of, .. }, Value::Text(word)) => of.contains(&word.as_str()),
            (Shape::Pairs { range }, Value::Pairs(pairs)) => pairs.iter().flatten().all(|&x| range.contains(x)),
            _ => false,
        };
        if allowed {
            Ok(value)
        } else {
            Err(ParamError { name: self.name, value: value.to_string(), expected: self.expected() })
        }
    }
}

/// As in TOML.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Integer(i) => write!(f, "{i}"),
            // {:?} prints the shortest text that reads back as the same number: "1e-8", "1.5", "inf".
            Self::Number(x) => write!(f, "{x:?}"),
            Self::Text(text) => write_toml_text(f, text),
            Self::Pairs(pairs) => write!(f, "{pairs:?}"),
        }
    }
}

/// A basic string of TOML, whose escapes are not those of Rust.
fn write_toml_text(f: &mut fmt::Formatter<'_>, text: &str) -> fmt::Result {
    f.write_char('"')?;
    for c in text.chars() {
        match c {
            '"' | '\\' => write!(f, "\\{c}")?,
            // All of them are below U+00A0.
            c if c.is_control() => write!(f, "\\u{:04X}", c as u32)?,
            c => f.write_char(c)?,
        }
    }
    f.write_char('"')
}

/// Checked values for all parameters of one stage.
#[derive(Clone, Debug)]
pub struct Params {
    specs: &'static [ParamSpec],
    /// Of each parameter.
    values: Vec<Value>,
}

impl Params {
    /// The defaults of `specs`.
    pub fn defaults(specs: &'static [ParamSpec]) -> Self {
        Self { specs, values: specs.iter().map(ParamSpec::default_value).collect() }
    }

    /// Replaces the value of a declared parameter.
    ///
    /// # Errors
    /// When the value is not allowed.
    ///
    /// # Panics
    /// When the stage does not declare the parameter.
    pub fn set(&mut self, name: &str, value: Value) -> Result<(), ParamError> {
        let place = self.place(name);
        self.values[place] = self.specs[place].check(value)?;
        Ok(())
    }

    /// The value of a parameter.
    ///
    /// # Panics
    /// When the stage does not declare the parameter; so do the typed getters, also when it is of another type.
    pub fn get(&self, name: &str) -> &Value {
        &self.values[self.place(name)]
    }

    fn place(&self, name: &str) -> usize {
        let place = self.specs.iter().position(|spec| spec.name == name);
        place.unwrap_or_else(|| panic!("the stage does not declare a parameter {name}"))
    }

    /// A true-or-false parameter.
    pub fn flag(&self, name: &str) -> bool {
        match self.get(name) {
            Value::Flag(flag) => *flag,
            other => panic!("{name} is {other}, not a flag"),
        }
    }

    /// A whole-number parameter.
    pub fn integer(&self, name: &str) -> i64 {
        match self.get(name) {
            Value::Integer(i) => *i,
            other => panic!("{name} is {other}, not a whole number"),
        }
    }

    /// A whole-number parameter whose declared minimum is at least 0.
    pub fn count(&self, name: &str) -> usize {
        usize::try_from(self.integer(name)).unwrap_or_else(|_| panic!("{name} is negative"))
    }

    /// A real-number parameter.
    pub fn number(&self, name: &str) -> f64 {
        match self.get(name) {
            Value::Number(x) => *x,
            other => panic!("{name} is {other}, not a number"),
        }
    }

    /// A text or choice parameter.
    pub fn text(&self, name: &str) -> &str {
        match self.get(name) {
            Value::Text(text) => text,
            other => panic!("{name} is {other}, not a text"),
        }
    }

    /// A list of pairs.
    pub fn pairs(&self, name: &str) -> &[[f64; 2]] {
        match self.get(name) {
            Value::Pairs(pairs) => pairs,
            other => panic!("{name} is {other}, not a list of pairs"),
        }
    }

    /// Every parameter with its value, in the order in which the stage declares them.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Value)> {
        self.specs.iter().map(|spec| spec.name).zip(&self.values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPECS: &[ParamSpec] = &[
        ParamSpec {
            name: "sigma_per_m2",
            unit: "1/m²",
            shape: Shape::Number { default: 1.5, range: Interval::above(0.0, 1e6) },
            doc: "",
        },
        ParamSpec { name: "restarts", unit: "", shape: Shape::Integer { default: 10, min: 1, max: 1000 }, doc: "" },
        ParamSpec { name: "rule", unit: "", shape: Shape::Choice { default: "a", of: &["a", "b"] }, doc: "" },
    ];

    #[test]
    fn each_value_outside_its_range_or_type_is_refused_with_what_is_allowed() {
        let refused = |index: usize, value: Value| SPECS[index].check(value).expect_err("must be refused").to_string();
        assert_eq!(refused(0, Value::Number(0.0)), "sigma_per_m2 = 0.0 is not allowed: a number in (0.0, 1000000.0]");
        assert!(refused(0, Value::Number(f64::NAN)).contains("NaN"));
        assert!(refused(0, Value::Number(f64::INFINITY)).contains("inf"));
        assert!(refused(0, Value::Text("1".into())).contains("a number"));
        assert!(refused(1, Value::Integer(0)).contains("[1, 1000]"));
        assert!(refused(1, Value::Number(1.0)).contains("whole number"));
        assert!(refused(2, Value::Text("c".into())).contains("one of a, b"));
    }

    #[test]
    fn set_values_replace_defaults_and_whole_numbers_serve_as_real_ones() {
        let mut params = Params::defaults(SPECS);
        params.set("sigma_per_m2", Value::Integer(2)).expect("allowed");
        params.set("restarts", Value::Integer(0)).expect_err("less than 1");
        assert_eq!((params.number("sigma_per_m2"), params.count("restarts"), params.text("rule")), (2.0, 10, "a"));
    }
}
