//! Results of an evaluation that are kept: to go on after an interruption, and to share the logs among
//! several computers.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use mlr_ga::Shard;
use serde::{Serialize, de::DeserializeOwned};

use super::{
    output,
    resume::{Finished, LogIdentity, ResumeFile, RunIdentity},
};

/// Where results are kept, and which logs are answered here.
#[derive(Debug, Args)]
pub(super) struct KeptResults {
    /// Keep the result of each finished log in this file (JSON lines), and take from it what an
    /// earlier run of the same program with the same settings finished.
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// Answer part K of N of the logs only, for --merge: on as many computers as there are. The results
    /// are kept in the file of --resume.
    #[arg(long, value_name = "K/N", requires = "resume")]
    shard: Option<Shard>,
    /// Answer nothing, and take the results of all logs from the files that the parts were kept in.
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["resume", "shard"])]
    merge: Vec<PathBuf>,
}

/// A log that is to be answered.
pub(super) trait Job {
    /// `None` where the log cannot be read: it is left to the answer to say so.
    fn identity(&self) -> Option<LogIdentity>;
    /// For people.
    fn name(&self) -> String;
}

/// An index of a job that is to be done, and what its result is kept as.
pub(super) type Open = (usize, Option<LogIdentity>);

impl KeptResults {
    /// Whether results are read or written, so that it matters which run they are of.
    pub(super) fn are_wanted(&self) -> bool {
        self.resume.is_some() || !self.merge.is_empty()
    }

    /// The result of each job in their order, taken from a file or found by `answer`, which `each` calls
    /// for the open ones; nothing where only a part of them was done.
    ///
    /// # Errors
    /// When files are of another run, or lack the result of a log that is not to be answered here.
    pub(super) fn of_all<J, R, E>(
        &self,
        jobs: &[J],
        run: Option<&RunIdentity>,
        each: E,
        answer: impl Fn(&J) -> anyhow::Result<R> + Sync,
    ) -> anyhow::Result<Option<Vec<R>>>
    where
        J: Job + Sync,
        R: Clone + Send + Sync + Serialize + DeserializeOwned,
        E: FnOnce(
            &[Open],
            &(dyn Fn(&Open) -> anyhow::Result<(usize, R)> + Sync),
        ) -> anyhow::Result<Vec<(usize, R)>>,
    {
        let resume = match (&self.resume, run) {
            (Some(path), Some(run)) => Some(ResumeFile::<R>::open(path, run)?),
            _ => None,
        };
        let merged = match run {
            Some(run) if !self.merge.is_empty() => Some(Finished::<R>::read(&self.merge, run)?),
            _ => None,
        };
        let known = merged
            .as_ref()
            .or(resume.as_ref().map(ResumeFile::finished));
        let (mut done, mut open) = (Vec::new(), Vec::new());
        let own = |index: &usize| self.shard.is_none_or(|shard| shard.has(*index));
        for (index, job) in jobs.iter().enumerate().filter(|(index, _)| own(index)) {
            let identity = known.and_then(|_| job.identity());
            let result = match (known, &identity) {
                (Some(known), Some(identity)) => known.result(identity)?,
                _ => None,
            };
            match result {
                Some(result) => done.push((index, result.clone())),
                None => open.push((index, identity)),
            }
        }
        if merged.is_some() {
            self.refuse_missing(jobs, &open)?;
        }
        let found = each(&open, &|(index, identity): &Open| {
            let result = answer(&jobs[*index])?;
            // As it is read from a file: numbers may change in their last digit. A run of one part
            // must print what the merged parts of others do.
            let result: R = serde_json::from_str(&serde_json::to_string(&result)?)?;
            if let (Some(resume), Some(identity)) = (&resume, identity) {
                resume.append(identity, &result)?;
            }
            Ok((*index, result))
        })?;
        done.extend(found);
        done.sort_by_key(|(index, _)| *index);
        if let (Some(shard), Some(path)) = (self.shard, &self.resume) {
            let mut table = output::Table::default();
            table.line("part", shard);
            table.line("logs", format!("{} of {}", done.len(), jobs.len()));
            table.line("results", path.display());
            output::result(&table.into_text())?;
            return Ok(None);
        }
        Ok(Some(done.into_iter().map(|(_, result)| result).collect()))
    }

    /// Parts that were merged must have the result of every log.
    fn refuse_missing<J: Job>(&self, jobs: &[J], open: &[Open]) -> anyhow::Result<()> {
        let Some((first, _)) = open.first() else {
            return Ok(());
        };
        let parts = self.merge.iter().map(|path| path.display().to_string());
        bail!(
            "{}: no result of {} of {} logs, such as {}: expected the files of all parts, each finished",
            parts.collect::<Vec<_>>().join(", "),
            open.len(),
            jobs.len(),
            jobs[*first].name()
        );
    }
}
