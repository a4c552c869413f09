//! The layout of every recording: a page for each question, all of them tabs of one window.
//!
//! [`pages`] places the views on a page, [`views`] makes each view. A page is readable at 1400×900.

pub(crate) mod mission;
mod pages;
mod properties;
pub(crate) mod together;
mod views;

use crosscut_stage::Frame;
use nalgebra::Point2;
use rerun::blueprint::components::{PanelState, PlayState};
use rerun::blueprint::{Blueprint, BlueprintPanel, ContainerLike, SelectionPanel, Tabs, TimePanel};
use rerun::log::{Chunk, LogMsg};
use rerun::{RecordingStream, RecordingStreamBuilder, RecordingStreamResult, StoreKind, Tensor, TensorBuffer};

use crate::beam_order::BeamOrder;
use crate::recorder::COMMAND;
use crate::schema::EXTENT;
use crate::tensors::f64_vector;
use properties::Properties;
use views::Views;

/// The page that a recording opens with. The other pages are tabs beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// A flight: counts, places, margin, and the revolutions worth a look.
    Overview,
    /// One revolution, stage by stage.
    #[default]
    Stages,
    /// The map of the flight: the way, the walls, places and passages.
    Map,
    /// Time of each stage, and whether it keeps up with the sensor.
    Speed,
}

impl Layout {
    /// The pages of a flight, in the order of their tabs.
    const ALL: [Self; 4] = [Self::Overview, Self::Stages, Self::Map, Self::Speed];

    /// All pages, this one first.
    fn all_from(first: Option<Self>) -> impl Iterator<Item = Self> {
        first.into_iter().chain(Self::ALL.into_iter().filter(move |page| Some(*page) != first))
    }

    fn page(self, views: &mut Views) -> ContainerLike {
        match self {
            Self::Overview => pages::overview(views),
            Self::Stages => pages::stages(views),
            Self::Map => pages::map(views),
            Self::Speed => pages::speed(views),
        }
    }

    fn page_of_both(self, left: &mut Views, right: &mut Views) -> ContainerLike {
        match self {
            Self::Overview => together::halves("Overview", [left, right].map(pages::overview)),
            Self::Stages => together::stages(left, right),
            Self::Map => together::halves("Map", [left, right].map(pages::map)),
            Self::Speed => together::halves("Speed", [left, right].map(pages::speed)),
        }
    }
}

/// What the views have to show: taken from the first revolution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Farthest distance that the views show, metres.
    pub(crate) range_m: f64,
    /// Places along the side of the pictures.
    pub(crate) places: usize,
    /// The affinity decides gap by gap: its gaps are shown before the eigenvalues.
    pub(crate) by_gaps: bool,
    /// The flight has its truth.
    pub(crate) has_truth: bool,
}

impl Default for Extent {
    fn default() -> Self {
        Self { range_m: 15.0, places: 360, by_gaps: false, has_truth: false }
    }
}

/// No lidar sees farther. A return beyond this is an error of the sensor and does not widen the views.
const FARTHEST_RETURN_M: f64 = 1000.0;

impl Extent {
    /// The sensor's range, but at most twice the distance of its farthest return; and the number of its beams.
    pub(crate) fn of(frame: &Frame) -> Self {
        let (default, revolution) = (Self::default(), &frame.revolution);
        let ranges_m = (0..revolution.len()).map(|i| revolution.range_m(i));
        let farthest_m = ranges_m.filter(|range_m| *range_m <= FARTHEST_RETURN_M).fold(0.0, f64::max);
        let seen_m = if farthest_m > 0.0 { 2.0 * farthest_m } else { default.range_m };
        let limit_m = revolution.beams().map(|sweep| sweep.range_max_m).filter(|limit| *limit > 0.0);
        let places = BeamOrder::of(revolution).used;
        Self {
            range_m: limit_m.unwrap_or(f64::INFINITY).min(seen_m),
            places: if places > 0 { places } else { default.places },
            by_gaps: !frame.affinity.verdicts.is_empty(),
            has_truth: default.has_truth,
        }
    }

    /// Records the extent, so that the recording can be laid out again.
    pub(crate) fn log(self, rec: &RecordingStream) -> RecordingStreamResult<()> {
        let [by_gaps, has_truth] = [self.by_gaps, self.has_truth].map(|is_so| f64::from(u8::from(is_so)));
        let values = vec![self.range_m, self.places as f64, by_gaps, has_truth];
        rec.log_static(EXTENT.path, &Tensor::new(f64_vector(values, EXTENT.dims)))
    }

    /// Reads the extent that was recorded.
    pub(crate) fn read(chunk: &Chunk) -> Option<Self> {
        let data: Vec<rerun::components::TensorData> =
            chunk.component_batch(Tensor::descriptor_data().component, 0)?.ok()?;
        match &data.first()?.buffer {
            TensorBuffer::F64(values) => match values.as_ref() {
                [range_m, places, ..] => {
                    let is_set = |at: usize| values.get(at).is_some_and(|value| *value > 0.0);
                    let [by_gaps, has_truth] = [2, 3].map(is_set);
                    Some(Self { range_m: *range_m, places: *places as usize, by_gaps, has_truth })
                }
                _ => None,
            },
            _ => None,
        }
    }
}

