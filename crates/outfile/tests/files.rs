//! What readers and a second writer find at any moment.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use crosscut_outfile::{BUSY, Growing, Keep, Replaced, Whole, write};

const KEEPS: [Keep; 2] = [Keep::ThroughKill, Keep::ThroughPowerLoss];

/// A folder with an older file `out`.
fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("works");
    let out = folder.path().join("out");
    fs::write(&out, "old").expect("works");
    (folder, out)
}

/// The names in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("works");
    entries.map(|entry| entry.expect("works").file_name().into_string().expect("works")).collect()
}

#[test]
fn an_older_file_is_there_until_the_new_one_is_whole() {
    for keep in KEEPS {
        let (folder, out) = folder();
        let mut whole = Whole::create(&out, keep).unwrap();
        whole.write_all(&[b'n'; 100_000]).unwrap();
        whole.flush().unwrap();
        assert_eq!(fs::read(&out).unwrap(), b"old");
        drop(whole);
        assert_eq!((fs::read(&out).unwrap(), names(folder.path())), (b"old".to_vec(), vec!["out".to_owned()]));
        write(&out, "new").unwrap();
        assert_eq!((fs::read(&out).unwrap(), names(folder.path())), (b"new".to_vec(), vec!["out".to_owned()]));
    }
}

#[test]
fn an_older_file_is_there_until_the_first_line_of_the_new_one() {
    for keep in KEEPS {
        let (folder, out) = folder();
        let mut growing = Growing::create(&out, keep).unwrap();
        growing.write_all(b"half a li").unwrap();
        assert_eq!(fs::read(&out).unwrap(), b"old");
        growing.write_all(b"ne\n").unwrap();
        growing.flush().unwrap();
        growing.write_all(b"second\n").unwrap();
        assert_eq!(fs::read(&out).unwrap(), b"half a line\nsecond\n");
        growing.finish().unwrap();
        drop(growing);
        assert_eq!(names(folder.path()), ["out"]);
        drop(Growing::create(&out, keep).unwrap());
        assert_eq!(fs::read(&out).unwrap(), b"half a line\nsecond\n", "nothing was written");
        assert_eq!(names(folder.path()), ["out"]);
    }
}

#[test]
#[cfg(unix)]
fn a_second_writer_is_refused_with_words_at_any_time() {
    let (_folder, out) = folder();
    let refused = || {
        for error in [
            Whole::create(&out, Keep::ThroughKill).err(),
            Growing::create(&out, Keep::ThroughKill).err(),
            Replaced::create(&out, Keep::ThroughKill).err(),
            write(&out, "other").err(),
        ] {
            assert_eq!(error.expect("refused").to_string(), BUSY);
        }
    };
    let mut whole = Whole::create(&out, Keep::ThroughKill).unwrap();
    refused();
    whole.write_all(b"whole").unwrap();
    refused();
    whole.finish().unwrap();

    let mut growing = Growing::create(&out, Keep::ThroughPowerLoss).unwrap();
    refused();
    growing.write_all(b"line\n").unwrap();
    growing.flush().unwrap();
    refused();
    drop(growing);

    let mut replaced = Replaced::create(&out, Keep::ThroughPowerLoss).unwrap();
    for map in ["first", "second", "third"] {
        refused();
        replaced.replace(map).unwrap();
        refused();
        assert_eq!(fs::read_to_string(&out).unwrap(), map);
    }
    drop(replaced);
    write(&out, "free again").unwrap();
}

#[test]
fn the_part_file_of_a_killed_program_is_taken_over() {
    let (folder, out) = folder();
    fs::write(folder.path().join(".out.part"), "what a killed program wrote, longer than the new file").unwrap();
    write(&out, "new").unwrap();
    assert_eq!((fs::read(&out).unwrap(), names(folder.path())), (b"new".to_vec(), vec!["out".to_owned()]));
}

#[test]
#[cfg(unix)]
fn a_linked_file_is_replaced_where_it_is_with_its_permissions() {
    use std::os::unix::fs::PermissionsExt as _;
    let (folder, out) = folder();
    fs::set_permissions(&out, fs::Permissions::from_mode(0o640)).unwrap();
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(&out, &link).unwrap();
    write(&link, "new").unwrap();
    assert_eq!(fs::read(&out).unwrap(), b"new");
    assert!(link.is_symlink());
    assert_eq!(fs::metadata(&out).unwrap().permissions().mode() & 0o777, 0o640);
}

#[test]
#[cfg(target_os = "linux")]
fn after_a_failed_write_the_flushed_part_stays_and_nothing_follows() {
    use std::process::Command;
    if let Some(out) = std::env::var_os("CROSSCUT_TEST_LIMITED") {
        let mut growing = Growing::create(Path::new(&out), Keep::ThroughKill).unwrap();
        growing.write_all(&[b'a'; 1000]).unwrap();
        growing.flush().unwrap();
        growing.write_all(&[b'b'; 100]).unwrap();
        growing.write_all(&[b'c'; 100_000]).expect_err("beyond the limit");
        growing.write_all(b"d").expect_err("nothing follows");
        growing.flush().expect_err("nothing follows");
        return;
    }
    let (folder, out) = folder();
    let test = "after_a_failed_write_the_flushed_part_stays_and_nothing_follows";
    let limited = format!("trap '' XFSZ; ulimit -f 20; exec \"$0\" --exact {test}");
    let mut shell = Command::new("sh");
    shell.args(["-c", &limited]).arg(std::env::current_exe().unwrap()).env("CROSSCUT_TEST_LIMITED", &out);
    let ran = shell.output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stdout));
    assert_eq!(fs::read(&out).unwrap(), [b'a'; 1000]);
    assert_eq!(names(folder.path()), ["out"]);
}

#[test]
#[cfg(unix)]
fn a_device_is_written_to_directly() {
    let null = Path::new("/dev/null");
    write(null, "gone").unwrap();
    let mut growing = Growing::create(null, Keep::ThroughPowerLoss).unwrap();
    growing.write_all(b"gone").unwrap();
    growing.finish().unwrap();
    let mut replaced = Replaced::create(null, Keep::ThroughPowerLoss).unwrap();
    assert!(!replaced.is_file());
    replaced.replace("gone").unwrap();
}
