//! Notes explained by their codes.

use crate::program::crosscut;

#[test]
fn a_code_is_explained_and_an_unknown_one_is_a_usage_error() {
    let output = |code| crosscut(["info", "--note", code]).output().expect("the program runs");
    let known = output("n082");
    let text = String::from_utf8_lossy(&known.stdout);
    assert!(known.status.success() && text.starts_with("code: N082\nwhat was seen: In a part of a wall"), "{known:?}");
    assert!(String::from_utf8_lossy(&output("all").stdout).contains("| N082 |"));
    let unknown = output("N000");
    assert_eq!(unknown.status.code(), Some(2), "{unknown:?}");
}
