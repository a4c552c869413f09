//! W and L as pictures in beam order: log10 |value| over [-16, 0], a decade a level, the upper triangle alone.
//!
//! Both matrices are symmetric, and two triangles take twice the space. On a linear scale the edges of 1e-8 that decide
//! the count could not be seen. 256 levels would show the sensor's noise and take nearly three times the space.
//! L = I - D^-1/2 W D^-1/2 is computed here, from W and the degrees, for the picture alone.

use crosscut_stage::{Affinity, Frame, Weights};
use rerun::components::{Colormap, MediaType};
use rerun::{AsComponents, EncodedDepthImage, LineStrips2D, Points2D, Radius, RecordingStream, RecordingStreamResult};

use crate::beam_order::{BeamOrder, LARGEST_SIDE};
use crate::colors::{VIRIDIS, WORDS_ON_PICTURES, color};
use crate::png::{Encoder, Picture};
use crate::rows::Rows;
use crate::schema::{AFFINITY_ABSENT, AFFINITY_DEGREES, AFFINITY_MARKS, AFFINITY_SCALE, AFFINITY_W, SPECTRAL_L};
use crate::tensors::f32_vector;
use crate::words::words;

/// The level of a value of 1 or more. There is a level for each decade down to level 0, which is 1e-16 or less.
const DECADES: u8 = 16;

/// The key to the colours, in the lower triangle of pictures with this many places: a bar with the colour of every other
/// level, and labels at its ends and middle.
pub(crate) fn log_scale(rec: &RecordingStream, places: usize) -> RecordingStreamResult<()> {
    let side = places as f32;
    let (left, top, height) = (0.03 * side, 0.58 * side, 0.36 * side);
    let y = |i: usize| top + height * i as f32 / (VIRIDIS.len() - 1) as f32;
    let half = 0.5 * height / (VIRIDIS.len() - 1) as f32;
    let from_1 = || VIRIDIS.iter().rev().enumerate();
    let bar = LineStrips2D::new(from_1().map(|(i, _)| [[left, y(i)], [left + 0.05 * side, y(i)]]))
        .with_colors(from_1().map(|(_, rgba)| color(*rgba)))
        .with_radii([Radius::new_scene_units(half)]);
    let named = (0..VIRIDIS.len()).step_by(4);
    let name = |i: usize| if i == 0 { "1".to_owned() } else { format!("1e-{}", 2 * i) };
    let names = words(named.map(|i| ([left + 0.15 * side, y(i) - 0.03 * side], name(i))));
    let names = names.with_colors([color(WORDS_ON_PICTURES)]);
    rec.log_static(AFFINITY_SCALE.path, &[&bar as &dyn AsComponents, &names])
}

/// Draws W and L, with buffers that are reused from one revolution to the next.
#[derive(Default)]
pub(crate) struct Pictures {
    /// Pixels a side of the last pictures.
    side: usize,
    scale: Scale,
    /// D^-1/2, by return.
    roots: Vec<f64>,
    w: Picture,
    l: Picture,
    encoder: Encoder,
}

impl Pictures {
    /// Degrees, and the pictures of W and L.
    pub(crate) fn log(&mut self, rows: &mut Rows, frame: &Frame, order: &BeamOrder) {
        let degrees = frame.affinity.degrees.iter().map(|&d| d as f32).collect();
        rows.log_tensor(&AFFINITY_DEGREES, f32_vector(degrees, AFFINITY_DEGREES.dims), &[]);
        self.side = order.side;
        self.clear();
        if is_drawn(frame) {
            self.draw(&frame.affinity, order);
        }
        self.log_pictures(rows);
    }

    /// Dark pictures of the size of the last ones: the viewer keeps showing a picture that is cleared.
    pub(crate) fn log_dark(&mut self, rows: &mut Rows) {
        self.clear();
        self.log_pictures(rows);
    }

    fn log_pictures(&mut self, rows: &mut Rows) {
        if self.side > 0 {
            rows.log(&AFFINITY_W, &EncodedDepthImage::new(self.encoder.encode(&self.w)));
            rows.log(&SPECTRAL_L, &EncodedDepthImage::new(self.encoder.encode(&self.l)));
        }
    }

    fn clear(&mut self) {
        self.w.clear(self.side, self.side);
        self.l.clear(self.side, self.side);
    }

    /// |L_ij| = W_ij / √(D_i D_j) off the diagonal, which is at most W_ij as D >= 1; L_ii = 1 - W_ii / D_i with W_ii = 1.
    fn draw(&mut self, affinity: &Affinity, BeamOrder { places, pixels, .. }: &BeamOrder) {
        let Self { scale, roots, w: w_picture, l: l_picture, .. } = self;
        roots.clear();
        roots.extend(affinity.degrees.iter().map(|degree| degree.sqrt().recip()));
        let mut entry = |i: usize, j: usize, w: f64| {
            let level = scale.level(w);
            if level > 0 {
                w_picture.set(places[i], places[j], *pixels, level);
                l_picture.set(places[i], places[j], *pixels, scale.level(w * roots[i] * roots[j]));
            }
        };
        match &affinity.weights {
            Weights::Dense(w) => {
                for j in 0..w.ncols() {
                    let above_diagonal = &w.col_as_slice(j)[..=j];
                    above_diagonal.iter().enumerate().for_each(|(i, &w)| entry(i, j, w));
                }
            }
            sparse => sparse.for_each(|i, j, w| {
                if i <= j {
                    entry(i, j, w);
                }
            }),
        }
        for (place, degree) in places.iter().zip(&affinity.degrees) {
            l_picture.set(*place, *place, *pixels, scale.level((1.0 - degree.recip()).abs()));
        }
    }
}

