//! Layers -> one checked configuration.

use std::fmt;

use crosscut_sensor::{MAX_RANGE_M, MIN_RANGE_M, Sensor};
use crosscut_stage::{Kind, ParamErrorKind, ParamSpec, Params, StageKind, Value};

use super::error::{ConfigError, nearest, nearest_and_all};
use super::layer::{Layer, Preset};
use super::retired::RETIRED;
use super::schema::{Body, Choice, IN_FLIGHT, Section, WORKERS, sections};
use crate::Registry;

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
    /// What set each parameter.
    pub(super) set_by: Vec<SetBy>,
}

/// What set a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum SetBy {
    Default,
    /// The layer of this name.
    Layer(String),
    /// The parameter of this name, which it follows.
    Parameter(&'static str),
}

impl fmt::Display for SetBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Default => f.write_str("default"),
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
    /// Applies `layers` in order over the defaults of the stages in `registry`.
    ///
    /// # Errors
    /// The first name that is unknown, or value that is not allowed; a stage of which the registry has no kind, or two of
    /// one name.
    pub fn resolve(registry: &Registry, layers: &[Layer]) -> Result<Self, ConfigError> {
        let sections = sections(registry);
        sections.iter().try_for_each(refuse_unusable_kinds)?;
        for layer in layers {
            refuse_unknown_sections(&sections, layer)?;
        }
        let sections = sections.iter().map(|section| resolve_section(section, layers));
        let mut config = Self { sections: sections.collect::<Result<_, _>>()? };
        config.follow();
        config.refuse_no_return()?;
        Ok(config)
    }

    /// Refuses ranges of the sensor between which no return lies.
    fn refuse_no_return(&self) -> Result<(), ConfigError> {
        let ingest = self.params("ingest");
        let (nearest_m, farthest_m) = (ingest.get(MIN_RANGE_M), ingest.get(MAX_RANGE_M));
        if nearest_m < farthest_m { Ok(()) } else { Err(ConfigError::NoReturnLeft { nearest_m, farthest_m }) }
    }

    /// Gives parameters that are not set themselves the values of those that they follow.
    fn follow(&mut self) {
        let followed: Vec<Vec<Option<Value>>> = self.sections.iter().map(|section| self.followed(section)).collect();
        for (section, followed) in self.sections.iter_mut().zip(followed) {
            for (place, value) in followed.into_iter().enumerate() {
                let spec = &section.specs[place];
                if let (Some(value), Some(parameter)) = (value, spec.follows)
                    && section.params.set(spec.name, value).is_ok()
                {
                    section.set_by[place] = SetBy::Parameter(parameter);
                }
            }
        }
    }

    /// The values that the parameters of a section have from others, if they follow any that is there and not 0, or share it.
    fn followed(&self, section: &Resolved) -> Vec<Option<Value>> {
        let followed = |(spec, set_by): (&ParamSpec, &SetBy)| {
            let follows = spec.follows.filter(|_| *set_by == SetBy::Default)?;
            let (other, name) = follows.split_once('.')?;
            let other = self.sections.iter().find(|section| section.name == other)?;
            match other.params.value(name)? {
                Value::Number(x) if *x != 0.0 || spec.shared => Some(Value::Number(*x)),
                _ => None,
            }
        };
        section.specs.iter().zip(&section.set_by).map(followed).collect()
    }

    /// A preset alone.
    ///
    /// # Errors
    /// When the registry lacks a stage that the preset names.
    pub fn preset(preset: Preset, registry: &Registry) -> Result<Self, ConfigError> {
        Self::resolve(registry, &[preset.into()])
    }

    /// The values of a section.
    ///
    /// # Panics
    /// When there is no such section.
    pub fn params(&self, section: &str) -> &Params {
        &self.section(section).params
    }

    /// The sensor, on its vehicle.
    pub fn sensor(&self) -> Sensor {
        Sensor::new(self.params("ingest"), self.params("vehicle"))
    }

    /// This configuration with another value of a parameter.
    ///
    /// # Panics
    /// When there is no such section or parameter, or it does not allow the value.
    pub fn with(&self, section: &str, name: &str, value: Value) -> Self {
        let mut config = self.clone();
        let found = config.sections.iter_mut().find(|known| known.name == section);
        let set = found.map(|section| section.params.set(name, value));
        assert!(matches!(set, Some(Ok(()))), "{section}.{name} takes this value");
        config
    }

    /// Every setting, as `section.key` and its value in TOML.
    pub fn settings(&self) -> impl Iterator<Item = (String, String)> {
        self.sections.iter().flat_map(|section| {
            let setting = |key: &str, value: String| (format!("{}.{key}", section.name), value);
            let kind = section.kind.as_ref().map(|kind| setting("kind", format!("{:?}", kind.name)));
            kind.into_iter().chain(section.own().map(move |(spec, value, _)| setting(spec.name, value.to_string())))
        })
    }

    /// The settings that a layer set: `section.key`, the value in TOML, and the layer's name.
    pub fn set_by_layers(&self) -> Vec<[String; 3]> {
        let layer = |set_by: &SetBy| if let SetBy::Layer(name) = set_by { Some(name.clone()) } else { None };
        let of_section = |section: &Resolved| {
            let set = |key: &str, value: String, set_by: &SetBy| {
                layer(set_by).map(|layer| [format!("{}.{key}", section.name), value, layer])
            };
            let kind = section.kind.as_ref().and_then(|kind| set("kind", format!("{:?}", kind.name), &kind.set_by));
            let params = section.own().filter_map(|(spec, value, set_by)| set(spec.name, value.to_string(), set_by));
            kind.into_iter().chain(params).collect::<Vec<_>>()
        };
        self.sections.iter().flat_map(of_section).collect()
    }

    /// The settings of a section that are not the defaults, as `section.key=value`.
    pub fn changed(&self, section: &str) -> Vec<String> {
        let section = self.section(section);
        let changed = section.own().filter(|(spec, value, _)| **value != spec.default_value());
        changed.map(|(spec, value, _)| format!("{}.{}={value}", section.name, spec.name)).collect()
    }

    /// How many lanes to run: not more than there are frames for.
    pub fn workers(&self) -> usize {
        let workers = match self.params("pipeline").get(WORKERS) {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            workers => workers,
        };
        workers.min(self.in_flight())
    }

    /// How many frames the pool holds.
    pub fn in_flight(&self) -> usize {
        self.params("pipeline").get(IN_FLIGHT)
    }

    /// The kind that was chosen among `kinds`.
    ///
    /// # Panics
    /// When `kinds` are not those of the registry that the configuration was resolved with.
    pub fn kind<'a, S: StageKind + ?Sized>(&self, kinds: &'a [Kind<S>]) -> &'a Kind<S> {
        let chosen = self.section(S::SECTION).kind.as_ref().map(|kind| kind.name);
        let kind = kinds.iter().find(|kind| Some(kind.name) == chosen);
        kind.expect("the configuration was resolved with the same registry")
    }

    /// Builds the stage that was chosen among `kinds`, for programs that run stages one by one.
    ///
    /// # Panics
    /// When `kinds` are not those of the registry that the configuration was resolved with.
    pub fn build<S: StageKind + ?Sized>(&self, kinds: &[Kind<S>]) -> Box<S> {
        self.kind(kinds).build(self.params(S::SECTION))
    }

    fn section(&self, name: &str) -> &Resolved {
        let found = self.sections.iter().find(|section| section.name == name);
        found.unwrap_or_else(|| panic!("the configuration has no section {name}"))
    }
}

