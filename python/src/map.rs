//! The map of a flight.

use crosscut_flight::Map as Graph;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// Junctions and dead ends, each once, and the passages between them, as they were known at one moment of a flight.
#[pyclass(frozen, module = "crosscut._native")]
pub(crate) struct Map(pub(crate) Graph);

#[pymethods]
impl Map {
    /// The nodes, and the passages as (from, to, attributes); both with the names of `crosscut run --map FILE.json`.
    fn graph<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyList>, Bound<'py, PyList>)> {
        let map = &self.0;
        let (nodes, passages) = (PyList::empty(py), PyList::empty(py));
        for node in &map.nodes {
            let ways = PyList::empty(py);
            for way in &node.ways {
                let entry = PyDict::new(py);
                entry.set_item("bearing_rad", way.bearing_rad)?;
                entry.set_item("width_m", way.width_m)?;
                entry.set_item("taken", way.taken)?;
                entry.set_item("edge", way.passage)?;
                ways.append(entry)?;
            }
            let entry = PyDict::new(py);
            entry.set_item("kind", node.kind.name())?;
            entry.set_item("x_m", node.position_m.x)?;
            entry.set_item("y_m", node.position_m.y)?;
            entry.set_item("ways", ways)?;
            entry.set_item("visits", node.visits.iter().map(|v| (v[0], v[1])).collect::<Vec<_>>())?;
            nodes.append(entry)?;
        }
        for passage in &map.passages {
            let entry = PyDict::new(py);
            entry.set_item("length_m", passage.length_m)?;
            entry.set_item("length_sd_m", passage.length_sd_m)?;
            entry.set_item("width_m", passage.width_m)?;
            entry.set_item("via_m", passage.via_m.iter().map(|place| (place.x, place.y)).collect::<Vec<_>>())?;
            passages.append((passage.from, passage.to, entry))?;
        }
        Ok((nodes, passages))
    }

    /// The map as `run --map` writes it.
    fn json(&self, py: Python<'_>) -> String {
        py.detach(|| crosscut::map_json(&self.0))
    }

    /// The map in a line.
    fn summary(&self) -> String {
        self.0.summary()
    }
}
