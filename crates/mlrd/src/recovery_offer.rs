//! A gait that walks again, offered after damage is known.

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use mlr_ga::{NoRecovery, RecoveryOf, RecoveryReport, recovery_gait};
use mlr_imu::NewFile;
use mlr_model::{ModelError, Motion, Robot};
use mlr_recover::{Diagnosis, RecoverSettings};
use mlr_residual::walk::EvidenceSettings;
use thiserror::Error;

use crate::robot_model::RobotModel;

/// A gait to be found.
#[derive(Debug)]
pub struct RecoverJob {
    /// What may be left of the robot.
    pub diagnosis: Diagnosis,
    /// The robot as it is known.
    pub robot: Arc<Robot>,
}

/// A gait that was found.
#[derive(Debug)]
pub struct RecoveryOffer {
    /// As `mlr-ga recover` reports it.
    pub report: RecoveryReport,
    gait: String,
    joints: String,
}

/// Why there is none.
#[derive(Debug, Error)]
pub enum NoOffer {
    /// None was found.
    #[error(transparent)]
    NoRecovery(#[from] NoRecovery),
    /// It has no form as a file.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// Offers that are kept.
const KEPT: u32 = 4;
/// Names of their files, with a number and what comes after it.
const NAME: &str = "recovery-";
const GAIT: &str = ".toml";
const JOINTS: &str = ".csv";

impl RecoverJob {
    /// Searches the gait.
    ///
    /// # Errors
    /// [`NoOffer`].
    pub(crate) fn done(
        &self,
        known: &RobotModel,
        explanation: &EvidenceSettings,
        settings: &RecoverSettings,
    ) -> Result<RecoveryOffer, NoOffer> {
        let begin = Instant::now();
        let (robot, seed) = (&self.robot, known.identification.seed);
        let of = RecoveryOf {
            robot,
            gait: &known.gait,
            diagnosis: &self.diagnosis,
            simulation: &known.identification.simulation,
            nuisance: &explanation.nuisance,
            detector: known.identification.detector,
        };
        let found = recovery_gait(of, settings, seed, &())?;
        let joints = match &found.gait.motion {
            Motion::Joints(joints) => joints.to_csv(robot)?,
            Motion::Feet(_) => String::new(),
        };
        Ok(RecoveryOffer {
            report: RecoveryReport::new(&self.diagnosis, &found, seed, begin.elapsed()),
            gait: found.gait.to_toml(),
            joints,
        })
    }
}

impl RecoveryOffer {
    /// Writes gait and joint angles into new files, and removes all but the last few offers. Returns
    /// the paths of both.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, dir: &Path) -> io::Result<[PathBuf; 2]> {
        let numbers = numbers(dir)?;
        let next = numbers.iter().max().map_or(1, |last| last + 1);
        let path = |number: u32, ending: &str| dir.join(format!("{NAME}{number}{ending}"));
        let paths = [path(next, GAIT), path(next, JOINTS)];
        for (path, text) in paths.iter().zip([&self.gait, &self.joints]) {
            let file = NewFile::reserve(path)?;
            file.write(|file| io::Write::write_all(file, text.as_bytes()))?;
        }
        for old in numbers.into_iter().filter(|number| number + KEPT <= next) {
            for ending in [GAIT, JOINTS] {
                match fs::remove_file(path(old, ending)) {
                    Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                    _ => {}
                }
            }
        }
        Ok(paths)
    }
}

/// Numbers of the offers in a directory.
fn numbers(dir: &Path) -> io::Result<Vec<u32>> {
    let mut numbers = Vec::new();
    for entry in fs::read_dir(dir)? {
        let name = entry?.file_name();
        let number = name.to_str().and_then(|name| {
            let number = name.strip_prefix(NAME)?;
            let number = number.strip_suffix(GAIT).or(number.strip_suffix(JOINTS))?;
            number.parse::<u32>().ok()
        });
        numbers.extend(number);
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use mlr_ga::diagnosis_of_json;

    use super::*;
    use crate::Settings;

    #[test]
    fn the_last_offers_are_kept_and_none_is_overwritten() {
        let settings = Settings::default();
        let known = RobotModel::new(&settings, "imu".into()).unwrap();
        let lost = r#"{"schema": "mlr.identification/1",
            "morphology": [[1,1,1],[1,1,1],[0,0,0],[0,0,0],[1,1,1],[1,1,1]]}"#;
        let job = RecoverJob {
            diagnosis: diagnosis_of_json(&known.robot, lost).unwrap(),
            robot: Arc::clone(&known.robot),
        };
        let little = RecoverSettings {
            screen_steps: 1,
            robots: 1,
            judged_robots: 1,
            generations: 0,
            ..RecoverSettings::default()
        };
        let offer = job.done(&known, &settings.explanation, &little).unwrap();
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("state.json"), "mine").unwrap();
        for number in 1..=6 {
            let [gait, joints] = offer.write(dir.path()).unwrap();
            assert_eq!(gait, dir.path().join(format!("recovery-{number}.toml")));
            assert_eq!(fs::read_to_string(gait).unwrap(), offer.gait);
            assert_eq!(fs::read_to_string(joints).unwrap(), offer.joints);
        }
        let mut left = numbers(dir.path()).unwrap();
        left.sort_unstable();
        assert_eq!(left, [3, 3, 4, 4, 5, 5, 6, 6]);
        assert!(dir.path().join("state.json").exists());
    }
}
