use std::path::{Path, PathBuf};

use mlr_imu::NewFile;
use mlr_model::{Gait, Robot};
use serde::{Deserialize, Serialize};

use super::{
    AXES, AtlasError, AtlasPlan, AtlasProblem,
    build::simulate,
    file::{self, AtlasReader, Header},
};
use crate::{IdentifySettings, Progress, Shard};

/// What a part of an atlas holds, and what it is a part of. Everything but `shard` is the same in all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct PartHeader {
    atlas: Header,
    /// The program that made it, to the build.
    build: String,
    /// Walks of the whole atlas.
    walks: usize,
    shard: Shard,
}

impl AsRef<Header> for PartHeader {
    fn as_ref(&self) -> &Header {
        &self.atlas
    }
}

/// Simulates the walks of one part of an atlas and writes them to a new file, from which
/// [`merge`] makes the atlas. Parts of different builds of a program are not merged. Returns the
/// size of the file in bytes.
///
/// # Errors
/// As [`build`](super::build()).
#[expect(
    clippy::too_many_arguments,
    reason = "what an atlas is made of, and the part"
)]
pub fn build_shard(
    path: &Path,
    robot: &Robot,
    gait: &Gait,
    settings: &IdentifySettings,
    plan: AtlasPlan,
    shard: Shard,
    build: &str,
    progress: &dyn Progress,
) -> Result<u64, AtlasError> {
    let write = || {
        let file = NewFile::reserve(path)?;
        let simulated = simulate(robot, gait, settings, plan, shard, progress)?;
        let header = PartHeader {
            atlas: simulated.header,
            build: build.into(),
            walks: simulated.walks,
            shard,
        };
        file.write(|file| file::write(file, file::PART, &header, &simulated.samples))
    };
    write().map_err(|problem| AtlasError {
        path: path.into(),
        problem,
    })
}

/// Makes an atlas of all its parts, in any order: the same bytes as [`build`](super::build())
/// writes. Returns its size in bytes.
///
/// # Errors
/// [`AtlasError`] when a part is missing, there twice, damaged, or of another atlas or program, and
/// when there is a file of that name already.
pub fn merge(parts: &[PathBuf], path: &Path) -> Result<u64, AtlasError> {
    let of = |path: &Path| {
        let path = path.to_path_buf();
        move |problem: AtlasProblem| AtlasError { path, problem }
    };
    let file = NewFile::reserve(path)
        .map_err(AtlasProblem::from)
        .map_err(of(path))?;
    let mut read: Vec<(PartHeader, Vec<i16>)> = Vec::with_capacity(parts.len());
    for part in parts {
        let reader = AtlasReader::<PartHeader>::open_as(part, file::PART).map_err(of(part))?;
        if let Some((first, _)) = read.first() {
            first.check_same(&reader.header).map_err(of(part))?;
        }
        if read
            .iter()
            .any(|(other, _)| other.shard == reader.header.shard)
        {
            return Err(of(part)(AtlasProblem::Twice {
                shard: reader.header.shard,
            }));
        }
        let header = &reader.header;
        let walks = header.shard.share_of(header.walks);
        let samples = walks.saturating_mul(AXES * header.atlas.walk_samples);
        read.push(reader.samples(samples).map_err(of(part))?);
    }
    read.sort_by_key(|(header, _)| header.shard);
    let count = read.first().map_or(1, |(header, _)| header.shard.count());
    let missing =
        Shard::all(count).filter(|shard| read.iter().all(|(header, _)| header.shard != *shard));
    let missing: Vec<String> = missing
        .take(MOST_NAMED)
        .map(|shard| shard.to_string())
        .collect();
    let Some((first, _)) = read.first().filter(|_| missing.is_empty()) else {
        return Err(of(path)(AtlasProblem::Missing {
            shards: missing.join(", "),
        }));
    };
    let length = AXES * first.atlas.walk_samples;
    let mut samples = Vec::with_capacity(first.walks * length);
    let mut walks: Vec<_> = read
        .iter()
        .map(|(_, samples)| samples.chunks(length))
        .collect();
    for walk in 0..first.walks {
        samples.extend(walks[walk % count].next().into_iter().flatten());
    }
    file.write(|file| file::write(file, file::ATLAS, &first.atlas, &samples))
        .map_err(of(path))
}

/// Missing parts that are named, at most.
const MOST_NAMED: usize = 20;

impl PartHeader {
    /// Names the first thing that another part does not share.
    fn check_same(&self, other: &Self) -> Result<(), AtlasProblem> {
        let count = |part: &Self| part.shard.count().to_string();
        for (what, own, others) in [
            (
                "build of the program",
                self.build.clone(),
                other.build.clone(),
            ),
            ("number of parts", count(self), count(other)),
            (
                "number of walks",
                self.walks.to_string(),
                other.walks.to_string(),
            ),
        ] {
            if own != others {
                return Err(AtlasProblem::OtherPart {
                    what,
                    first: own,
                    this: others,
                });
            }
        }
        self.atlas.check_same(&other.atlas)
    }
}
