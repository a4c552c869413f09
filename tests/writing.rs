//! Every output of every command is whole, or holds what was there before: after a kill, on a full disk, beside another
//! writer. An output that grows may also hold a beginning that can be read.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crosscut_outfile::{Keep, Whole};
use serde_json::Value;

use crate::program::{Ran, crosscut, run, shipped_flight};

/// What was there before.
const OLD: &[u8] = b"an older file\n";

/// Each output is killed this often, unless the environment says otherwise.
const KILLS: u32 = 3;
const KILLS_VARIABLE: &str = "CROSSCUT_KILLS";

/// An output of a command.
struct Output {
    /// Its arguments; `FLIGHT` is the shipped flight, `PLAN` the plan of a mine, `RECORDING` a recording of the
    /// flight, `@` the output.
    command: &'static str,
    /// The output.
    out: &'static str,
    holds: Holds,
}

/// What a file may hold at any time, if not what was there before.
#[derive(Clone, Copy, PartialEq)]
enum Holds {
    /// What the finished command leaves in it.
    All,
    /// JSON that is complete: it is replaced on the way, or states times.
    Json,
    /// Text with this end: it is replaced on the way, or states times.
    End(&'static str),
    /// A beginning of what the finished command leaves in it.
    Beginning,
    /// A recording that `rrd ls` opens.
    #[cfg_attr(not(feature = "rerun"), allow(dead_code))]
    Recording,
}

const fn output(command: &'static str, out: &'static str, holds: Holds) -> Output {
    Output { command, out, holds }
}

const OUTPUTS: &[Output] = &[
    output("run FLIGHT --quiet --out @", "results.jsonl", Holds::Beginning),
    output("run FLIGHT --quiet --out @", "results.mcap", Holds::Beginning),
    output("run FLIGHT --quiet --map @", "map.json", Holds::Json),
    output("run FLIGHT --quiet --rate 20 --map @", "map.json", Holds::Json),
    output("run FLIGHT --quiet --map @", "map.svg", Holds::End("</svg>")),
    output("report FLIGHT --quiet --out @", "page.html", Holds::End("</html>\n")),
    output("convert FLIGHT --out @", "converted.mcap", Holds::All),
    output("compare FLIGHT --quiet --with default --with threshold --json @", "c.json", Holds::Json),
    output("compare FLIGHT --quiet --grid vehicle.width_m=0.6,1.2 --csv @", "c.csv", Holds::All),
    output("simulate tee --quiet --out @", "tee.mcap", Holds::All),
    output("simulate --plan PLAN --quiet --out @", "plan.mcap", Holds::All),
    output("explore --plan PLAN --quiet --json @", "outcome.json", Holds::Json),
    output("explore --plan PLAN --quiet --journal @", "journal.mcap", Holds::Beginning),
    #[cfg(feature = "rerun")]
    output("run FLIGHT --quiet --save @", "flight.rrd", Holds::Recording),
    #[cfg(feature = "rerun")]
    output("explore --plan PLAN --quiet --save @", "mission.rrd", Holds::Recording),
    #[cfg(feature = "rerun")]
    output("rrd get RECORDING /kmeans/labels --out @", "labels.csv", Holds::All),
    #[cfg(feature = "rerun")]
    output("rrd get RECORDING /spectral/U --at 17 --out @", "u.npy", Holds::All),
];

/// A short tunnel.
const PLAN: &str = r#"{"nodes": [{"id": 0, "x_m": 0, "y_m": 0}, {"id": 1, "x_m": 12, "y_m": 0}],
    "edges": [{"from": 0, "to": 1, "width_m": 3.5}]}"#;

/// A recording of the shipped flight, which the tests share.
fn recorded() -> &'static Path {
    static RECORDED: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = RECORDED.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("recorded.rrd");
        let flight = shipped_flight();
        run(["run".as_ref(), flight.as_os_str(), "--quiet".as_ref(), "--save".as_ref(), path.as_os_str()])
            .expect_code(0);
        (folder, path)
    });
    path
}

impl Output {
    /// Its command, in a folder with the plan.
    fn words(&self, folder: &Path) -> Vec<PathBuf> {
        let plan = folder.join("plan.json");
        fs::write(&plan, PLAN).expect("written");
        let word = |word: &str| match word {
            "FLIGHT" => shipped_flight(),
            "PLAN" => plan.clone(),
            "RECORDING" => recorded().into(),
            "@" => folder.join(self.out),
            word => word.into(),
        };
        self.command.split(' ').map(word).collect()
    }

    /// A folder with an older file.
    fn folder(&self) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join(self.out);
        fs::create_dir_all(file.parent().expect("it has one")).expect("made");
        fs::write(file, OLD).expect("written");
        folder
    }

    /// Fails unless the file holds what it may. `all` is what the finished command leaves in it.
    #[track_caller]
    fn check(&self, folder: &Path, all: &[u8], when: &str) {
        let file = folder.join(self.out);
        let there = fs::read(&file).expect("there in any case");
        let is_right = there == OLD
            || match self.holds {
                Holds::All => there == all,
                Holds::Json => serde_json::from_slice::<Value>(&there).is_ok(),
                Holds::End(end) => there.ends_with(end.as_bytes()),
                Holds::Beginning => !there.is_empty() && all.starts_with(&there),
                Holds::Recording => {
                    let listed = run(["rrd".as_ref(), "ls".as_ref(), file.as_os_str()]);
                    matches!(listed.code, Some(0 | 3))
                }
            };
        assert!(is_right, "{} {when}: {} bytes of {}", self.command, there.len(), all.len());
    }
}

