//! Layers, kinds, and what is refused.

use std::path::Path;

use crosscut_detector::{Config, ConfigError, Layer, Preset, Registry, Settings};
use crosscut_stage::{Affinity, AffinityStage, Kind, Notes, Number, ParamErrorKind, Revolution, StageError, Value};

const ERROR_AT_X: Number = Number::new("error_at_x", "", -1.0).from(-1.0).to(1e9);

struct Failing;

impl AffinityStage for Failing {
    fn weigh(&mut self, _: &Revolution, _: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        Err(StageError::Unsupported("told to fail".to_owned()))
    }
}

/// The standard registry, with an affinity that has a parameter of its own.
fn registry() -> Registry {
    let mut registry = Registry::standard();
    let failing = Kind::affinity("failing", "fails", |_| Box::new(Failing)).params(&[ERROR_AT_X.spec]);
    registry.affinity.insert(0, failing);
    registry
}

fn resolve(file: &str, settings: &[&str]) -> Result<Config, ConfigError> {
    let settings: Vec<_> = settings.iter().map(ToString::to_string).collect();
    let layers =
        [Preset::Paper.into(), Layer::file(Path::new("mine.toml"), file)?, Layer::settings("--set", &settings)?];
    Config::resolve(&registry(), &layers)
}

/// The value of a number, `section.name`.
fn number(config: &Config, parameter: &str) -> f64 {
    let (section, name) = parameter.split_once('.').expect("section.name");
    match config.params(section).value(name) {
        Some(Value::Float(x)) => *x,
        other => panic!("{parameter} is {other:?}"),
    }
}

fn refused(file: &str, settings: &[&str]) -> String {
    resolve(file, settings).expect_err("must be refused").to_string()
}

#[test]
fn later_layers_win_and_the_printout_says_who_set_what() {
    let config = resolve("[affinity]\nsigma_per_m2 = 2", &["spectral.zero_tolerance=1e-6"]).expect("allowed");
    assert_eq!(number(&config, "affinity.sigma_per_m2"), 2.0);
    assert_eq!(number(&config, "spectral.zero_tolerance"), 1e-6);
    let text = config.to_string();
    assert!(text.contains("sigma_per_m2 = 2.0  # mine.toml"), "{text}");
    assert!(text.contains("zero_tolerance = 1e-6  # --set"), "{text}");
    assert!(text.contains("kind = \"rbf\"  # preset paper"), "{text}");
    assert!(text.contains("width_m = 0.6  # default"), "{text}");
}

#[test]
fn the_affinity_is_of_the_vehicle_and_its_islands_are_those_of_the_report() {
    let registry = Registry::standard();
    for preset in [Preset::Default, Preset::ClearWidth] {
        let settings = ["vehicle.width_m=2".to_owned(), "report.island_m=0".to_owned()];
        let layers = [preset.into(), Layer::settings("--set", &settings).expect("settings")];
        let config = Config::resolve(&registry, &layers).expect("allowed");
        assert_eq!((number(&config, "affinity.width_m"), number(&config, "affinity.island_m")), (2.0, 0.0));
        let text = config.to_string();
        assert_eq!((text.matches("\nwidth_m = ").count(), text.matches("\nisland_m = ").count()), (1, 1), "{text}");
        assert!(config.changed("affinity").is_empty());
    }
    assert!(
        refused("", &["affinity.kind=passage", "affinity.width_m=1"])
            .contains("affinity of kind \"passage\" has no width_m")
    );
}

#[test]
fn a_setting_of_an_earlier_version_is_refused_with_what_holds_now() {
    assert_eq!(
        refused("[affinity]\nkind = \"passage\"\npassage_m = 1", &[]),
        "mine.toml: affinity.passage_m is no setting any more: use vehicle.width_m"
    );
    let fixed = refused("", &["affinity.stretch_m=1"]);
    assert_eq!(fixed, "--set: affinity.stretch_m is no setting any more: it is 0.85 m, fixed");
}

