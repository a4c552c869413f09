//! Pages of combinations: two flights side by side; a flight with the other sensors of its MCAP recording.

use rerun::blueprint::{ContainerLike, Horizontal, Tabs, Vertical};

use super::differs::{DIFFERS_CONFIDENCE, DIFFERS_WALLS};
use super::pages;
use super::views::Views;
use crate::schema::AFFINITY_W;

/// Two flights: where they differ, and below it the scan and the reasons of both, the first on the left.
pub(super) fn beside(left: &mut Views, right: &mut Views) -> ContainerLike {
    let truth = if left.has_truth() || right.has_truth() { ", truth green" } else { "" };
    let lines = Tabs::new([
        left.lines_of_both(&format!("Walls counted: left orange, right blue{truth}"), DIFFERS_WALLS),
        left.lines_of_both("Confidence: left orange, right blue", DIFFERS_CONFIDENCE),
    ]);
    let flight = Vertical::new([lines.into(), left.strip_of_both(right)]).with_row_shares([1.0, 1.1]);
    let list = Vertical::new([left.differences_in_words(), left.differences()]).with_row_shares([1.0, 1.1]);
    let differs = Horizontal::new([flight.into(), list.into()]).with_column_shares([1.0, 1.0]);
    let halves = Horizontal::new([left, right].map(half));
    Vertical::new([differs.into(), halves.into()])
        .with_row_shares([1.15, 1.0])
        .with_name("Side by side: what differs")
        .into()
}

/// Two pages beside each other.
pub(super) fn halves(name: &str, pages: [ContainerLike; 2]) -> ContainerLike {
    Horizontal::new(pages).with_name(name).into()
}

/// One revolution stage by stage, the first flight on the left: a page up to the eigenvalues, and one for what follows.
pub(super) fn stages(left: &mut Views, right: &mut Views) -> ContainerLike {
    let [first, second]: [Vec<ContainerLike>; 2] = [left, right].map(pages::steps).into_iter().fold(
        [Vec::new(), Vec::new()],
        |[mut first, mut second], [returns, w, eigenvalues, u, labels, openings, words]| {
            first.push(square([returns, w, eigenvalues, words]));
            second.push(square_of_three([openings, labels, u]));
            [first, second]
        },
    );
    let pages = [("Stages 1 to 4, and why", first), ("Stages 5 to 7", second)];
    Tabs::new(pages.map(|(name, halves)| Horizontal::new(halves).with_name(name).into())).with_name("Stages").into()
}

fn square([a, b, c, d]: [ContainerLike; 4]) -> ContainerLike {
    Vertical::new([Horizontal::new([a, b]).into(), Horizontal::new([c, d]).into()]).into()
}

fn square_of_three([a, b, c]: [ContainerLike; 3]) -> ContainerLike {
    Vertical::new([a, Horizontal::new([b, c]).into()]).into()
}

/// The scan, with W and the eigenvalues as tabs, and the reasons.
fn half(views: &mut Views) -> ContainerLike {
    let scan = [views.scan("scan"), views.picture("W, upper half", AFFINITY_W), views.chart("eigenvalues")];
    let words = Tabs::new([views.why("why?"), views.answer(), views.config()]);
    Horizontal::new([Tabs::new(scan).into(), words.into()]).into()
}

/// Walls and openings among the robot's own point clouds, its cameras, and below them the flight over time.
pub(super) fn sensors(views: &mut Views, root: &str, pictures: &[String]) -> ContainerLike {
    let scene = views.scene("Walls and openings among the robot's point clouds [m]", root, pictures);
    let cameras = Tabs::new(pictures.iter().map(|entity| Views::camera(entity)));
    let words = Tabs::new([views.why("Why this count?"), views.answer()]);
    let beside: Vec<ContainerLike> = match pictures {
        [] => vec![words.into()],
        _ => vec![cameras.into(), words.into()],
    };
    let above = Horizontal::new([scene, Vertical::new(beside).into()]).with_column_shares([1.6, 1.0]);
    let below = Horizontal::new([views.walls(), views.places()]);
    let page = Vertical::new([above.into(), below.into()]).with_row_shares([3.0, 1.0]);
    page.with_name("Sensors: with the robot's own data").into()
}
