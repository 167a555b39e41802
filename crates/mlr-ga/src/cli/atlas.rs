//! `mlr-ga atlas build`.

use std::{num::NonZeroUsize, path::PathBuf, time::Instant};

use clap::{Args, Subcommand};
use mlr_ga::atlas;

use super::{
    model_files::{self, ModelFiles},
    output,
    progress::Bar,
};

#[derive(Debug, Args)]
pub(super) struct AtlasOptions {
    #[command(subcommand)]
    command: AtlasCommand,
}

#[derive(Debug, Subcommand)]
enum AtlasCommand {
    /// Simulates the walks of every feasible morphology, and under variations of the model those of
    /// the ones with few damaged legs.
    Build(BuildOptions),
}

#[derive(Debug, Args)]
struct BuildOptions {
    /// The file to write. An existing file is never overwritten.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// All settings, in TOML, as the atlas's user will have them.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Leave out morphologies with more damaged legs: a smaller atlas, built sooner. An answer from
    /// it never names more damaged legs, and warns of that [default: every morphology].
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = clap::value_parser!(u16).range(1..))]
    most_damaged_legs: Option<u16>,
    #[command(flatten)]
    model: ModelFiles,
}

pub(super) fn run(options: &AtlasOptions) -> anyhow::Result<()> {
    let AtlasCommand::Build(options) = &options.command;
    let started = Instant::now();
    let settings = model_files::configuration(options.config.as_deref(), None)?.identification;
    let (robot, gait) = options.model.read()?;
    settings.check_on(&robot)?;
    output::refuse_stdout(&options.output)?;
    let most_damaged_legs = options.most_damaged_legs.map(usize::from);
    let plan = atlas::AtlasPlan {
        most_damaged_legs: most_damaged_legs.and_then(NonZeroUsize::new),
        ..atlas::AtlasPlan::default()
    };
    let bar = Bar::new();
    let built = atlas::build(&options.output, &robot, &gait, &settings, plan, &bar);
    bar.clear();
    let mut table = output::Table::default();
    table.line("atlas", options.output.display());
    table.line("robot", robot.name());
    table.line("gait", &gait.name);
    table.line("size", format!("{:.1} MB", built? as f64 / 1e6));
    table.line("time", format!("{:.0} s", started.elapsed().as_secs_f64()));
    Ok(output::result(&table.into_text())?)
}
