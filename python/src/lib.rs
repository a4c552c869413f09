//! The native half of the Python package `crosscut`; `python/crosscut` is the other half and what users see.
//!
//! Stages run without the interpreter's lock. Only a stage written in Python takes it, for its call alone.

mod answer;
mod arrays;
mod columns;
mod engine;
mod error;
mod flight_map;
mod frames;
mod navigator;
mod odometry;
mod program;
mod recording;
mod scan;
mod stages;
mod testing;

use pyo3::pymodule;

#[pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::engine::Engine;
    #[pymodule_export]
    use crate::flight_map::FlightMap;
    #[pymodule_export]
    use crate::navigator::Navigator;
    #[pymodule_export]
    use crate::odometry::Odometry;
    #[pymodule_export]
    use crate::program::program;
    #[pymodule_export]
    use crate::recording::Recording;
    #[pymodule_export]
    use crate::scan::Scan;
    #[pymodule_export]
    use crate::testing::check_affinity;

    #[pymodule_init]
    fn add_version(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
