use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

/// A position servo: a spring and a damper towards the held, delayed and
/// rate-limited command, with the motor and the gears that make the torque.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Servo {
    /// Torque per radian of a small position error.
    pub stiffness_nm_per_rad: f64,
    /// Torque per rad/s of joint speed.
    pub damping_nm_s_per_rad: f64,
    /// Largest torque.
    pub torque_limit_nm: f64,
    /// Largest speed at which the servo's set point moves.
    pub speed_limit_rad_per_s: f64,
    /// How long the controller holds each command.
    pub command_hold_s: f64,
    /// Time from a command to its effect.
    pub latency_s: f64,
    /// What motor and gears add to this.
    #[serde(default)]
    pub drive: Drive,
}

/// What the motor and the gears of a servo do to its spring and damper. By default nothing: of most
/// servos none of this is known.
///
/// Dry friction is at most
/// `coulomb + stribeck · s + load_friction · |motor − driven_ratio · load|`
/// `+ stribeck_load · s · |motor − load| + quadratic_load · load² + quadratic_gears · (motor − load)²`
/// with `s = exp(−(speed/stribeck_speed)²)`, the torque of the motor, and that of the load on
/// the joint: where they push against each other, the gears carry both. All but the last are the terms of
/// the extended friction models M1 to M6 of
/// [Duclusaud et al. (2024)](https://arxiv.org/abs/2410.08650).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Drive {
    /// Whether the torque limit is that of a motor at rest: damping is the motor's back EMF and takes
    /// torque away at the limit as well; with play, a dead band or saturation it does in any case. If not, spring
    /// and damper together stay within the limit.
    pub back_emf: bool,
    /// How much less than in proportion to its current the motor's torque grows: at the torque limit it is
    /// 1/(1 + this) of what it would be. Stiffness and damping hold for small currents.
    pub torque_saturation: f64,
    /// Inertia of the rotor, as it acts on the joint.
    pub armature_kg_m2: f64,
    /// Friction per rad/s, which a motor without current has as well.
    pub viscous_nm_s_per_rad: f64,
    /// Dry friction of a joint that moves without load.
    pub coulomb_nm: f64,
    /// Dry friction at rest beyond that.
    pub stribeck_nm: f64,
    /// Speed at which friction at rest has become that of motion.
    pub stribeck_speed_rad_per_s: f64,
    /// Dry friction per torque of the motor in the gears.
    pub load_friction: f64,
    /// The same per torque of the load, over that.
    pub driven_ratio: f64,
    /// Dry friction at rest per torque, beyond that of motion.
    pub stribeck_load: f64,
    /// Dry friction per squared torque of the load.
    pub quadratic_load_per_nm: f64,
    /// Dry friction per squared torque in the gears, that of the motor less that of the load.
    pub quadratic_gears_per_nm: f64,
    /// Play of the gears: the joint is free over this angle about where the motor holds it.
    pub backlash_rad: f64,
    /// Errors of less than this give no torque at all.
    pub dead_band_rad: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            back_emf: false,
            torque_saturation: 0.0,
            armature_kg_m2: 0.0,
            viscous_nm_s_per_rad: 0.0,
            coulomb_nm: 0.0,
            stribeck_nm: 0.0,
            stribeck_speed_rad_per_s: 0.5,
            load_friction: 0.0,
            driven_ratio: 1.0,
            stribeck_load: 0.0,
            quadratic_load_per_nm: 0.0,
            quadratic_gears_per_nm: 0.0,
            backlash_rad: 0.0,
            dead_band_rad: 0.0,
        }
    }
}

impl Servo {
    /// Least stiffness, in N m/rad.
    pub(crate) const SOFTEST: f64 = 1e-9;
    /// Largest stiffness, in N m/rad.
    pub(crate) const STIFFEST: f64 = 1e6;

