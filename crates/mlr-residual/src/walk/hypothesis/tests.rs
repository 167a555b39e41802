use mlr_model::{Calibration, Gait, Gaussian, Robot, RobotParameter, SimulationSettings};

use super::*;
use crate::walk::{Discrepancy, NuisanceSettings, record::tests::level_record};
use crate::walk_effects::find;

/// What `of` makes of a whole robot that stands for a second, walks for three, and may have
/// these effects.
fn with_walker<T>(effects: &[(&str, Place)], of: impl Fn(&Walker<'_>) -> T) -> T {
    of_robot(Robot::jethexa(), effects, of)
}

/// The same of another robot.
fn of_robot<T>(robot: Robot, effects: &[(&str, Place)], of: impl Fn(&Walker<'_>) -> T) -> T {
    let morphology = Morphology::healthy(&robot.layout());
    let nominal = WalkModel::nominal(robot, Gait::tripod(), SimulationSettings::default());
    let record = level_record();
    let discrepancy = Discrepancy::default();
    let observation = Observation::new(&record, &discrepancy, nominal.gait.period_s);
    let prior = NuisancePrior::new(&NuisanceSettings::default(), &nominal);
    let hypothesis = Hypothesis {
        morphology,
        lost_links: LostLinks::Absent,
        effects: placed(effects),
    };
    of(&Walker::new(hypothesis, &observation, &prior, &nominal))
}

fn placed(effects: &[(&str, Place)]) -> Vec<Placement> {
    let placement = |(kind, place): &(&str, Place)| Placement {
        effect: find(kind).unwrap(),
        place: *place,
    };
    effects.iter().map(placement).collect()
}

/// The robot of a walker, with these effects.
fn of_same<'a>(walker: &Walker<'a>, effects: &[(&str, Place)]) -> Walker<'a> {
    let hypothesis = Hypothesis {
        effects: placed(effects),
        ..walker.hypothesis.clone()
    };
    Walker::new(
        hypothesis,
        walker.observation,
        walker.prior,
        &walker.nominal,
    )
}

fn at_rest(walker: &Walker<'_>) -> Walked {
    walker.walk(DVector::zeros(walker.dimension())).unwrap()
}

#[test]
fn what_is_known_of_a_robot_mixes_its_coordinates() {
    let robot = Robot::jethexa();
    let own = [
        RobotParameter::ImuMounting(0),
        RobotParameter::ServoStiffness,
        RobotParameter::JointZero { leg: 0, joint: 1 },
    ];
    let covariance = DMatrix::from_row_slice(
        3,
        3,
        &[0.25, 0.02, 3e-3, 0.02, 0.01, -2e-4, 3e-3, -2e-4, 1.44e-4],
    );
    let physical = Gaussian {
        mean: DVector::zeros(3),
        covariance: covariance.clone(),
    };
    let calibration = Calibration::new(&robot, own.to_vec(), covariance.clone(), physical);
    let robot = robot.with_calibration(calibration.unwrap());
    let tilted = [("imu_misalignment", Place::Robot)];
    of_robot(robot, &[], |bare| {
        let nuisances = Nuisance::of(&bare.hypothesis.morphology, bare.observation.record);
        let units = NuisanceSettings::default();
        let deviation = |nuisance: &Nuisance| nuisance.deviation(&units, bare.observation.record);
        // The covariance of deviations is the calibration's, and one where nothing is known.
        let mixing = bare.mixing();
        let mixed = &mixing * mixing.transpose();
        for (i, one) in nuisances.iter().enumerate() {
            for (j, other) in nuisances.iter().enumerate() {
                let row = |n: &Nuisance| own.iter().position(|p| Some(*p) == n.parameter());
                let expected = match (row(one), row(other)) {
                    (Some(a), Some(b)) => covariance[(a, b)] / (deviation(one) * deviation(other)),
                    _ => f64::from(u8::from(i == j)),
                };
                let day = one.day_deviation(&units) / deviation(one);
                let expected = expected + f64::from(u8::from(i == j)) * day * day;
                assert!(
                    (mixed[(i, j)] - expected).abs() < 1e-9,
                    "{} {}",
                    one.name(),
                    other.name()
                );
            }
        }
        // Sensitivities are those that differences of whole coordinates have, and unmixing
        // undoes mixing.
        let at = bare.walk(DVector::zeros(bare.dimension())).unwrap();
        let jacobian = bare.jacobian(&at);
        let again = bare.mixed(bare.unmixed(jacobian.clone()));
        assert!((&again - &jacobian).amax() < 1e-9);
        let k = nuisances
            .iter()
            .position(|n| *n == Nuisance::Misalignment(0))
            .unwrap();
        let mut z = at.z.clone();
        z[k] = 1.0;
        let moved = bare.walk(z).unwrap();
        let change = &at.residual - &moved.residual;
        let missed = (change - jacobian.column(k)).amax();
        let most = jacobian.column(k).amax();
        assert!(missed < 0.2 * most, "{missed} of {most}");
        // An effect that replaces the mounting takes its sensitivity out.
        let with_effect = of_same(bare, &tilted);
        let own = with_effect.jacobian(&at_rest(&with_effect));
        let own = own.columns(0, bare.dimension()).clone_owned();
        let taken_out = with_effect.without_replaced(jacobian);
        assert!((&own - &taken_out).amax() < 0.02 * own.amax());
    });
}

