//! The pages: their views, with place and size.

use rerun::blueprint::{ContainerLike, Horizontal, Tabs, Vertical};

use super::views::Views;
use crate::schema::{ABOUT, AFFINITY_W, FLIGHT_SUMMARY, SPECTRAL_L, TIMING_SUMMARY};
use crate::why::UNSURE;

/// The title of a cloud in space.
const CLOUD: &str = "Cloud and ways on: drag to turn";

/// A flight: the scan at the chosen revolution, and the counts over all revolutions.
pub(super) fn overview(views: &mut Views) -> ContainerLike {
    let words =
        Tabs::new([views.why("Why this count?"), views.answer(), views.config(), views.document("About", ABOUT)]);
    let scan = if views.has_ways() { views.cloud(CLOUD) } else { views.scan("Here: x up, y left") };
    let here = Vertical::new([scan, words.into()]).with_row_shares([1.15, 1.0]);
    let sure = Tabs::new([views.confidence(), views.margin()]);
    let counts = Tabs::new([views.walls(), views.zeros()]);
    let flight = Vertical::new([counts.into(), views.places(), sure.into(), looks(views).into()]);
    let flight = flight.with_row_shares([1.15, 1.0, 0.75, 1.3]);
    let page = Horizontal::new([here.into(), flight.into()]).with_column_shares([0.72, 1.0]);
    page.with_name("Overview: the flight").into()
}

/// The revolutions worth a look, a list for each reason: the wrong ones first, where the flight has its truth.
fn looks(views: &mut Views) -> Tabs {
    let wrong = views.has_truth().then(|| views.listed("Wrong: click one", &["CRITICAL", "ERROR"]));
    let others = [
        views.listed("Changed: click one", &["WARN"]),
        views.listed("Unsure", &[UNSURE]),
        views.log("All, with notes"),
    ];
    Tabs::new(wrong.into_iter().chain(others))
}

/// One revolution stage by stage, and why its count is what it is.
pub(super) fn stages(views: &mut Views) -> ContainerLike {
    let [returns, w, eigenvalues, u, labels, openings, words] = steps(views);
    let above = Horizontal::new([returns, w, eigenvalues, words]).with_column_shares([1.0, 1.0, 0.95, 1.35]);
    let below = Horizontal::new([u, labels, openings]).with_column_shares([1.0, 1.0, 1.0]);
    Vertical::new([above.into(), below.into()]).with_name(views.titled("Stages: one revolution")).into()
}

/// The views of the page [`stages`], in their order.
pub(super) fn steps(views: &mut Views) -> [ContainerLike; 7] {
    let matrices =
        Tabs::new([views.picture("2 W, upper half", AFFINITY_W), views.picture("3 L, upper half", SPECTRAL_L)]);
    let [eigenvalues, gaps] = [views.chart("4 Eigenvalues of L"), views.gaps("Room at gaps")];
    let deciding = if views.by_gaps() { [gaps, eigenvalues] } else { [eigenvalues, gaps] };
    let by = if views.has_ways() { "5 U by direction" } else { "5 U by beam" };
    let u = Tabs::new([views.eigenvectors(by), views.embedding(), views.embedding_plane()]);
    let words = Tabs::new([
        views.why("8 Why?"),
        views.answer(),
        views.worth("Worth a look"),
        views.config(),
        views.document("About", ABOUT),
    ]);
    let [returns, labels] = match views.has_ways() {
        true => [
            views.cloud(&format!("1 {CLOUD}")),
            views.sphere("6 Sphere unrolled: bright is far, striped is not in view"),
        ],
        false => [views.returns("1 Returns"), views.labels("6 Walls and ranges by beam")],
    };
    [
        returns,
        matrices.into(),
        Tabs::new(deciding).into(),
        u.into(),
        labels,
        views.scan("7 Walls and openings"),
        words.into(),
    ]
}

/// The map of the flight so far: the way, the walls, the places and passages, and why.
pub(super) fn map(views: &mut Views) -> ContainerLike {
    let words = Tabs::new([
        views.document("Map in words", FLIGHT_SUMMARY),
        views.flight_graph(),
        views.answer(),
        views.log("Log"),
    ]);
    let aside = Vertical::new([words.into(), views.flight_places()]).with_row_shares([1.0, 0.4]);
    let page = Horizontal::new([views.flight_map(), aside.into()]).with_column_shares([1.0, 0.62]);
    page.with_name("Map: places and passages").into()
}

/// Time of each stage, and whether it keeps up with the sensor.
pub(super) fn speed(views: &mut Views) -> ContainerLike {
    let times = Vertical::new([views.timings(), views.total(), views.returns_count()]).with_row_shares([1.7, 0.9, 0.6]);
    let page =
        Horizontal::new([times.into(), views.document("Time so far", TIMING_SUMMARY)]).with_column_shares([1.0, 0.5]);
    page.with_name("Speed: time per stage").into()
}
