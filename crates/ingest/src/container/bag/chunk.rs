//! A chunk: connections and messages, compressed together.

use std::io::{BufRead, BufReader, Read};

use super::records::{Head, op, read_data, read_message, skip, topic_of};
use crate::container::chunked::Visitor;
use crate::{Damage, limits};

const BUFFER_BYTES: usize = 64 * 1024;

/// Hands the records of a chunk to `visitor`. `input` is the chunk's data and `head` its header; `record` and
/// `data` are buffers.
///
/// On an error the visitor has seen what came before the fault.
pub(super) fn visit_chunk(
    head: &Head,
    input: impl BufRead,
    (record, data): (&mut Head, &mut Vec<u8>),
    visitor: &mut impl Visitor,
) -> Result<(), Damage> {
    let bytes = u64::from(head.u32("size")?);
    if bytes > limits::CHUNK_BYTES {
        return Err(Damage::TooLarge { bytes, limit: limits::CHUNK_BYTES });
    }
    let compression = head.text("compression")?;
    let plain: Box<dyn Read + '_> = match compression.as_str() {
        "none" => Box::new(input),
        "bz2" => Box::new(bzip2::bufread::BzDecoder::new(input)),
        "lz4" => Box::new(lz4::Decoder::new(input)?),
        _ => return Err(Damage::Compression(compression)),
    };
    let mut records = BufReader::with_capacity(BUFFER_BYTES, plain.take(bytes));
    while record.read(&mut records)? {
        visit_record(record, &mut records, data, visitor)?;
    }
    if records.into_inner().limit() == 0 { Ok(()) } else { Err(Damage::Ended) }
}

/// Hands the record to `visitor` if it is a connection or a message; the data of others is not read.
pub(super) fn visit_record(
    head: &Head,
    input: &mut impl Read,
    data: &mut Vec<u8>,
    visitor: &mut impl Visitor,
) -> Result<(), Damage> {
    match head.op()? {
        op::CONNECTION => {
            read_data(input, head.data_bytes, data)?;
            visitor.channel(head.u32("conn")?, topic_of(head, data)?);
        }
        op::MESSAGE => {
            let (channel, log_time_ns) = (head.u32("conn")?, head.time_ns("time")?);
            if visitor.wants(channel) {
                read_message(input, head.data_bytes, data)?;
            } else {
                skip(input, head.data_bytes)?;
                data.clear();
            }
            visitor.message(channel, log_time_ns, data);
        }
        _ => skip(input, head.data_bytes)?,
    }
    Ok(())
}
