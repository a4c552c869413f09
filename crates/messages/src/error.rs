//! Why the bytes of a message could not be read.

/// Why the bytes of a message could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DecodeError {
    /// Too short for the encapsulation header.
    #[error("the message has {bytes} bytes, too few for the 4 bytes of a CDR header")]
    NoHeader {
        /// Bytes of the message.
        bytes: usize,
    },
    /// Not plain CDR.
    #[error("the message is {name} (header {id:#06x}); only plain CDR and plain XCDR2 can be read")]
    Encapsulation {
        /// The first two bytes of the header, most significant first.
        id: u16,
        /// What they stand for.
        name: &'static str,
    },
    /// A sequence claims more elements than the message has bytes for.
    #[error(
        "`{field}` claims {claimed} elements, at least {needed_bytes} bytes, but {left_bytes} bytes of the message are \
         left"
    )]
    Length {
        /// The sequence.
        field: &'static str,
        /// Elements, as the message says.
        claimed: u32,
        /// The least number of bytes that these take.
        needed_bytes: u64,
        /// Bytes from the first element to the end of the message.
        left_bytes: u64,
    },
    /// The message ends too early.
    #[error("the message ends in `{field}`, after {bytes} bytes")]
    Ended {
        /// The field that is not complete.
        field: &'static str,
        /// Bytes of the message.
        bytes: usize,
    },
    /// A value that its field does not allow.
    #[error("`{field}` cannot be read: {cause}")]
    Value {
        /// The field.
        field: &'static str,
        /// What is wrong with it.
        cause: String,
    },
    /// What held the message could not be read.
    #[error("{0}")]
    Damaged(String),
    /// Not JSON or protobuf of the schema.
    #[error("the message is not {encoding} of its schema: {cause}")]
    Format {
        /// The encoding.
        encoding: &'static str,
        /// What is wrong.
        cause: String,
    },
}
