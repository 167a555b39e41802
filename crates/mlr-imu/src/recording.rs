use mlr_filter::{OrientationSeries, TimeStampFaults, increasing_times};

use crate::{Columns, RawSeries};

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
    /// Where its columns were found, for advice on how to read them otherwise.
    pub columns: Columns,
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
    /// Drops samples whose time stamps are duplicated or run backwards, and says how many.
    pub fn with_increasing_times(mut self) -> (Self, TimeStampFaults) {
        let (kept, faults) = increasing_times(self.orientation.times_s());
        if faults.dropped() > 0 {
            self.orientation = self.orientation.picked(&kept);
            self.raw = self.raw.map(|raw| raw.picked(&kept));
        }
        (self, faults)
    }

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
            columns: Columns::default(),
            notes: Vec::new(),
        }
    }
}
