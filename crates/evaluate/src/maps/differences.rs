//! What is wrong with a map, in words.

use std::collections::BTreeSet;

use crosscut_flight::{Map, Node};

use super::{MapTruth, ordered};

impl MapTruth {
    /// What keeps a map from being exact, and wrong numbers of ways, one sentence each.
    pub fn differences(&self, map: &Map) -> Vec<String> {
        let mut said = Vec::new();
        let places: Vec<BTreeSet<Option<usize>>> = map.nodes.iter().map(|node| self.places_of(&node.visits)).collect();
        let one = |node: usize| places[node].iter().next().copied().flatten();
        let mut seen = BTreeSet::new();
        for (id, node) in map.nodes.iter().enumerate() {
            said.extend(self.node_difference(id, node, &places[id], seen.insert(one(id))));
        }
        let through = self.flown_through();
        let missing = through.iter().filter(|place| !seen.contains(&Some(**place)));
        said.extend(missing.map(|&place| format!("place {place} ({} ways) is missing", self.places[place].ways)));
        let mut joined = BTreeSet::new();
        for passage in &map.passages {
            let ends = one(passage.from).zip(one(passage.to)).map(|(from, to)| ordered(from, to));
            match ends.and_then(|ends| self.passage(ends, passage.length_m, &joined)) {
                Some(found) => _ = joined.insert(found),
                None => said.push(format!("the passage {} to {} joins places {ends:?}", passage.from, passage.to)),
            }
        }
        let missing =
            self.flown_passages().difference(&joined).map(|&missing| self.passages[missing].ends).collect::<Vec<_>>();
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
            (Some(Some(place)), 1) if self.places[*place].ways != ways => {
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
