use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

/// A position servo: a spring and a damper towards the held, delayed and
/// rate-limited command, with the motor and the gears that make the torque.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Servo {
    /// Torque per radian of position error.
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
/// `+ stribeck_load · s · |motor − load| + quadratic_load · load²`
/// with `s = exp(−(speed/stribeck_speed)²)`, the torque of the motor's spring, and that of the load on
/// the joint: where they push against each other, the gears carry both. These are the terms of the
/// extended friction models M1 to M6 of
/// [Duclusaud et al. (2024)](https://arxiv.org/abs/2410.08650).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Drive {
    /// Whether the torque limit is that of a motor at rest: damping is the motor's back EMF and takes
    /// torque away at the limit as well; with play or a dead band it does in any case. If not, spring
    /// and damper together stay within the limit.
    pub back_emf: bool,
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
    /// Play of the gears: the joint is free over this angle about where the motor holds it.
    pub backlash_rad: f64,
    /// Errors of less than this give no torque at all.
    pub dead_band_rad: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            back_emf: false,
            armature_kg_m2: 0.0,
            viscous_nm_s_per_rad: 0.0,
            coulomb_nm: 0.0,
            stribeck_nm: 0.0,
            stribeck_speed_rad_per_s: 0.5,
            load_friction: 0.0,
            driven_ratio: 1.0,
            stribeck_load: 0.0,
            quadratic_load_per_nm: 0.0,
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

    /// Torque of the spring at a position error, the motor at rest, and whether it changes with the
    /// error there.
    pub(crate) fn spring_nm(&self, error_rad: f64) -> (f64, bool) {
        let Drive {
            backlash_rad,
            dead_band_rad,
            ..
        } = self.drive;
        let taut_rad = (error_rad.abs() - backlash_rad / 2.0).max(0.0);
        if taut_rad <= 0.0 || error_rad.abs() < dead_band_rad {
            return (0.0, !self.drive.has_gap());
        }
        let wanted_nm = self.stiffness_nm_per_rad * taut_rad;
        let torque_nm = wanted_nm.min(self.torque_limit_nm);
        (
            torque_nm.copysign(error_rad),
            wanted_nm <= self.torque_limit_nm,
        )
    }
}

impl Drive {
    /// Checks every number. None of these effects is valid.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        for (name, value, most, unit) in [
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
            ("backlash_rad", self.backlash_rad, 1.0, "rad"),
            ("dead_band_rad", self.dead_band_rad, 1.0, "rad"),
        ] {
            SettingError::check(name, value, 0.0..=most, unit)?;
        }
        let speed = self.stribeck_speed_rad_per_s;
        SettingError::check("stribeck_speed_rad_per_s", speed, 1e-6..=1e6, "rad/s")
    }

    /// Whether there are errors that give no torque.
    pub(crate) fn has_gap(&self) -> bool {
        self.backlash_rad > 0.0 || self.dead_band_rad > 0.0
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
        for (error_rad, torque_nm, elastic) in [
            (0.0, 0.0, true),
            (0.1, 1.0, true),
            (-0.1, -1.0, true),
            (0.5, 2.0, false),
            (-0.5, -2.0, false),
        ] {
            assert_eq!(plain.spring_nm(error_rad), (torque_nm, elastic));
        }
    }

    #[test]
    fn play_shifts_the_spring_and_a_dead_band_silences_it() {
        let play = servo(Drive {
            backlash_rad: 0.04,
            ..Drive::default()
        });
        assert_eq!(play.spring_nm(0.019), (0.0, false));
        assert!((play.spring_nm(-0.12).0 + 1.0).abs() < 1e-12);
        let deaf = servo(Drive {
            dead_band_rad: 0.02,
            ..Drive::default()
        });
        assert_eq!(deaf.spring_nm(-0.019), (0.0, false));
        assert!((deaf.spring_nm(0.12).0 - 1.2).abs() < 1e-12);
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
            ..Drive::default()
        };
        // Fast: 0.1 + 0.2 · (2 + 3 · 1) + 0.5 · 1 where they push against each other, and less where not.
        assert!((drive.dry_friction_nm(9.0, 2.0, -1.0) - 1.6).abs() < 1e-9);
        assert!((drive.dry_friction_nm(9.0, 2.0, 1.0) - 0.8).abs() < 1e-9);
        // At rest with both terms of Stribeck.
        let at_rest = 0.1 + 0.05 + 0.2 * 5.0 + 0.1 * 3.0 + 0.5;
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
