//! Layers -> one checked configuration.

use std::fmt;

use crosscut_stage::{Kind, ParamError, ParamSpec, Params, StageKind, Value};

use super::error::{ConfigError, nearest, nearest_and_all};
use super::layer::Layer;
use super::schema::{Body, Choice, Schema, Section};
use crate::Registry;

/// Parameters that are those of the vehicle unless they are set themselves: the two, each by section and name.
const OF_VEHICLE: [[(&str, &str); 2]; 2] =
    [[("affinity", "passage_m"), ("vehicle", "width_m")], [("affinity", "height_m"), ("vehicle", "height_m")]];

/// Every parameter with its value and the layer that set it.
#[derive(Clone, Debug)]
pub struct Config {
    pub(super) sections: Vec<Resolved>,
}

/// One section, resolved.
#[derive(Clone, Debug)]
pub(super) struct Resolved {
    pub(super) name: &'static str,
    pub(super) kind: Option<ResolvedKind>,
    pub(super) specs: &'static [ParamSpec],
    pub(super) params: Params,
    /// Of each parameter.
    pub(super) set_by: Vec<SetBy>,
}

/// Who set a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum SetBy {
    Nobody,
    /// The layer of this name.
    Layer(String),
    /// The parameter of this name, which it follows.
    Parameter(String),
}

impl fmt::Display for SetBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nobody => f.write_str("default"),
            Self::Layer(name) => f.write_str(name),
            Self::Parameter(name) => write!(f, "follows {name}"),
        }
    }
}

/// The kind that was chosen for a section.
#[derive(Clone, Debug)]
pub(super) struct ResolvedKind {
    pub(super) name: &'static str,
    pub(super) doc: &'static str,
    pub(super) set_by: SetBy,
}

impl Config {
    /// Applies `layers` in order over the defaults of `schema`.
    ///
    /// # Errors
    /// The first name that is unknown, or value that is not allowed.
    pub fn resolve(schema: &Schema, layers: &[Layer]) -> Result<Self, ConfigError> {
        for layer in layers {
            refuse_unknown_sections(schema, layer)?;
        }
        let sections = schema.sections.iter().map(|section| resolve_section(section, layers));
        let mut config = Self { sections: sections.collect::<Result<_, _>>()? };
        OF_VEHICLE.into_iter().try_for_each(|[to, from]| config.follow(to, from))?;
        Ok(config)
    }

    /// Sets a parameter to another, unless it was set itself, or its kind does not have it.
    fn follow(&mut self, (section, name): (&str, &'static str), (of, other): (&str, &str)) -> Result<(), ConfigError> {
        let value = Value::Number(self.params(of).number(other));
        let to = self.sections.iter_mut().find(|resolved| resolved.name == section).expect("a section of the method");
        if let Some(place) = to.specs.iter().position(|spec| spec.name == name)
            && to.set_by[place] == SetBy::Nobody
        {
            let followed = format!("{of}.{other}");
            let refused = |error| ConfigError::BadValue { layer: followed.clone(), section: to.name, error };
            to.params.set(name, value).map_err(refused)?;
            to.set_by[place] = SetBy::Parameter(followed);
        }
        Ok(())
    }

    /// A preset alone, for the sections of the method.
    ///
    /// # Errors
    /// When there is no such preset, or the registry lacks a stage that it names.
    pub fn preset(name: &str, registry: &Registry) -> Result<Self, ConfigError> {
        Self::resolve(&Schema::new(registry), &[Layer::preset(name)?])
    }

    /// The values of a section.
    ///
    /// # Panics
    /// When the schema has no such section.
    pub fn params(&self, section: &str) -> &Params {
        &self.section(section).params
    }

    /// Every setting, as `section.key` and its value in TOML.
    pub fn settings(&self) -> impl Iterator<Item = (String, String)> {
        self.sections.iter().flat_map(|section| {
            let setting = |key: &str, value: String| (format!("{}.{key}", section.name), value);
            let kind = section.kind.as_ref().map(|kind| setting("kind", format!("{:?}", kind.name)));
            kind.into_iter().chain(section.params.iter().map(move |(key, value)| setting(key, value.to_string())))
        })
    }

    /// The settings of a section that are not the defaults, as `section.key=value`.
    pub fn changed(&self, section: &str) -> Vec<String> {
        let section = self.section(section);
        let defaults = Params::defaults(section.specs);
        let values = section.params.iter().zip(defaults.iter());
        let changed = values.filter(|((_, value), (_, default))| value != default);
        changed.map(|((key, value), _)| format!("{}.{key}={value}", section.name)).collect()
    }

    /// How many lanes to run: not more than there are frames for.
    pub fn workers(&self) -> usize {
        let workers = match self.params("pipeline").count("workers") {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            workers => workers,
        };
        workers.min(self.in_flight())
    }

    /// How many frames the pool holds.
    pub fn in_flight(&self) -> usize {
        self.params("pipeline").count("in_flight")
    }

    /// Builds the stage that was chosen among `kinds`, for programs that run stages one by one.
    ///
    /// # Panics
    /// When `kinds` are not those of the registry that the configuration was resolved with.
    pub fn build<S: StageKind + ?Sized>(&self, kinds: &[Kind<S>]) -> Box<S> {
        let section = self.section(S::SECTION);
        let chosen = section.kind.as_ref().map(|kind| kind.name);
        let kind = kinds.iter().find(|kind| Some(kind.name) == chosen);
        (kind.expect("the configuration was resolved with the same registry").build)(&section.params)
    }

    fn section(&self, name: &str) -> &Resolved {
        let found = self.sections.iter().find(|section| section.name == name);
        found.unwrap_or_else(|| panic!("the configuration has no section {name}"))
    }
}

fn refuse_unknown_sections(schema: &Schema, layer: &Layer) -> Result<(), ConfigError> {
    let known = || schema.sections.iter().map(|section| section.name);
    match layer.table.keys().find(|name| !known().any(|k| k == name.as_str())) {
        None => Ok(()),
        Some(name) => Err(ConfigError::UnknownSection {
            layer: layer.name.clone(),
            name: name.clone(),
            nearest: match name.as_str() {
                "preset" => "presets are chosen on the command line".to_owned(),
                _ => nearest(name, known()),
            },
        }),
    }
}

fn resolve_section(section: &Section, layers: &[Layer]) -> Result<Resolved, ConfigError> {
    let mut resolved = defaults(section);
    for layer in layers {
        let Some(value) = layer.table.get(section.name) else { continue };
        let table = value
            .as_table()
            .ok_or_else(|| ConfigError::NotASection { layer: layer.name.clone(), section: section.name })?;
        if let (Body::Kinds(choices), Some(kind)) = (&section.body, table.get("kind")) {
            resolved.choose(choices, kind, layer)?;
        }
        for (key, value) in table {
            if key != "kind" || resolved.kind.is_none() {
                resolved.set(section, key, value, layer)?;
            }
        }
    }
    Ok(resolved)
}

fn defaults(section: &Section) -> Resolved {
    let (kind, specs) = match &section.body {
        Body::Fixed(specs) => (None, *specs),
        Body::Kinds(choices) => (Some(choices[0]), choices[0].params),
    };
    Resolved::new(section.name, kind, specs, SetBy::Nobody)
}

impl Resolved {
    fn new(name: &'static str, kind: Option<Choice>, specs: &'static [ParamSpec], kind_set_by: SetBy) -> Self {
        Self {
            name,
            kind: kind.map(|kind| ResolvedKind { name: kind.name, doc: kind.doc, set_by: kind_set_by }),
            specs,
            params: Params::defaults(specs),
            set_by: vec![SetBy::Nobody; specs.len()],
        }
    }

