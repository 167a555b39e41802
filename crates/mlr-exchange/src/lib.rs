//! Robots in the formats of other programs.
//!
//! [`ExportedRobot`] writes what is left of a damaged robot as URDF, MJCF or JSON, for the
//! controllers and simulators of others; [`import_urdf`] reads the URDF of a healthy robot into a
//! description that every other part of mlr takes, as far as that can hold it, and says what it
//! could not.
//!
//! Angles, frames and names are those of [`mlr_model`]: joints are called as the columns of joint
//! trajectories (`leg1_coxa`), and a joint at angle 0 is where the controller commands it to 0.

mod export;
mod import;
mod xml;

pub use export::{ExportedJson, ExportedRobot, Format};
pub use import::{ImportError, ImportOptions, Imported, JointMap, MOST_URDF_BYTES, import_urdf};