#[test]
fn what_an_effect_has_in_place_of_a_parameter_is_that_parameter_without_it() {
    let tilted = [1.0, -0.7];
    let joint = Place::Link(2, 1);
    // The share of what the effect changes that is left. A gait of another period is simulated anew,
    // which another clock is not.
    for (kind, place, values, share) in [
        ("gyro_scale", Place::Robot, &[0.02][..], 0.01),
        ("friction", Place::Robot, &[-0.1], 0.01),
        ("servo_stiffness", Place::Robot, &[-0.15], 0.01),
        ("gait_period", Place::Robot, &[0.03], 0.6),
        ("sensor_delay", Place::Robot, &[0.02], 0.01),
        ("gyro_bias", Place::Robot, &[0.1, -0.2, 0.3], 0.01),
        ("imu_misalignment", Place::Robot, &tilted, 0.01),
        ("joint_offset", joint, &[0.03], 0.01),
    ] {
        with_walker(&[], |bare| {
            let with_effect = of_same(bare, &[(kind, place)]);
            let mut z = with_effect.described(&[values.to_vec()]);
            // The robot differs in other ways, too.
            for k in 0..bare.dimension() {
                z[k] = 0.3;
            }
            with_effect.clamp(&mut z);
            let walked = with_effect.walk(z.clone()).unwrap();
            let alike = bare
                .walk(bare.with_parameters_of(&with_effect, &z))
                .unwrap();
            let unlike = bare.walk(z.rows(0, bare.dimension()).into()).unwrap();
            let off = |other: &Walked| (&other.residual - &walked.residual).amax();
            assert!(off(&unlike) > 1e-3, "{kind} changes nothing");
            let (alike, unlike) = (off(&alike), off(&unlike));
            assert!(alike < share * unlike, "{kind}: {alike} of {unlike}");
            // With the effect, all stay.
            let again = with_effect.with_parameters_of(&with_effect, &z);
            let own = 0..with_effect.dimension();
            assert!(
                own.into_iter().all(|k| (again[k] - z[k]).abs() < 1e-9),
                "{kind}"
            );
        });
    }
}

