//! A map as a drawing from above, x to the right: walls, way, passages and places, with a scale and a legend.

use std::collections::BTreeSet;

use crosscut_evaluate::chart::{INK, line, page, text};
use crosscut_flight::{Anchored, HereKind, Map, MapDrawing, Mapper, NodeWay};
use svg::Document;
use svg::node::element::{Circle, Group, Path, Polyline};

/// Colours of the viewer's page of the map.
const PASSAGE: &str = "#56b4e9";
const NOT_TAKEN: &str = "#e8308c";
const JUNCTION: &str = "#e69f00";
const DEAD_END: &str = "#5f5f5f";
const WALLS: &str = "#8c8c8c";
const UNSURE: &str = "#d6c713";

/// A drawing on a page of its own, and one that has to be readable on a phone, are at most this wide.
pub(crate) const WIDE_PX: f64 = 880.0;
pub(crate) const NARROW_PX: f64 = 560.0;
/// A drawing is at most this many times as high as it may be wide.
const MOST_HEIGHT: f64 = 1.3;
/// A metre is at most this many pixels.
const MOST_PX_PER_M: f64 = 40.0;
const MARGIN_PX: f64 = 30.0;
const FONT_PX: f64 = 14.0;
/// A letter of the font is at most about this wide, also where a page shows it larger on a phone.
const LETTER_PX: f64 = 0.7 * FONT_PX;
/// A line of the title has at most this many letters.
const TITLE_LETTERS: usize = 80;
const TITLE_LINE_PX: f64 = 20.0;
const LEGEND_LINE_PX: f64 = 24.0;
/// From the left of an entry of the legend to its words.
const SIGN_PX: f64 = 34.0;
/// Length of a way's line.
const WAY_PX: f64 = 16.0;
/// The bar of the scale takes at most this share of the drawing's width.
const BAR_SHARE: f64 = 0.4;
/// Walls are drawn as one dot for each square of this side.
const SQUARE_PX: f64 = 1.2;
const DOT_PX: f64 = 2.0;
/// Of a place where the answer was unsure.
const BEAD_PX: f64 = 5.0;

/// What a drawing shows, in the frame of the map.
pub(crate) struct Drawing {
    map: Map,
    walls_m: Vec<[f64; 2]>,
    /// In stretches: how one lies to the one before was not seen.
    path_m: Vec<Vec<[f64; 2]>>,
    /// Places of the path where the answer was unsure.
    unsure_m: Vec<[f64; 2]>,
}

/// From metres of the map to pixels of the page.
#[derive(Clone, Copy)]
struct Scale {
    left_m: f64,
    top_m: f64,
    /// Of its upper edge.
    top_px: f64,
    px_per_m: f64,
}

impl Scale {
    fn px(self, [x_m, y_m]: [f64; 2]) -> [f64; 2] {
        let px = [(x_m - self.left_m) * self.px_per_m, (self.top_m - y_m) * self.px_per_m];
        [tenth(px[0] + MARGIN_PX), tenth(px[1] + self.top_px)]
    }
}

impl Drawing {
    pub(crate) fn of(map: Map, seen: &MapDrawing, mapper: &Mapper) -> Self {
        let placed_m = |at: &Anchored| mapper.placed(at).translation.vector.into();
        let placed = |of: &[Anchored]| -> Vec<[f64; 2]> { of.iter().map(placed_m).collect() };
        let path_m = seen.stretches().map(placed).collect();
        let unsure_m = seen.unsure_at().iter().map(|at| placed_m(&seen.path()[*at])).collect();
        Self { map, walls_m: placed(seen.walls()), path_m, unsure_m }
    }

    /// The drawing under a title, at most `most_px` wide.
    pub(crate) fn svg(&self, title: &str, most_px: f64) -> String {
        let [low_m, high_m] = self.corners_m();
        let [width_m, height_m] = [high_m[0] - low_m[0], high_m[1] - low_m[1]];
        let px_per_m = MOST_PX_PER_M.min(most_px / width_m).min(MOST_HEIGHT * most_px / height_m);
        let title = lines(title);
        let top_px = MARGIN_PX + title.len() as f64 * TITLE_LINE_PX;
        let scale = Scale { left_m: low_m[0], top_m: high_m[1], top_px, px_per_m };
        let legend = self.legend();
        let widest = legend.iter().map(|(words, _)| words.chars().count()).max().unwrap_or(0) as f64;
        let title_px = title.iter().map(|line| line.chars().count() as f64 * LETTER_PX).fold(0.0, f64::max);
        let least_px = title_px.max(SIGN_PX + widest * LETTER_PX);
        let width_px = (width_m * px_per_m).max(least_px).ceil() + 2.0 * MARGIN_PX;
        let below_px = top_px + height_m * px_per_m + MARGIN_PX;
        let height_px = (below_px + (legend.len() + 1) as f64 * LEGEND_LINE_PX).ceil();
        let mut page = page(width_px, height_px, FONT_PX);
        for (nth, line) in title.iter().enumerate() {
            page = page.add(text(line, [MARGIN_PX, 26.0 + nth as f64 * TITLE_LINE_PX], "start"));
        }
        page = self.drawn(page, scale);
        for (nth, (words, sign)) in legend.into_iter().enumerate() {
            let y_px = tenth(below_px + nth as f64 * LEGEND_LINE_PX);
            let sign = sign.set("transform", format!("translate({} {})", MARGIN_PX + 0.5 * WAY_PX, y_px - 4.0));
            page = page.add(sign).add(text(&words, [MARGIN_PX + SIGN_PX, y_px], "start"));
        }
        let bar_px = [MARGIN_PX, tenth(below_px - MARGIN_PX + 4.0)];
        bar(page, bar_px, round_length_m(BAR_SHARE * width_m), px_per_m).to_string()
    }

