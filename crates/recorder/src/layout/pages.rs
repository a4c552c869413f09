//! The pages: their views, with place and size.

use rerun::blueprint::{ContainerLike, Horizontal, Tabs, Vertical};

use super::views::Views;
use crate::schema::{AFFINITY_W, SPECTRAL_L};

/// A flight: the scan at the chosen revolution, and the counts over all revolutions.
pub(super) fn overview(views: &mut Views) -> ContainerLike {
    let words = Tabs::new([views.answer(), views.why("Why this count?"), views.config(), views.about()]);
    let here = Vertical::new([views.scan("Here: x up, y left"), words.into()]).with_row_shares([1.25, 1.0]);
    let counts = [views.junctions(), views.places(), views.zeros(), views.margin(), views.confidence()];
    let flight = counts.into_iter().chain([views.log("Worth a look: click a revolution")]);
    let flight = Vertical::new(flight).with_row_shares([1.1, 0.5, 1.1, 0.7, 0.65, 0.95]);
    let page = Horizontal::new([here.into(), flight.into()]).with_column_shares([0.72, 1.0]);
    page.with_name("Overview: the flight").into()
}

/// One revolution stage by stage, and why its count is what it is.
pub(super) fn stages(views: &mut Views) -> ContainerLike {
    let [returns, w, l, eigenvalues, embedding, labels, openings, words] = steps(views);
    let graph = Horizontal::new([returns, w, l, eigenvalues]).with_column_shares([1.05, 1.0, 1.0, 0.95]);
    let answer = Horizontal::new([embedding, labels, openings, words]).with_column_shares([0.8, 0.9, 1.05, 1.25]);
    Vertical::new([graph.into(), answer.into()]).with_name("Stages: one revolution").into()
}

/// The views of the page [`stages`], in their order.
pub(super) fn steps(views: &mut Views) -> [ContainerLike; 8] {
    let embedding = Tabs::new([views.embedding(), views.embedding_plane()]);
    let words =
        Tabs::new([views.why("8 Why?"), views.answer(), views.log("Worth a look"), views.config(), views.about()]);
    [
        views.returns("1 Returns: x up, y left"),
        views.picture("2 W by beam, 1e-16 to 1", AFFINITY_W),
        views.picture("3 L by beam, 1e-16 to 1", SPECTRAL_L),
        views.chart("4 Eigenvalues of L: zeros blue, τ pink"),
        embedding.into(),
        views.labels("6 Labels and ranges by beam"),
        views.scan("7 Walls and openings"),
        words.into(),
    ]
}

/// The map of the flight so far: the way, the walls, the places and passages, and why.
pub(super) fn map(views: &mut Views) -> ContainerLike {
    let from_above = Vertical::new([views.flight_map(), views.flight_places()]).with_row_shares([1.0, 0.13]);
    let words = Tabs::new([views.flight_summary(), views.answer(), views.log("Log")]);
    let aside = Vertical::new([views.flight_graph(), words.into()]).with_row_shares([0.8, 1.0]);
    let page = Horizontal::new([from_above.into(), aside.into()]).with_column_shares([1.0, 0.62]);
    page.with_name("Map: places and passages").into()
}

/// Time of each stage, and whether it keeps up with the sensor.
pub(super) fn speed(views: &mut Views) -> ContainerLike {
    let times = Vertical::new([views.timings(), views.total(), views.returns_count()]).with_row_shares([1.4, 1.0, 0.7]);
    let page = Horizontal::new([times.into(), views.timing_table()]).with_column_shares([1.0, 0.5]);
    page.with_name("Speed: time per stage").into()
}
