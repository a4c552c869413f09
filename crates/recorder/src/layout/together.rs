//! Pages of combinations: two flights side by side; a flight with the other sensors of its MCAP recording.

use rerun::blueprint::{ContainerLike, Grid, Horizontal, Tabs, Vertical};

use super::pages;
use super::views::Views;
use crate::schema::AFFINITY_W;

/// Two flights with the same views: the answer, and the matrix and spectrum that it follows from.
pub(super) fn beside(left: &mut Views, right: &mut Views) -> ContainerLike {
    halves("Side by side", [left, right].map(half))
}

/// Two pages beside each other.
pub(super) fn halves(name: &str, pages: [ContainerLike; 2]) -> ContainerLike {
    Horizontal::new(pages).with_name(name).into()
}

/// One revolution stage by stage, each stage of the first flight next to that of the second.
pub(super) fn stages(left: &mut Views, right: &mut Views) -> ContainerLike {
    let pairs = pages::steps(left).into_iter().zip(pages::steps(right));
    Grid::new(pairs.flat_map(|(left, right)| [left, right])).with_grid_columns(4).with_name("Stages").into()
}

fn half(views: &mut Views) -> ContainerLike {
    let words = Tabs::new([views.why("Why?"), views.answer(), views.config()]);
    let answer = Horizontal::new([views.scan("Walls, openings"), words.into()]);
    let numbers = Horizontal::new([views.picture("W, upper half", AFFINITY_W), views.chart("Eigenvalues of L")]);
    let flight = Horizontal::new([views.walls(), views.margin()]);
    Vertical::new([answer.into(), numbers.into(), flight.into()]).with_row_shares([1.25, 1.0, 0.7]).into()
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
