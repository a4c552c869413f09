//! Square grey pictures as PNG files.
//!
//! The encoder of the crate `image` hands the rows to its compressor one by one, which clears its buffer for each of
//! them: that took most of the time of a recording. Here a picture is compressed at once, and the compressor is reused.

use flate2::{Compress, Compression, Crc, FlushCompress, Status};

/// Bytes of a row before its pixels: the number of the filter, which is 0 for none.
const FILTER_BYTES: usize = 1;

/// Encodes pictures.
pub(crate) struct Encoder {
    compress: Compress,
    /// Room for the compressed pixels.
    buffer: Vec<u8>,
}

impl Default for Encoder {
    fn default() -> Self {
        Self { compress: Compress::new(Compression::new(6), true), buffer: Vec::new() }
    }
}

/// A square picture.
#[derive(Default)]
pub(crate) struct Picture {
    side: usize,
    /// Rows, each with its filter byte in front.
    rows: Vec<u8>,
}

impl Picture {
    /// Makes all pixels dark.
    pub(crate) fn clear(&mut self, side: usize) {
        self.side = side;
        self.rows.clear();
        self.rows.resize(side * (side + FILTER_BYTES), 0);
    }

    /// Sets the pixel in row `i` and column `j`.
    pub(crate) fn set(&mut self, i: usize, j: usize, level: u8) {
        self.rows[i * (self.side + FILTER_BYTES) + FILTER_BYTES + j] = level;
    }
}

impl Encoder {
    /// The picture as the content of a PNG file.
    pub(crate) fn encode(&mut self, picture: &Picture) -> Vec<u8> {
        const GREY_8_BIT: [u8; 5] = [8, 0, 0, 0, 0]; // depth, colour, compression, filter, no interlace
        let side = u32::try_from(picture.side).expect("a picture has a few thousand pixels a side").to_be_bytes();
        let pixels = self.compressed(&picture.rows);
        let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
        add_chunk(&mut png, *b"IHDR", &[&side[..], &side, &GREY_8_BIT].concat());
        add_chunk(&mut png, *b"IDAT", pixels);
        add_chunk(&mut png, *b"IEND", &[]);
        png
    }

    fn compressed(&mut self, bytes: &[u8]) -> &[u8] {
        let most = bytes.len() + bytes.len() / 8 + 64; // if they do not get smaller
        self.buffer.resize(most, 0);
        self.compress.reset();
        let status = self.compress.compress(bytes, &mut self.buffer, FlushCompress::Finish);
        assert_eq!(status.expect("nothing but memory can fail"), Status::StreamEnd, "{most} bytes are room enough");
        &self.buffer[..self.compress.total_out() as usize]
    }
}

/// A chunk: length, kind, content and checksum.
fn add_chunk(png: &mut Vec<u8>, kind: [u8; 4], content: &[u8]) {
    let mut checksum = Crc::new();
    checksum.update(&kind);
    checksum.update(content);
    let bytes = u32::try_from(content.len()).expect("a picture has a few megabytes");
    png.extend_from_slice(&bytes.to_be_bytes());
    png.extend_from_slice(&kind);
    png.extend_from_slice(content);
    png.extend_from_slice(&checksum.sum().to_be_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_any_content_and_size_read_back() {
        let mut encoder = Encoder::default();
        for side in [64, 1024, 1, 320] {
            let noise = |i: usize, j: usize| ((i * 31 + j * 17).wrapping_mul(0x9E37_79B9) >> 11) as u8;
            for level in [noise, |_, _| 0, |i, j| u8::from(i == j)] {
                let mut picture = Picture::default();
                picture.clear(side);
                (0..side * side).for_each(|at| picture.set(at / side, at % side, level(at / side, at % side)));
                let png = encoder.encode(&picture);
                let read = rerun::external::image::load_from_memory(&png).expect("a PNG").to_luma8();
                assert_eq!(read.dimensions(), (side as u32, side as u32));
                assert!(read.enumerate_pixels().all(|(x, y, grey)| grey.0 == [level(y as usize, x as usize)]));
            }
        }
    }
}