    /// Of all that is drawn; of nothing, a small square.
    fn corners_m(&self) -> [[f64; 2]; 2] {
        let Self { map, walls_m, path_m, .. } = self;
        let courses_m = map.passages.iter().flat_map(|passage| &passage.via_m);
        let of_map = map.nodes.iter().map(|node| &node.position_m).chain(courses_m).map(|at_m| [at_m.x, at_m.y]);
        let places_m = of_map.chain(walls_m.iter().chain(path_m.iter().flatten()).copied());
        let ends = places_m.fold(None, |ends: Option<[[f64; 2]; 2]>, at_m| {
            let [low_m, high_m] = ends.unwrap_or([at_m; 2]);
            Some([[0, 1].map(|axis| low_m[axis].min(at_m[axis])), [0, 1].map(|axis| high_m[axis].max(at_m[axis]))])
        });
        let [low_m, high_m] = ends.unwrap_or_default();
        [low_m, [0, 1].map(|axis| high_m[axis].max(low_m[axis] + 1.0))]
    }

    fn drawn(&self, mut page: Document, scale: Scale) -> Document {
        let Self { map, walls_m, path_m, unsure_m } = self;
        let mut squares = BTreeSet::new();
        let dots = walls_m.iter().map(|at_m| scale.px(*at_m).map(|px| (px / SQUARE_PX).round() as i64));
        let dots: String = dots
            .filter(|square| squares.insert(*square))
            .map(|[x, y]| format!("M{} {}h0", tenth(x as f64 * SQUARE_PX), tenth(y as f64 * SQUARE_PX)))
            .collect();
        page = page.add(dotted(&dots, WALLS, DOT_PX));
        for stretch_m in path_m {
            page = page.add(course(stretch_m.iter().copied(), scale, WALLS, 1.0));
        }
        for passage in &map.passages {
            page = page.add(course(map.course_m(passage).map(|at_m| [at_m.x, at_m.y]), scale, PASSAGE, 3.0));
        }
        let beads: String = unsure_m.iter().map(|at_m| scale.px(*at_m)).map(|[x, y]| format!("M{x} {y}h0")).collect();
        page = page.add(dotted(&beads, UNSURE, BEAD_PX));
        for (id, node) in map.nodes.iter().enumerate() {
            let [x_px, y_px] = scale.px([node.position_m.x, node.position_m.y]);
            let ways = node.ways.iter().map(way);
            let group = ways.fold(Group::new(), Group::add).add(place(node.kind));
            page = page.add(group.set("transform", format!("translate({x_px} {y_px})")));
            page = page.add(text(&id.to_string(), [x_px + 8.0, y_px - 9.0], "start").set("font-weight", "bold"));
        }
        page
    }

    /// The words and the sign of each thing that is drawn.
    fn legend(&self) -> Vec<(String, Group)> {
        let Map { nodes, passages, .. } = &self.map;
        let has = |kind: HereKind| nodes.iter().any(|node| node.kind == kind);
        let has_way = |taken: bool| nodes.iter().flat_map(|node| &node.ways).any(|way| way.taken == taken);
        let stroke = |colour, width_px: f64| {
            let half_px = 0.5 * WAY_PX;
            Group::new().add(line([-half_px, 0.0], [half_px, 0.0], colour).set("stroke-width", width_px))
        };
        let sign = |of| Group::new().add(place(of));
        let dots = "M-8 0h0M-4 1h0M0 0h0M4 -1h0M8 0h0";
        let beads = "M-7 0h0M0 0h0M7 0h0";
        let way = match self.path_m.len() {
            0 | 1 => "way of the vehicle".to_owned(),
            stretches => format!("way of the vehicle, lost between its {stretches} stretches"),
        };
        let entries = [
            (
                !self.walls_m.is_empty(),
                "walls, where the lidar saw them",
                Group::new().add(dotted(dots, WALLS, DOT_PX)),
            ),
            (!self.path_m.is_empty(), &*way, stroke(WALLS, 1.0)),
            (!self.unsure_m.is_empty(), "where the count was unsure", Group::new().add(dotted(beads, UNSURE, BEAD_PX))),
            (!passages.is_empty() || has_way(true), "passage, and a way that was taken", stroke(PASSAGE, 3.0)),
            (has_way(false), "way that was not taken", stroke(NOT_TAKEN, 4.0)),
            (has(HereKind::Junction), "junction, by its number", sign(HereKind::Junction)),
            (has(HereKind::DeadEnd), "dead end", sign(HereKind::DeadEnd)),
            (!self.path_m.is_empty(), "ahead of the vehicle at its start; north is not known", arrow()),
        ];
        entries
            .into_iter()
            .filter(|(is_drawn, ..)| *is_drawn)
            .map(|(_, words, sign)| (words.to_owned(), sign))
            .collect()
    }
}