/// How the viewer shows pictures of levels.
pub(crate) fn look(colors: Colormap) -> EncodedDepthImage {
    EncodedDepthImage::update_fields()
        .with_media_type(MediaType::PNG)
        .with_colormap(colors)
        .with_depth_range([0.0, f64::from(DECADES) / 255.0]) // the viewer reads a grey PNG as 0 to 1
}

/// Look of the pictures of W and L, and of the marks on that of W.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let marks = Points2D::update_fields().with_radii([Radius::new_ui_points(3.0)]).with_show_labels(true);
    rec.log_static(AFFINITY_MARKS.path, &marks)?;
    rec.log_static(AFFINITY_W.path, &look(Colormap::Viridis))?;
    rec.log_static(SPECTRAL_L.path, &look(Colormap::Viridis))
}

/// Why there is no picture of W, L and U, written in the middle of their views when it changes.
#[derive(Default)]
pub(crate) struct Absent {
    written: Option<String>,
}

impl Absent {
    /// Writes the reason of this revolution; none of a picture that is there.
    pub(crate) fn log(&mut self, rows: &mut Rows, frame: &Frame, has_matrices: bool, order: &BeamOrder) {
        let n = frame.affinity.weights.n();
        let reason = match has_matrices {
            false => "Not recorded (recording.detail=light)".to_owned(),
            true if n == 0 && frame.affinity.dual.is_some() => "No direction is a way".to_owned(),
            true if n == 0 => "The scan has no return".to_owned(),
            true if !is_drawn(frame) => format!("{n} rows: pictures are made up to {LARGEST_SIDE}"),
            true => String::new(),
        };
        if self.written.as_ref() == Some(&reason) {
            return;
        }
        let middle = 0.5 * order.used as f32;
        let shown = Some(reason.as_str()).filter(|reason| !reason.is_empty());
        rows.log(&AFFINITY_ABSENT, &words(shown.map(|reason| ([middle, 0.5 * middle], reason))));
        self.written = Some(reason);
    }
}

/// Whether W and L of this revolution are drawn.
pub(crate) fn is_drawn(frame: &Frame) -> bool {
    let n = frame.affinity.weights.n();
    let is_whole = frame.affinity.dual.is_some() || frame.revolution.len() == n;
    (1..=LARGEST_SIDE).contains(&n) && frame.affinity.degrees.len() == n && is_whole
}

/// Levels of values: decades above 1e-16, rounded, without a logarithm for each value.
struct Scale {
    /// For each power of 2 from 2^-53 to 1: the level there, and the value from which on the next level begins. Levels are
    /// a factor of 10 apart, so at most one begins before the next power of 2. None begins after 1 (NaN).
    binades: [(u8, f64); BINADES],
}

/// Powers of 2 from 2^-53, which has level 0, to 1, which has the highest level.
const BINADES: usize = 54;

impl Default for Scale {
    fn default() -> Self {
        let binade = |at: usize| {
            let power = 0.5f64.powi((BINADES - 1 - at) as i32);
            let level = (power.log10() + f64::from(DECADES)).clamp(0.0, f64::from(DECADES)).round();
            let next = if at < BINADES - 1 { 10f64.powf(level + 0.5 - f64::from(DECADES)) } else { f64::NAN };
            (level as u8, next)
        };
        Self { binades: std::array::from_fn(binade) }
    }
}

impl Scale {
    /// The level of a value that is not negative; NaN has level 0.
    fn level(&self, value: f64) -> u8 {
        const EXPONENT_OF_1: usize = 1023;
        if value.is_nan() {
            return 0;
        }
        let exponent = (value.to_bits() >> 52) as usize;
        let (level, next) = self.binades[(exponent + BINADES).saturating_sub(EXPONENT_OF_1 + 1).min(BINADES - 1)];
        level + u8::from(value >= next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_rounded_decades_and_never_wrap() {
        let level = |value: f64| Scale::default().level(value);
        assert_eq!([level(1.0), level(1e3), level(f64::INFINITY)], [16; 3]);
        assert_eq!([level(1e-16), level(1e-300), level(0.0), level(f64::NAN)], [0; 4]);
        for decades in -200..20 {
            let decades = 0.1 * f64::from(decades) + 0.03;
            let expected = (decades + 16.0).clamp(0.0, 16.0).round() as u8;
            assert_eq!(level(10f64.powf(decades)), expected, "10^{decades}");
        }
    }
}