#[test]
fn a_solver_put_in_place_of_another_takes_the_leak_for_its_tolerance() {
    let printed = |settings: &[&str]| {
        let settings: Vec<_> = settings.iter().map(ToString::to_string).collect();
        let layers = [Preset::Default.into(), Layer::settings("--set", &settings).expect("settings")];
        Config::resolve(&Registry::standard(), &layers).expect("allowed").to_string()
    };
    for kind in ["blocks", "faer", "slicing"] {
        let text = printed(&[&format!("spectral.kind={kind}"), "affinity.leak=1e-9"]);
        assert!(text.contains("# zero_tolerance = 1e-9  # follows affinity.leak"), "{text}");
    }
    let set = printed(&["spectral.zero_tolerance=1e-6"]);
    assert!(set.contains("zero_tolerance = 1e-6  # --set"), "{set}");
    for none in ["affinity.leak=0", "affinity.kind=rbf"] {
        assert!(printed(&[none]).contains("zero_tolerance = 1e-7  # default"), "{none}");
    }
}

#[test]
fn a_printed_file_does_not_untie_the_solver_from_the_affinity() {
    let registry = Registry::standard();
    let printed = Config::preset(Preset::Default, &registry).expect("a preset").to_string();
    let changed = printed.replace("leak = 1e-8  # default", "leak = 1e-9");
    assert_ne!(changed, printed);
    let layers = [Layer::file(Path::new("changed.toml"), &changed).expect("TOML")];
    let config = Config::resolve(&registry, &layers).expect("allowed");
    assert_eq!(number(&config, "spectral.zero_tolerance"), 1e-9);
}

