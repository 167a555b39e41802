//! Mirrored legs have mirrored effects, half a cycle apart.
//!
//! The robot is the same on both sides, and each leg of the tripod gait does half a cycle after its
//! mirror image what that one does. So does the walk: with an effect on the other side, roll and
//! yaw have the opposite sign half a cycle later, pitch the same one. The solver handles contacts
//! one after the other, so that this holds to some hundredths of a degree and not exactly.

use super::*;

/// Samples of half a cycle.
const HALF: usize = 12;
/// Cycles that are compared, once the stride has grown and the start is forgotten.
const CYCLES: usize = 3;

/// Walks whose half cycle is a whole number of samples.
struct Mirror {
    walks: Walks,
    plain: Axes<Vec<f64>>,
}

/// How walks differ, root mean square in degrees.
#[derive(Debug)]
struct Asymmetry {
    /// What the effect changes.
    effect: f64,
    /// Its walk from the mirrored one half a cycle later.
    mirrored: f64,
    /// The same without mirroring roll and yaw.
    not_mirrored: f64,
    /// The same at the same time.
    not_shifted: f64,
}

impl Mirror {
    fn new() -> Self {
        let walks = Walks::lasting(8.0);
        let plain = walks.of(&Self::model());
        Self { walks, plain }
    }

    fn model() -> WalkModel {
        let mut model = described();
        let period_s = 2.0 * HALF as f64 * WalkRecord::PERIOD_S;
        model.gait.slow_down(period_s / model.gait.period_s);
        model
    }

    fn difference_deg(
        &self,
        a: &Axes<Vec<f64>>,
        b: &Axes<Vec<f64>>,
        sign: f64,
        later: usize,
    ) -> f64 {
        let from = self.walks.at(4.0);
        let squares = (from..from + CYCLES * 2 * HALF).map(|index| {
            let turned_a = a.yaw[index] - a.yaw[from];
            let turned_b = b.yaw[index + later] - b.yaw[from + later];
            let roll = a.roll[index] - sign * b.roll[index + later];
            let pitch = a.pitch[index] - b.pitch[index + later];
            (roll.powi(2) + pitch.powi(2) + (turned_a - sign * turned_b).powi(2)) / 3.0
        });
        mean(&squares.collect::<Vec<_>>()).sqrt()
    }

    /// Of an effect on a leg on the left and its mirror image.
    fn asymmetry(
        &self,
        kind: &str,
        [left, right]: [Place; 2],
        [value, image]: [f64; 2],
    ) -> Asymmetry {
        let walk = |place, value| {
            self.walks
                .of(&changed(Self::model(), kind, place, &[value]))
        };
        let (left, right) = (walk(left, value), walk(right, image));
        Asymmetry {
            effect: self.difference_deg(&left, &self.plain, 1.0, 0),
            mirrored: self.difference_deg(&left, &right, -1.0, HALF),
            not_mirrored: self.difference_deg(&left, &right, 1.0, HALF),
            not_shifted: self.difference_deg(&left, &right, -1.0, 0),
        }
    }
}

#[test]
fn effects_on_mirrored_legs_are_mirrored_half_a_cycle_later() {
    let mirror = Mirror::new();
    let leg = |pair: usize| [Place::Leg(2 * pair), Place::Leg(2 * pair + 1)];
    let link = |pair: usize, link| [Place::Link(2 * pair, link), Place::Link(2 * pair + 1, link)];
    for (kind, places, values) in [
        ("weak_leg", leg(0), [-1.5, -1.5]),
        ("weak_leg", leg(1), [-1.5, -1.5]),
        ("weak_leg", leg(2), [-1.5, -1.5]),
        // A yaw joint's angle has the opposite sign on the other side, a lift joint's has not.
        ("joint_offset", link(0, 0), [0.17, -0.17]),
        ("joint_offset", link(0, 1), [0.17, 0.17]),
        ("joint_offset", link(1, 2), [0.17, 0.17]),
        ("stuck_joint", link(1, 1), [0.17, 0.17]),
        ("short_link", link(2, 2), [0.02, 0.02]),
    ] {
        let asymmetry = mirror.asymmetry(kind, places, values);
        let Asymmetry {
            effect,
            mirrored,
            not_mirrored,
            not_shifted,
        } = asymmetry;
        assert!(effect > 0.3, "{kind} {places:?} {asymmetry:?}");
        assert!(mirrored < 0.2 * effect, "{kind} {places:?} {asymmetry:?}");
        assert!(
            not_mirrored > 0.4 * effect,
            "{kind} {places:?} {asymmetry:?}"
        );
        assert!(
            not_shifted > 0.4 * effect,
            "{kind} {places:?} {asymmetry:?}"
        );
    }
}

#[test]
fn effects_on_legs_that_are_no_mirror_images_are_not() {
    let mirror = Mirror::new();
    for places in [
        [Place::Leg(0), Place::Leg(5)],
        [Place::Leg(2), Place::Leg(1)],
    ] {
        let asymmetry = mirror.asymmetry("weak_leg", places, [-1.5, -1.5]);
        assert!(
            asymmetry.mirrored > 0.4 * asymmetry.effect,
            "{places:?} {asymmetry:?}"
        );
    }
    let wrong_sign = mirror.asymmetry(
        "joint_offset",
        [Place::Link(0, 0), Place::Link(1, 0)],
        [0.17, 0.17],
    );
    assert!(wrong_sign.mirrored > wrong_sign.effect, "{wrong_sign:?}");
}

#[test]
fn friction_and_play_of_all_joints_change_mirrored_robots_alike() {
    let mirror = Mirror::new();
    for (kind, value) in [("joint_friction", 0.4), ("backlash", 0.1)] {
        let lame = |leg: usize, value: f64| {
            let lame = changed(Mirror::model(), "weak_leg", Place::Leg(leg), &[-1.5]);
            mirror
                .walks
                .of(&changed(lame, kind, Place::Robot, &[value]))
        };
        let (left, right) = (lame(2, value), lame(3, value));
        let effect = mirror.difference_deg(&left, &lame(2, 0.0), 1.0, 0);
        let mirrored = mirror.difference_deg(&left, &right, -1.0, HALF);
        assert!(effect > 0.3, "{kind} {effect} {mirrored}");
        assert!(mirrored < 0.2 * effect, "{kind} {effect} {mirrored}");
    }
}
