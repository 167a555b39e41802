//! Robots, gaits and settings from the files that a person names.

use std::{
    error::Error,
    path::{Path, PathBuf},
};

use mlr_imu::{MAX_TEXT_BYTES, read_text};
use mlr_model::{Gait, JointCommands, Robot};
use mlr_residual::walk::EvidenceSettings;
use thiserror::Error;

use crate::{Configuration, IdentifySettings, Method, checked_toml};

/// What stands for the embedded gait among the names of files.
const TRIPOD: &str = "tripod";

/// Why a robot, a gait or settings cannot be had from files. Its source says what is wrong with them.
#[derive(Debug, Error)]
pub enum ModelFileError {
    /// A file cannot be read, or files do not fit together.
    #[error("{files}")]
    Unusable {
        /// The names of the files.
        files: String,
        /// What is wrong.
        source: Box<dyn Error + Send + Sync>,
    },
    /// More gaits than one, and not one for each log.
    #[error("{gaits} gaits for {logs} logs, expected one --gait for all logs, or one for each")]
    Gaits {
        /// Gaits named.
        gaits: usize,
        /// Logs.
        logs: usize,
    },
}

/// A robot, and the text that describes it.
#[derive(Debug, Clone)]
pub struct DescribedRobot {
    /// The robot.
    pub robot: Robot,
    /// Its description in TOML.
    pub text: String,
    file: Option<PathBuf>,
}

impl DescribedRobot {
    /// The robot that a file describes; the embedded JetHexa where none is named.
    ///
    /// # Errors
    /// [`ModelFileError`] naming the file.
    pub fn read(file: Option<&Path>) -> Result<Self, ModelFileError> {
        let described = |text: &str| Robot::from_toml(text).map(|robot| (robot, text.to_string()));
        let read = load(MAX_TEXT_BYTES, file, described)?;
        let (robot, text) =
            read.unwrap_or_else(|| (Robot::jethexa(), Robot::JETHEXA_TOML.to_string()));
        Ok(Self {
            robot,
            text,
            file: file.map(Path::to_path_buf),
        })
    }

    /// The gait of a file, which the robot can follow from its first step until it repeats or ends; the
    /// embedded tripod where none is named, or `tripod`.
    ///
    /// # Errors
    /// [`ModelFileError`] naming the files.
    pub fn gait(&self, file: Option<&Path>) -> Result<Gait, ModelFileError> {
        let file = file.filter(|file| file.as_os_str() != TRIPOD);
        let gait = load(Gait::MOST_FILE_BYTES, file, Gait::from_toml)?;
        let gait = gait.unwrap_or_else(Gait::tripod);
        match JointCommands::new(&self.robot, &gait, gait.first_pass_s()) {
            Ok(_) => Ok(gait),
            Err(error) => Err(ModelFileError::Unusable {
                files: self.names_with(file),
                source: error.into(),
            }),
        }
    }

    /// The gait of each of so many logs: of one file for all, or of one each in their order.
    ///
    /// # Errors
    /// [`ModelFileError`] naming the files, or when they are neither one nor one each.
    pub fn gaits(&self, files: &[PathBuf], logs: usize) -> Result<Vec<Gait>, ModelFileError> {
        if files.len() > 1 && files.len() != logs {
            return Err(ModelFileError::Gaits {
                gaits: files.len(),
                logs,
            });
        }
        let of = |log: usize| files.get(log).or(files.first()).map(PathBuf::as_path);
        (0..logs).map(|log| self.gait(of(log))).collect()
    }

    /// The names of the files that gait and robot come from.
    fn names_with(&self, gait: Option<&Path>) -> String {
        let files: Vec<String> = [gait, self.file.as_deref()]
            .into_iter()
            .flatten()
            .map(|path| path.display().to_string())
            .collect();
        match files.is_empty() {
            true => "the embedded robot and gait".to_string(),
            false => files.join(" with "),
        }
    }
}

impl Configuration {
    /// All settings, checked, from a file in TOML over the preset of the method; the preset alone where
    /// no file is named.
    ///
    /// # Errors
    /// [`ModelFileError`] naming the file, with a [`ConfigurationError`](crate::ConfigurationError).
    pub fn read(file: Option<&Path>, method: Option<Method>) -> Result<Self, ModelFileError> {
        let read = load(MAX_TEXT_BYTES, file, |text| {
            Self::from_toml_for(text, method)
        })?;
        Ok(read.unwrap_or_else(|| Self {
            identification: IdentifySettings::of(method.unwrap_or_default()),
            ..Self::default()
        }))
    }
}

/// Settings of the explanation, checked, from a file of their own, if one is named.
///
/// # Errors
/// [`ModelFileError`] naming the file.
pub fn explanation_settings(
    file: Option<&Path>,
) -> Result<Option<EvidenceSettings>, ModelFileError> {
    load(MAX_TEXT_BYTES, file, |text| {
        checked_toml(text, EvidenceSettings::check)
    })
}

/// The gait of a file, whatever robot can follow it.
///
/// # Errors
/// [`ModelFileError`] naming the file.
pub fn gait_of_file(file: &Path) -> Result<Gait, ModelFileError> {
    read_file(Gait::MOST_FILE_BYTES, file, Gait::from_toml)
}

/// The robot of a file.
///
/// # Errors
/// [`ModelFileError`] naming the file.
pub fn robot_of_file(file: &Path) -> Result<Robot, ModelFileError> {
    read_file(MAX_TEXT_BYTES, file, Robot::from_toml)
}

/// Reads and parses a file that is no larger than that, if there is one to read.
fn load<T, E>(
    max_bytes: u64,
    file: Option<&Path>,
    parse: impl FnOnce(&str) -> Result<T, E>,
) -> Result<Option<T>, ModelFileError>
where
    E: Error + Send + Sync + 'static,
{
    file.map(|file| read_file(max_bytes, file, parse))
        .transpose()
}

fn read_file<T, E>(
    max_bytes: u64,
    file: &Path,
    parse: impl FnOnce(&str) -> Result<T, E>,
) -> Result<T, ModelFileError>
where
    E: Error + Send + Sync + 'static,
{
    let unusable = |source: Box<dyn Error + Send + Sync>| ModelFileError::Unusable {
        files: file.display().to_string(),
        source,
    };
    let text = read_text(file, max_bytes).map_err(|error| unusable(error.into()))?;
    log::debug!("{}: {} bytes", file.display(), text.len());
    parse(&text).map_err(|error| unusable(error.into()))
}