#[test]
fn every_preset_prints_a_file_that_resolves_to_itself() {
    for preset in Preset::ALL {
        let config = Config::preset(preset, &Registry::standard()).expect("a preset");
        let layers = [Layer::file(Path::new("printed.toml"), &config.to_string()).expect("TOML")];
        let again = Config::resolve(&Registry::standard(), &layers).expect("allowed");
        let values = |config: &Config| {
            let text = config.to_string();
            text.lines().map(|line| line.split("  #").next().unwrap_or_default().to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(values(&again), values(&config));
    }
}

#[test]
fn every_preset_chooses_every_kind_itself() {
    for preset in Preset::ALL {
        let text = Config::preset(preset, &Registry::standard()).expect("a preset").to_string();
        let chosen = format!("# preset {}", preset.name());
        let kinds = text.lines().filter(|line| line.starts_with("kind = ") && line.ends_with(&chosen)).count();
        assert_eq!(kinds, 3, "{text}");
    }
}

#[test]
fn a_changed_kind_takes_its_own_defaults_and_applies_before_the_rest_of_its_layer() {
    let config = resolve("[affinity]\nerror_at_x = 4\nkind = \"failing\"", &[]).expect("allowed");
    assert_eq!(number(&config, "affinity.error_at_x"), 4.0);
    let config = resolve("[affinity]\nsigma_per_m2 = 7", &["affinity.kind=failing"]).expect("allowed");
    assert_eq!(number(&config, "affinity.error_at_x"), -1.0, "sigma of the other kind is gone");
    let config = resolve("[affinity]\nsigma_per_m2 = 7", &["affinity.kind=rbf"]).expect("allowed");
    assert_eq!(number(&config, "affinity.sigma_per_m2"), 7.0, "the same kind again keeps what was set");
}

#[test]
fn unknown_names_are_refused_with_the_nearest_right_one() {
    assert_eq!(
        refused("[affinity]\nsigma = 1", &[]),
        r#"mine.toml: affinity of kind "rbf" has no sigma; did you mean sigma_per_m2?"#
    );
    assert_eq!(refused("[afinity]\nkind = 1", &[]), "mine.toml: there is no section [afinity]; did you mean affinity?");
    assert!(refused("preset = \"paper\"", &[]).ends_with("presets are chosen on the command line"));
    assert!(refused("", &["affinity.kind=rfb"]).contains("did you mean rbf?"));
    assert!(refused("", &["affinity.error_at_x=1"]).contains(r#"that is a parameter of affinity.kind = "failing""#));
    assert!(refused("", &["report.kind=x"]).contains("report has no kind"));
    let unknown = Preset::named("papper").expect_err("no such preset").to_string();
    assert_eq!(unknown, r#"there is no preset "papper"; did you mean paper?"#);
}

#[test]
fn bad_values_are_refused_with_what_is_allowed() {
    assert_eq!(
        refused("", &["affinity.sigma_per_m2=0"]).split(" is not").next(),
        Some("--set: affinity.sigma_per_m2 = 0.0")
    );
    assert!(refused("", &["pipeline.in_flight=0"]).contains("a whole number in [1, 4096]"));
    assert!(refused("", &["vehicle.width_m=wide"]).contains("a number in"));
    assert!(refused("", &["vehicle.width_m={a=1}"]).contains("a number in"));
    assert!(refused("affinity = 3", &[]).contains("affinity must be a section"));
}

#[test]
fn text_that_is_not_configuration_is_refused() {
    assert!(refused("[affinity", &[]).starts_with("mine.toml: this is not TOML"));
    for malformed in ["sigma=1", "affinity.sigma_per_m2", ""] {
        assert!(refused("", &[malformed]).contains("is not of the form section.key=value"), "{malformed}");
    }
}

#[test]
fn a_registry_with_no_kind_or_two_of_one_name_is_refused() {
    let resolve = |registry: &Registry| Config::resolve(registry, &[]).expect_err("must be refused").to_string();
    let mut twice = Registry::standard();
    twice.affinity.push(twice.affinity[0]);
    assert!(resolve(&twice).contains("rename yours"), "{}", resolve(&twice));
    let mut none = Registry::standard();
    none.kmeans.clear();
    assert_eq!(resolve(&none), "the registry has no kind of kmeans: append one");
}

#[test]
fn typed_settings_arrive_as_they_are() {
    let text = "a \"b\" = [1], \u{7}\u{e9}";
    let settings = Settings::new(Preset::Paper)
        .set("ingest.frame_id", text)
        .set("ingest.yaw_rad", 0.1 + 0.2)
        .set("ingest.upside_down", true)
        .set("kmeans.seed", 7_u32)
        .set("ingest.masked_sectors_rad", Value::from(vec![vec![0.1, 1.0 / 3.0]]));
    let config = settings.config(&Registry::standard()).expect("allowed");
    let value = |section: &str, name: &str| config.params(section).value(name).cloned();
    assert_eq!(value("ingest", "frame_id"), Some(Value::String(text.to_owned())));
    assert_eq!(value("ingest", "yaw_rad"), Some(Value::Float(0.1 + 0.2)));
    assert_eq!(value("ingest", "upside_down"), Some(Value::Boolean(true)));
    assert_eq!(value("kmeans", "seed"), Some(Value::Integer(7)));
    assert_eq!(value("ingest", "masked_sectors_rad"), Some(Value::from(vec![vec![0.1, 1.0 / 3.0]])));
    let printed = config.to_string();
    assert!(printed.contains("upside_down = true  # settings"), "where a value comes from: {printed}");
    let refused = |settings: Settings| settings.config(&Registry::standard()).expect_err("refused").to_string();
    assert!(refused(Settings::default().set("vehicle", 1.0)).contains("section.key=value"));
    let nearest_m = Settings::default().set("ingest.min_range_m", 9.0).set("ingest.max_range_m", 9.0);
    assert!(refused(nearest_m).contains("no return would be left"));
}

#[test]
fn code_can_match_on_what_is_wrong_with_a_value() {
    let kind = |setting: &str| match resolve("", &[setting]) {
        Err(ConfigError::BadValue { error, .. }) => error.kind,
        other => panic!("{other:?}"),
    };
    assert_eq!(kind("affinity.sigma_per_m2=-1"), ParamErrorKind::OutOfRange);
    assert_eq!(kind("affinity.sigma_per_m2=wide"), ParamErrorKind::WrongType);
    assert_eq!(kind("affinity.sigma_per_m2=1979-05-27"), ParamErrorKind::WrongType, "a date is no value of ours");
    let mut params = resolve("", &[]).expect("the preset").params("affinity").clone();
    let unknown = params.set("sigma", 1.0).expect_err("there is no such parameter");
    assert_eq!(unknown.kind, ParamErrorKind::NotFound);
}
