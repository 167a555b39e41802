use std::{
    fs::File,
    io::{self, BufRead as _, BufReader, Read, Write},
    num::NonZeroUsize,
    path::Path,
};

use crc::{CRC_64_XZ, Crc, Digest};
use mlr_model::{Gait, LostLinks, ModelError, Morphology, Robot, Variation};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use thiserror::Error;

use super::{AtlasPlan, all_lost_links};
use crate::{IdentifySettings, Shard, comparison::ComparableWalk, walks::Case};

/// Why an atlas cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AtlasProblem {
    /// It cannot be read or written.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// It is no atlas.
    #[error("is no atlas")]
    NoAtlas,
    /// It is a part of an atlas, or the other way round.
    #[error("is {found}, expected {expected}; `mlr-ga atlas merge` makes an atlas of its parts")]
    OtherKind {
        /// What it is.
        found: &'static str,
        /// What it should be.
        expected: &'static str,
    },
    /// It has another version of the format.
    #[error("has version {found} of the file format, expected {VERSION}; build it anew")]
    OtherFormat {
        /// The version found.
        found: u32,
    },
    /// The header cannot be read.
    #[error("its header is damaged: {0}")]
    Header(#[from] serde_json::Error),
    /// It ends early, or has more than its header says.
    #[error("is truncated; build it anew")]
    Truncated,
    /// Bytes changed since it was written.
    #[error("its check sum is wrong, the file is damaged; build it anew")]
    Damaged,
    /// It was made for another robot, gait, settings or program.
    #[error("is stale: made for another {what} ({then}, now {now}); build it anew")]
    Stale {
        /// What has changed.
        what: &'static str,
        /// What it was made for.
        then: String,
        /// What is asked for.
        now: String,
    },
    /// A part of an atlas that has nothing to do with the first one.
    #[error("is a part of another atlas: its {what} is {this}, that of the first part {first}")]
    OtherPart {
        /// What differs.
        what: &'static str,
        /// What the first part has.
        first: String,
        /// What this one has.
        this: String,
    },
    /// A part was named twice.
    #[error("part {shard} was named before, expected each part once")]
    Twice {
        /// Which one.
        shard: Shard,
    },
    /// Not all parts are there.
    #[error("parts are missing: {shards}")]
    Missing {
        /// Some of them.
        shards: String,
    },
    /// The physics engine gives another walk than when the atlas was made.
    #[error("is stale: this program's simulation walks otherwise; build it anew")]
    OtherEngine,
    /// Robot, gait and settings do not fit together.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// How an atlas begins.
pub(super) const ATLAS: &[u8; 8] = b"MLRATLAS";
/// How a part of one begins.
pub(super) const PART: &[u8; 8] = b"MLRATPRT";
const VERSION: u32 = 1;
const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);
const CRC_LENGTH: usize = 8;
/// Magic, version and length of the header.
const SIZE_BEFORE_HEADER: usize = ATLAS.len() + 4 + 4;
/// Upper bound of a header's length.
const MAX_HEADER_BYTES: u32 = 10_000_000;
/// Upper bound of a walk's length: an hour.
const MAX_WALK_SAMPLES: usize = 100_000;
/// The offset of the samples is a multiple of this.
const ALIGNMENT: usize = 64;
/// What one count of a sample is worth.
pub(super) const SAMPLE_DEG: f32 = 0.01;

/// What an error calls the gait.
pub(super) const GAIT: &str = "gait";

/// What an atlas holds, and what it was made for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    program: String,
    robot: Described,
    gait: Described,
    simulation: Described,
    variations: Vec<Variation>,
    /// Morphologies with more damaged legs are not in it; without a number all are.
    #[serde(default)]
    pub(super) most_damaged_legs: Option<NonZeroUsize>,
    /// Morphologies with at most so many damaged legs are in it under variations.
    few_legs: usize,
    pub(super) walk_samples: usize,
}

/// Something by its name and a digest of all that it says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Described {
    name: String,
    digest: String,
}

impl Described {
    fn new(name: &str, all: &impl std::fmt::Debug) -> Self {
        Self {
            name: name.into(),
            digest: format!("{:016x}", CRC.checksum(format!("{all:?}").as_bytes())),
        }
    }

