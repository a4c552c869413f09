//! No output replaces an input, no file is written twice, and none is named as another format.

use std::path::{Path, PathBuf};

use crate::program::{crosscut, run, shipped_flight};

/// A folder with a flight `flight.mcap` and a configuration `settings.toml`.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::copy(shipped_flight(), folder.path().join("flight.mcap")).expect("a copy");
    std::fs::write(folder.path().join("settings.toml"), "[affinity]\n").expect("written");
    folder
}

/// The files of the folder with their contents, by name.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let files = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut files: Vec<_> = files.map(|path| (path.clone(), std::fs::read(path).expect("a file"))).collect();
    files.sort();
    files
}

/// Fails unless the command is refused as wrong usage and changes nothing. Words `@NAME` are files of the folder.
#[track_caller]
fn refused(folder: &Path, command: &str) {
    let before = contents(folder);
    let word = |word: &str| match word.strip_prefix('@') {
        Some(name) => folder.join(name).into_os_string(),
        None => word.into(),
    };
    let ran = run(command.split(' ').map(word)).expect_code(2);
    assert!(ran.stderr.contains("would be overwritten"), "{command}: {}", ran.stderr);
    assert!(contents(folder) == before, "{command}: nothing is changed");
}

#[test]
fn the_input_is_never_overwritten() {
    let folder = folder();
    for input in ["@flight.mcap", "@"] {
        refused(folder.path(), &format!("run {input} --out @flight.mcap"));
        refused(folder.path(), &format!("run {input} --out @../{}/flight.mcap", name(folder.path())));
        refused(folder.path(), &format!("compare {input} --json @flight.mcap"));
    }
    // A table is a recording, too.
    std::fs::copy(folder.path().join("flight.mcap"), folder.path().join("table.csv")).expect("copied");
    refused(folder.path(), "compare @table.csv --with default --with paper --csv @table.csv");
}

#[test]
fn what_is_read_beside_the_input_is_never_overwritten() {
    let folder = folder();
    std::fs::copy(folder.path().join("flight.mcap"), folder.path().join("flight.rrd")).expect("copied");
    refused(folder.path(), "run @flight.mcap --out @metadata.yaml");
    refused(folder.path(), "run @flight.mcap --out @flight.mcap-wal");
    #[cfg(feature = "rerun")]
    refused(folder.path(), "compare @flight.rrd --csv @flight-2.rrd");
    let settings = folder.path().join("settings.toml");
    let mut found = crosscut(["run"]);
    found.arg(folder.path().join("flight.mcap")).arg("--out").arg(&settings).env("CROSSCUT_CONFIG", &settings);
    let ran = found.output().expect("the program starts");
    assert_eq!(
        (ran.status.code(), std::fs::read_to_string(settings).expect("text").as_str()),
        (Some(2), "[affinity]\n")
    );
}

fn name(folder: &Path) -> &str {
    folder.file_name().and_then(|name| name.to_str()).expect("a name in UTF-8")
}

#[test]
#[cfg(unix)]
fn the_input_is_not_overwritten_through_a_link() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::hard_link(at("flight.mcap"), at("hard")).expect("a link");
    std::os::unix::fs::symlink(at("flight.mcap"), at("soft")).expect("a link");
    for link in ["hard", "soft"] {
        refused(folder.path(), &format!("run @flight.mcap --out @{link}"));
        refused(folder.path(), &format!("run @flight.mcap --save @{link}"));
        refused(folder.path(), &format!("compare @flight.mcap --csv @{link}"));
        refused(folder.path(), &format!("compare @flight.mcap --with default --with paper --json @{link}"));
    }
}

#[test]
#[cfg(unix)]
fn one_file_under_two_names_is_not_written_twice() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("a.out"), "").expect("written");
    std::fs::hard_link(at("a.out"), at("b.out")).expect("a link");
    refused(folder.path(), "compare @flight.mcap --json @a.out --csv @b.out");
    refused(folder.path(), "run @flight.mcap --out @a.out --save @b.out");
    let other_way = format!("@../{}/new", name(folder.path()));
    refused(folder.path(), &format!("run @flight.mcap --out @new --save {other_way}"));
}

#[test]
fn the_configuration_file_is_never_overwritten() {
    let folder = folder();
    refused(folder.path(), "run @flight.mcap --config @settings.toml --out @settings.toml");
    refused(folder.path(), "run @flight.mcap --config @settings.toml --save @settings.toml");
    refused(folder.path(), "convert @flight.mcap --config @settings.toml --out @settings.toml");
    for (output, name) in [("run --map", "settings.json"), ("report --out", "settings.html")] {
        std::fs::copy(folder.path().join("settings.toml"), folder.path().join(name)).expect("copied");
        refused(folder.path(), &format!("{output} @{name} @flight.mcap --config @{name}"));
    }
    refused(folder.path(), "compare @flight.mcap --with @settings.toml,affinity.kind=rbf --csv @settings.toml");
    refused(folder.path(), "compare @flight.mcap --with default --with @settings.toml --json @settings.toml");
}

#[cfg(feature = "rerun")]
#[test]
fn a_later_part_never_replaces_another_file() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::rename(at("flight.mcap"), at("in-2.rrd")).expect("renamed");
    std::fs::rename(at("settings.toml"), at("in-7.out")).expect("renamed");
    refused(folder.path(), "run @in-2.rrd --save @in.rrd --set recording.part_revolutions=50");
    refused(folder.path(), "run @in-2.rrd --config @in-7.out --save @in.out");
    #[cfg(unix)]
    {
        std::fs::hard_link(at("in-2.rrd"), at("z-3.rrd")).expect("a link");
        refused(folder.path(), "run @in-2.rrd --save @z.rrd --set recording.part_revolutions=50");
    }
}

#[test]
fn results_named_as_another_format_are_refused() {
    let folder = folder();
    for name in ["results.csv", "results.RRD", "results.svg", "results.html"] {
        let before = contents(folder.path());
        let out = folder.path().join(name);
        let ran = run(["run".as_ref(), folder.path().join("flight.mcap").as_os_str(), "-o".as_ref(), out.as_os_str()]);
        assert!(ran.expect_code(2).stderr.contains("results are JSON lines"), "{name}");
        assert_eq!(contents(folder.path()), before, "{name}");
    }
}
