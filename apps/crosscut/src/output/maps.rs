//! The map of a flight as a file, in the format of its extension.

use std::path::Path;

use crosscut_flight::{Map, MapDrawing, Mapper, NoPlace, Node, write_g2o};
use serde_json::{Value, json};

use crate::output::map_picture::{Drawing, WIDE_PX};

/// The extensions of the formats.
pub(crate) const FORMATS: [&str; 4] = ["json", "svg", "geojson", "g2o"];

/// The extension that chooses the format, in small letters.
pub(crate) fn format_of(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// The file at `path`; of a drawing, with what was `seen`.
pub(crate) fn text(path: &Path, mapper: &Mapper, no_place: &NoPlace, seen: &MapDrawing) -> String {
    let map = mapper.map();
    match format_of(path).as_str() {
        "svg" => {
            let title = no_place.reason(&map).unwrap_or_else(|| map.summary());
            Drawing::of(map, seen, mapper).svg(&title, WIDE_PX)
        }
        "geojson" => geojson(&map).to_string(),
        "g2o" => write_g2o(&mapper.pose_graph()),
        _ => json(&map).to_string() + "\n",
    }
}

/// The contract of the map: nodes, edges and merges.
pub(crate) fn json(map: &Map) -> Value {
    let node = |(id, node): (usize, &Node)| {
        json!({"id": id, "kind": node.kind.name(), "x_m": node.position_m.x, "y_m": node.position_m.y,
               "ways": node.ways, "visits": node.visits, "stretch": map.stretch_of(node) + 1})
    };
    let edge = |(id, edge): (usize, &crosscut_flight::Passage)| {
        let via_m: Vec<[f64; 2]> = edge.via_m.iter().map(|place_m| [place_m.x, place_m.y]).collect();
        json!({"id": id, "from": edge.from, "to": edge.to, "length_m": edge.length_m,
               "length_sd_m": edge.length_sd_m, "width_m": edge.width_m,
               "stretch_ns": edge.stretch_ns, "via_m": via_m})
    };
    json!({
        "nodes": map.nodes.iter().enumerate().map(node).collect::<Vec<_>>(),
        "edges": map.passages.iter().enumerate().map(edge).collect::<Vec<_>>(),
        "merges": map.merges,
        "refusals": map.refusals,
    })
}

/// In metres of the map's frame, not in degrees, as Nav2's Route Server loads graphs: numbers (`id`) are unique over nodes
/// and edges, and each edge leads one way, so that a passage is two.
fn geojson(map: &Map) -> Value {
    let node = |(id, node): (usize, &Node)| {
        json!({"type": "Feature", "geometry": {"type": "Point", "coordinates": [node.position_m.x, node.position_m.y]},
               "properties": {"id": id, "frame": "map", "kind": node.kind.name(), "ways": node.ways.len()}})
    };
    let edge = |(number, passage): (usize, &crosscut_flight::Passage)| {
        let course: Vec<[f64; 2]> = map.course_m(passage).map(|place_m| [place_m.x, place_m.y]).collect();
        let back: Vec<[f64; 2]> = course.iter().rev().copied().collect();
        let first = map.nodes.len() + 2 * number;
        [(first, passage.from, passage.to, course), (first + 1, passage.to, passage.from, back)].map(
            |(id, start, end, course)| {
                json!({"type": "Feature", "geometry": {"type": "MultiLineString", "coordinates": [course]},
                       "properties": {"id": id, "startid": start, "endid": end, "cost": passage.length_m,
                                      "length_m": passage.length_m, "length_sd_m": passage.length_sd_m,
                                      "width_m": passage.width_m}})
            },
        )
    };
    let nodes = map.nodes.iter().enumerate().map(node);
    let features: Vec<Value> = nodes.chain(map.passages.iter().enumerate().flat_map(edge)).collect();
    json!({"type": "FeatureCollection", "features": features})
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use crosscut_flight::{HereKind, Passage};

    use super::*;

    /// Two junctions with a passage between them.
    fn two_junctions() -> Map {
        let node = |x_m: f64| Node {
            kind: HereKind::Junction,
            position_m: [x_m, 0.0].into(),
            ways: Vec::new(),
            visits: Vec::new(),
        };
        let passage = Passage {
            from: 0,
            to: 1,
            length_m: 21.0,
            length_sd_m: None,
            width_m: 4.0,
            stretch_ns: [0, 1],
            via_m: vec![[10.0, 2.0].into()],
        };
        Map { nodes: vec![node(0.0), node(20.0)], passages: vec![passage], ..Map::default() }
    }

    /// By the rules of `GeoJsonGraphFileLoader` of Nav2's `nav2_route`.
    #[test]
    fn the_geojson_is_a_graph_of_the_route_server() {
        let graph = geojson(&two_junctions());
        let features = graph["features"].as_array().expect("a list");
        let of_type = |name: &str| features.iter().filter(|of| of["geometry"]["type"] == name).collect::<Vec<_>>();
        let (nodes, edges) = (of_type("Point"), of_type("MultiLineString"));
        assert!(nodes.len() == 2 && edges.len() == 2 && features.len() == 4);
        let id = |of: &&Value| of["properties"]["id"].as_u64().expect("unsigned");
        assert_eq!(features.iter().map(|of| id(&of)).collect::<BTreeSet<_>>().len(), 4, "unique over both");
        assert!(nodes.iter().all(|node| node["properties"]["frame"] == "map"));
        let known: BTreeSet<u64> = nodes.iter().map(id).collect();
        for edge in &edges {
            let [start, end] = ["startid", "endid"].map(|key| edge["properties"][key].as_u64().expect("unsigned"));
            assert!(known.contains(&start) && known.contains(&end) && start != end);
            let course = edge["geometry"]["coordinates"][0].as_array().expect("a line");
            assert_eq!(course[0], nodes[start as usize]["geometry"]["coordinates"]);
            assert_eq!(course[2], nodes[end as usize]["geometry"]["coordinates"]);
        }
    }
}
