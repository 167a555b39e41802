use mlr_filter::SettingError;
use mlr_model::{Fault, Gait, LostLinks, Morphology, Payload, Robot};
use mlr_recover::{GaitPlan, WhatIsLeft};
use serde::{Deserialize, Serialize};

/// A recovery gait as reports describe it: all that it takes to make it again. Legs are counted from 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReportedGait {
    /// What is left of the robot, most probably.
    pub morphology: Morphology,
    /// Numbers of the legs that miss a link.
    pub damaged_legs: Vec<usize>,
    /// Whether lost links are gone or hang on.
    pub lost_links: LostLinks,
    /// What else is wrong.
    pub faults: Vec<Fault>,
    /// What the body carries beyond its description.
    pub payload: Option<Payload>,
    /// Legs that swing together, in their order.
    pub order: Vec<Vec<usize>>,
    /// Legs that are folded.
    pub folded_legs: Vec<usize>,
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
    /// Where the body is beside its steady path: amplitudes of the cosine and the sine of one and two
    /// cycles, along x and along y.
    pub sway_m: [[f64; 4]; 2],
    /// When the gait repeats itself, after the way into it.
    pub steady_from_s: f64,
}

impl ReportedGait {
    /// The gait of a plan for what is left of a robot.
    pub(super) fn new(left: &WhatIsLeft, plan: &GaitPlan, gait: &Gait) -> Self {
        let walking = plan.walking();
        let folded = (0..plan.stance_m.len()).filter(|leg| !walking.contains(leg));
        let numbers = |legs: &Vec<usize>| legs.iter().map(|leg| leg + 1).collect();
        Self {
            morphology: left.morphology.clone(),
            damaged_legs: left.morphology.damaged_legs(),
            lost_links: left.lost_links,
            faults: left.faults.clone(),
            payload: left.payload,
            order: plan.order.iter().map(numbers).collect(),
            folded_legs: folded.map(|leg| leg + 1).collect(),
            duty_factor: plan.duty_factor(),
            period_s: gait.period_s,
            stride_m: plan.advance_m,
            steering_deg: plan.turn_rad.to_degrees(),
            lift_m: plan.lift_m,
            body_height_m: plan.body_height_m,
            stance_m: plan.stance_m.clone(),
            sway_m: plan.sway_m,
            steady_from_s: gait.steady_from_s(),
        }
    }

    /// What is left of the robot.
    pub fn left(&self) -> WhatIsLeft {
        WhatIsLeft {
            lost_links: self.lost_links,
            faults: self.faults.clone(),
            payload: self.payload,
            ..WhatIsLeft::of(self.morphology.clone())
        }
    }

    /// The plan of the gait.
    pub fn plan(&self) -> GaitPlan {
        let from_zero = |legs: &Vec<usize>| legs.iter().map(|leg| leg.saturating_sub(1)).collect();
        GaitPlan {
            order: self.order.iter().map(from_zero).collect(),
            swing_share: (1.0 - self.duty_factor) * self.order.len() as f64,
            period_s: self.period_s,
            advance_m: self.stride_m,
            turn_rad: self.steering_deg.to_radians(),
            lift_m: self.lift_m,
            body_height_m: self.body_height_m,
            stance_m: self.stance_m.clone(),
            sway_m: self.sway_m,
        }
    }

    /// Checks every number that the gait is made of.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub(super) fn check_on(&self, robot: &Robot) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        let legs = robot.legs().len();
        let mut walking = self.order.concat();
        for (index, leg) in walking.iter().enumerate() {
            SettingError::check(format!("order[{index}]"), *leg, 1..=legs, "")?;
        }
        walking.sort_unstable();
        let different = walking.windows(2).all(|pair| pair[0] != pair[1]);
        if walking.len() < 2 || !different || self.order.iter().any(Vec::is_empty) {
            let found = format!("{:?}", self.order);
            let expected = "groups of legs, at least two legs in all and each of them once";
            return Err(SettingError::new("order", found, expected));
        }
        for fault in &self.faults {
            fault.check()?;
        }
        check("duty_factor", self.duty_factor, 0.0..=1.0, "")?;
        check("period_s", self.period_s, 0.1..=60.0, "s")?;
        check("stride_m", self.stride_m, -1.0..=1.0, "m")?;
        check("steering_deg", self.steering_deg, -180.0..=180.0, "degrees")?;
        check("lift_m", self.lift_m, 0.0..=1.0, "m")?;
        check("body_height_m", self.body_height_m, 0.0..=10.0, "m")?;
        check("steady_from_s", self.steady_from_s, 0.0..=3600.0, "s")?;
        if self.stance_m.len() != legs {
            let expected = format!("{legs} places, one for each leg");
            return Err(SettingError::new("stance_m", self.stance_m.len(), expected));
        }
        SettingError::check_each("stance_m", self.stance_m.as_flattened(), -10.0..=10.0, "m")?;
        SettingError::check_each("sway_m", self.sway_m.as_flattened(), -1.0..=1.0, "m")
    }
}
