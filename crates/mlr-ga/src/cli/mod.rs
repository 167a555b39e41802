//! The command line.

mod atlas;
mod atlas_files;
mod calibrate;
mod compare;
mod convert;
mod detect;
mod effects_tables;
mod evaluate;
mod evaluate_discrepancy;
mod evaluate_effects;
mod explain;
mod explain_sensor;
mod explain_servo;
mod export;
mod failure;
mod identification;
mod identify;
mod import;
mod kept_results;
mod log_file;
mod markdown;
mod model_files;
mod morphology_choice;
mod motion_files;
mod output;
mod plot;
mod probe;
mod progress;
mod recover;
mod report;
mod resume;
mod robot;
mod robot_drawing;
mod saved_answer;
mod schema;
mod scored;
mod search_options;
mod shell;
mod side_by_side;
mod simulate;
mod steer;

use std::{process::ExitCode, time::Instant};

use clap::{Args, CommandFactory, Parser, Subcommand};
use log::LevelFilter;
use mlr_filter::SettingError;
use mlr_ga::most_threads;

/// Finds out which legs a legged robot has lost, from a log of its body IMU.
#[derive(Debug, Parser)]
#[command(name = "mlr-ga", version = env!("MLR_VERSION"), max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    global: GlobalOptions,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Names the damaged legs of the robot that recorded LOG.
    ///
    /// Several logs of one robot, between which nothing more was damaged, give one answer: every
    /// morphology in question is compared with all of them, and what belongs to the day is fitted
    /// for each.
    ///
    /// By default, the likelihood of what is left between the spectra of measured and simulated
    /// walk, times the prior probability of the damage, decides; the search proposes candidates.
    /// With --method paper, the paper's cost F decides, and nothing else.
    Identify(identify::IdentifyOptions),
    /// Finds when the robot in LOG started to walk and when it was damaged.
    Detect(detect::DetectOptions),
    /// Compares the walk of one morphology with LOG, by the paper's cost F.
    Compare(compare::CompareOptions),
    /// Says how probable it is that an effect which the model lacks made the robot walk as in LOG.
    ///
    /// The evidence of hypotheses decides: morphologies with and without effects, what robots of one
    /// make differ by integrated out. The error is measured on the last third of the walk, which
    /// decides nothing.
    Explain(explain::ExplainOptions),
    /// Traces what a gyroscope's integrated rate misses of a measured angle to effects that its
    /// data sheet lacks.
    ExplainSensor(explain_sensor::ExplainSensorOptions),
    /// Finds what a real servo has that its data sheet lacks: friction, rotor, play, delay.
    ///
    /// The servo of the walking robot's model swings a pendulum on a bench; effects are added to it as
    /// long as their evidence grows.
    ExplainServo(explain_servo::ExplainServoOptions),
    /// Finds the robot's own parameters in walks in which nothing is wrong with it.
    ///
    /// What robots of one make differ by is fitted to the walks, and how surely it is known. Every
    /// other command takes the description that this writes as --robot.
    Calibrate(calibrate::CalibrateOptions),
    /// Finds the motion that tells most: about what logs or an explanation leave open, or with --calibrate about
    /// the parameters of a healthy robot.
    ///
    /// Legs press on the ground, or fold while the others walk; the robot turns on the spot and nods. The motion
    /// keeps its bounds on every robot in question, and has the greatest expected information about what they
    /// differ by.
    Probe(probe::ProbeOptions),
    /// Finds a gait that walks again with what is left of a robot.
    ///
    /// Every order in which the legs can swing is screened for static stability; the most promising
    /// gaits walk in the model, on robots drawn from what is known of this one, and the best is
    /// improved. Nothing is commanded: the gait is written to files.
    Recover(recover::RecoverOptions),
    /// Steers a recovery gait by a log of the robot that walked with it.
    ///
    /// A robot turns by what its joint zeros and its ground make of the gait, which no model knows
    /// beforehand. The same gait is made to turn as far the other way.
    Steer(steer::SteerOptions),
    /// Shows what LOG says of its robot as one page that needs no other file.
    ///
    /// The page has the robot from above, measured and simulated walk, the damage detector, what is
    /// probable, and whatever was computed before: --answer saves the identification, --explanation and
    /// --recovery show what explain and recover found.
    Report(report::ReportOptions),
    /// Writes a log from the model, with any morphology.
    Simulate(simulate::SimulateOptions),
    /// Writes what is left of a robot for its controller or another simulator: URDF, MJCF or JSON.
    ///
    /// Damaged as --morphology, --legs-lost or the answer of identify or explain says, with the
    /// numbers of --robot, calibrated or not.
    Export(export::ExportOptions),
    /// Reads the URDF of a robot into a description, as far as that can hold it.
    ///
    /// What was left out, what had to be assumed, and how far the feet are off is said.
    Import(import::ImportRobotOptions),
    /// Writes LOG in another format: .csv, .csv.gz, or .mcap with sensor_msgs/msg/Imu of ROS 2.
    ///
    /// What the sensor recorded stays as it is: nothing is fused, turned or left out of the time. What
    /// the other format cannot hold is said. Bags of ROS 1 are only read.
    Convert(convert::ConvertOptions),
    /// Checks the description of another robot, and draws it.
    Robot(robot::RobotOptions),
    /// Simulates walks beforehand, for instant answers.
    Atlas(atlas::AtlasOptions),
    /// Scores answers on directories of logs against what was done to the robots.
    Evaluate(evaluate::EvaluateOptions),
    /// Scores explanations on directories of logs against what was done to the robots.
    EvaluateEffects(evaluate_effects::EvaluateEffectsOptions),
    /// Shows what the model leaves of robots that lack nothing.
    EvaluateDiscrepancy(evaluate_discrepancy::EvaluateDiscrepancyOptions),
    /// Prints all keys of --config with their defaults and what they mean, as TOML.
    Config(schema::ConfigOptions),
    /// Prints what completes the arguments of mlr-ga in a shell.
    Completions(shell::CompletionsOptions),
    /// Writes the manual pages of mlr-ga and its commands into a folder.
    Man(shell::ManOptions),
    /// Prints the JSON Schema of what a command prints with --json, of --config, or of what mlrd
    /// prints and reads.
    Schema(schema::SchemaOptions),
}

