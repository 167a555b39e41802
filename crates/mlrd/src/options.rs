use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{
    CommandFactory, Parser, ValueEnum,
    builder::{NonEmptyStringValueParser, PossibleValuesParser, TypedValueParser},
};
use clap_complete::Shell;
use clap_mangen::Man;
use mlr_ga::{IdentifySettings, Method, documented_toml};
use mlr_imu::{MAX_TEXT_BYTES, read_text};

use crate::{CommandLine, FramingName, Settings};

/// Reads an IMU, notices when the robot is damaged, and identifies the damage.
#[derive(Debug, Clone, Parser)]
#[command(name = "mlrd", version = env!("MLR_VERSION"), max_term_width = 100)]
pub struct Options {
    /// Serial port of the IMU, as in /dev/ttyTHS1.
    #[arg(long, value_name = "DEVICE", conflicts_with_all = ["i2c", "stdin"],
          value_parser = NonEmptyStringValueParser::new())]
    port: Option<String>,
    /// I²C bus of an MPU6050, as in /dev/i2c-1, instead of a port.
    #[arg(long, value_name = "BUS", conflicts_with = "stdin")]
    i2c: Option<PathBuf>,
    /// Samples that another program hands on, instead of a port: lines of CSV below a line with
    /// the names of the columns, as in a log, or JSON objects with these names. Its end is the
    /// daemon's.
    #[arg(long)]
    stdin: bool,
    /// Speed of the port [default: 115200].
    #[arg(long, value_name = "BAUD", allow_negative_numbers = true)]
    baud: Option<u32>,
    /// Framing of the bytes [default: auto].
    #[arg(long, value_enum)]
    format: Option<FramingName>,
    /// All settings, in TOML; options override it.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Print the manual page, or what completes the options in a shell, and end.
    #[arg(long, value_name = "WHAT", exclusive = true)]
    generate: Option<Generated>,
    /// Print all settings with what they mean, as a file for --config, and end: the defaults, with
    /// what --config and other options say in their place.
    #[arg(long)]
    print_config: bool,
    /// Where to remember the last identification and the sensor's calibration.
    #[arg(long, value_name = "DIR")]
    state_dir: Option<PathBuf>,
    /// Record what the sensor says into this directory, bounded in size.
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
    /// Walks simulated beforehand by `mlr-ga atlas build`, for instant answers.
    #[arg(long, value_name = "FILE")]
    atlas: Option<PathBuf>,
    /// Robot description in TOML [default: the embedded JetHexa].
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Gait in TOML [default: the embedded tripod].
    #[arg(long, value_name = "FILE")]
    gait: Option<PathBuf>,
    /// Threads for identifications, explanations and recovery gaits [default: all cores but one].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    threads: Option<usize>,
    /// What decides which legs are damaged: mlr, or the paper's method as published, which needs
    /// no atlas and explains nothing [default: mlr].
    #[arg(long, value_parser = PossibleValuesParser::new(["mlr", "paper"]).try_map(|name| name.parse::<Method>()))]
    method: Option<Method>,
    /// Seed of the genetic algorithm [default: 1].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Do not explain walks that were identified.
    #[arg(long)]
    no_explain: bool,
    /// Do not offer a recovery gait for damage that was identified.
    #[arg(long)]
    no_recover: bool,
    /// Do not learn the robot's own parameters from healthy walks.
    #[arg(long)]
    no_learn: bool,
}

/// What is made of the description of the options.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Generated {
    /// The manual page.
    Man,
    /// The manual page of `mlrd check`.
    ManCheck,
    /// The manual page of `mlrd top`.
    #[cfg(feature = "top")]
    ManTop,
    /// Completions for Bash.
    CompleteBash,
    /// Completions for Zsh.
    CompleteZsh,
    /// Completions for fish.
    CompleteFish,
}

impl Generated {
    fn text(self) -> anyhow::Result<String> {
        let mut options = CommandLine::command();
        let mut text = Vec::new();
        let mut complete =
            |shell, options| clap_complete::generate(shell, options, "mlrd", &mut text);
        match self {
            Self::CompleteBash => complete(Shell::Bash, &mut options),
            Self::CompleteZsh => complete(Shell::Zsh, &mut options),
            Self::CompleteFish => complete(Shell::Fish, &mut options),
            Self::Man => Man::new(options.disable_help_subcommand(true)).render(&mut text)?,
            Self::ManCheck => manual(options, "check")?.render(&mut text)?,
            #[cfg(feature = "top")]
            Self::ManTop => manual(options, "top")?.render(&mut text)?,
        }
        Ok(String::from_utf8(text)?)
    }
}

/// The manual page of a command.
fn manual(mut program: clap::Command, name: &str) -> anyhow::Result<Man> {
    program.build();
    let command = program.find_subcommand(name);
    let command = command.with_context(|| format!("no command {name}"))?;
    let full_name = format!("mlrd-{name}");
    Ok(Man::new(command.clone().version(env!("MLR_VERSION"))).title(full_name))
}

/// What each setting means: the doc comments of the types.
const CONFIG_SCHEMA: &str = include_str!("../../../docs/schemas/mlrd-config.schema.json");

impl Options {
    /// What is to be printed in place of everything else, if anything is.
    ///
    /// # Errors
    /// As [`Options::settings`].
    pub fn printed(&self) -> anyhow::Result<Option<String>> {
        match self.generate {
            Some(what) => Ok(Some(what.text()?)),
            None if self.print_config => Ok(Some(self.documented_settings()?)),
            None => Ok(None),
        }
    }

