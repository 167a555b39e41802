//! Robots drawn from what is known of one.

use mlr_model::{Morphology, standard_normal};
use nalgebra::DVector;
use rand::Rng;

use super::{
    Nuisance, NuisancePrior, NuisanceSettings, WalkError, WalkModel, WalkRecord,
    information::level_record,
};

impl WalkModel {
    /// A robot like this one, drawn from what robots of its make with these links differ by, or from
    /// what its calibration has left open, on any day.
    ///
    /// # Errors
    /// [`WalkError`] where a setting makes no sense.
    pub fn drawn(
        &self,
        morphology: &Morphology,
        settings: &NuisanceSettings,
        generator: &mut impl Rng,
    ) -> Result<Self, WalkError> {
        settings.check()?;
        let record = level_record(WalkRecord::LONGEST_WALK_S)?;
        let nuisances = Nuisance::of(morphology, &record);
        let prior = NuisancePrior::new(settings, self);
        let z = DVector::from_fn(nuisances.len(), |_, _| standard_normal(generator));
        let deviations = match prior.mixing(&nuisances, &record) {
            Some(mixing) => mixing * z,
            None => z,
        };
        let mut model = self.clone();
        for (nuisance, deviation) in nuisances.iter().zip(&deviations) {
            nuisance.apply(settings, *deviation, &record, &mut model);
        }
        Ok(model)
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::{Fault, Gait, Robot, SimulationSettings};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn drawn_robots_spread_as_their_make_does() {
        let robot = Robot::jethexa();
        let legs_lost = Morphology::parse_legs_lost("3", &robot.layout()).unwrap();
        let settings = NuisanceSettings::default();
        let simulation = SimulationSettings::default();
        let nominal = WalkModel::of_make(robot, Gait::tripod(), simulation, &settings);
        let mut generator = ChaCha8Rng::seed_from_u64(3);
        let drawn: Vec<WalkModel> = (0..400)
            .map(|_| {
                nominal
                    .drawn(&legs_lost, &settings, &mut generator)
                    .unwrap()
            })
            .collect();
        let deviation = |of: &dyn Fn(&WalkModel) -> f64| {
            let squares = drawn.iter().map(|model| of(model) * of(model));
            (squares.sum::<f64>() / drawn.len() as f64).sqrt()
        };
        let stiffness = deviation(&|model| {
            (model.servo.stiffness_nm_per_rad / nominal.servo.stiffness_nm_per_rad).ln()
        });
        assert!((stiffness / settings.ln_stiffness - 1.0).abs() < 0.12);
        let play =
            deviation(&|model| (model.servo.drive.backlash_rad / settings.backlash_rad).ln());
        assert!((play / settings.ln_backlash - 1.0).abs() < 0.12);
        let forward = deviation(&|model| model.robot.body().center_of_mass_m.x);
        assert!((forward / settings.center_of_mass_m - 1.0).abs() < 0.12);
        // A zero for every joint that is there, and none for those that are lost.
        for model in &drawn {
            let zeros = model.simulation.faults.iter();
            let legs: Vec<usize> = zeros
                .map(|fault| match fault {
                    Fault::JointOffset { leg, .. } => *leg,
                    other => panic!("{other:?}"),
                })
                .collect();
            assert_eq!(legs.len(), 15);
            assert!(!legs.contains(&3));
        }
    }

    #[test]
    fn play_is_that_of_the_make_where_the_description_has_none() {
        let settings = NuisanceSettings::default();
        let play_rad = |described_rad: f64| {
            let mut servo = *Robot::jethexa().servo();
            servo.drive.backlash_rad = described_rad;
            let robot = Robot::jethexa().with_servo(servo).unwrap();
            let simulation = SimulationSettings::default();
            let model = WalkModel::of_make(robot, Gait::tripod(), simulation, &settings);
            model.servo.drive.backlash_rad
        };
        assert_eq!(play_rad(0.0), settings.backlash_rad);
        assert_eq!(play_rad(0.012), 0.012);
    }
}
