//! All that was found out, and what is made of it.

use mlr_filter::SettingError;
use mlr_model::{Gait, Robot};
use thiserror::Error;

use crate::{
    Picture, PictureError,
    answer::{Explanation, Identification},
    page,
    plots::{self, DetectorRun, Footfalls, WalkSignals},
};

/// What was found out about a robot.
#[derive(Debug, Clone)]
pub struct Report<'a> {
    /// The robot as described.
    pub robot: &'a Robot,
    /// Which legs are damaged.
    pub identification: &'a Identification,
    /// The logs that say so; at least one.
    pub walks: Vec<Walk<'a>>,
    /// What else is wrong, where that was asked.
    pub explanation: Option<&'a Explanation>,
    /// When feet stand in the gait that walks again, where there is one.
    pub footfalls: Option<Footfalls>,
    /// What is needed to get all of it again.
    pub manifest: Manifest,
}

/// A log and what can be computed of it at once.
#[derive(Debug, Clone)]
pub struct Walk<'a> {
    /// Where it came from.
    pub log: String,
    /// SHA-256 of its bytes, where they can be read twice.
    pub sha256: Option<String>,
    /// What the robot was commanded.
    pub gait: &'a Gait,
    /// The compared stretch, beside the walk of the best morphology on the model that fits best.
    pub signals: WalkSignals,
    /// Error of that walk after the filter, per sample and axis.
    pub error_deg: f64,
    /// What the damage detector made of it, or why it made nothing.
    pub detector: Result<DetectorRun<'a>, String>,
}

/// What is needed to get a report again.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Manifest {
    /// Name and version of the program, with the commit that it was built of where that is known.
    pub program: String,
    /// Where the identification came from.
    pub identification: String,
    /// The file that describes the robot; none for the embedded one.
    pub robot_file: Option<String>,
}

/// Why there is no report.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A picture cannot be drawn.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The filter of a walk makes no sense.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The page cannot be written.
    #[error(transparent)]
    Template(#[from] askama::Error),
}

/// Every plot of a report.
pub(crate) struct Plots {
    pub(crate) robot: Picture,
    pub(crate) walks: Vec<WalkPlots>,
    pub(crate) course: Option<Picture>,
    pub(crate) residual: Option<Picture>,
    pub(crate) footfalls: Option<Picture>,
}

/// The plots of one log.
pub(crate) struct WalkPlots {
    pub(crate) before: Picture,
    pub(crate) after: Picture,
    pub(crate) spectra: Picture,
    pub(crate) detector: Option<Picture>,
}

impl Report<'_> {
    /// One page in HTML with all of it, which needs no other file and no network.
    ///
    /// # Errors
    /// [`ReportError`] when a plot cannot be drawn.
    pub fn page(&self) -> Result<String, ReportError> {
        Ok(page::page(self, &self.drawn()?)?)
    }

    /// What a page could show and this one does not, in a few words each.
    pub fn not_computed(&self) -> Vec<&'static str> {
        page::missing(self).iter().map(|one| one.what).collect()
    }

    /// The plots one by one.
    ///
    /// # Errors
    /// [`ReportError`] when a plot cannot be drawn.
    pub fn plots(&self) -> Result<Vec<Picture>, ReportError> {
        let drawn = self.drawn()?;
        let mut all = vec![drawn.robot];
        for walk in drawn.walks {
            all.extend([walk.before, walk.after, walk.spectra]);
            all.extend(walk.detector);
        }
        let others = [drawn.course, drawn.residual, drawn.footfalls];
        all.extend(others.into_iter().flatten());
        Ok(all)
    }

    fn drawn(&self) -> Result<Plots, ReportError> {
        let found = self.identification;
        let gait = match self.walks.first() {
            Some(walk) => walk.gait,
            None => &Gait::tripod(),
        };
        let several = self.walks.len() > 1;
        let walks = self.walks.iter().enumerate().map(|(index, walk)| {
            // Plots of several logs are numbered.
            let name = |plot: &str| match several {
                true => format!("{plot}-{}", index + 1),
                false => plot.to_string(),
            };
            let detector = walk.detector.as_ref().ok();
            let detector = detector.map(|run| plots::detector(&name("detector"), run).draw());
            Ok(WalkPlots {
                before: walk.signals.before(&name("signals-before")).draw()?,
                after: walk.signals.after(&name("signals-after")).draw()?,
                spectra: plots::spectra(&name("spectra"), &walk.signals)?.draw()?,
                detector: detector.transpose()?,
            })
        });
        let course = plots::course("course", &found.cost_per_generation);
        let residual = self.explanation.map(|one| plots::residual("residual", one));
        let footfalls = self.footfalls.as_ref();
        Ok(Plots {
            robot: plots::robot_from_above(
                "robot",
                self.robot,
                gait,
                &found.morphology,
                &found.leg_damage_probability,
            )?,
            walks: walks.collect::<Result<_, ReportError>>()?,
            course: course.map(|one| one.draw()).transpose()?,
            residual: residual.map(|one| one.draw()).transpose()?,
            footfalls: footfalls.map(|one| one.draw("footfalls")).transpose()?,
        })
    }
}
