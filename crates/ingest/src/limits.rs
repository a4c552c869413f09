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
/// Bytes of a whole file after decompression, and of standard input. It is kept on disk.
pub(crate) const DECOMPRESSED_BYTES: u64 = 64 << 30;
/// Bytes of a line in a text file.
pub(crate) const LINE_BYTES: u64 = 16 << 20;
/// Beams of one scan.
pub(crate) const BEAMS: usize = 1 << 20;