fn refuse_unusable_kinds(section: &Section) -> Result<(), ConfigError> {
    let Body::Kinds(choices) = &section.body else { return Ok(()) };
    let section = section.name;
    if choices.is_empty() {
        return Err(ConfigError::NoKinds { section });
    }
    let mut names: Vec<_> = choices.iter().map(|choice| choice.name).collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(ConfigError::KindTwice { section, kind: pair[0] }),
        None => Ok(()),
    }
}

fn refuse_unknown_sections(sections: &[Section], layer: &Layer) -> Result<(), ConfigError> {
    let known = || sections.iter().map(|section| section.name);
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
    Resolved::new(section.name, kind, specs, SetBy::Default)
}

/// A kind that begins so is a callable of Python: `python:module.name`.
const CODE: &str = "python:";

impl Resolved {
    fn new(name: &'static str, kind: Option<Choice>, specs: &'static [ParamSpec], kind_set_by: SetBy) -> Self {
        Self {
            name,
            kind: kind.map(|kind| ResolvedKind { name: kind.name, doc: kind.doc, set_by: kind_set_by }),
            specs,
            params: Params::defaults(specs),
            set_by: vec![SetBy::Default; specs.len()],
        }
    }

    /// The parameters that are set here, with their values and what set them.
    pub(super) fn own(&self) -> impl Iterator<Item = (&'static ParamSpec, &Value, &SetBy)> {
        let all = self.specs.iter().zip(self.params.iter()).zip(&self.set_by);
        all.filter(|((spec, _), _)| !spec.shared).map(|((spec, (_, value)), set_by)| (spec, value, set_by))
    }

