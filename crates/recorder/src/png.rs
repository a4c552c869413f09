//! Grey pictures as PNG files.
//!
//! Own code, because the crate `png` makes a new compressor for each picture: a W of chains (360×360) takes 1.9 times as
//! long for as many bytes, or 2.3 times the bytes in half the time. Here the compressor is reused.

use flate2::{Compress, Compression, Crc, FlushCompress, Status};

/// Bytes of a row before its pixels: the number of the filter, which is 0 for none.
const FILTER_BYTES: usize = 1;

/// The filter of a row that holds differences to the row above.
const DIFFERENCE_TO_ROW_ABOVE: u8 = 2;

/// A picture is bright if at least one pixel in this many was set.
const BRIGHT: usize = 16;

/// Encodes pictures.
pub(crate) struct Encoder {
    /// For pictures that are mostly dark: more effort makes them no smaller.
    dark: Compress,
    bright: Compress,
    /// Room for the compressed pixels.
    buffer: Vec<u8>,
}

impl Default for Encoder {
    fn default() -> Self {
        let of_level = |level| Compress::new(Compression::new(level), true);
        Self { dark: of_level(4), bright: of_level(5), buffer: Vec::new() }
    }
}

/// A picture.
#[derive(Default)]
pub(crate) struct Picture {
    width: usize,
    height: usize,
    /// Rows, each with its filter byte in front.
    rows: Vec<u8>,
    /// Pixels that were set one by one.
    set: usize,
}

impl Picture {
    /// Makes all pixels of a picture of this width and height dark.
    pub(crate) fn clear(&mut self, width: usize, height: usize) {
        (self.width, self.height, self.set) = (width, height, 0);
        self.rows.clear();
        self.rows.resize(height * (width + FILTER_BYTES), 0);
    }

    /// Sets a square from row `i` and column `j` on, `pixels` wide and high.
    pub(crate) fn set(&mut self, i: usize, j: usize, pixels: usize, level: u8) {
        for row in i..i + pixels {
            let first = row * (self.width + FILTER_BYTES) + FILTER_BYTES + j;
            self.rows[first..first + pixels].fill(level);
        }
        self.set += pixels * pixels;
    }

    /// Fills the rows `from` up to `to` with levels by column. All but the first are stored as equal to the row above.
    pub(crate) fn fill_rows(&mut self, from: usize, to: usize, levels: &[u8]) {
        let mut rows = self.rows.chunks_exact_mut(self.width + FILTER_BYTES).take(to).skip(from);
        if let Some(first) = rows.next() {
            first.fill(0);
            first[FILTER_BYTES..][..levels.len()].copy_from_slice(levels);
        }
        for row in rows {
            row.fill(0);
            row[0] = DIFFERENCE_TO_ROW_ABOVE;
        }
    }
}

impl Encoder {
    /// The picture as the content of a PNG file.
    pub(crate) fn encode(&mut self, picture: &Picture) -> Vec<u8> {
        const GREY_8_BIT: [u8; 5] = [8, 0, 0, 0, 0]; // depth, colour, compression, filter, no interlace
        let bytes = |side| u32::try_from(side).expect("a picture has a few thousand pixels a side").to_be_bytes();
        let (width, height) = (bytes(picture.width), bytes(picture.height));
        let pixels = self.compressed(picture);
        let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
        add_chunk(&mut png, *b"IHDR", &[&width[..], &height, &GREY_8_BIT].concat());
        add_chunk(&mut png, *b"IDAT", pixels);
        add_chunk(&mut png, *b"IEND", &[]);
        png
    }

    fn compressed(&mut self, picture: &Picture) -> &[u8] {
        let bytes = &picture.rows[..];
        let is_dark = picture.set < bytes.len() / BRIGHT;
        let compress = if is_dark { &mut self.dark } else { &mut self.bright };
        let most = bytes.len() + bytes.len() / 8 + 64; // if they do not get smaller
        self.buffer.resize(most, 0);
        compress.reset();
        let status = compress.compress(bytes, &mut self.buffer, FlushCompress::Finish);
        assert_eq!(status.expect("nothing but memory can fail"), Status::StreamEnd, "{most} bytes are room enough");
        &self.buffer[..compress.total_out() as usize]
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
    fn filled_rows_read_back_as_bands() {
        let mut picture = Picture::default();
        picture.clear(3, 6);
        picture.fill_rows(0, 6, &[9; 3]);
        picture.fill_rows(2, 5, &[1, 2, 3]);
        picture.fill_rows(5, 6, &[9; 3]);
        let read =
            rerun::external::image::load_from_memory(&Encoder::default().encode(&picture)).expect("a PNG").to_luma8();
        let rows: Vec<&[u8]> = read.as_raw().chunks(3).collect();
        assert_eq!(rows, [[9; 3], [9; 3], [1, 2, 3], [1, 2, 3], [1, 2, 3], [9; 3]]);
    }

    #[test]
    fn pictures_of_any_content_and_size_read_back() {
        let mut encoder = Encoder::default();
        for (width, height) in [(64, 64), (1024, 1024), (1, 1), (320, 160)] {
            let noise = |i: usize, j: usize| ((i * 31 + j * 17).wrapping_mul(0x9E37_79B9) >> 11) as u8;
            for level in [noise, |_, _| 0, |i, j| u8::from(i == j)] {
                let mut picture = Picture::default();
                picture.clear(width, height);
                (0..width * height)
                    .for_each(|at| picture.set(at / width, at % width, 1, level(at / width, at % width)));
                let png = encoder.encode(&picture);
                let read = rerun::external::image::load_from_memory(&png).expect("a PNG").to_luma8();
                assert_eq!(read.dimensions(), (width as u32, height as u32));
                assert!(read.enumerate_pixels().all(|(x, y, grey)| grey.0 == [level(y as usize, x as usize)]));
            }
        }
    }
}
