//! The layout of every recording: a page for each question, all of them tabs of one window.
//!
//! [`pages`] places the views on a page, [`views`] makes each view. A page is readable at 1400×900.

pub(crate) mod differs;
mod extent;
pub(crate) mod mission;
mod pages;
mod properties;
mod together;
mod views;

use nalgebra::Point2;
use rerun::blueprint::components::{PanelState, PlayState};
use rerun::blueprint::{Blueprint, BlueprintPanel, ContainerLike, SelectionPanel, Tabs, TimePanel};
use rerun::log::LogMsg;
use rerun::{RecordingStream, RecordingStreamBuilder, RecordingStreamResult, StoreKind};

pub(crate) use extent::{Extent, Side};
use properties::Properties;
use views::Views;

/// The timeline of revolutions that are shown one after the other ([`crate::DebugView`]).
pub(crate) const COMMAND: &str = "command";

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
