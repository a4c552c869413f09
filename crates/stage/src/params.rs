//! The parameters of a stage with their values.

use toml::Value;

use crate::{Param, ParamError, ParamErrorKind, ParamSpec, value_text};

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
            let (kind, name, value) = (ParamErrorKind::NotFound, name.to_owned(), value_text(&value));
            return Err(ParamError { kind, name, value, expected });
        };
        self.values[place] = self.specs[place].check(value)?;
        Ok(())
    }

    /// The value of a parameter; its default if the stage does not declare it.
    pub fn get<T>(&self, key: Param<T>) -> T {
        let set = self.value(key.spec.name).and_then(key.read);
        set.or_else(|| (key.read)(&key.spec.default_value())).expect("the default of a key is of its type")
    }

    /// The value of a parameter by its name, if the stage declares it.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.iter().find(|(spec, _)| spec.name == name).map(|(_, value)| value)
    }

    /// The parameters, in the order in which the stage declares them.
    pub fn specs(&self) -> &'static [ParamSpec] {
        self.specs
    }

    /// Every parameter with its value, in the order in which the stage declares them.
    pub fn iter(&self) -> impl Iterator<Item = (&'static ParamSpec, &Value)> {
        self.specs.iter().zip(&self.values)
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
        assert_eq!(refused(0, Value::Float(0.0)), "sigma_per_m2 = 0.0 is not allowed: a number in (0.0, 1000000.0]");
        assert!(refused(0, Value::Float(f64::NAN)).contains("NaN"));
        assert!(refused(0, Value::Float(f64::INFINITY)).contains("inf"));
        assert!(refused(0, Value::String("1".into())).contains("a number"));
        assert!(refused(1, Value::Integer(0)).contains("[1, 1000]"));
        assert!(refused(1, Value::Float(1.0)).contains("whole number"));
        assert!(refused(2, Value::String("c".into())).contains("one of a, b"));
        let names = vec!["doors", "door"].into();
        let allowed = "a list of any of doors, line";
        assert_eq!(refused(3, names), format!(r#"without = ["doors", "door"] is not allowed: {allowed}"#));
        assert!(refused(3, vec![vec![0.0, 1.0]].into()).contains(allowed));
    }

    #[test]
    fn set_values_replace_defaults_and_whole_numbers_serve_as_real_ones() {
        let mut params = Params::defaults(SPECS);
        params.set("sigma_per_m2", Value::Integer(2)).expect("allowed");
        params.set("restarts", 0).expect_err("less than 1");
        let (sigma, restarts, rule) = (params.get(SIGMA_PER_M2), params.get(RESTARTS), params.get(RULE));
        assert_eq!((sigma, restarts, rule.as_str()), (2.0, 10, "a"));
        params.set("without", vec!["line"]).expect("allowed");
        assert_eq!(params.get(WITHOUT), ["line"]);
        params.set("without", Value::Array(Vec::new())).expect("allowed");
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
