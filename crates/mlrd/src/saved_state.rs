//! What the daemon remembers beyond its end.

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
    time::SystemTime,
};

use mlr_ga::Identification;
use mlr_imu::{MAX_TEXT_BYTES, read_text};
use mlr_model::Morphology;
use mlr_residual::walk::Sensing;
use serde::{Deserialize, Serialize};

/// The last identification and what is known of the sensor, as JSON in one file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SavedState {
    /// Version of the file.
    schema: Schema,
    /// The last known morphology.
    pub last_known: Option<KnownMorphology>,
    /// Bias of the gyroscope when the sensor last stood still, x, y, z of the body.
    pub gyroscope_bias_radps: Option<[f64; 3]>,
    /// What explanations found of the sensor, on top of that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensing: Option<Sensing>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
enum Schema {
    #[default]
    #[serde(rename = "mlr.state/1")]
    First,
}

/// A morphology, and since when it is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KnownMorphology {
    /// When it was identified, RFC 3339.
    pub time: String,
    /// What is left of the robot.
    pub morphology: Morphology,
    /// Numbers of the legs that miss a link.
    pub damaged_legs: Vec<usize>,
    /// The damage in words.
    pub description: String,
}

impl KnownMorphology {
    /// The morphology of an identification made at `time`.
    pub fn new(time: SystemTime, identification: &Identification) -> Self {
        Self {
            time: humantime::format_rfc3339_millis(time).to_string(),
            morphology: identification.morphology.clone(),
            damaged_legs: identification.damaged_legs.clone(),
            description: identification.description.clone(),
        }
    }
}

/// Where the state is kept.
#[derive(Debug, Clone)]
pub struct StateFile {
    path: PathBuf,
}

/// Name of the file in the state directory.
const NAME: &str = "state.json";
/// What a file that cannot be read is renamed to.
const SET_ASIDE: &str = "state.json.unreadable";

impl StateFile {
    /// The file in this directory, which is made if need be.
    ///
    /// # Errors
    /// When the directory cannot be made.
    pub fn new(dir: &Path) -> io::Result<Self> {
        fs::create_dir_all(dir)?;
        Ok(Self {
            path: dir.join(NAME),
        })
    }

    /// What was kept; nothing if there is no file. A file that is not this
    /// program's, or of another version, is set aside under another name: the
    /// second value tells.
    ///
    /// # Errors
    /// When the file cannot be read, or not be set aside.
    pub fn load(&self) -> io::Result<(SavedState, Option<String>)> {
        let read = read_text(&self.path, MAX_TEXT_BYTES);
        let broken = match read {
            Ok(text) => match serde_json::from_str(&text) {
                Ok(state) => return Ok((state, None)),
                Err(error) => error.to_string(),
            },
            Err(error) => match error.kind() {
                io::ErrorKind::NotFound => return Ok((SavedState::default(), None)),
                io::ErrorKind::FileTooLarge | io::ErrorKind::InvalidData => error.to_string(),
                _ => return Err(error),
            },
        };
        let aside = self.path.with_file_name(SET_ASIDE);
        fs::rename(&self.path, &aside)?;
        let notice = format!(
            "{}: {broken}; kept as {}",
            self.path.display(),
            aside.display()
        );
        Ok((SavedState::default(), Some(notice)))
    }

    /// Keeps the state. Whenever power fails, the file holds the old state or the
    /// new one.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn save(&self, state: &SavedState) -> io::Result<()> {
        let folder = self.path.parent().unwrap_or(Path::new("."));
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        serde_json::to_writer_pretty(&mut file, state)?;
        file.write_all(b"\n")?;
        file.as_file().sync_all()?;
        file.persist(&self.path)?;
        // The new name must survive as well.
        fs::File::open(folder)?.sync_all()
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::Robot;

    use super::*;

    fn known() -> SavedState {
        SavedState {
            last_known: Some(KnownMorphology {
                time: "2026-01-01T00:00:00.000Z".into(),
                morphology: Morphology::parse(&"110".repeat(6), &Robot::jethexa().layout())
                    .unwrap(),
                damaged_legs: vec![1, 2, 3, 4, 5, 6],
                description: "all".into(),
            }),
            gyroscope_bias_radps: Some([0.01, -0.02, 0.03]),
            sensing: Some(Sensing {
                misalignment_deg: [1.5, -0.5, 0.0],
                scale: 1.02,
                ..Sensing::default()
            }),
            ..SavedState::default()
        }
    }

    #[test]
    fn what_is_saved_is_loaded() {
        let folder = tempfile::tempdir().unwrap();
        let file = StateFile::new(&folder.path().join("deep/er")).unwrap();
        assert_eq!(file.load().unwrap(), (SavedState::default(), None));
        file.save(&known()).unwrap();
        file.save(&known()).unwrap();
        assert_eq!(file.load().unwrap(), (known(), None));
        let files = fs::read_dir(folder.path().join("deep/er")).unwrap().count();
        assert_eq!(files, 1, "nothing else is left behind");
    }

    #[test]
    fn a_file_from_before_explanations_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = StateFile::new(folder.path()).unwrap();
        let text = r#"{
            "schema": "mlr.state/1",
            "last_known": null,
            "gyroscope_bias_radps": [0.01, -0.02, 0.03]
        }"#;
        fs::write(folder.path().join(NAME), text).unwrap();
        let (state, notice) = file.load().unwrap();
        assert_eq!(notice, None);
        assert_eq!(state.gyroscope_bias_radps, known().gyroscope_bias_radps);
        assert_eq!(state.sensing, None);
    }

    #[test]
    fn a_damaged_file_is_set_aside_and_told() {
        let folder = tempfile::tempdir().unwrap();
        let file = StateFile::new(folder.path()).unwrap();
        let endless = vec![b' '; MAX_TEXT_BYTES as usize + 1];
        let texts: [&[u8]; 4] = [
            b"{\"schema\": \"mlr.st",
            b"{\"schema\": \"mlr.state/9\"}",
            b"\xff\xfe",
            &endless,
        ];
        for text in texts {
            fs::write(folder.path().join(NAME), text).unwrap();
            let (state, notice) = file.load().unwrap();
            assert_eq!(state, SavedState::default());
            assert!(notice.unwrap().contains(NAME));
            assert_eq!(fs::read(folder.path().join(SET_ASIDE)).unwrap(), text);
        }
    }
}
