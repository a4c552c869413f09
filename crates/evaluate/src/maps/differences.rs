//! What is wrong with a map, in words.

use std::collections::BTreeSet;

use crosscut_flight::{Map, Node};

use super::MapTruth;

impl MapTruth {
    /// What keeps a map from being exact, and wrong numbers of ways, one sentence each.
    pub fn differences(&self, map: &Map) -> Vec<String> {
        let visits: Vec<Vec<[u64; 2]>> = map.nodes.iter().map(|node| node.visits.clone()).collect();
        self.seen_by(&visits).differences_of(map)
    }

    fn differences_of(&self, map: &Map) -> Vec<String> {
        let mut said = Vec::new();
        let named = self.named(map);
        let mut seen = BTreeSet::new();
        for (id, node) in map.nodes.iter().enumerate() {
            said.extend(self.node_difference(id, node, &named.places[id], seen.insert(named.place(id))));
        }
        let through = self.flown_through();
        let missing = through.iter().filter(|place| !seen.contains(&Some(**place)));
        said.extend(missing.map(|&place| format!("place {place} ({} ways) is missing", self.places[place].ways)));
        let wrong = map.passages.iter().zip(&named.passages).filter(|(_, right)| right.is_none());
        said.extend(wrong.map(|(passage, _)| {
            let ends = [passage.from, passage.to].map(|node| named.place(node));
            format!("the passage {} to {} joins places {ends:?}", passage.from, passage.to)
        }));
        let found: BTreeSet<usize> = named.passages.iter().copied().flatten().collect();
        let missing =
            self.flown_passages().difference(&found).map(|&missing| self.passages[missing].ends).collect::<Vec<_>>();
        said.extend(missing.into_iter().map(|ends| format!("the passage of places {ends:?} is missing")));
        said
    }

    fn node_difference(
        &self,
        id: usize,
        node: &Node,
        places: &BTreeSet<Option<usize>>,
        is_first: bool,
    ) -> Option<String> {
        let (kind, ways) = (node.kind.name(), node.ways.len());
        match (places.iter().next(), places.len()) {
            (Some(Some(place)), 1) if !is_first => {
                Some(format!("node {id} ({kind}, {ways} ways) is place {place} once more"))
            }
            (Some(Some(place)), 1) if !self.has_ways(*place, ways) => {
                Some(format!("node {id} has {ways} ways, place {place} {}", self.places[*place].ways))
            }
            (Some(Some(_)), 1) => None,
            (_, 1) => {
                let near = node.visits.first().and_then(|visit| self.nearest_during(*visit));
                let near =
                    near.map_or_else(String::new, |(place, widths)| format!(", {widths:.1} widths from {place}"));
                Some(format!("node {id} ({kind}, {ways} ways) is no place{near}"))
            }
            _ => Some(format!("node {id} ({kind}, {ways} ways) mixes places {places:?}")),
        }
    }
}
