//! The functions behind the Python package `mlr`, which gives them types, defaults and documentation
//! (`python/mlr/`).
//!
//! Each takes what the package made of a caller's arguments, computes on threads of its own without the
//! interpreter (`running`), and returns the JSON object that `mlr-ga … --json` prints. What goes
//! wrong is said in the words of the command line (`failure`).

mod arguments;
mod calibration;
mod detection;
mod explanation;
mod failure;
mod identification;
mod logs;
mod running;
mod simulation;

use pyo3::pymodule;

#[pymodule]
mod _mlr {
    #[pymodule_export]
    use super::calibration::calibrate;
    #[pymodule_export]
    use super::detection::detect;
    #[pymodule_export]
    use super::explanation::explain;
    #[pymodule_export]
    use super::identification::identify;
    #[pymodule_export]
    use super::logs::read_log;
    #[pymodule_export]
    use super::simulation::simulate;

    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