#[test]
fn another_robot_takes_what_both_have_and_nothing_else() {
    with_walker(&[("friction", Place::Robot), WEAK], |whole| {
        let lost = Hypothesis {
            morphology: whole.hypothesis.morphology.clone().without_leg(4),
            lost_links: LostLinks::Locked,
            effects: placed(&[WEAK, DELAY]),
        };
        let (observation, prior) = (whole.observation, whole.prior);
        let other = Walker::new(lost, observation, prior, &whole.nominal);
        let mut z = whole.described(&[vec![-0.1], vec![-0.4]]);
        for k in 0..whole.nuisances() {
            z[k] = 0.1 * (k as f64 + 1.0);
        }
        whole.clamp(&mut z);
        let taken = other.with_parameters_of(whole, &z);
        // Its joint zeros are those of the same joints: leg 5 has none that show.
        let zeros = |walker: &Walker<'_>, z: &DVector<f64>| -> Vec<f64> {
            let deviations = walker.deviations(z);
            let each = walker.coordinates.iter().zip(&deviations);
            let of_legs = |leg: usize| {
                let each = each.clone();
                each.filter_map(move |(one, deviation)| match one.nuisance()?.parameter() {
                    Some(RobotParameter::JointZero { leg: l, .. }) => {
                        (l == leg).then_some(*deviation)
                    }
                    _ => None,
                })
            };
            [0, 1, 2, 3, 5].into_iter().flat_map(of_legs).collect()
        };
        assert!(!zeros(whole, &z).is_empty());
        assert_eq!(zeros(&other, &taken), zeros(whole, &z));
        assert!(other.nuisances() < whole.nuisances());
        // Friction is what the effect made of it; the weak leg is as weak; there was no delay.
        assert_eq!(other.values(&taken)[0], whole.values(&z)[1]);
        assert_eq!(
            taken[other.dimension() - 1],
            other.described(&[])[other.dimension() - 1]
        );
        let friction = |model: WalkModel| model.simulation.contact.friction;
        let (own, of_whole) = (friction(other.model(&taken)), friction(whole.model(&z)));
        assert!((own - of_whole).abs() < 1e-9, "{own} {of_whole}");
        assert!((of_whole - friction(whole.nominal.clone())).abs() > 0.05);
        // The same of sensitivities, which say by column whose they are.
        let rows = 3;
        let marked = DMatrix::from_fn(rows, whole.dimension(), |_, k| k as f64 + 1.0);
        let slopes = other.with_slopes_of(whole, &marked);
        let of_weak = marked[(0, whole.dimension() - 1)];
        assert_eq!(slopes[(0, other.nuisances())], of_weak);
        assert_eq!(slopes[(0, other.dimension() - 1)], 0.0);
        let shared = (0..other.nuisances()).filter(|k| slopes[(0, *k)] != 0.0);
        // All but friction, which an effect replaces on the whole robot, and the delay, which one replaces on the other.
        assert_eq!(shared.count(), other.nuisances() - 2);
    });
}

const WEAK: (&str, Place) = ("weak_leg", Place::Leg(2));
const DELAY: (&str, Place) = ("sensor_delay", Place::Robot);

/// Logarithm of the mass of the standard normal prior of the coordinates that their bounds
/// leave, coordinate by coordinate.
fn ln_mass(walker: &Walker<'_>) -> f64 {
    let steps = 40_000;
    let width = 20.0 / f64::from(steps);
    let each = (walker.nuisances()..walker.dimension()).map(|k| {
        let possible = (0..steps)
            .map(|i| -10.0 + (f64::from(i) + 0.5) * width)
            .filter(|x| {
                let mut z = DVector::zeros(walker.dimension());
                z[k] = *x;
                walker.clamp(&mut z);
                (z[k] - x).abs() < 1e-12
            });
        let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
        (possible.map(density).sum::<f64>() * width).ln()
    });
    each.sum()
}

#[test]
fn the_prior_of_a_hypothesis_integrates_to_one_over_the_bounds_of_its_parameters() {
    for effects in [&[WEAK][..], &[DELAY], &[WEAK, DELAY]] {
        let total = with_walker(effects, |walker| walker.ln_truncation() + ln_mass(walker));
        assert!(total.abs() < 1e-3, "{effects:?}: {total}");
    }
    // Control: without the correction, some of it is lost beyond the bounds.
    let lost = with_walker(&[WEAK, DELAY], ln_mass);
    assert!(lost < -0.08, "{lost}");
    let bare = with_walker(&[], |walker| walker.ln_truncation());
    assert_eq!(bare, 0.0);
}

#[test]
fn coordinates_are_clamped_to_the_bounds_and_values_read_back() {
    with_walker(&[WEAK, DELAY], |walker| {
        let values = vec![vec![-0.7], vec![0.02]];
        let z = walker.described(&values);
        for (seen, value) in walker
            .values(&z)
            .iter()
            .flatten()
            .zip(values.iter().flatten())
        {
            assert!((seen - value).abs() < 1e-12);
        }
        let mut beyond = walker.described(&[vec![0.4], vec![-0.1]]);
        walker.clamp(&mut beyond);
        assert_eq!(beyond, walker.described(&[vec![0.0], vec![0.0]]));
    });
}