/// To the right.
fn arrow() -> Group {
    let path = Path::new().set("d", "M-8 0H8M3 -4L8 0L3 4").set("stroke", INK).set("stroke-width", 2);
    Group::new().add(path.set("fill", "none"))
}

/// Dots of this width.
fn dotted(dots: &str, colour: &str, width_px: f64) -> Path {
    Path::new().set("d", dots).set("stroke", colour).set("stroke-width", width_px).set("stroke-linecap", "round")
}

fn course(places_m: impl Iterator<Item = [f64; 2]>, scale: Scale, colour: &str, width_px: f64) -> Polyline {
    let corners = places_m.map(|place_m| scale.px(place_m)).map(|[x_px, y_px]| format!("{x_px},{y_px}"));
    let line = Polyline::new().set("points", corners.collect::<Vec<_>>().join(" ")).set("fill", "none");
    line.set("stroke", colour).set("stroke-width", width_px)
}

/// From the middle of its node.
fn way(way: &NodeWay) -> svg::node::element::Line {
    let end_px = [WAY_PX * way.bearing_rad.cos(), -WAY_PX * way.bearing_rad.sin()].map(tenth);
    line([0.0; 2], end_px, if way.taken { PASSAGE } else { NOT_TAKEN }).set("stroke-width", 4)
}

fn place(kind: HereKind) -> Circle {
    let (radius_px, colour) = if kind == HereKind::Junction { (6, JUNCTION) } else { (4, DEAD_END) };
    Circle::new().set("r", radius_px).set("fill", colour).set("stroke", INK)
}

/// A bar of this length, and the length beside it.
fn bar(page: Document, [x_px, y_px]: [f64; 2], length_m: f64, px_per_m: f64) -> Document {
    let end_px = tenth(x_px + length_m * px_per_m);
    let ends = [x_px, end_px].map(|at_px| line([at_px, y_px - 4.0], [at_px, y_px + 4.0], INK).set("stroke-width", 2));
    let [start, end] = ends;
    let bar = line([x_px, y_px], [end_px, y_px], INK).set("stroke-width", 2);
    page.add(bar).add(start).add(end).add(text(&format!("{length_m} m"), [end_px + 8.0, y_px + 4.0], "start"))
}

/// The words in lines of at most [`TITLE_LETTERS`].
fn lines(words: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words.split_whitespace() {
        match lines.last_mut().filter(|line| line.chars().count() + 1 + word.chars().count() <= TITLE_LETTERS) {
            Some(line) => *line += &format!(" {word}"),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

/// The longest of 1, 2, 5, 10... that is no longer than `most_m`.
fn round_length_m(most_m: f64) -> f64 {
    let power = 10f64.powf(most_m.max(0.1).log10().floor());
    [5.0, 2.0].into_iter().map(|times| times * power).find(|length_m| *length_m <= most_m).unwrap_or(power)
}

fn tenth(px: f64) -> f64 {
    (10.0 * px).round() / 10.0
}

#[cfg(test)]
mod tests {
    use crosscut_flight::Node;

    use super::*;

    #[test]
    fn the_page_is_as_wide_as_its_title_and_shows_a_scale() {
        let node = Node { kind: HereKind::Junction, position_m: [0.0; 2].into(), ways: Vec::new(), visits: Vec::new() };
        let map = Map { nodes: vec![node], ..Map::default() };
        let walls_m = vec![[-2.0, 1.0], [3.0, 1.0]];
        let title = "1 junction: 1 tee; 0 dead ends; 0 loops; 2 ways not taken";
        let drawing = Drawing { map, walls_m, path_m: Vec::new(), unsure_m: vec![[1.0, 0.0]] };
        let svg = drawing.svg(title, WIDE_PX);
        let width_px =
            svg.split("width=\"").nth(1).and_then(|rest| rest.split('"').next()).and_then(|px| px.parse().ok());
        assert!(width_px.is_some_and(|width_px: f64| width_px > title.len() as f64 * 7.0), "{width_px:?}");
        let legend = ["walls, where the lidar saw them", "where the count was unsure", "junction, by its number"];
        for part in [title, ">\n2 m\n<"].into_iter().chain(legend) {
            assert!(svg.contains(part), "{part}: {svg}");
        }
        assert!(!svg.contains("dead end<") && !svg.contains("way of the vehicle"), "only what is drawn is explained");
    }

    #[test]
    fn the_bar_has_a_round_length() {
        let lengths_m = [0.3, 1.0, 3.4, 7.0, 19.0, 60.0].map(round_length_m);
        for (length_m, expected_m) in lengths_m.into_iter().zip([0.2, 1.0, 2.0, 5.0, 10.0, 50.0]) {
            assert!((length_m - expected_m).abs() < 1e-9, "{length_m} {expected_m}");
        }
    }
}
