//! U as a picture by beam, a band for each eigenvector, under a bar of the walls: in a clear scan every band has one colour
//! for each wall.

use crosscut_stage::Frame;
use rerun::components::Colormap;
use rerun::{AsComponents, EncodedDepthImage, LineStrips2D, Points2D, Radius, RecordingStream, RecordingStreamResult};

use crate::beam_order::BeamOrder;
use crate::matrices::{is_drawn, look};
use crate::partition::runs;
use crate::png::{Encoder, Picture};
use crate::rows::Rows;
use crate::schema::{SPECTRAL_U_BARS, SPECTRAL_U_PICTURE};
use crate::tracks::Classes;
use crate::words;

/// The level of 0; the largest absolute value of an eigenvector lies this many levels above or below it, and level 0 is never used.
const ZERO: u8 = 8;
const STEPS: f64 = 7.0;
/// Bands at most; more of them could not be told apart.
const BANDS: usize = 16;
/// Height of the picture as a share of its width.
pub(crate) const HEIGHT: f64 = 0.5;

/// Look of the picture, the bars and the names.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    rec.log_static(SPECTRAL_U_PICTURE.path, &look(Colormap::CyanToYellow))?;
    let ui = Radius::new_ui_points;
    let bars = LineStrips2D::update_fields().with_radii([ui(4.0)]).with_show_labels(false);
    let names = words::look(Points2D::update_fields());
    rec.log_static(SPECTRAL_U_BARS.path, &[&bars as &dyn AsComponents, &names])
}

/// Draws U, with buffers that are reused from one revolution to the next.
#[derive(Default)]
pub(crate) struct Bands {
    side: usize,
    levels: Vec<u8>,
    picture: Picture,
    encoder: Encoder,
}

impl Bands {
    /// The picture, and the bars and names around it.
    pub(crate) fn log(&mut self, rows: &mut Rows, frame: &Frame, order: &BeamOrder, classes: &Classes) {
        let u = &frame.spectrum.u;
        self.clear(order.side);
        let bands = if is_drawn(frame) && u.nrows() == order.places.len() { u.ncols().min(BANDS) } else { 0 };
        let height = self.height();
        for band in 0..bands {
            self.levels.fill(ZERO);
            let largest = (0..u.nrows()).map(|i| u[(i, band)].abs()).fold(0.0, f64::max);
            for (i, &place) in order.places.iter().enumerate() {
                let steps = (STEPS * u[(i, band)] / largest.max(f64::MIN_POSITIVE)).round();
                self.levels[place..place + order.pixels].fill((f64::from(ZERO) + steps) as u8);
            }
            self.picture.fill_rows(band * height / bands, (band + 1) * height / bands, &self.levels);
        }
        self.log_picture(rows);
        log_bars(rows, order, classes, (height, bands));
    }

    /// A dark picture of the size of the last one: the viewer keeps showing a picture that is cleared.
    pub(crate) fn log_dark(&mut self, rows: &mut Rows) {
        if self.side > 0 {
            self.clear(self.side);
            self.log_picture(rows);
        }
    }

    fn height(&self) -> usize {
        (HEIGHT * self.side as f64) as usize
    }

    fn clear(&mut self, side: usize) {
        self.side = side;
        self.levels.clear();
        self.levels.resize(side, ZERO);
        self.picture.clear(side, self.height());
        self.picture.fill_rows(0, self.height(), &self.levels);
    }

    fn log_picture(&mut self, rows: &mut Rows) {
        rows.log(&SPECTRAL_U_PICTURE, &EncodedDepthImage::new(self.encoder.encode(&self.picture)));
    }
}

/// A bar for each run of returns of one wall, and the name of each band.
fn log_bars(rows: &mut Rows, order: &BeamOrder, classes: &Classes, (height, bands): (usize, usize)) {
    let runs = runs(classes.of_rows(), &order.places, order.pixels);
    let y = -0.03 * order.used as f32;
    let bars = LineStrips2D::new(runs.iter().map(|&(_, from, to)| [[from as f32, y], [to as f32, y]]))
        .with_class_ids(runs.iter().map(|&(class, ..)| class));
    let middle = |band: usize| (band as f32 + 0.5) * height as f32 / bands as f32;
    let at = |band: usize| [-0.06 * order.used as f32, middle(band) - 0.035 * order.used as f32];
    let names = Points2D::new((0..bands).map(at)).with_labels((1..=bands).map(|band| format!("u{band}")));
    rows.log(&SPECTRAL_U_BARS, &[&bars as &dyn AsComponents, &names]);
}