    fn check(&self, what: &'static str, now: &Self) -> Result<(), AtlasProblem> {
        if self == now {
            return Ok(());
        }
        let spell = |described: &Self| format!("{:?} {}", described.name, described.digest);
        Err(AtlasProblem::Stale {
            what,
            then: spell(self),
            now: spell(now),
        })
    }
}

impl Header {
    pub(super) fn new(
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
        plan: AtlasPlan,
    ) -> Self {
        Self {
            program: env!("CARGO_PKG_VERSION").into(),
            robot: Described::new(robot.name(), robot),
            gait: Described::new(&gait.name, gait),
            simulation: Described::new("simulation", &settings.simulation),
            variations: settings.variations.clone(),
            most_damaged_legs: plan.most_damaged_legs,
            few_legs: plan.few_legs,
            walk_samples: (plan.duration_s * ComparableWalk::RATE_HZ).round() as usize,
        }
    }

    /// Whether the walks of this morphology under this variation are in it.
    pub(super) fn holds(&self, morphology: &Morphology, variation: usize) -> bool {
        let damaged = morphology.damaged_legs().len();
        self.most_damaged_legs
            .is_none_or(|most| damaged <= most.get())
            && (variation == 0 || damaged <= self.few_legs)
    }

    /// The cases in the order in which their walks follow each other.
    pub(super) fn cases(&self) -> Vec<Case> {
        let case = |variation| {
            move |lost_links: LostLinks| Case {
                lost_links,
                variation,
            }
        };
        (0..self.variations.len())
            .flat_map(|variation| all_lost_links().map(case(variation)))
            .collect()
    }

    /// Refuses the header of a part that was made for something else.
    pub(super) fn check_same(&self, other: &Self) -> Result<(), AtlasProblem> {
        let described = |of: &Described| format!("{:?} {}", of.name, of.digest);
        let plan = |of: &Self| {
            let (most, few) = (of.most_damaged_legs, of.few_legs);
            format!(
                "{most:?} damaged legs at most, {few} under variations, {} samples",
                of.walk_samples
            )
        };
        for (what, own, others) in [
            (
                "version of the program",
                self.program.clone(),
                other.program.clone(),
            ),
            ("robot", described(&self.robot), described(&other.robot)),
            (GAIT, described(&self.gait), described(&other.gait)),
            (
                "simulation setting",
                described(&self.simulation),
                described(&other.simulation),
            ),
            (
                "list of variations",
                format!("{:?}", self.variations),
                format!("{:?}", other.variations),
            ),
            ("plan", plan(self), plan(other)),
        ] {
            if own != others {
                return Err(AtlasProblem::OtherPart {
                    what,
                    first: own,
                    this: others,
                });
            }
        }
        Ok(())
    }

    /// Names the first thing that has changed since the atlas was made.
    pub(super) fn check(
        &self,
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
    ) -> Result<(), AtlasProblem> {
        let now = Self::new(robot, gait, settings, AtlasPlan::default());
        if self.program != now.program {
            return Err(AtlasProblem::Stale {
                what: "version of the program",
                then: self.program.clone(),
                now: now.program,
            });
        }
        self.robot.check("robot", &now.robot)?;
        self.gait.check(GAIT, &now.gait)?;
        self.simulation
            .check("simulation setting", &now.simulation)?;
        // Settings with fewer variations use the first ones.
        if !self.variations.starts_with(&now.variations) {
            return Err(AtlasProblem::Stale {
                what: "list of variations",
                then: format!("{} of them", self.variations.len()),
                now: format!("{} others", now.variations.len()),
            });
        }
        Ok(())
    }
}

impl AsRef<Self> for Header {
    fn as_ref(&self) -> &Self {
        self
    }
}

/// An atlas, or a part of one, whose header has been read and whose samples have not.
pub(super) struct AtlasReader<H = Header> {
    pub(super) header: H,
    file: BufReader<File>,
    /// The check sum of what was read.
    digest: Digest<'static, u64>,
}

impl AtlasReader {
    /// Reads the header. What is no atlas is refused after its first bytes.
    pub(super) fn open(path: &Path) -> Result<Self, AtlasProblem> {
        Self::open_as(path, ATLAS)
    }
}