#[derive(Debug, Args)]
struct GlobalOptions {
    /// Threads to use [default: one per core].
    #[arg(long, global = true, value_name = "N", allow_negative_numbers = true)]
    threads: Option<usize>,
    /// Say nothing on stderr but what went wrong: no progress, notes or warnings. Warnings stay in JSON.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Say on stderr which files are read and how long it takes.
    #[arg(short, long, global = true)]
    verbose: bool,
}

impl GlobalOptions {
    fn level(&self) -> LevelFilter {
        match (self.quiet, self.verbose) {
            (true, _) => LevelFilter::Error,
            (_, true) => LevelFilter::Debug,
            _ => LevelFilter::Info,
        }
    }
}

/// Parses the arguments, runs the command and turns its end into an exit status.
pub(crate) fn run() -> ExitCode {
    let started = Instant::now();
    let cli = Cli::parse();
    output::say_up_to(cli.global.level());
    let status = failure::exit_status(execute(&cli));
    log::debug!("{:.1} s", started.elapsed().as_secs_f64());
    status
}

fn execute(cli: &Cli) -> anyhow::Result<()> {
    output::outlive_file_size_limits()?;
    if let Some(threads) = cli.global.threads {
        let most = most_threads();
        SettingError::check("--threads", threads, 1..=most, "threads on this machine")?;
    }
    // No number, or zero, is one per core.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(cli.global.threads.unwrap_or_default())
        .build()?;
    log::debug!(
        "version {}, {} threads",
        env!("MLR_VERSION"),
        pool.current_num_threads()
    );
    pool.install(|| match &cli.command {
        Command::Identify(options) => identify::run(options),
        Command::Detect(options) => detect::run(options),
        Command::Compare(options) => compare::run(options),
        Command::Explain(options) => explain::run(options),
        Command::ExplainSensor(options) => explain_sensor::run(options),
        Command::ExplainServo(options) => explain_servo::run(options),
        Command::Calibrate(options) => calibrate::run(options),
        Command::Probe(options) => probe::run(options),
        Command::Recover(options) => recover::run(options),
        Command::Steer(options) => steer::run(options),
        Command::Report(options) => report::run(options),
        Command::Simulate(options) => simulate::run(options),
        Command::Export(options) => export::run(options),
        Command::Import(options) => import::run(options),
        Command::Convert(options) => convert::run(options),
        Command::Robot(options) => robot::run(options),
        Command::Atlas(options) => atlas::run(options),
        Command::Evaluate(options) => evaluate::run(options),
        Command::EvaluateEffects(options) => evaluate_effects::run(options),
        Command::EvaluateDiscrepancy(options) => evaluate_discrepancy::run(options),
        Command::Config(options) => schema::print_config(options),
        Command::Completions(options) => shell::completions(options, Cli::command()),
        Command::Man(options) => shell::man(options, Cli::command()),
        Command::Schema(options) => schema::run(options),
    })
}
