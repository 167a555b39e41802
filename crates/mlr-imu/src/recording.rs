use mlr_filter::OrientationSeries;

use crate::RawSeries;

/// What a log or a sensor says about a body's motion: its orientation over time, and the
/// raw samples of the same moments where they are known.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Roll, pitch and yaw, with the time stamps as recorded.
    pub orientation: OrientationSeries,
    /// Accelerations and rates, one for each sample of the orientation.
    pub raw: Option<RawSeries>,
    /// Where the orientation comes from.
    pub source: OrientationSource,
    /// What a person should know about how it was read.
    pub notes: Vec<String>,
}

/// Who made roll, pitch and yaw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrientationSource {
    /// The log holds them: a sensor's own filter, or another program.
    Recorded,
    /// Fused from the raw samples ([`RawSeries::fuse`]).
    Fused,
}

impl Recording {
    /// The raw samples that somebody else made roll, pitch and yaw from; `None` where they
    /// were fused here or are not known.
    pub fn raw_beside_angles(&self) -> Option<&RawSeries> {
        self.raw
            .as_ref()
            .filter(|_| self.source == OrientationSource::Recorded)
    }
}

impl From<OrientationSeries> for Recording {
    fn from(orientation: OrientationSeries) -> Self {
        Self {
            orientation,
            raw: None,
            source: OrientationSource::Recorded,
            notes: Vec::new(),
        }
    }
}
