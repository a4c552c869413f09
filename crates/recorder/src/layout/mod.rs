//! The layout that goes with every recording: a page for each question, all of them tabs of one window.
//!
//! [`pages`] says what stands on a page, [`views`] what each view shows; a page is readable at 1400×900.

mod pages;
mod properties;
mod views;

use crosscut_stage::Frame;
use rerun::blueprint::components::{PanelState, PlayState};
use rerun::blueprint::{Blueprint, BlueprintPanel, ContainerLike, SelectionPanel, Tabs, TimePanel};
use rerun::{RecordingStream, RecordingStreamResult};

use crate::beam_order::BeamOrder;
use views::Views;

/// The page that a recording opens with. The other pages of a flight are tabs beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// A flight: counts, places, margin, and the revolutions worth a look.
    Overview,
    /// One revolution, stage by stage.
    #[default]
    Stages,
    /// What each stage took, and whether it keeps up with the sensor.
    Speed,
}

impl Layout {
    /// The pages of a flight, in the order of their tabs.
    const ALL: [Self; 3] = [Self::Overview, Self::Stages, Self::Speed];

    fn page(self, views: &mut Views) -> ContainerLike {
        match self {
            Self::Overview => pages::overview(views),
            Self::Stages => pages::stages(views),
            Self::Speed => pages::speed(views),
        }
    }
}

/// How far the views have to reach; taken from the first revolution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Farthest distance that the scan shows, metres.
    pub(crate) range_m: f64,
    /// Places along the side of the pictures.
    pub(crate) places: usize,
}

impl Default for Extent {
    fn default() -> Self {
        Self { range_m: 15.0, places: 360 }
    }
}

impl Extent {
    /// The sensor's range, but at most twice as far as its returns lie; the sensor's beams.
    pub(crate) fn of(frame: &Frame) -> Self {
        let (default, revolution) = (Self::default(), &frame.revolution);
        let farthest_m = (0..revolution.len()).map(|i| revolution.range_m(i)).fold(0.0, f64::max);
        let seen_m = if farthest_m > 0.0 { 2.0 * farthest_m } else { default.range_m };
        let limit_m = revolution.sweep.as_ref().map(|sweep| sweep.range_max_m).filter(|limit| *limit > 0.0);
        let places = BeamOrder::of(revolution).used;
        Self {
            range_m: limit_m.unwrap_or(f64::INFINITY).min(seen_m),
            places: if places > 0 { places } else { default.places },
        }
    }
}

/// Sends the layout with the recording and makes it the active one. The viewer opens the first tab.
pub(crate) fn send(rec: &RecordingStream, first: Layout, extent: Extent) -> RecordingStreamResult<()> {
    let mut views = Views::new("", extent);
    let others = Layout::ALL.into_iter().filter(|page| *page != first);
    let tabs: Vec<_> = std::iter::once(first).chain(others).map(|page| page.page(&mut views)).collect();
    let layout = Blueprint::new(Tabs::new(tabs))
        .with_auto_views(false)
        .with_auto_layout(false)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Collapsed))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Collapsed))
        .with_time_panel(time_panel());
    properties::send(rec, &layout, views.into_properties())
}

/// By revolution; at the newest one until somebody moves it.
fn time_panel() -> TimePanel {
    TimePanel::new()
        .with_state(PanelState::Collapsed)
        .with_timeline("revolution")
        .with_play_state(PlayState::Following)
        .with_fps(10.0)
}
