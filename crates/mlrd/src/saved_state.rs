//! What the daemon remembers beyond its end.

use std::{
    fs,
    io::{self, Write},
    marker::PhantomData,
    path::{Path, PathBuf},
    time::SystemTime,
};

use mlr_ga::Identification;
use mlr_imu::{MAX_TEXT_BYTES, read_text};
use mlr_model::Morphology;
use mlr_residual::walk::Sensing;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

/// What is kept in a file of its own in the state directory, as JSON.
pub trait Kept: Default + Serialize + DeserializeOwned {
    /// Name of the file.
    const NAME: &'static str;
}

impl Kept for SavedState {
    const NAME: &'static str = "state.json";
}

/// Where something is kept.
#[derive(Debug, Clone)]
pub struct StateFile<T = SavedState> {
    path: PathBuf,
    kept: PhantomData<T>,
}

/// What the name of a file that cannot be read gets at its end.
const SET_ASIDE: &str = ".unreadable";

impl<T: Kept> StateFile<T> {
    /// The file in this directory, which is made if need be.
    ///
    /// # Errors
    /// When the directory cannot be made.
    pub fn new(dir: &Path) -> io::Result<Self> {
        fs::create_dir_all(dir)?;
        Ok(Self::at(dir))
    }

    /// The file in this directory, which may be missing.
    pub fn at(dir: &Path) -> Self {
        Self {
            path: dir.join(T::NAME),
            kept: PhantomData,
        }
    }

    /// What was kept; nothing if there is no file. A file that is not this
    /// program's, or of another version, is set aside under another name: the
    /// second value tells.
    ///
    /// # Errors
    /// When the file cannot be read, or not be set aside.
    pub fn load(&self) -> io::Result<(T, Option<String>)> {
        match self.read()? {
            Ok(kept) => Ok((kept, None)),
            Err(broken) => Ok((T::default(), Some(self.set_aside(&broken)?))),
        }
    }

    /// What was kept, or what is wrong with the file; nothing if there is no file.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn read(&self) -> io::Result<Result<T, String>> {
        match read_text(&self.path, MAX_TEXT_BYTES) {
            Ok(text) => Ok(serde_json::from_str(&text).map_err(|error| error.to_string())),
            Err(error) => match error.kind() {
                io::ErrorKind::NotFound => Ok(Ok(T::default())),
                io::ErrorKind::FileTooLarge | io::ErrorKind::InvalidData => {
                    Ok(Err(error.to_string()))
                }
                _ => Err(error),
            },
        }
    }

    /// Renames the file, of which this is wrong; returns what is to be told about it.
    ///
    /// # Errors
    /// When it cannot be renamed.
    pub fn set_aside(&self, wrong: &str) -> io::Result<String> {
        let aside = self.path.with_file_name(T::NAME.to_owned() + SET_ASIDE);
        fs::rename(&self.path, &aside)?;
        Ok(format!(
            "{}: {wrong}; kept as {}",
            self.path.display(),
            aside.display()
        ))
    }

    /// Keeps it. Whenever power fails, the file holds what was kept before or this.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn save(&self, kept: &T) -> io::Result<()> {
        let mut text = serde_json::to_vec_pretty(kept)?;
        text.push(b'\n');
        replace(&self.path, &text)
    }
}

/// Gives a file other contents. Whenever power fails, it has the old ones or these.
///
/// # Errors
/// When it cannot be written.
pub fn replace(path: &Path, contents: &[u8]) -> io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(contents)?;
    file.as_file().sync_all()?;
    file.persist(path)?;
    // The new name must survive as well.
    fs::File::open(folder)?.sync_all()
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
        let file = StateFile::<SavedState>::new(&folder.path().join("deep/er")).unwrap();
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
        let file = StateFile::<SavedState>::new(folder.path()).unwrap();
        let text = r#"{
            "schema": "mlr.state/1",
            "last_known": null,
            "gyroscope_bias_radps": [0.01, -0.02, 0.03]
        }"#;
        fs::write(folder.path().join(SavedState::NAME), text).unwrap();
        let (state, notice) = file.load().unwrap();
        assert_eq!(notice, None);
        assert_eq!(state.gyroscope_bias_radps, known().gyroscope_bias_radps);
        assert_eq!(state.sensing, None);
    }

    #[test]
    fn a_damaged_file_is_set_aside_and_told() {
        let folder = tempfile::tempdir().unwrap();
        let file = StateFile::<SavedState>::new(folder.path()).unwrap();
        let endless = vec![b' '; MAX_TEXT_BYTES as usize + 1];
        let texts: [&[u8]; 4] = [
            b"{\"schema\": \"mlr.st",
            b"{\"schema\": \"mlr.state/9\"}",
            b"\xff\xfe",
            &endless,
        ];
        for text in texts {
            fs::write(folder.path().join(SavedState::NAME), text).unwrap();
            let (state, notice) = file.load().unwrap();
            assert_eq!(state, SavedState::default());
            assert!(notice.unwrap().contains(SavedState::NAME));
            assert_eq!(
                fs::read(folder.path().join("state.json.unreadable")).unwrap(),
                text
            );
        }
    }
}