    /// Takes another kind, with its defaults; the same kind again changes nothing but who said so.
    fn choose(&mut self, choices: &[Choice], wanted: &toml::Value, layer: &Layer) -> Result<(), ConfigError> {
        let name = wanted.as_str().unwrap_or_default();
        let choice = choices.iter().find(|choice| choice.name == name).ok_or_else(|| ConfigError::UnknownKind {
            layer: layer.name.clone(),
            section: self.name,
            kind: wanted.to_string(),
            nearest: nearest_and_all(name, &choices.iter().map(|choice| choice.name).collect::<Vec<_>>()),
        })?;
        match &mut self.kind {
            Some(kind) if kind.name == choice.name => kind.set_by = SetBy::Layer(layer.name.clone()),
            _ => *self = Self::new(self.name, Some(*choice), choice.params, SetBy::Layer(layer.name.clone())),
        }
        Ok(())
    }

    fn set(&mut self, section: &Section, key: &str, value: &toml::Value, layer: &Layer) -> Result<(), ConfigError> {
        let place = self.specs.iter().position(|spec| spec.name == key);
        let place = place.ok_or_else(|| self.unknown_key(section, key, layer))?;
        let spec = &self.specs[place];
        let refused = |error| ConfigError::BadValue { layer: layer.name.clone(), section: self.name, error };
        let value = from_toml(value).ok_or_else(|| {
            let (name, value, expected) = (spec.name, value.to_string(), spec.expected());
            refused(ParamError { name, value, expected })
        })?;
        self.params.set(spec.name, value).map_err(refused)?;
        self.set_by[place] = SetBy::Layer(layer.name.clone());
        Ok(())
    }

    fn unknown_key(&self, section: &Section, key: &str, layer: &Layer) -> ConfigError {
        let owner = match &section.body {
            Body::Kinds(choices) => choices.iter().find(|choice| choice.params.iter().any(|spec| spec.name == key)),
            Body::Fixed(_) => None,
        };
        let nearest = match owner {
            Some(owner) => format!("that is a parameter of {}.kind = {:?}", self.name, owner.name),
            None => {
                let kind = self.kind.as_ref().map(|_| "kind");
                nearest(key, kind.into_iter().chain(self.specs.iter().map(|spec| spec.name)))
            }
        };
        let kind = self.kind.as_ref().map_or_else(String::new, |kind| format!(" of kind {:?}", kind.name));
        ConfigError::UnknownKey {
            layer: layer.name.clone(),
            section: format!("{}{kind}", self.name),
            key: key.to_owned(),
            nearest,
        }
    }
}

fn from_toml(value: &toml::Value) -> Option<Value> {
    Some(match value {
        toml::Value::Boolean(flag) => Value::Flag(*flag),
        toml::Value::Integer(i) => Value::Integer(*i),
        toml::Value::Float(x) => Value::Number(*x),
        toml::Value::String(text) => Value::Text(text.clone()),
        toml::Value::Array(pairs) => Value::Pairs(pairs.iter().map(pair).collect::<Option<_>>()?),
        toml::Value::Datetime(_) | toml::Value::Table(_) => return None,
    })
}

fn pair(value: &toml::Value) -> Option<[f64; 2]> {
    let number = |value: &toml::Value| value.as_float().or_else(|| value.as_integer().map(|i| i as f64));
    match value.as_array()?.as_slice() {
        [from, to] => Some([number(from)?, number(to)?]),
        _ => None,
    }
}
