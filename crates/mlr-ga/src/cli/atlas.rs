//! `mlr-ga atlas build` and `mlr-ga atlas merge`.

use std::{num::NonZeroUsize, path::PathBuf, time::Instant};

use clap::{Args, Subcommand};
use mlr_ga::{Configuration, Shard, atlas};

use super::{model_files::ModelFiles, output, progress::Bar, resume::this_build};

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
    /// Makes one atlas of all the parts that `atlas build --shard` wrote: the same file as without.
    Merge(MergeOptions),
}

#[derive(Debug, Args)]
struct MergeOptions {
    /// All parts, in any order.
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// The atlas to write. An existing file is never overwritten.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
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
    /// Simulate part K of N only, for `atlas merge`: on as many computers as there are.
    #[arg(long, value_name = "K/N")]
    shard: Option<Shard>,
    #[command(flatten)]
    model: ModelFiles,
}

pub(super) fn run(options: &AtlasOptions) -> anyhow::Result<()> {
    match &options.command {
        AtlasCommand::Build(options) => build(options),
        AtlasCommand::Merge(options) => merge(options),
    }
}

fn merge(options: &MergeOptions) -> anyhow::Result<()> {
    output::refuse_stdout(&options.output)?;
    let size = atlas::merge(&options.parts, &options.output)?;
    let mut table = output::Table::default();
    table.line("atlas", options.output.display());
    table.line("parts", options.parts.len());
    table.line("size", format!("{:.1} MB", size as f64 / 1e6));
    Ok(output::result(&table.into_text())?)
}

fn build(options: &BuildOptions) -> anyhow::Result<()> {
    let started = Instant::now();
    let settings = Configuration::read(options.config.as_deref(), None)?.identification;
    let (robot, gait) = options.model.read()?;
    settings.check_on(&robot)?;
    output::refuse_stdout(&options.output)?;
    let most_damaged_legs = options.most_damaged_legs.map(usize::from);
    let plan = atlas::AtlasPlan {
        most_damaged_legs: most_damaged_legs.and_then(NonZeroUsize::new),
        ..atlas::AtlasPlan::default()
    };
    let bar = Bar::new();
    let path = &options.output;
    let built = match options.shard {
        None => atlas::build(path, &robot, &gait, &settings, plan, &bar),
        Some(shard) => {
            let program = this_build();
            atlas::build_shard(path, &robot, &gait, &settings, plan, shard, &program, &bar)
        }
    };
    bar.clear();
    let mut table = output::Table::default();
    match options.shard {
        None => table.line("atlas", path.display()),
        Some(shard) => table.line("atlas", format!("{}, part {shard}", path.display())),
    }
    table.line("robot", robot.name());
    table.line("gait", &gait.name);
    table.line("size", format!("{:.1} MB", built? as f64 / 1e6));
    table.line("time", format!("{:.0} s", started.elapsed().as_secs_f64()));
    Ok(output::result(&table.into_text())?)
}
