//! Where a leg can put its foot, and where its mass is then.

use mlr_model::{Leg, kinematics};
use nalgebra::Point3;

use crate::support::Ground;

/// A grid of places that a foot reaches, standing and lifted, with the first moment of the leg's mass.
#[derive(Debug, Clone)]
pub(crate) struct Footholds {
    first_m: Ground,
    /// First moments along x and y, kg m; `None` out of reach. Row by row along y.
    moments: Vec<Option<Ground>>,
    pub(crate) mass_kg: f64,
    pub(crate) hip_m: Ground,
}

const CELL_M: f64 = 0.01;
/// Cells along each side.
const CELLS: usize = 33;

impl Footholds {
    /// Places around the nominal one, at which no joint turns further than `most_turn_rad` from the
    /// leg's posture.
    pub(crate) fn of(leg: &Leg, body_height_m: f64, lift_m: f64, most_turn_rad: f64) -> Self {
        let half_m = CELL_M * (CELLS - 1) as f64 / 2.0;
        let first_m = leg.nominal_foot_m.map(|at_m| at_m - half_m);
        let length_m: f64 = leg.links.iter().map(|link| link.length_m).sum();
        let turns_too_far = |angles_rad: &[f64]| {
            let each = leg.links.iter().zip(angles_rad);
            each.into_iter()
                .any(|(link, angle_rad)| (angle_rad - link.posture_rad).abs() > most_turn_rad)
        };
        let reached = |x_m: f64, y_m: f64, z_m: f64| {
            let target = Point3::new(x_m, y_m, z_m);
            if (target - leg.hip_m).norm() > length_m {
                return None;
            }
            let angles_rad = kinematics::inverse(leg, target).ok()?;
            (!turns_too_far(&angles_rad)).then_some(angles_rad)
        };
        let mut mass_kg = 0.0;
        let mut moments = Vec::with_capacity(CELLS * CELLS);
        for row in 0..CELLS {
            for column in 0..CELLS {
                let [x_m, y_m] = [column, row].map(|cells| CELL_M * cells as f64);
                let [x_m, y_m] = [first_m[0] + x_m, first_m[1] + y_m];
                let standing = reached(x_m, y_m, -body_height_m);
                let lifted = || reached(x_m, y_m, lift_m - body_height_m);
                moments.push(standing.filter(|_| lifted().is_some()).map(|angles_rad| {
                    let (of_leg_kg, moment) = kinematics::mass_moment(leg, &angles_rad);
                    mass_kg = of_leg_kg;
                    [moment.x, moment.y]
                }));
            }
        }
        Self {
            first_m,
            moments,
            mass_kg,
            hip_m: [leg.hip_m.x, leg.hip_m.y],
        }
    }

    /// First moment of the leg's mass with the foot at this place; `None` out of reach.
    pub(crate) fn moment(&self, at_m: Ground) -> Option<Ground> {
        let cells = [0, 1].map(|axis| (at_m[axis] - self.first_m[axis]) / CELL_M);
        let last = (CELLS - 1) as f64;
        if !cells.iter().all(|cell| (0.0..last).contains(cell)) {
            return None;
        }
        let [column, row] = cells.map(|cell| cell as usize);
        let [x, y] = [cells[0] - column as f64, cells[1] - row as f64];
        let at = |column: usize, row: usize| self.moments[row * CELLS + column];
        let corners = [
            (at(column, row)?, (1.0 - x) * (1.0 - y)),
            (at(column + 1, row)?, x * (1.0 - y)),
            (at(column, row + 1)?, (1.0 - x) * y),
            (at(column + 1, row + 1)?, x * y),
        ];
        let along = |axis: usize| {
            corners
                .iter()
                .map(|(moment, share)| share * moment[axis])
                .sum()
        };
        Some([along(0), along(1)])
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::Robot;

    use super::*;

    #[test]
    fn the_table_gives_the_moment_of_the_leg_where_it_reaches() {
        let robot = Robot::jethexa();
        for leg in robot.legs() {
            let table = Footholds::of(leg, 0.09, 0.04, 1.1);
            let [x, y] = leg.nominal_foot_m;
            let place = [x + 0.0137, y - 0.0042];
            let angles = kinematics::inverse(leg, Point3::new(place[0], place[1], -0.09)).unwrap();
            let (mass_kg, moment) = kinematics::mass_moment(leg, &angles);
            let of_table = table.moment(place).unwrap();
            assert!((of_table[0] - moment.x).abs() < 1e-4 * mass_kg / 0.2);
            assert!((of_table[1] - moment.y).abs() < 1e-4 * mass_kg / 0.2);
            assert_eq!(table.mass_kg, mass_kg);
            // Beyond the leg, and beyond the table.
            let out = [
                x + x.signum() * 0.12 * x.abs().min(1.0),
                y + y.signum() * 0.12,
            ];
            assert_eq!(table.moment(out), None);
            assert_eq!(table.moment([5.0, 0.0]), None);
        }
    }
}
