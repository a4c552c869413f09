//! One parameter of a stage: name, unit, range, default and meaning, and the type of its value.

use std::fmt;

use toml::Value;

/// The key of a parameter whose value is a `T`.
///
/// A stage declares it once, as a constant. The constant documents the parameter, checks what is set, and reads the
/// value.
///
/// ```
/// use crosscut_stage::{Number, Params};
///
/// const RADIUS_M: Number = Number::new("radius_m", "m", 2.5).above(0.0).to(1e6).doc("reach of an edge");
///
/// let mut params = Params::defaults(&[RADIUS_M.spec]);
/// assert_eq!(params.get(RADIUS_M), 2.5);
/// params.set("radius_m", 3.0)?;
/// assert_eq!(params.get(RADIUS_M), 3.0);
/// assert!(params.set("radius_m", 0.0).is_err());
/// # Ok::<(), crosscut_stage::ParamError>(())
/// ```
#[derive(Debug)]
pub struct Param<T> {
    /// What it is.
    pub spec: ParamSpec,
    /// A checked value as a `T`; `None` of a value of another type.
    pub(crate) read: fn(&Value) -> Option<T>,
}

/// A real number.
pub type Number = Param<f64>;
/// A whole number, 0 or more.
pub type Count = Param<usize>;
/// True or false.
pub type Flag = Param<bool>;
/// One of a few words, or any text.
pub type Word = Param<String>;
/// A list of `[from, to]` pairs, empty by default.
pub type Pairs = Param<Vec<[f64; 2]>>;
/// A list of names, empty by default.
pub type Names = Param<Vec<String>>;

impl<T> Param<T> {
    const fn of(name: &'static str, unit: &'static str, shape: Shape, read: fn(&Value) -> Option<T>) -> Self {
        Self { spec: ParamSpec { name, unit, shape, doc: "", follows: None, shared: false }, read }
    }

    /// What it means, in one sentence.
    pub const fn doc(mut self, doc: &'static str) -> Self {
        self.spec.doc = doc;
        self
    }

    const fn with_low(mut self, low: f64, low_open: bool) -> Self {
        if let Shape::Number { range, .. } | Shape::Pairs { range } = &mut self.spec.shape {
            (range.low, range.low_open) = (low, low_open);
        }
        self
    }

    const fn with_high(mut self, high: f64) -> Self {
        if let Shape::Number { range, .. } | Shape::Pairs { range } = &mut self.spec.shape {
            range.high = high;
        }
        self
    }
}

impl Number {
    /// Any finite number unless the range is narrowed.
    pub const fn new(name: &'static str, unit: &'static str, default: f64) -> Self {
        Self::of(name, unit, Shape::Number { default, range: Interval::FINITE }, number)
    }

    /// Only numbers larger than `low`.
    pub const fn above(self, low: f64) -> Self {
        self.with_low(low, true)
    }

    /// Only `low` and larger numbers.
    pub const fn from(self, low: f64) -> Self {
        self.with_low(low, false)
    }

    /// Only numbers up to `high`, which may be infinite.
    pub const fn to(self, high: f64) -> Self {
        self.with_high(high)
    }

    /// While it is not set itself, it has the value of another parameter, `section.name`. A value of 0, or one that is
    /// not allowed here, is not followed.
    pub const fn follows(mut self, parameter: &'static str) -> Self {
        self.spec.follows = Some(parameter);
        self
    }

    /// A parameter of another section, `section.name`, as one that a stage reads. It is set and printed in that section alone.
    pub const fn shared(self, parameter: &'static str) -> ParamSpec {
        ParamSpec { shared: true, ..self.follows(parameter).spec }
    }
}

impl Count {
    /// Any whole number from 0 unless the range is narrowed.
    pub const fn new(name: &'static str, unit: &'static str, default: u32) -> Self {
        let shape = Shape::Integer { default: default as i64, min: 0, max: i64::MAX };
        Self::of(name, unit, shape, |value| usize::try_from(value.as_integer()?).ok())
    }

    /// Only `low` and larger numbers.
    pub const fn from(mut self, low: u32) -> Self {
        if let Shape::Integer { min, .. } = &mut self.spec.shape {
            *min = low as i64;
        }
        self
    }

    /// Only numbers up to `high`.
    pub const fn to(mut self, high: u32) -> Self {
        if let Shape::Integer { max, .. } = &mut self.spec.shape {
            *max = high as i64;
        }
        self
    }
}

impl Flag {
    /// True or false.
    pub const fn new(name: &'static str, default: bool) -> Self {
        Self::of(name, "", Shape::Flag { default }, Value::as_bool)
    }
}

impl Word {
    /// One of these words; the first is the default.
    pub const fn one_of(name: &'static str, words: &'static [&'static str]) -> Self {
        Self::of(name, "", Shape::Choice { default: words[0], of: words }, word)
    }

    /// Any text.
    pub const fn any(name: &'static str, default: &'static str) -> Self {
        Self::of(name, "", Shape::Text { default }, word)
    }
}

impl Pairs {
    /// Pairs of any finite numbers unless the range is narrowed.
    pub const fn new(name: &'static str, unit: &'static str) -> Self {
        Self::of(name, unit, Shape::Pairs { range: Interval::FINITE }, pairs)
    }

    /// Only `low` and larger numbers.
    pub const fn from(self, low: f64) -> Self {
        self.with_low(low, false)
    }

