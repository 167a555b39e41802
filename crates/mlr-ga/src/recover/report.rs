use std::time::Duration;

use mlr_recover::{Diagnosis, Outlook, Recovery, Walking};
use serde::Serialize;

use super::ReportedGait;

/// Version of the JSON form.
pub(super) const SCHEMA: &str = "mlr.recovery/1";

/// A recovery gait as other programs read it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RecoveryReport {
    /// Name and version of the form.
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// The gait, and what it is for.
    #[serde(flatten)]
    pub gait: ReportedGait,
    /// How many cases the robots were drawn from.
    pub cases: usize,
    /// Orders in which the legs could swing that were looked at.
    pub orders: usize,
    /// Whether the centre of mass stays over the feet that stand.
    pub statically_stable: bool,
    /// Least distance of the centre of mass from the edge of the feet that stand.
    pub margin_m: f64,
    /// The same on the way into the gait.
    pub first_steps_margin_m: f64,
    /// Robots that it was judged on.
    pub robots: usize,
    /// How they walk with the nominal gait.
    pub before: ReportedOutlook,
    /// How they walk with this one.
    pub after: ReportedOutlook,
    /// Largest fluctuation of roll or pitch of any of them, the way into the gait included.
    pub first_steps_fluctuation_deg: f64,
    /// Whether this gait can be counted on for more speed than the nominal one.
    pub better_than_nominal: bool,
    /// Seed of the search.
    pub seed: u64,
    /// Time that it took.
    pub elapsed_s: f64,
}

/// How robots walk: means, and the worst.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReportedOutlook {
    /// Means over the robots; of drifts, that of their size.
    #[serde(flatten)]
    pub mean: Walking,
    /// Largest fluctuation of any robot.
    pub worst_fluctuation_deg: f64,
    /// Robots whose simulation diverged.
    pub diverged: usize,
    /// Probability that the fluctuation stays below the detector's threshold.
    pub calm_probability: f64,
    /// The speed that can be counted on: what gaits are chosen by.
    pub reliable_speed_m_per_s: f64,
}

impl RecoveryReport {
    /// The report of a recovery.
    pub fn new(diagnosis: &Diagnosis, found: &Recovery, seed: u64, elapsed: Duration) -> Self {
        Self {
            schema: SCHEMA,
            gait: ReportedGait::new(diagnosis.most_probable(), &found.plan, &found.gait),
            cases: diagnosis.cases(),
            orders: found.orders,
            statically_stable: found.margin_m > 0.0,
            margin_m: found.margin_m,
            first_steps_margin_m: found.first_steps_margin_m,
            robots: found.after.walks.len(),
            before: ReportedOutlook::new(&found.before),
            after: ReportedOutlook::new(&found.after),
            first_steps_fluctuation_deg: found.first_steps_fluctuation_deg,
            better_than_nominal: found.after.reliable_speed_m_per_s
                > found.before.reliable_speed_m_per_s,
            seed,
            elapsed_s: elapsed.as_secs_f64(),
        }
    }
}

impl ReportedOutlook {
    fn new(outlook: &Outlook) -> Self {
        let walks: Vec<Walking> = outlook.walks.iter().flatten().copied().collect();
        let worst = walks.iter().map(|one| one.fluctuation_deg);
        Self {
            mean: Walking::mean(&walks),
            worst_fluctuation_deg: worst.fold(0.0, f64::max),
            diverged: outlook.walks.len() - walks.len(),
            calm_probability: outlook.calm_probability,
            reliable_speed_m_per_s: outlook.reliable_speed_m_per_s,
        }
    }
}