/// What a layout shows. Its pages are tabs. `first` opens, or else the page that only this layout has.
pub(crate) enum Shown<'a> {
    /// A flight.
    Flight { first: Layout, extent: Extent },
    /// Two flights.
    Beside { first: Option<Layout>, sides: [Side<'a>; 2] },
    /// A mission through a mine in a rectangle between these corners, and its flight.
    Mission { corners_m: [Point2<f64>; 2], extent: Extent },
    /// One revolution after the other, and beside it what is held.
    Debug { held: Option<Side<'a>>, now: Side<'a> },
    /// A flight with the other sensors of its MCAP recording, which stand below `root`; `pictures` are cameras.
    Sensors { first: Option<Layout>, extent: Extent, root: &'a str, pictures: &'a [String] },
}

/// One of two flights.
pub(crate) struct Side<'a> {
    /// The entity that all its entities stand below.
    pub(crate) below: &'a str,
    /// Its name in titles.
    pub(crate) name: &'a str,
    pub(crate) extent: Extent,
}

/// Sends the layout with the recording and makes it the active one. The viewer opens the first tab.
pub(crate) fn send(rec: &RecordingStream, shown: &Shown) -> RecordingStreamResult<()> {
    let (tabs, properties) = match shown {
        Shown::Flight { first, extent } => {
            let mut views = Views::new(*extent);
            let tabs = Layout::all_from(Some(*first)).map(|page| page.page(&mut views)).collect();
            (tabs, views.into_properties())
        }
        Shown::Beside { first, sides } => {
            let [mut left, mut right] = sides.each_ref().map(Views::of);
            let mut tabs: Vec<_> =
                Layout::all_from(*first).map(|page| page.page_of_both(&mut left, &mut right)).collect();
            tabs.insert(usize::from(first.is_some()), together::beside(&mut left, &mut right));
            (tabs, left.into_properties().and(right.into_properties()))
        }
        Shown::Mission { corners_m, extent } => {
            let (mut views, mut properties) = (Views::new(*extent), Properties::default());
            let mission = mission::page(&mut properties, *corners_m);
            let tabs =
                std::iter::once(mission).chain(Layout::all_from(None).map(|page| page.page(&mut views))).collect();
            (tabs, views.into_properties().and(properties))
        }
        Shown::Debug { held, now } => {
            let mut now = Views::of(now);
            match held {
                None => (vec![pages::stages(&mut now)], now.into_properties()),
                Some(held) => {
                    let mut held = Views::of(held);
                    let both = together::stages(&mut held, &mut now);
                    let tabs = vec![both, pages::stages(&mut now), pages::stages(&mut held)];
                    (tabs, held.into_properties().and(now.into_properties()))
                }
            }
        }
        Shown::Sensors { first, extent, root, pictures } => {
            let mut views = Views::new(*extent);
            let mut tabs: Vec<_> = Layout::all_from(*first).map(|page| page.page(&mut views)).collect();
            tabs.insert(usize::from(first.is_some()), together::sensors(&mut views, root, pictures));
            (tabs, views.into_properties())
        }
    };
    let timeline = if matches!(shown, Shown::Debug { .. }) { COMMAND } else { "revolution" };
    let layout = Blueprint::new(Tabs::new(tabs))
        .with_auto_views(false)
        .with_auto_layout(false)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Collapsed))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Collapsed))
        .with_time_panel(time_panel(timeline));
    properties::send(rec, &layout, properties)
}

/// The messages of a layout for a recording that is shown again.
pub(crate) fn messages(shown: &Shown) -> RecordingStreamResult<Vec<LogMsg>> {
    let (scratch, storage) = RecordingStreamBuilder::new("crosscut").send_properties(false).memory()?;
    send(&scratch, shown)?;
    let mut messages = storage.take();
    messages.retain(|message| message.store_id().kind() == StoreKind::Blueprint);
    Ok(messages)
}

/// The time panel follows the newest revolution until the user moves it.
fn time_panel(timeline: &str) -> TimePanel {
    TimePanel::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(timeline)
        .with_play_state(PlayState::Following)
        .with_fps(10.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::Point;

    #[test]
    fn an_impossible_range_does_not_widen_the_views() {
        let range_m = |ranges_m: &[f64]| {
            let mut frame = Frame::default();
            frame.revolution.points_m = ranges_m.iter().map(|&range_m| Point::new(range_m, 0.0, 0.0)).collect();
            Extent::of(&frame).range_m
        };
        assert_eq!(range_m(&[3.0, 40.0]), 80.0);
        for wild in [2e9, 1e30, f64::MAX, f64::INFINITY, f64::NAN] {
            assert_eq!(range_m(&[3.0, wild, 40.0]), 80.0, "{wild}");
            assert_eq!(range_m(&[wild]), Extent::default().range_m, "{wild}");
        }
    }
}