    /// All settings with what they mean, as a file for `--config`.
    fn documented_settings(&self) -> anyhow::Result<String> {
        let schema = serde_json::from_str(CONFIG_SCHEMA).context("the embedded schema")?;
        let settings = documented_toml(&self.settings()?, &schema)?;
        Ok(format!(
            "# Settings of mlrd, as in /etc/mlrd.toml. A file needs only those that differ from \
             their defaults.\n\n{settings}"
        ))
    }

    /// The configuration file's settings, or the defaults, with these options in
    /// their place.
    ///
    /// # Errors
    /// Names the file, the line and the key, or the option, and what was expected.
    pub fn settings(&self) -> anyhow::Result<Settings> {
        self.in_place_of(self.of_the_file()?)
    }

    /// The configuration file, if one is named.
    pub(crate) fn config(&self) -> Option<&Path> {
        self.config.as_deref()
    }

    /// The configuration file's settings, or the defaults.
    pub(crate) fn of_the_file(&self) -> anyhow::Result<Settings> {
        let Some(path) = &self.config else {
            return Ok(Settings {
                identification: IdentifySettings::of(self.method.unwrap_or_default()),
                ..Settings::default()
            });
        };
        let name = || path.display().to_string();
        let text = read_text(path, MAX_TEXT_BYTES).with_context(name)?;
        Settings::checked_from_toml(&text, self.method).with_context(name)
    }

    /// These settings with the options in their place.
    pub(crate) fn in_place_of(&self, mut settings: Settings) -> anyhow::Result<Settings> {
        // A source on the command line replaces the file's, of whichever kind.
        if self.port.is_some() || self.i2c.is_some() || self.stdin {
            settings.stdin = self.stdin;
            settings.port.clone_from(&self.port);
            settings.i2c.clone_from(&self.i2c);
        }
        let Self {
            baud,
            format,
            threads,
            seed,
            no_explain,
            no_recover,
            no_learn,
            ..
        } = *self;
        settings.baud = baud.unwrap_or(settings.baud);
        settings.format = format.unwrap_or(settings.format);
        settings.seed = seed.unwrap_or(settings.seed);
        settings.threads = threads.or(settings.threads);
        settings.explain &= !no_explain;
        settings.recover &= !no_recover;
        settings.learn &= !no_learn;
        for (option, setting) in [
            (&self.state_dir, &mut settings.state_dir),
            (&self.atlas, &mut settings.atlas),
            (&self.record, &mut settings.record.dir),
            (&self.robot, &mut settings.robot),
            (&self.gait, &mut settings.gait),
        ] {
            if option.is_some() {
                setting.clone_from(option);
            }
        }
        // The file was checked: what is wrong now was typed.
        let checked = settings.check().map_err(|error| {
            error.as_option(&[
                ("baud", "--baud"),
                ("threads", "--threads"),
                ("seed", "--seed"),
            ])
        });
        checked?;
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_method_brings_its_preset_and_no_explanations() {
        let settings = |more: &[&str]| {
            let arguments = ["mlrd", "--port", "/dev/ttyTHS1"].iter().chain(more);
            Options::parse_from(arguments).settings().unwrap()
        };
        let paper = settings(&["--method", "paper"]);
        assert_eq!(paper.identification, IdentifySettings::of(Method::Paper));
        assert!(!paper.explains() && paper.learning().is_none());
        assert!(settings(&["--method", "mlr"]).explains());
    }

    #[test]
    fn explanations_and_learning_are_switched_off_by_name() {
        let settings = |more: &[&str]| {
            let arguments = ["mlrd", "--port", "/dev/ttyTHS1"].iter().chain(more);
            Options::parse_from(arguments).settings().unwrap()
        };
        assert!(settings(&[]).explain);
        assert!(!settings(&["--no-explain"]).explain);
        // Without a directory there is nowhere to write a gait to.
        assert_eq!(settings(&[]).recovery_dir(), None);
        let kept = settings(&["--state-dir", "kept"]);
        assert_eq!(kept.recovery_dir(), Some(Path::new("kept")));
        let off = settings(&["--state-dir", "kept", "--no-recover"]);
        assert_eq!(off.recovery_dir(), None);
        assert!(settings(&["--no-explain"]).learning().is_some());
        assert!(settings(&["--no-learn"]).learning().is_none());
        assert!(settings(&["--no-learn"]).explain);
    }

    /// What is said of these arguments, by the parser or by the settings.
    fn refused(arguments: &[&str]) -> String {
        let arguments = ["mlrd"].iter().chain(arguments);
        match Options::try_parse_from(arguments) {
            Ok(options) => format!("{:#}", options.settings().unwrap_err()),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn options_that_make_no_sense_are_named() {
        for (option, value) in [
            ("--baud", "0"),
            ("--baud", "-1"),
            ("--baud", "4000000000"),
            ("--threads", "0"),
            ("--threads", "-2"),
            ("--threads", "10000"),
            ("--seed", "-1"),
            ("--seed", "18446744073709551615"),
            ("--port", ""),
            ("--i2c", ""),
            ("--config", ""),
            ("--state-dir", ""),
            ("--record", ""),
            ("--atlas", ""),
            ("--robot", ""),
            ("--gait", ""),
        ] {
            let message = refused(&[option, value]);
            assert!(message.contains(option), "{option} {value}: {message}");
        }
        let message = refused(&["--baud", "0"]);
        assert_eq!(
            message,
            "--baud: 0 is not valid, expected 1200 to 12000000 baud"
        );
    }

    #[test]
    fn a_bad_value_in_the_file_is_the_files() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mlrd.toml");
        std::fs::write(&path, "# robot 7\nbaud = 0\n").unwrap();
        let message = refused(&["--config", path.to_str().unwrap()]);
        assert!(
            message.contains("mlrd.toml: line 2: baud: 0 is not valid"),
            "{message}"
        );
    }
}
