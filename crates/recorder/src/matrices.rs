//! W and L as pictures in beam order: log10 |value| over [-16, 0], a decade a level.
//!
//! Linear levels would show nothing: the leaks that decide the count are 1e-8. Finer levels show the sensor's noise: 256
//! of them make a picture nearly three times as large. L = I - D^-1/2 W D^-1/2 is computed here, from W and the degrees, for the
//! picture alone.

use crosscut_stage::{Affinity, Frame};
use rerun::components::{Colormap, MediaType};
use rerun::external::image::codecs::png::{CompressionType, FilterType, PngEncoder};
use rerun::external::image::{ExtendedColorType, ImageEncoder as _};
use rerun::{EncodedDepthImage, RecordingStream, RecordingStreamResult};

use crate::tensors::f32_vector;

/// Beyond this many returns no picture is made.
pub(crate) const LARGEST_PICTURE: usize = 1024;

/// The decades that a picture spans, ending at 1: the level of a value of 1 or more. Level 0 is 1e-16 or less.
const DECADES: f32 = 16.0;

/// Buffers for the pictures, reused from one revolution to the next.
#[derive(Default)]
pub(crate) struct Pictures {
    /// log10 W, n×n.
    decades: Vec<f32>,
    /// ½ log10 D, n.
    half_degree_decades: Vec<f32>,
    levels: Vec<u8>,
}

impl Pictures {
    /// Degrees, and the pictures of W and L; where there is none, a single dark pixel takes the place of the last one
    /// (the viewer goes on drawing a picture that is cleared).
    pub(crate) fn log(&mut self, rec: &RecordingStream, frame: &Frame) -> RecordingStreamResult<()> {
        let affinity = &frame.affinity;
        rec.log("affinity/degrees", &f32_vector(affinity.degrees.iter().map(|&d| d as f32).collect(), "return"))?;
        let n = affinity.weights.n();
        if !is_drawn(affinity) {
            rec.log("affinity/W", &picture(&[0], 1))?;
            return rec.log("spectral/L", &picture(&[0], 1));
        }
        self.take_decades(affinity);
        self.draw_w();
        rec.log("affinity/W", &picture(&self.levels, n))?;
        self.draw_l(affinity);
        rec.log("spectral/L", &picture(&self.levels, n))
    }

    fn take_decades(&mut self, affinity: &Affinity) {
        let n = affinity.weights.n();
        self.decades.clear();
        self.decades.resize(n * n, f32::NEG_INFINITY);
        affinity.weights.for_each(|i, j, w| self.decades[i * n + j] = (w as f32).log10());
        self.half_degree_decades.clear();
        self.half_degree_decades.extend(affinity.degrees.iter().map(|&d| 0.5 * d.log10() as f32));
    }

    fn draw_w(&mut self) {
        self.levels.clear();
        self.levels.extend(self.decades.iter().map(|&decades| level(decades)));
    }

    /// log10 |L_ij| = log10 W_ij - ½ log10 D_i - ½ log10 D_j off the diagonal; L_ii = 1 - W_ii / D_i.
    fn draw_l(&mut self, affinity: &Affinity) {
        let n = affinity.weights.n();
        let halves = &self.half_degree_decades;
        self.levels.clear();
        for i in 0..n {
            let row = &self.decades[i * n..(i + 1) * n];
            self.levels.extend(row.iter().zip(halves).map(|(w, half)| level(w - halves[i] - half)));
            let own_share = 10f32.powf(row[i] - 2.0 * halves[i]);
            self.levels[i * n + i] = level((1.0 - own_share).abs().log10());
        }
    }
}

fn picture(levels: &[u8], n: usize) -> EncodedDepthImage {
    EncodedDepthImage::new(png(levels, n))
        .with_media_type(MediaType::PNG)
        .with_colormap(Colormap::Viridis)
        .with_depth_range([0.0, f64::from(DECADES) / 255.0]) // the viewer reads a grey PNG as 0 to 1
}

/// Whether W and L of this revolution are drawn.
pub(crate) fn is_drawn(affinity: &Affinity) -> bool {
    let n = affinity.weights.n();
    (1..=LARGEST_PICTURE).contains(&n) && affinity.degrees.len() == n
}

/// Decades above 1e-16.
fn level(decades: f32) -> u8 {
    (decades + DECADES).clamp(0.0, DECADES).round() as u8 // NaN casts to 0
}

/// An n×n grey picture as PNG.
fn png(levels: &[u8], n: usize) -> Vec<u8> {
    let mut png = Vec::with_capacity(levels.len() / 4);
    let side = n as u32;
    PngEncoder::new_with_quality(&mut png, CompressionType::Level(4), FilterType::NoFilter)
        .write_image(levels, side, side, ExtendedColorType::L8)
        .expect("n×n levels make an n×n picture, and memory takes it");
    png
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_span_sixteen_decades_and_never_wrap() {
        assert_eq!([level(0.0), level(3.0), level(f32::INFINITY)], [16; 3]);
        assert_eq!([level(-16.0), level(-300.0), level(f32::NEG_INFINITY), level(f32::NAN)], [0; 4]);
        assert_eq!([level(-8.0), level(-7.6), level(-7.4)], [8, 8, 9]);
    }
}
