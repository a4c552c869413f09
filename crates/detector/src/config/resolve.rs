//! Layers -> one checked configuration.

use std::fmt;

use crosscut_sensor::{MAX_RANGE_M, MIN_RANGE_M, Sensor};
use crosscut_stage::{Kind, ParamSpec, Params, StageKind, Value, value_text};

use super::error::{ConfigError, nearest, nearest_and_all};
use super::layer::{Layer, Preset};
use super::retired::RETIRED;
use super::schema::{Choice, IN_FLIGHT, Section, WORKERS, sections};
use crate::Registry;

/// Every parameter with its value and the layer that set it.
#[derive(Clone, Debug)]
pub struct Config {
    pub(super) sections: Vec<Resolved>,
    /// The affinity takes the whole cloud.
    takes_cloud: bool,
}

/// One section, resolved.
#[derive(Clone, Debug)]
pub(super) struct Resolved {
    pub(super) name: &'static str,
    /// The kind that was chosen, and what chose it; `None` in a section without kinds.
    pub(super) kind: Option<(Choice, SetBy)>,
    params: Params,
    /// What set each parameter.
    set_by: Vec<SetBy>,
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

impl Config {
    /// Applies `layers` in order over the defaults of the stages in `registry`.
    ///
    /// # Errors
    /// The first name that is unknown, or value that is not allowed; a stage of which the registry has no kind, or two of
    /// one name.
    pub fn resolve(registry: &Registry, layers: &[Layer]) -> Result<Self, ConfigError> {
        let sections = sections(registry)?;
        for layer in layers {
            refuse_unknown_sections(&sections, layer)?;
        }
        let sections = sections.iter().map(|section| resolve_section(section, layers));
        let mut config = Self { sections: sections.collect::<Result<_, _>>()?, takes_cloud: false };
        config.takes_cloud = config.kind(&registry.affinity).properties.takes_cloud;
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
        let before = self.clone();
        for section in &mut self.sections {
            for (place, spec) in section.params.specs().iter().enumerate() {
                let Some(parameter) = spec.follows.filter(|_| section.set_by[place] == SetBy::Default) else {
                    continue;
                };
                // A value of 0 is shared, but not followed.
                let value = before.value(parameter).filter(|value| spec.shared || value.as_float() != Some(0.0));
                if value.is_some_and(|value| section.params.set(spec.name, value.clone()).is_ok()) {
                    section.set_by[place] = SetBy::Parameter(parameter);
                }
            }
        }
    }

    /// The value of `section.name`, if there is such a parameter.
    fn value(&self, parameter: &str) -> Option<&Value> {
        let (section, name) = parameter.split_once('.')?;
        self.sections.iter().find(|known| known.name == section)?.params.value(name)
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

    /// Whether the affinity takes the whole cloud, which the [sensor](Self::sensor) keeps then.
    pub fn takes_cloud(&self) -> bool {
        self.takes_cloud
    }

    /// The sensor, on its vehicle.
    pub fn sensor(&self) -> Sensor {
        Sensor::new(self.params("ingest"), self.params("vehicle")).keeping_cloud(self.takes_cloud)
    }

    /// The configuration with another value of a parameter.
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
        self.sections.iter().flat_map(Resolved::settings).map(|(key, value, _)| (key, value))
    }

    /// The settings that a layer set: `section.key`, the value in TOML, and the layer's name.
    pub fn set_by_layers(&self) -> Vec<[String; 3]> {
        let by_layer = |(key, value, set_by): (String, String, &SetBy)| match set_by {
            SetBy::Layer(name) => Some([key, value, name.clone()]),
            SetBy::Default | SetBy::Parameter(_) => None,
        };
        self.sections.iter().flat_map(Resolved::settings).filter_map(by_layer).collect()
    }

