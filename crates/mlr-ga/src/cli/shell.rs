//! `mlr-ga completions` and `mlr-ga man`.

use std::{io, path::PathBuf};

use anyhow::Context;
use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;

use super::output::{self, ResultFile};

#[derive(Debug, Args)]
pub(super) struct CompletionsOptions {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

#[derive(Debug, Args)]
pub(super) struct ManOptions {
    /// The folder, such as ~/.local/share/man/man1; it is made where there is none. An existing file
    /// is never overwritten.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Prints what a shell reads.
pub(super) fn completions(
    options: &CompletionsOptions,
    mut program: Command,
) -> anyhow::Result<()> {
    let name = program.get_name().to_string();
    let mut script = Vec::new();
    clap_complete::generate(options.shell, &mut program, name, &mut script);
    // Not as a result for people: scripts have tabs.
    Ok(io::Write::write_all(&mut io::stdout().lock(), &script)?)
}

/// Writes a page for the program and for each of its commands.
pub(super) fn man(options: &ManOptions, program: Command) -> anyhow::Result<()> {
    let folder = &options.folder;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let mut program = program.disable_help_subcommand(true);
    program.build();
    let mut pages = Vec::new();
    collect_pages(&program, &mut pages)?;
    let files: Vec<ResultFile> = pages
        .iter()
        .map(|(name, _)| ResultFile::reserve(&folder.join(name)))
        .collect::<anyhow::Result<_>>()?;
    for (file, (_, page)) in files.into_iter().zip(&pages) {
        file.write(page)?;
    }
    Ok(output::result(&format!(
        "{}: {} pages\n",
        folder.display(),
        pages.len()
    ))?)
}

fn collect_pages(command: &Command, pages: &mut Vec<(String, String)>) -> anyhow::Result<()> {
    let man = Man::new(command.clone());
    let mut page = Vec::new();
    man.render(&mut page)?;
    pages.push((man.get_filename(), String::from_utf8(page)?));
    let commands = command.get_subcommands();
    commands
        .filter(|command| !command.is_hide_set())
        .try_for_each(|command| collect_pages(command, pages))
}