    /// Checks every number. No damping and no latency are valid.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        let Self {
            stiffness_nm_per_rad: stiffness,
            damping_nm_s_per_rad: damping,
            speed_limit_rad_per_s: speed_limit,
            ..
        } = *self;
        let stiffnesses = Self::SOFTEST..=Self::STIFFEST;
        check("stiffness_nm_per_rad", stiffness, stiffnesses, "N m/rad")?;
        check("damping_nm_s_per_rad", damping, 0.0..=1e6, "N m s/rad")?;
        check("torque_limit_nm", self.torque_limit_nm, 1e-9..=1e6, "N m")?;
        check("speed_limit_rad_per_s", speed_limit, 1e-9..=1e6, "rad/s")?;
        check("command_hold_s", self.command_hold_s, 1e-4..=1.0, "s")?;
        check("latency_s", self.latency_s, 0.0..=1.0, "s")?;
        self.drive.check().map_err(|error| error.under("drive"))
    }

    /// What share of its largest effort the controller makes at an error of the angle: the duty cycle of
    /// a motor at a voltage.
    pub fn effort(&self, error_rad: f64) -> f64 {
        if error_rad.abs() < self.drive.dead_band_rad {
            return 0.0;
        }
        (self.stiffness_nm_per_rad * error_rad / self.largest_wanted_nm()).clamp(-1.0, 1.0)
    }

    /// Torque of a spring without saturation where the motor's is at its limit.
    fn largest_wanted_nm(&self) -> f64 {
        (1.0 + self.drive.torque_saturation) * self.torque_limit_nm
    }

    /// Damping with which it acts in simulated steps of this length. The spring of a joint is implicit: it acts in a
    /// step as if the joint had been all the time where it ends, which damps by half of stiffness times step more.
    pub fn damping_in_steps_nm_s_per_rad(&self, time_step_s: f64) -> f64 {
        self.damping_nm_s_per_rad + 0.5 * self.stiffness_nm_per_rad * time_step_s
    }

    /// Torque of the motor at a position error and a speed, its damping included, and how it grows with
    /// the error there, N m/rad.
    pub(crate) fn motor(&self, error_rad: f64, speed_rad_per_s: f64) -> (f64, f64) {
        let Drive {
            backlash_rad,
            dead_band_rad,
            torque_saturation,
            ..
        } = self.drive;
        let stiffness = self.stiffness_nm_per_rad;
        let damping_nm = self.damping_nm_s_per_rad * speed_rad_per_s;
        if self.drive.is_plain() {
            let limit_nm = self.torque_limit_nm;
            let wanted_nm = stiffness * error_rad - damping_nm;
            return (wanted_nm.clamp(-limit_nm, limit_nm), stiffness);
        }
        let taut_rad = (error_rad.abs() - backlash_rad / 2.0).max(0.0);
        let is_free = taut_rad <= 0.0 || error_rad.abs() < dead_band_rad;
        let spring_nm = if is_free { 0.0 } else { stiffness * taut_rad };
        let largest_nm = self.largest_wanted_nm();
        let driving_nm = spring_nm.min(largest_nm).copysign(error_rad) - damping_nm;
        let less = 1.0 + torque_saturation * driving_nm.abs() / largest_nm;
        let is_elastic = spring_nm <= largest_nm && !(is_free && self.drive.has_gap());
        let growth = if is_elastic {
            stiffness / (less * less)
        } else {
            0.0
        };
        (driving_nm / less, growth)
    }
}

