//! Ways on in words, in metres: how far the vehicle gets in each, and what parts them.

use crosscut_stage::{Between, Dual, Frame, Way, direction_words};

/// What is known of a way: "**way 0 (blue)**, level at +12°, 0° up: 2.6 m, p = 0.98: the vehicle gets 14.2 m far in it, and 4.6 m
/// make a way." `name` is what it is called.
fn of_way(name: &str, way: &Way, dual: &Dual) -> String {
    let of_way = dual.cells.iter().filter(|cell| cell.way.is_some_and(|of| dual.ways.get(of as usize) == Some(way)));
    let reach_m = of_way.map(|cell| cell.reach_m).fold(0.0, f64::max);
    let far = if reach_m.is_finite() { format!("{reach_m:.1} m far") } else { "as far as the sensor sees".to_owned() };
    let cut = if way.cut_by_view { " It goes on beyond the view: this is of the part in view." } else { "" };
    let wide = if way.is_wide {
        " It takes up half a turn, or a third of all directions, as in a place that is wide for its height: it may be several ways."
    } else {
        ""
    };
    let (words, p, on_m) = (way.words(), way.p, dual.on_m);
    format!("**{name}**, {words}, p = {p:.2}: the vehicle gets {far} in it, and {on_m:.1} m make a way.{cut}{wide}")
}

/// The ways of a frame in words, those that the report has first, then what parts them; none of a frame without ways.
/// `color_of` names the colour in which a way is drawn.
pub fn ways(frame: &Frame, color_of: &dyn Fn(u32) -> &'static str) -> Vec<String> {
    let (Some(ways), Some(dual)) = (&frame.junction.ways, &frame.affinity.dual) else { return Vec::new() };
    let lines = (0..).zip(ways).map(|(number, way)| of_way(&name(number, color_of), way, dual));
    lines.chain(dual.between.iter().map(|between| parted(between, ways, dual, color_of))).collect()
}

/// What parts the two ways that are nearest to being one; `None` of fewer than two.
pub(crate) fn nearest(ways: &[Way], dual: &Dual, color_of: &dyn Fn(u32) -> &'static str) -> Option<String> {
    let nearest = dual.between.iter().max_by(|a, b| a.reach_m.total_cmp(&b.reach_m));
    nearest.map(|between| parted(between, ways, dual, color_of))
}

/// "Between way 0 (blue) and way 2 (green), at +90°, 2° up, the vehicle gets 2.9 m far; with 4.2 m they would be one."
fn parted(between: &Between, ways: &[Way], dual: &Dual, color_of: &dyn Fn(u32) -> &'static str) -> String {
    let numbers = dual.numbers_in(ways);
    let [a, b] = between.ways.map(|of| numbers[of as usize].map_or("another one".to_owned(), |at| name(at, color_of)));
    let (at, reach_m, cut_m) = (direction_words(&between.direction), between.reach_m, dual.cut_m);
    format!("Between {a} and {b}, at {at}, the vehicle gets {reach_m:.1} m far; with {cut_m:.1} m they would be one.")
}

fn name(number: u32, color_of: &dyn Fn(u32) -> &'static str) -> String {
    numbered("way", number, color_of(number))
}

pub(crate) fn numbered(what: &str, id: u32, color: &str) -> String {
    if color.is_empty() { format!("{what} {id}") } else { format!("{what} {id} ({color})") }
}