/// Runs the command where no file may grow beyond `half_kib`, as on a full disk.
#[cfg(unix)]
fn limited(words: &[PathBuf], half_kib: u32) -> Ran {
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("ulimit -f {half_kib}; exec \"$0\" \"$@\"")]);
    shell.arg(env!("CARGO_BIN_EXE_crosscut")).args(words).output().expect("it runs").into()
}

#[test]
#[cfg(unix)]
fn a_full_disk_leaves_older_files_and_has_words_and_an_exit_code() {
    for output in OUTPUTS {
        let folder = output.folder();
        let ran = limited(&output.words(folder.path()), 0);
        let said = format!("{} ended with {:?}: {}", output.command, ran.code, ran.stderr);
        assert!(matches!(ran.code, Some(1 | 3)) && ran.stderr.contains("File too large"), "{said}");
        assert_eq!(fs::read(folder.path().join(output.out)).expect("there"), OLD, "{said}");
    }
}

#[test]
#[cfg(unix)]
fn a_disk_that_fills_up_leaves_a_beginning_or_older_files() {
    for output in OUTPUTS {
        let folder = output.folder();
        run(output.words(folder.path()));
        let all = fs::read(folder.path().join(output.out)).expect("there");
        let folder = output.folder();
        let half_kib = u32::try_from(all.len() / 1024).expect("small");
        let ran = limited(&output.words(folder.path()), half_kib);
        assert!(matches!(ran.code, Some(1 | 3)), "{} ended with {:?}: {}", output.command, ran.code, ran.stderr);
        output.check(folder.path(), &all, "on a disk that fills up");
    }
}

#[test]
#[cfg(unix)]
fn a_second_writer_is_refused_and_the_first_keeps_its_file() {
    for output in OUTPUTS {
        let folder = output.folder();
        let held = Whole::create(&folder.path().join(output.out), Keep::ThroughKill).expect("nobody writes to it");
        let ran = run(output.words(folder.path()));
        let said = format!("{} ended with {:?}: {}", output.command, ran.code, ran.stderr);
        assert!(matches!(ran.code, Some(1 | 3)) && ran.stderr.contains("another program is writing to it"), "{said}");
        drop(held);
        assert_eq!(fs::read(folder.path().join(output.out)).expect("there"), OLD, "{said}");
    }
}

#[test]
fn a_kill_at_any_moment_leaves_whole_or_older_files() {
    let kills = std::env::var(KILLS_VARIABLE).ok().and_then(|kills| kills.parse().ok()).unwrap_or(KILLS);
    let mut random = 7_u64;
    let mut share = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as f64 / (1_u64 << 31) as f64
    };
    for output in OUTPUTS {
        let folder = output.folder();
        let start = Instant::now();
        let ran = run(output.words(folder.path()));
        assert_eq!(ran.code, Some(0), "{}: {}", output.command, ran.stderr);
        let (all, took) = (fs::read(folder.path().join(output.out)).expect("written"), start.elapsed());
        assert!(all != OLD, "{} writes {}", output.command, output.out);
        output.check(folder.path(), &all, "finished");
        for _ in 0..kills {
            let folder = output.folder();
            let mut command = crosscut(output.words(folder.path()));
            let mut child = command.stderr(Stdio::null()).stdout(Stdio::null()).spawn().expect("it starts");
            let after = took.mul_f64(1.1 * share());
            std::thread::sleep(after);
            child.kill().expect("it was started");
            child.wait().expect("it ends");
            output.check(folder.path(), &all, &format!("killed after {after:?} of {took:?}"));
        }
    }
}

#[test]
#[cfg(target_os = "linux")]
fn closed_or_unwritable_standard_output_is_an_error() {
    let flight = shipped_flight();
    for redirection in [">&-", "1</dev/null", ">/dev/full"] {
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("exec \"$0\" run \"$1\" --quiet --out - {redirection}")]);
        let ran: Ran = shell.arg(env!("CARGO_BIN_EXE_crosscut")).arg(&flight).output().expect("it runs").into();
        let ran = ran.expect_code(1);
        assert!(ran.stderr.starts_with("error: "), "{redirection}: {}", ran.stderr);
    }
    let mut command = crosscut(["run".as_ref(), flight.as_os_str(), "--out".as_ref(), "-".as_ref()]);
    assert_eq!(command.arg("--quiet").stdout(Stdio::null()).status().expect("it runs").code(), Some(0));
}

#[test]
#[cfg(unix)]
fn a_signal_ends_a_run_whose_output_nobody_reads() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("it is on every Unix").success());
    let flight = shipped_flight();
    let mut child = crosscut(["run".as_ref(), flight.as_os_str(), "--out".as_ref(), pipe.as_os_str()])
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    std::thread::sleep(Duration::from_millis(500));
    let sent = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    assert!(sent.expect("kill is on every Unix").success());
    let deadline = Instant::now() + Duration::from_secs(20);
    while Instant::now() < deadline {
        if let Some(status) = child.try_wait().expect("it is a child") {
            assert_eq!(status.code(), Some(130));
            return;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.kill().expect("it was started");
    child.wait().expect("it ends");
    panic!("the signal was swallowed");
}
