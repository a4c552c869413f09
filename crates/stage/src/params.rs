//! The parameters of a stage with their values.

use std::fmt::{self, Write as _};

use crate::{Param, ParamSpec};

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // each is the shape of the same name
pub enum Value {
    Flag(bool),
    Integer(i64),
    Number(f64),
    Text(String),
    Pairs(Vec<[f64; 2]>),
    Names(Vec<String>),
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

/// As in TOML.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Integer(i) => write!(f, "{i}"),
            // {:?} prints the shortest text that reads back as the same number: "1e-8", "1.5", "inf".
            Self::Number(x) => write!(f, "{x:?}"),
            Self::Text(text) => write_toml_text(f, text),
            Self::Names(names) => {
                f.write_char('[')?;
                for (at, name) in names.iter().enumerate() {
                    f.write_str(if at > 0 { ", " } else { "" })?;
                    write_toml_text(f, name)?;
                }
                f.write_char(']')
            }
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

    /// Replaces the value of a parameter.
    ///
    /// # Errors
    /// When the stage does not declare the parameter, or the value is not allowed.
    pub fn set(&mut self, name: &str, value: impl Into<Value>) -> Result<(), ParamError> {
        let value = value.into();
        let Some(place) = self.specs.iter().position(|spec| spec.name == name) else {
            let names: Vec<_> = self.specs.iter().map(|spec| spec.name).collect();
            let expected = match &names[..] {
                [] => "there are no parameters".to_owned(),
                names => format!("there are the parameters {}", names.join(", ")),
            };
            let (kind, name, value) = (ParamErrorKind::NotFound, name.to_owned(), value.to_string());
            return Err(ParamError { kind, name, value, expected });
        };
        self.values[place] = self.specs[place].check(value)?;
        Ok(())
    }

    /// The value of a parameter; its default if the stage does not declare it.
    pub fn get<T: ParamValue>(&self, key: Param<T>) -> T {
        let set = self.value(key.spec.name).and_then(T::read);
        set.or_else(|| T::read(&key.spec.default_value())).expect("the default of a key is of its type")
    }

    /// The value of a parameter by its name, if the stage declares it.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.iter().find(|(other, _)| *other == name).map(|(_, value)| value)
    }

    /// Every parameter with its value, in the order in which the stage declares them.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Value)> {
        self.specs.iter().map(|spec| spec.name).zip(&self.values)
    }
}

/// A type that a [`Param`] can be of.
pub trait ParamValue: Sized {
    /// `value`, if it is of this type.
    fn read(value: &Value) -> Option<Self>;
}

macro_rules! values {
    ($($type:ty: $variant:ident($inner:ident) => $read:expr;)*) => {$(
        impl ParamValue for $type {
            fn read(value: &Value) -> Option<Self> {
                match value {
                    Value::$variant($inner) => $read,
                    _ => None,
                }
            }
        }
    )*};
}

values! {
    bool: Flag(flag) => Some(*flag);
    usize: Integer(i) => usize::try_from(*i).ok();
    f64: Number(x) => Some(*x);
    String: Text(text) => Some(text.clone());
    Vec<[f64; 2]>: Pairs(pairs) => Some(pairs.clone());
    Vec<String>: Names(names) => Some(names.clone());
}

impl From<bool> for Value {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

impl From<u32> for Value {
    fn from(count: u32) -> Self {
        Self::Integer(count.into())
    }
}

impl From<f64> for Value {
    fn from(x: f64) -> Self {
        Self::Number(x)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Count, Names, Number, Word};

    const SIGMA_PER_M2: Number = Number::new("sigma_per_m2", "1/m²", 1.5).above(0.0).to(1e6);
    const RESTARTS: Count = Count::new("restarts", "", 10).from(1).to(1000);
    const RULE: Word = Word::one_of("rule", &["a", "b"]);
    const WITHOUT: Names = Names::any_of("without", &["doors", "line"]);
    const SPECS: &[ParamSpec] = &[SIGMA_PER_M2.spec, RESTARTS.spec, RULE.spec, WITHOUT.spec];

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
        let names = Value::Names(vec!["doors".into(), "door\"".into()]);
        let allowed = "a list of any of doors, line";
        assert_eq!(refused(3, names), format!(r#"without = ["doors", "door\""] is not allowed: {allowed}"#));
        assert!(refused(3, Value::Pairs(vec![[0.0, 1.0]])).contains(allowed));
    }

    #[test]
    fn set_values_replace_defaults_and_whole_numbers_serve_as_real_ones() {
        let mut params = Params::defaults(SPECS);
        params.set("sigma_per_m2", Value::Integer(2)).expect("allowed");
        params.set("restarts", 0).expect_err("less than 1");
        let (sigma, restarts, rule) = (params.get(SIGMA_PER_M2), params.get(RESTARTS), params.get(RULE));
        assert_eq!((sigma, restarts, rule.as_str()), (2.0, 10, "a"));
        params.set("without", Value::Names(vec!["line".into()])).expect("allowed");
        assert_eq!(params.get(WITHOUT), ["line"]);
        params.set("without", Value::Pairs(Vec::new())).expect("an empty list is of any type");
        assert_eq!(params.get(WITHOUT), [""; 0]);
    }

    #[test]
    fn a_name_that_is_not_declared_is_refused_and_reads_as_its_default() {
        let mut params = Params::defaults(&SPECS[..1]);
        let refused = params.set("sigma", 2.0).expect_err("must be refused").to_string();
        assert_eq!(refused, "sigma = 2.0 is not allowed: there are the parameters sigma_per_m2");
        assert_eq!((params.get(RESTARTS), params.value("restarts")), (10, None));
        let refused = Params::defaults(&[]).set("sigma", 2.0).expect_err("must be refused").to_string();
        assert_eq!(refused, "sigma = 2.0 is not allowed: there are no parameters");
    }
}
