//! How large things in a recording may be. What exceeds a limit is damage, or costs one message: a few altered bytes
//! must not cost all memory.

/// Bytes of one message.
pub(crate) const MESSAGE_BYTES: u64 = 256 << 20;
/// Bytes of a definition, a header or another record that is no message.
pub(crate) const RECORD_BYTES: u64 = 64 << 20;
/// Bytes of one chunk after decompression.
pub(crate) const CHUNK_BYTES: u64 = 4 << 30;
/// Channels of one file.
pub(crate) const CHANNELS: usize = 65_536;
/// Topics of which the first scans are looked at to describe a file.
pub(crate) const DESCRIBED: usize = 256;
/// Bytes of a whole file after decompression, and of standard input. It is kept on disk.
pub(crate) const SPOOLED_BYTES: u64 = 64 << 30;
/// A compressed file may be this many times as large after decompression, beyond the first bytes.
pub(crate) const EXPANSION: u64 = 100;
/// Bytes after decompression that any compressed file may have.
pub(crate) const ANY_EXPANSION_BYTES: u64 = 64 << 20;
/// Messages that wait for those before them take a fourth of `pipeline.memory_mb`, or this where nobody has set that.
pub(crate) const WAITING_BYTES: u64 = 1 << 30;
/// Bytes of a line in a text file.
pub(crate) const LINE_BYTES: u64 = 16 << 20;
/// Beams of one scan.
pub(crate) const BEAMS: usize = crosscut_messages::MOST_BEAMS;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_in_the_documentation_states_these_limits() {
        let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/recordings.md"));
        let page = page.expect("the documentation");
        let with_commas = |count: usize| {
            let digits = count.to_string();
            let groups: Vec<&[u8]> = digits.as_bytes().rchunks(3).rev().collect();
            String::from_utf8(groups.join(&b',')).expect("digits")
        };
        let mib = |bytes: u64| format!("{} MiB", bytes >> 20);
        let gib = |bytes: u64| format!("{} GiB", bytes >> 30);
        for (what, limit) in [
            ("message", mib(MESSAGE_BYTES)),
            ("record that is no message", mib(RECORD_BYTES)),
            ("chunk after decompression", gib(CHUNK_BYTES)),
            ("beams of a scan", with_commas(BEAMS)),
            ("points of a cloud", with_commas(crosscut_messages::MOST_POINTS)),
            ("fields of a point", with_commas(crosscut_messages::MOST_FIELDS)),
            ("line of a text file", mib(LINE_BYTES)),
            ("channels of a file", with_commas(CHANNELS)),
            ("topics of a file that `info` describes", with_commas(DESCRIBED)),
            ("standard input", format!("{} on disk", gib(SPOOLED_BYTES))),
            (
                "file after decompression",
                format!("{EXPANSION} times its size and {}, {}", mib(ANY_EXPANSION_BYTES), gib(SPOOLED_BYTES)),
            ),
            ("messages that wait in memory", "a fourth of `pipeline.memory_mb`".to_owned()),
        ] {
            assert!(page.contains(&format!("\n| {what} | {limit} |")), "no row `| {what} | {limit} |`");
        }
    }
}
