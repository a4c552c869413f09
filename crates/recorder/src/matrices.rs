//! W and L as pictures in beam order: log10 |value| over [-16, 0], a decade a level, the upper triangle alone.
//!
//! Both are symmetric, and two triangles take twice the room of one. Linear levels would show nothing: the leaks that
//! decide the count are 1e-8. Finer levels show the sensor's noise: 256 of them make a picture nearly three times as
//! large. L = I - D^-1/2 W D^-1/2 is computed here, from W and the degrees, for the picture alone.

use crosscut_stage::{Affinity, Frame};
use rerun::components::{Colormap, MediaType};
use rerun::external::image::codecs::png::{CompressionType, FilterType, PngEncoder};
use rerun::external::image::{ExtendedColorType, ImageEncoder as _};
use rerun::{AsComponents, EncodedDepthImage, LineStrips2D, Points2D, Radius, RecordingStream, RecordingStreamResult};

use crate::beam_order::{BeamOrder, LARGEST_SIDE};
use crate::colors::{VIRIDIS, WORDS_ON_PICTURES, color};
use crate::tensors::f32_vector;

/// The decades that a picture spans, ending at 1: the level of a value of 1 or more. Level 0 is 1e-16 or less.
const DECADES: f32 = 16.0;

/// What the colours stand for, in the lower triangle of pictures of so many places: a bar with a colour for every other
/// level, with the ends and the middle named.
pub(crate) fn log_scale(rec: &RecordingStream, places: usize) -> RecordingStreamResult<()> {
    let side = places as f32;
    let (left, top, height) = (0.07 * side, 0.58 * side, 0.36 * side);
    let y = |i: usize| top + height * i as f32 / (VIRIDIS.len() - 1) as f32;
    let half = 0.5 * height / (VIRIDIS.len() - 1) as f32;
    let from_1 = || VIRIDIS.iter().rev().enumerate();
    let bar = LineStrips2D::new(from_1().map(|(i, _)| [[left, y(i)], [left + 0.05 * side, y(i)]]))
        .with_colors(from_1().map(|(_, rgba)| color(*rgba)))
        .with_radii([Radius::new_scene_units(half)]);
    let named = (0..VIRIDIS.len()).step_by(4);
    let names = Points2D::new(named.clone().map(|i| [left + 0.17 * side, y(i) - 0.03 * side]))
        .with_radii([Radius::new_ui_points(0.0)])
        .with_colors([color(WORDS_ON_PICTURES)])
        .with_labels(named.map(|i| if i == 0 { "1".to_owned() } else { format!("1e-{}", 2 * i) }))
        .with_show_labels(true);
    rec.log_static("affinity/scale", &[&bar as &dyn AsComponents, &names])
}

/// Buffers for the pictures, reused from one revolution to the next.
#[derive(Default)]
pub(crate) struct Pictures {
    /// Pixels a side of the last pictures.
    side: usize,
    /// log10 W, side×side, upper triangle; -∞ where there is no return.
    decades: Vec<f32>,
    /// ½ log10 D, by place.
    half_degree_decades: Vec<f32>,
    levels: Vec<u8>,
}

impl Pictures {
    /// Degrees, and the pictures of W and L.
    pub(crate) fn log(&mut self, rec: &RecordingStream, frame: &Frame, order: &BeamOrder) -> RecordingStreamResult<()> {
        let degrees = frame.affinity.degrees.iter().map(|&d| d as f32).collect();
        rec.log("affinity/degrees", &f32_vector(degrees, "return"))?;
        self.side = order.side;
        if !is_drawn(frame) {
            return self.log_dark(rec);
        }
        self.take_decades(&frame.affinity, order);
        self.draw_w();
        rec.log("affinity/W", &self.picture())?;
        self.draw_l(&frame.affinity, order);
        rec.log("spectral/L", &self.picture())
    }

    /// Dark pictures of the size of the last ones: the viewer goes on showing a picture that is cleared.
    pub(crate) fn log_dark(&mut self, rec: &RecordingStream) -> RecordingStreamResult<()> {
        if self.side == 0 {
            return Ok(()); // there was no picture yet
        }
        self.levels.clear();
        self.levels.resize(self.side * self.side, 0);
        let dark = self.picture();
        rec.log("affinity/W", &dark)?;
        rec.log("spectral/L", &dark)
    }

    fn take_decades(&mut self, affinity: &Affinity, order: &BeamOrder) {
        let (side, places) = (order.side, &order.places);
        self.decades.clear();
        self.decades.resize(side * side, f32::NEG_INFINITY);
        affinity.weights.for_each(|i, j, w| {
            if i <= j {
                self.decades[places[i] * side + places[j]] = (w as f32).log10();
            }
        });
        self.half_degree_decades.clear();
        self.half_degree_decades.resize(side, 0.0);
        for (&place, degree) in places.iter().zip(&affinity.degrees) {
            self.half_degree_decades[place] = 0.5 * degree.log10() as f32;
        }
    }

    fn draw_w(&mut self) {
        self.levels.clear();
        self.levels.extend(self.decades.iter().map(|&decades| level(decades)));
    }

    /// log10 |L_ij| = log10 W_ij - ½ log10 D_i - ½ log10 D_j off the diagonal; L_ii = 1 - W_ii / D_i with W_ii = 1, in
    /// f64: for a return that is nearly alone it is a leak of 1e-8 and less, which f32 would round to 0.
    fn draw_l(&mut self, affinity: &Affinity, order: &BeamOrder) {
        let halves = &self.half_degree_decades;
        self.levels.clear();
        for (row, own_half) in self.decades.chunks_exact(order.side).zip(halves) {
            self.levels.extend(row.iter().zip(halves).map(|(w, half)| level(w - own_half - half)));
        }
        for (&place, degree) in order.places.iter().zip(&affinity.degrees) {
            self.levels[place * order.side + place] = level((1.0 - 1.0 / degree).abs().log10() as f32);
        }
    }

    fn picture(&self) -> EncodedDepthImage {
        EncodedDepthImage::new(png(&self.levels, self.side))
            .with_media_type(MediaType::PNG)
            .with_colormap(Colormap::Viridis)
            .with_depth_range([0.0, f64::from(DECADES) / 255.0]) // the viewer reads a grey PNG as 0 to 1
    }
}

/// Whether W and L of this revolution are drawn.
pub(crate) fn is_drawn(frame: &Frame) -> bool {
    let n = frame.affinity.weights.n();
    (1..=LARGEST_SIDE).contains(&n) && frame.affinity.degrees.len() == n && frame.revolution.len() == n
}

/// Decades above 1e-16.
fn level(decades: f32) -> u8 {
    (decades + DECADES).clamp(0.0, DECADES).round() as u8 // NaN casts to 0
}

/// A square grey picture as PNG.
fn png(levels: &[u8], side: usize) -> Vec<u8> {
    let mut png = Vec::with_capacity(levels.len() / 4);
    let pixels = side as u32;
    PngEncoder::new_with_quality(&mut png, CompressionType::Level(6), FilterType::NoFilter)
        .write_image(levels, pixels, pixels, ExtendedColorType::L8)
        .expect("the levels fill the picture, and memory takes it");
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
