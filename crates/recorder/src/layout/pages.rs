//! The pages: which views stand on them, where, and how large.

use rerun::blueprint::{ContainerLike, Grid, Horizontal, Tabs, Vertical};

use super::views::Views;

/// A flight: where it was at the chosen revolution, and what was counted all along.
pub(super) fn overview(views: &mut Views) -> ContainerLike {
    let words = Tabs::new([views.answer(), views.why(), views.config(), views.about()]);
    let here = Vertical::new([views.scan("Here: x up, y left"), words.into()]).with_row_shares([1.5, 1.0]);
    let flight = [views.counts(), views.places(), views.margin(), views.confidence(), views.log()];
    let flight = Vertical::new(flight).with_row_shares([1.2, 0.55, 0.9, 0.75, 1.2]);
    let page = Horizontal::new([here.into(), flight.into()]).with_column_shares([0.72, 1.0]);
    page.with_name("Overview: the flight").into()
}

/// One revolution in the order of the stages, and why its count is what it is.
pub(super) fn stages(views: &mut Views) -> ContainerLike {
    Grid::new(steps(views)).with_grid_columns(4).with_name("Stages: one revolution").into()
}

/// What stands on that page, in its order.
pub(super) fn steps(views: &mut Views) -> [ContainerLike; 8] {
    let embedding = Tabs::new([views.embedding(), views.embedding_plane()]);
    let words = Tabs::new([views.why(), views.answer(), views.log(), views.config(), views.about()]);
    [
        views.returns("1 Returns: x up, y left"),
        views.picture("2 W by beam: log10, 1e-16 to 1", "affinity/W"),
        views.picture("3 L by beam: likewise", "spectral/L"),
        views.chart("4 Eigenvalues of L: zeros blue, τ pink"),
        embedding.into(),
        views.labels("6 Labels and ranges by beam"),
        views.scan("7 Walls and openings"),
        words.into(),
    ]
}

/// What each stage took, and whether it keeps up with the sensor.
pub(super) fn speed(views: &mut Views) -> ContainerLike {
    let times = Vertical::new([views.timings(), views.total(), views.returns_count()]).with_row_shares([1.4, 1.0, 0.7]);
    let page = Horizontal::new([times.into(), views.timing_table()]).with_column_shares([1.0, 0.5]);
    page.with_name("Speed: time per stage").into()
}
