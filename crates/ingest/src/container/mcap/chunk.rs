//! A chunk: records, compressed together, with a checksum.

use std::io::{self, BufRead, BufReader, Read};

use super::records::{Schemas, read_head, read_record, skip, visit};
use crate::container::chunked::Visitor;
use crate::{Damage, limits};

const BUFFER_BYTES: usize = 64 * 1024;

/// What stands before the records of a chunk.
struct ChunkHeader {
    uncompressed_bytes: u64,
    /// 0 if there is none.
    checksum: u32,
    compression: String,
    compressed_bytes: u64,
}

impl ChunkHeader {
    fn read(input: &mut impl Read) -> Result<Self, Damage> {
        skip(input, 2 * 8)?; // the first and the last log time in the chunk
        let uncompressed_bytes = u64::from_le_bytes(read_array(input)?);
        let checksum = u32::from_le_bytes(read_array(input)?);
        let name_bytes = u32::from_le_bytes(read_array(input)?);
        let mut name = Vec::new();
        read_record(input, u64::from(name_bytes), &mut name)?;
        let compression = String::from_utf8_lossy(&name).into_owned();
        Ok(Self { uncompressed_bytes, checksum, compression, compressed_bytes: u64::from_le_bytes(read_array(input)?) })
    }
}

fn read_array<const N: usize>(input: &mut impl Read) -> Result<[u8; N], Damage> {
    let mut bytes = [0; N];
    input.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Hands the records of a chunk to `visitor`. `input` is at the chunk's header and ends with the chunk.
///
/// On an error the visitor has seen what came before the fault, which may be faulty as well: without the whole chunk
/// there is nothing to hold against its checksum.
pub(super) fn visit_chunk(
    mut input: impl BufRead,
    (schemas, body): (&mut Schemas, &mut Vec<u8>),
    visitor: &mut impl Visitor,
) -> Result<(), Damage> {
    let header = ChunkHeader::read(&mut input)?;
    if header.uncompressed_bytes > limits::CHUNK_BYTES {
        return Err(Damage::TooLarge { bytes: header.uncompressed_bytes, limit: limits::CHUNK_BYTES });
    }
    let compressed = input.take(header.compressed_bytes);
    let plain: Box<dyn Read + '_> = match header.compression.as_str() {
        "" => Box::new(compressed),
        "zstd" => Box::new(zstd::stream::read::Decoder::with_buffer(compressed)?),
        "lz4" => Box::new(lz4::Decoder::new(compressed)?),
        _ => return Err(Damage::Compression(header.compression)),
    };
    let mut records = BufReader::with_capacity(BUFFER_BYTES, Checked::new(plain.take(header.uncompressed_bytes)));
    while let Some((opcode, length)) = read_head(&mut records)? {
        let mut record = (&mut records).take(length);
        visit((opcode, length), &mut record, (schemas, body), visitor)?;
        let left = record.limit();
        skip(&mut record, left)?;
    }
    let (bytes, calculated) = records.into_inner().finish();
    if bytes != header.uncompressed_bytes {
        return Err(Damage::Ended);
    }
    check(header.checksum, calculated)
}

/// Whether a checksum is right; 0 stands for none.
pub(super) fn check(saved: u32, calculated: u32) -> Result<(), Damage> {
    if saved == 0 || saved == calculated { Ok(()) } else { Err(Damage::Checksum { saved, calculated }) }
}

/// Counts and sums up the bytes that are read through it.
pub(super) struct Checked<R> {
    input: R,
    hasher: crc32fast::Hasher,
    bytes: u64,
}

impl<R> Checked<R> {
    pub(super) fn new(input: R) -> Self {
        Self { input, hasher: crc32fast::Hasher::new(), bytes: 0 }
    }

    /// Number and checksum of the bytes.
    pub(super) fn finish(self) -> (u64, u32) {
        (self.bytes, self.hasher.finalize())
    }
}

impl<R: Read> Read for Checked<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        self.hasher.update(&buffer[..count]);
        self.bytes += count as u64;
        Ok(count)
    }
}