impl<H: DeserializeOwned + AsRef<Header>> AtlasReader<H> {
    /// Reads the header of a file that begins so.
    pub(super) fn open_as(path: &Path, kind: &[u8; 8]) -> Result<Self, AtlasProblem> {
        let mut file = BufReader::new(File::open(path)?);
        let mut digest = CRC.digest();
        let mut magic = [0; ATLAS.len()];
        match file.read_exact(&mut magic) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                return Err(AtlasProblem::NoAtlas);
            }
            result => result?,
        }
        if &magic != kind {
            return Err(match &magic {
                ATLAS | PART => AtlasProblem::OtherKind {
                    found: name_of(&magic),
                    expected: name_of(kind),
                },
                _ => AtlasProblem::NoAtlas,
            });
        }
        digest.update(&magic);
        let found = u32::from_le_bytes(next(&mut file, &mut digest)?);
        if found != VERSION {
            return Err(AtlasProblem::OtherFormat { found });
        }
        let length = u32::from_le_bytes(next(&mut file, &mut digest)?);
        if length > MAX_HEADER_BYTES {
            return Err(AtlasProblem::Damaged);
        }
        let length = length as usize;
        let mut text = vec![0; samples_begin(length) - SIZE_BEFORE_HEADER];
        file.read_exact(&mut text).map_err(truncated)?;
        digest.update(&text);
        let header: H = serde_json::from_slice(text.get(..length).unwrap_or_default())?;
        let walk_samples = header.as_ref().walk_samples;
        if walk_samples == 0 || walk_samples > MAX_WALK_SAMPLES {
            return Err(AtlasProblem::Damaged);
        }
        Ok(Self {
            header,
            file,
            digest,
        })
    }

    /// Reads the samples, which must be so many, and nothing behind them but their check sum.
    pub(super) fn samples(mut self, count: usize) -> Result<(H, Vec<i16>), AtlasProblem> {
        // Memory is taken as samples come, not as a header promises them.
        let mut samples = Vec::new();
        let mut chunk = [0; 1 << 16];
        while samples.len() < count {
            let bytes = (2 * (count - samples.len())).min(chunk.len());
            let Some(chunk) = chunk.get_mut(..bytes) else {
                break;
            };
            self.file.read_exact(chunk).map_err(truncated)?;
            self.digest.update(chunk);
            let (pairs, _) = chunk.as_chunks::<2>();
            samples.extend(pairs.iter().map(|bytes| i16::from_le_bytes(*bytes)));
        }
        let mut crc = [0; CRC_LENGTH];
        self.file.read_exact(&mut crc).map_err(truncated)?;
        if self.digest.finalize() != u64::from_le_bytes(crc) {
            return Err(AtlasProblem::Damaged);
        }
        if !self.file.fill_buf()?.is_empty() {
            return Err(AtlasProblem::Truncated);
        }
        Ok((self.header, samples))
    }
}

fn name_of(kind: &[u8; 8]) -> &'static str {
    match kind {
        PART => "a part of an atlas",
        _ => "an atlas",
    }
}

fn next(file: &mut impl Read, digest: &mut Digest<'_, u64>) -> Result<[u8; 4], AtlasProblem> {
    let mut bytes = [0; 4];
    file.read_exact(&mut bytes).map_err(truncated)?;
    digest.update(&bytes);
    Ok(bytes)
}

fn truncated(error: io::Error) -> AtlasProblem {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => AtlasProblem::Truncated,
        _ => AtlasProblem::Io(error),
    }
}

pub(super) fn write(
    file: &mut impl Write,
    kind: &[u8; 8],
    header: &impl Serialize,
    samples: &[i16],
) -> Result<(), AtlasProblem> {
    let header = serde_json::to_vec(header)?;
    let length = u32::try_from(header.len()).map_err(io::Error::other)?;
    let mut bytes = Vec::with_capacity(samples_begin(header.len()) + 2 * samples.len());
    bytes.extend(kind);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(length.to_le_bytes());
    bytes.extend(&header);
    bytes.resize(samples_begin(header.len()), 0);
    for sample in samples {
        bytes.extend(sample.to_le_bytes());
    }
    let crc = CRC.checksum(&bytes);
    file.write_all(&bytes)?;
    file.write_all(&crc.to_le_bytes())?;
    Ok(())
}

fn samples_begin(header_length: usize) -> usize {
    (SIZE_BEFORE_HEADER + header_length).next_multiple_of(ALIGNMENT)
}
