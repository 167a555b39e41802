use std::time::Duration;

use mlr_model::{Fault, LostLinks, Morphology, Payload};
use mlr_recover::{Diagnosis, Outlook, Recovery, Walking};
use serde::Serialize;

/// Version of the JSON form.
const SCHEMA: &str = "mlr.recovery/1";

/// A recovery gait as other programs read it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RecoveryReport {
    /// Name and version of the form.
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// What is left of the robot, most probably.
    pub morphology: Morphology,
    /// Numbers (from 1) of the legs that miss a link.
    pub damaged_legs: Vec<usize>,
    /// Whether lost links are gone or hang on.
    pub lost_links: LostLinks,
    /// What else is wrong.
    pub faults: Vec<Fault>,
    /// What the body carries beyond its description.
    pub payload: Option<Payload>,
    /// How many cases the robots were drawn from.
    pub cases: usize,
    /// Orders in which the legs could swing that were looked at.
    pub orders: usize,
    /// Legs (from 1) that swing together, in their order.
    pub order: Vec<Vec<usize>>,
    /// Legs that are folded.
    pub folded_legs: Vec<usize>,
    /// Whether the centre of mass stays over the feet that stand.
    pub statically_stable: bool,
    /// Least distance of the centre of mass from the edge of the feet that stand.
    pub margin_m: f64,
    /// The same on the way into the gait.
    pub first_steps_margin_m: f64,
    /// Share of the cycle during which a foot stands.
    pub duty_factor: f64,
    /// Duration of a cycle.
    pub period_s: f64,
    /// How far the body moves forward in a cycle.
    pub stride_m: f64,
    /// By how much it turns in a cycle, to walk straight on.
    pub steering_deg: f64,
    /// How high feet are lifted.
    pub lift_m: f64,
    /// Height of the body's origin over the foot tips.
    pub body_height_m: f64,
    /// Where each foot stands in the middle of its stance, body frame.
    pub stance_m: Vec<[f64; 2]>,
    /// When the gait repeats itself, after the way into it.
    pub steady_from_s: f64,
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
        let left = diagnosis.most_probable();
        let plan = &found.plan;
        let walking = plan.walking();
        let folded = (0..plan.stance_m.len()).filter(|leg| !walking.contains(leg));
        let numbers = |legs: &Vec<usize>| legs.iter().map(|leg| leg + 1).collect();
        Self {
            schema: SCHEMA,
            morphology: left.morphology.clone(),
            damaged_legs: left.morphology.damaged_legs(),
            lost_links: left.lost_links,
            faults: left.faults.clone(),
            payload: left.payload,
            cases: diagnosis.cases(),
            orders: found.orders,
            order: plan.order.iter().map(numbers).collect(),
            folded_legs: folded.map(|leg| leg + 1).collect(),
            statically_stable: found.margin_m > 0.0,
            margin_m: found.margin_m,
            first_steps_margin_m: found.first_steps_margin_m,
            duty_factor: plan.duty_factor(),
            period_s: found.gait.period_s,
            stride_m: plan.advance_m,
            steering_deg: plan.turn_rad.to_degrees(),
            lift_m: plan.lift_m,
            body_height_m: plan.body_height_m,
            stance_m: plan.stance_m.clone(),
            steady_from_s: found.gait.steady_from_s(),
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