    /// The settings of a section that are not the defaults, as `section.key=value`.
    pub fn changed(&self, section: &str) -> Vec<String> {
        let section = self.section(section);
        let changed = section.own().filter(|(spec, value, _)| **value != spec.default_value());
        changed.map(|(spec, value, _)| format!("{}.{}={}", section.name, spec.name, value_text(value))).collect()
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
        let chosen = self.section(S::SECTION).kind.as_ref().map(|(kind, _)| kind.name);
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
    let mut resolved =
        Resolved::new(section.name, section.params, section.kinds.first().map(|kind| (*kind, SetBy::Default)));
    for layer in layers {
        let Some(value) = layer.table.get(section.name) else { continue };
        let table = value
            .as_table()
            .ok_or_else(|| ConfigError::NotASection { layer: layer.name.clone(), section: section.name })?;
        let kind = table.get("kind").filter(|_| !section.kinds.is_empty());
        if let Some(kind) = kind {
            resolved.choose(&section.kinds, kind, layer)?;
        }
        for (key, value) in table.iter().filter(|(key, _)| kind.is_none() || *key != "kind") {
            resolved.set(section, key, value, layer)?;
        }
    }
    Ok(resolved)
}

/// A kind that begins so is a callable of Python: `python:module.name`.
const CODE: &str = "python:";

impl Resolved {
    /// The defaults of the section.
    fn new(name: &'static str, params: &'static [ParamSpec], kind: Option<(Choice, SetBy)>) -> Self {
        Self { name, kind, params: Params::defaults(params), set_by: vec![SetBy::Default; params.len()] }
    }

    /// The parameters that are set here, with their values and what set them.
    pub(super) fn own(&self) -> impl Iterator<Item = (&'static ParamSpec, &Value, &SetBy)> {
        let all = self.params.iter().zip(&self.set_by).map(|((spec, value), set_by)| (spec, value, set_by));
        all.filter(|(spec, ..)| !spec.shared)
    }

    /// Kind and parameters: `section.key`, the value in TOML, and what set it.
    fn settings(&self) -> impl Iterator<Item = (String, String, &SetBy)> {
        let kind = self.kind.iter().map(|(kind, set_by)| ("kind", format!("{:?}", kind.name), set_by));
        let params = self.own().map(|(spec, value, set_by)| (spec.name, value_text(value), set_by));
        kind.chain(params).map(|(key, value, set_by)| (format!("{}.{key}", self.name), value, set_by))
    }

    /// Takes another kind, with its defaults. The kind that is chosen already keeps its values.
    fn choose(&mut self, choices: &[Choice], wanted: &Value, layer: &Layer) -> Result<(), ConfigError> {
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
        let set_by = SetBy::Layer(layer.name.clone());
        match &mut self.kind {
            Some((kind, kind_set_by)) if kind.name == choice.name => *kind_set_by = set_by,
            _ => *self = Self::new(self.name, choice.params, Some((*choice, set_by))),
        }
        Ok(())
    }

    fn set(&mut self, section: &Section, key: &str, value: &Value, layer: &Layer) -> Result<(), ConfigError> {
        let place = self.params.specs().iter().position(|spec| spec.name == key && !spec.shared);
        let place = place.ok_or_else(|| self.unknown_key(section, key, layer))?;
        let refused = |error| ConfigError::BadValue { layer: layer.name.clone(), section: self.name, error };
        self.params.set(key, value.clone()).map_err(refused)?;
        self.set_by[place] = SetBy::Layer(layer.name.clone());
        Ok(())
    }

    fn unknown_key(&self, section: &Section, key: &str, layer: &Layer) -> ConfigError {
        let setting = format!("{}.{key}", self.name);
        if let Some((_, now)) = RETIRED.iter().find(|(retired, _)| *retired == setting) {
            return ConfigError::Retired { layer: layer.name.clone(), setting, now };
        }
        let has_key = |kind: &&Choice| kind.params.iter().any(|spec| spec.name == key && !spec.shared);
        let nearest = match section.kinds.iter().find(has_key) {
            Some(owner) => {
                let of_kind = |preset: &Preset| Layer::from(*preset).kind(self.name).as_deref() == Some(owner.name);
                let preset = Preset::ALL.iter().find(|preset| of_kind(preset));
                let with = preset.map_or_else(String::new, |preset| format!(", as with --preset {}", preset.name()));
                format!("that is a parameter of {}.kind = {:?}{with}", self.name, owner.name)
            }
            None => {
                let kind = self.kind.as_ref().map(|_| "kind");
                nearest(key, kind.into_iter().chain(self.own().map(|(spec, ..)| spec.name)))
            }
        };
        let kind = self.kind.as_ref().map_or_else(String::new, |(kind, _)| format!(" of kind {:?}", kind.name));
        ConfigError::UnknownKey {
            layer: layer.name.clone(),
            section: format!("{}{kind}", self.name),
            key: key.to_owned(),
            nearest,
        }
    }
}