impl Drive {
    /// Checks every number. None of these effects is valid.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        for (name, value, most, unit) in [
            ("torque_saturation", self.torque_saturation, 100.0, ""),
            ("armature_kg_m2", self.armature_kg_m2, 1e3, "kg m²"),
            (
                "viscous_nm_s_per_rad",
                self.viscous_nm_s_per_rad,
                1e6,
                "N m s/rad",
            ),
            ("coulomb_nm", self.coulomb_nm, 1e6, "N m"),
            ("stribeck_nm", self.stribeck_nm, 1e6, "N m"),
            ("load_friction", self.load_friction, 100.0, ""),
            ("driven_ratio", self.driven_ratio, 100.0, ""),
            ("stribeck_load", self.stribeck_load, 100.0, ""),
            (
                "quadratic_load_per_nm",
                self.quadratic_load_per_nm,
                1e6,
                "per N m",
            ),
            (
                "quadratic_gears_per_nm",
                self.quadratic_gears_per_nm,
                1e6,
                "per N m",
            ),
            ("backlash_rad", self.backlash_rad, 1.0, "rad"),
            ("dead_band_rad", self.dead_band_rad, 1.0, "rad"),
        ] {
            SettingError::check(name, value, 0.0..=most, unit)?;
        }
        let speed = self.stribeck_speed_rad_per_s;
        SettingError::check("stribeck_speed_rad_per_s", speed, 1e-6..=1e6, "rad/s")
    }

    /// Whether there are errors that give no torque.
    fn has_gap(&self) -> bool {
        self.backlash_rad > 0.0 || self.dead_band_rad > 0.0
    }

    /// Whether spring and damper are in proportion to error and speed, and share the torque limit.
    fn is_plain(&self) -> bool {
        !self.back_emf && !self.has_gap() && self.torque_saturation == 0.0
    }

    /// The largest torque of dry friction, N m, at a speed of the joint, with these torques of the motor
    /// and of the load, positive where the joint turns.
    pub(crate) fn dry_friction_nm(&self, speed_rad_per_s: f64, motor_nm: f64, load_nm: f64) -> f64 {
        let relative = speed_rad_per_s / self.stribeck_speed_rad_per_s;
        let at_rest = libm::exp(-relative * relative);
        self.coulomb_nm
            + self.stribeck_nm * at_rest
            + self.load_friction * (motor_nm - self.driven_ratio * load_nm).abs()
            + self.stribeck_load * at_rest * (motor_nm - load_nm).abs()
            + self.quadratic_load_per_nm * load_nm * load_nm
            + self.quadratic_gears_per_nm * (motor_nm - load_nm) * (motor_nm - load_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Robot;

    fn servo(drive: Drive) -> Servo {
        Servo {
            stiffness_nm_per_rad: 10.0,
            torque_limit_nm: 2.0,
            drive,
            ..*Robot::jethexa().servo()
        }
    }

    #[test]
    fn the_spring_pulls_towards_the_command_up_to_its_limit() {
        let plain = servo(Drive::default());
        for (error_rad, torque_nm, stiffness, effort) in [
            (0.0, 0.0, 10.0, 0.0),
            (0.1, 1.0, 10.0, 0.5),
            (-0.1, -1.0, 10.0, -0.5),
            (0.5, 2.0, 0.0, 1.0),
            (-0.5, -2.0, 0.0, -1.0),
        ] {
            let strong = servo(Drive {
                back_emf: true,
                ..Drive::default()
            });
            assert_eq!(strong.motor(error_rad, 0.0), (torque_nm, stiffness));
            assert_eq!(plain.motor(error_rad, 0.0), (torque_nm, 10.0));
            assert_eq!(plain.effort(error_rad), effort);
        }
    }

    #[test]
    fn a_motor_that_saturates_makes_the_same_largest_torque_of_a_larger_error() {
        let saturating = servo(Drive {
            torque_saturation: 0.5,
            ..Drive::default()
        });
        // Largest where a spring without saturation would make 3 N m.
        assert_eq!(saturating.motor(0.301, 0.0), (2.0, 0.0));
        assert!((saturating.motor(0.3, 0.0).0 - 2.0).abs() < 1e-12);
        assert!((saturating.effort(-0.15) + 0.5).abs() < 1e-12);
        // Half the effort makes more than half of the torque, and small errors what stiffness says.
        assert!((saturating.motor(0.15, 0.0).0 - 1.5 / 1.25).abs() < 1e-12);
        assert!((saturating.motor(1e-6, 0.0).0 / 1e-5 - 1.0).abs() < 1e-5);
        for (error_rad, speed) in [(-0.25, 0.0), (0.01, 1.0), (0.2, -0.5)] {
            let step_rad = 1e-6;
            let at = |by: f64| saturating.motor(error_rad + by, speed).0;
            let slope = (at(step_rad) - at(-step_rad)) / (2.0 * step_rad);
            assert!((saturating.motor(error_rad, speed).1 / slope - 1.0).abs() < 1e-6);
        }
        // At its no-load speed it makes no torque, saturated or not.
        let no_load = 3.0 / saturating.damping_nm_s_per_rad;
        assert!(saturating.motor(9.0, no_load).0.abs() < 1e-12);
    }

    #[test]
    fn play_shifts_the_spring_and_a_dead_band_silences_it() {
        let play = servo(Drive {
            backlash_rad: 0.04,
            ..Drive::default()
        });
        assert_eq!(play.motor(0.019, 0.0), (0.0, 0.0));
        assert!((play.motor(-0.12, 0.0).0 + 1.0).abs() < 1e-12);
        let deaf = servo(Drive {
            dead_band_rad: 0.02,
            ..Drive::default()
        });
        assert_eq!(deaf.motor(-0.019, 0.0), (0.0, 0.0));
        assert_eq!(deaf.effort(-0.019), 0.0);
        assert!((deaf.motor(0.12, 0.0).0 - 1.2).abs() < 1e-12);
    }

    #[test]
    fn friction_is_the_sum_of_its_terms_and_the_same_both_ways() {
        let drive = Drive {
            coulomb_nm: 0.1,
            stribeck_nm: 0.05,
            stribeck_speed_rad_per_s: 0.5,
            load_friction: 0.2,
            driven_ratio: 3.0,
            stribeck_load: 0.1,
            quadratic_load_per_nm: 0.5,
            quadratic_gears_per_nm: 0.01,
            ..Drive::default()
        };
        // Fast: 0.1 + 0.2 · (2 + 3 · 1) + 0.5 · 1 + 0.01 · 9 where they push against each other, and less
        // where not.
        assert!((drive.dry_friction_nm(9.0, 2.0, -1.0) - 1.69).abs() < 1e-9);
        assert!((drive.dry_friction_nm(9.0, 2.0, 1.0) - 0.81).abs() < 1e-9);
        // At rest with both terms of Stribeck.
        let at_rest = 0.1 + 0.05 + 0.2 * 5.0 + 0.1 * 3.0 + 0.5 + 0.09;
        assert!((drive.dry_friction_nm(0.0, 2.0, -1.0) - at_rest).abs() < 1e-9);
        for (speed, motor, load) in [(0.3, 1.0, 0.5), (0.01, -2.0, 1.0), (0.0, 0.5, 0.0)] {
            let one = drive.dry_friction_nm(speed, motor, load);
            let other = drive.dry_friction_nm(-speed, -motor, -load);
            assert!((one - other).abs() < 1e-12);
        }
        assert_eq!(Drive::default().dry_friction_nm(0.0, 3.0, 1.0), 0.0);
    }

    #[test]
    fn numbers_that_make_no_sense_are_named() {
        let wrong = Drive {
            coulomb_nm: -0.1,
            ..Drive::default()
        };
        let error = servo(wrong).check().unwrap_err();
        assert_eq!(error.name, "drive.coulomb_nm");
        assert!(servo(Drive::default()).check().is_ok());
    }
}