    /// Only numbers up to `high`.
    pub const fn to(self, high: f64) -> Self {
        self.with_high(high)
    }
}

impl Names {
    /// Any of these names.
    pub const fn any_of(name: &'static str, of: &'static [&'static str]) -> Self {
        Self::of(name, "", Shape::Names { of }, names)
    }
}

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
    /// The parameter, `section.name`, whose value it has while it is not set.
    pub follows: Option<&'static str>,
    /// The parameter that it follows is the same one: it cannot be set here.
    pub shared: bool,
}

/// Type, range and default of a parameter.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// True or false.
    Flag {
        /// The default.
        default: bool,
    },
    /// A whole number.
    Integer {
        /// The default.
        default: i64,
        /// Smallest allowed value.
        min: i64,
        /// Largest allowed value.
        max: i64,
    },
    /// A real number.
    Number {
        /// The default.
        default: f64,
        /// Allowed values.
        range: Interval,
    },
    /// One of a few words.
    Choice {
        /// The default.
        default: &'static str,
        /// The words.
        of: &'static [&'static str],
    },
    /// Any text.
    Text {
        /// The default.
        default: &'static str,
    },
    /// A list of `[from, to]` pairs, empty by default.
    Pairs {
        /// Allowed values of both ends.
        range: Interval,
    },
    /// A list of names, empty by default.
    Names {
        /// The names.
        of: &'static [&'static str],
    },
}

/// The allowed values of a real number. Infinity is allowed only as an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    low: f64,
    low_open: bool,
    high: f64,
}

impl Interval {
    /// Every finite number.
    const FINITE: Self = Self { low: f64::MIN, low_open: false, high: f64::MAX };

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

impl ParamSpec {
    /// The default.
    pub fn default_value(&self) -> Value {
        match self.shape {
            Shape::Flag { default } => default.into(),
            Shape::Integer { default, .. } => default.into(),
            Shape::Number { default, .. } => default.into(),
            Shape::Choice { default, .. } | Shape::Text { default } => default.into(),
            Shape::Pairs { .. } | Shape::Names { .. } => Value::Array(Vec::new()),
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
            Shape::Names { of } => format!("a list of any of {}", of.join(", ")),
        }
    }

    /// `value` if it is allowed here; whole numbers serve where real ones are asked for.
    ///
    /// # Errors
    /// When its type or its size is not allowed.
    pub fn check(&self, value: Value) -> Result<Value, ParamError> {
        let value = self.as_real(value);
        let allowed = match self.shape {
            Shape::Flag { .. } => value.as_bool().map(|_| true),
            Shape::Integer { min, max, .. } => value.as_integer().map(|i| (min..=max).contains(&i)),
            Shape::Number { range, .. } => number(&value).map(|x| range.contains(x)),
            Shape::Choice { of, .. } => value.as_str().map(|word| of.contains(&word)),
            Shape::Text { .. } => value.as_str().map(|_| true),
            Shape::Pairs { range } => pairs(&value).map(|pairs| pairs.iter().flatten().all(|&x| range.contains(x))),
            Shape::Names { of } => names(&value).map(|names| names.iter().all(|name| of.contains(&name.as_str()))),
        };
        let kind = match allowed {
            Some(true) => return Ok(value),
            Some(false) => ParamErrorKind::OutOfRange,
            None => ParamErrorKind::WrongType,
        };
        let degrees = number(&value).filter(|x| self.unit == "rad" && x.abs() <= 360.0);
        let degrees = degrees.map_or_else(String::new, |x| format!("; {x} degrees are {:.4}", x.to_radians()));
        let (name, value) = (self.name.to_owned(), value_text(&value));
        Err(ParamError { kind, name, value, expected: self.expected() + &degrees })
    }

    /// A value with real numbers where whole ones serve for them.
    fn as_real(&self, value: Value) -> Value {
        match self.shape {
            Shape::Number { .. } => number(&value).map_or(value, Value::Float),
            Shape::Pairs { .. } => match pairs(&value) {
                Some(pairs) => pairs.into_iter().map(Vec::from).collect::<Vec<_>>().into(),
                None => value,
            },
            _ => value,
        }
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

fn word(value: &Value) -> Option<String> {
    value.as_str().map(str::to_owned)
}

fn pairs(value: &Value) -> Option<Vec<[f64; 2]>> {
    let pair = |value: &Value| match value.as_array()?.as_slice() {
        [from, to] => Some([number(from)?, number(to)?]),
        _ => None,
    };
    value.as_array()?.iter().map(pair).collect()
}

fn names(value: &Value) -> Option<Vec<String>> {
    value.as_array()?.iter().map(word).collect()
}

/// A value as TOML: a number in the shortest text that reads back as the same one, such as 1e-8, 1.5 or inf.
pub fn value_text(value: &Value) -> String {
    match value {
        Value::Float(x) => format!("{x:?}"),
        Value::Array(list) => format!("[{}]", list.iter().map(value_text).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}

/// A value that its parameter does not allow.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value} is not allowed: {expected}")]
pub struct ParamError {
    /// Why, for code.
    pub kind: ParamErrorKind,
    /// The parameter.
    pub name: String,
    /// The value, as written.
    pub value: String,
    /// What is allowed.
    pub expected: String,
}

/// Why a value is not allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParamErrorKind {
    /// There is no parameter of this name.
    NotFound,
    /// The value is of another type than the parameter.
    WrongType,
    /// The type is right; the parameter allows other numbers, words or names.
    OutOfRange,
}
