//! The native half of the Python package `crosscut`; `python/crosscut` is the other half and what users see.
//!
//! Stages run without the interpreter's lock. Only a stage written in Python takes it, for its call alone.

mod answer;
mod arrays;
mod engine;
mod error;
mod flight;
mod kept;
mod map;
mod navigator;
mod odometry;
mod program;
#[cfg(feature = "rerun")]
mod recorder;
mod recording;
mod robots;
mod scan;
mod sparse;
mod stages;
mod testing;
mod values;

use pyo3::pymodule;

#[pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::engine::Engine;
    #[pymodule_export]
    use crate::flight::Flight;
    #[pymodule_export]
    use crate::kept::Kept;
    #[pymodule_export]
    use crate::map::Map;
    #[pymodule_export]
    use crate::navigator::Navigator;
    #[pymodule_export]
    use crate::odometry::Odometry;
    #[pymodule_export]
    use crate::program::program;
    #[cfg(feature = "rerun")]
    #[pymodule_export]
    use crate::recorder::Recorder;
    #[pymodule_export]
    use crate::recording::Recording;
    #[pymodule_export]
    use crate::robots::Feed;
    #[pymodule_export]
    use crate::scan::Scan;
    #[pymodule_export]
    use crate::testing::check_affinity;

    #[pymodule_init]
    fn add_version(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
