use mlr_model::{Gait, Motion};

use crate::{
    first_steps::FirstSteps,
    gait_plan::GaitPlan,
    nominal_stance::NominalStance,
    rows::{Joints, NotFollowed},
};

/// A gait with the way into it, from the nominal stance on.
#[derive(Debug, Clone)]
pub(crate) struct WholeGait {
    pub(crate) gait: Gait,
    /// Least static stability margin on the way into it.
    pub(crate) first_steps_margin_m: f64,
}

impl WholeGait {
    /// The gait of a plan.
    ///
    /// # Errors
    /// [`NotFollowed`].
    pub(crate) fn of(
        plan: &GaitPlan,
        joints: Joints<'_>,
        stance: &NominalStance,
    ) -> Result<Self, NotFollowed> {
        let statics = joints.statics(&plan.walking(), plan.body_height_m);
        let first = FirstSteps::into(&statics, plan, &stance.feet_m);
        let trajectory = joints.whole(&stance.angles_rad, plan, &first)?;
        let cycle_s = trajectory.repeat_rows().map_or(1, |rows| rows.len()) as f64;
        Ok(Self {
            gait: Gait {
                name: "recovery".into(),
                period_s: cycle_s * trajectory.row_s(),
                motion: Motion::Joints(trajectory),
            },
            first_steps_margin_m: first.margin_m,
        })
    }
}