    /// Takes another kind, with its defaults. The kind that is chosen already keeps its values.
    fn choose(&mut self, choices: &[Choice], wanted: &toml::Value, layer: &Layer) -> Result<(), ConfigError> {
        let name = wanted.as_str().unwrap_or_default();
        let choice = choices.iter().find(|choice| choice.name == name).ok_or_else(|| ConfigError::UnknownKind {
            layer: layer.name.clone(),
            section: self.name,
            kind: wanted.to_string(),
            nearest: if name.strip_prefix(CODE).is_some_and(|callable| !callable.contains('.')) {
                format!("a stage of Python is {CODE}MODULE.FUNCTION")
            } else if name.starts_with(CODE) {
                format!(
                    "a stage of Python runs in the wheel's program alone (`python/run --install`, docs/python.md), where the \
                     command line names it: --set {}.kind={name}",
                    self.name
                )
            } else {
                nearest_and_all(name, &choices.iter().map(|choice| choice.name).collect::<Vec<_>>())
            },
        })?;
        match &mut self.kind {
            Some(kind) if kind.name == choice.name => kind.set_by = SetBy::Layer(layer.name.clone()),
            _ => *self = Self::new(self.name, Some(*choice), choice.params, SetBy::Layer(layer.name.clone())),
        }
        Ok(())
    }

    fn set(&mut self, section: &Section, key: &str, value: &toml::Value, layer: &Layer) -> Result<(), ConfigError> {
        let place = self.specs.iter().position(|spec| spec.name == key && !spec.shared);
        let place = place.ok_or_else(|| self.unknown_key(section, key, layer))?;
        let spec = &self.specs[place];
        let refused = |error| ConfigError::BadValue { layer: layer.name.clone(), section: self.name, error };
        let value =
            from_toml(value).ok_or_else(|| refused(spec.refuse(ParamErrorKind::WrongType, value.to_string())))?;
        self.params.set(spec.name, value).map_err(refused)?;
        self.set_by[place] = SetBy::Layer(layer.name.clone());
        Ok(())
    }

    fn unknown_key(&self, section: &Section, key: &str, layer: &Layer) -> ConfigError {
        let setting = format!("{}.{key}", self.name);
        if let Some((_, now)) = RETIRED.iter().find(|(retired, _)| *retired == setting) {
            return ConfigError::Retired { layer: layer.name.clone(), setting, now };
        }
        let owner = match &section.body {
            Body::Kinds(choices) => {
                choices.iter().find(|choice| choice.params.iter().any(|spec| spec.name == key && !spec.shared))
            }
            Body::Fixed(_) => None,
        };
        let nearest = match owner {
            Some(owner) => {
                let of_kind = |preset: &Preset| Layer::from(*preset).kind(self.name) == Some(owner.name.to_owned());
                let preset = Preset::ALL.iter().find(|preset| of_kind(preset));
                let with = preset.map_or_else(String::new, |preset| format!(", as with --preset {}", preset.name()));
                format!("that is a parameter of {}.kind = {:?}{with}", self.name, owner.name)
            }
            None => {
                let kind = self.kind.as_ref().map(|_| "kind");
                nearest(key, kind.into_iter().chain(self.own().map(|(spec, ..)| spec.name)))
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
        toml::Value::Array(list) if list.iter().any(toml::Value::is_str) => {
            Value::Names(list.iter().map(|name| name.as_str().map(str::to_owned)).collect::<Option<_>>()?)
        }
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
