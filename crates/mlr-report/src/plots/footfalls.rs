use askama::Template;
use mlr_model::{Gait, JointCommands, ModelError, Morphology, Robot, kinematics::foot_tip};

use crate::{Ink, Picture, PictureError};

/// Which feet stand when, in one cycle of a gait, as commanded.
#[derive(Debug, Clone, PartialEq)]
pub struct Footfalls {
    /// Name of the gait.
    pub gait: String,
    /// Duration of the cycle.
    pub cycle_s: f64,
    /// Of each leg.
    pub legs: Vec<LegFootfall>,
}

/// When a foot stands.
#[derive(Debug, Clone, PartialEq)]
pub struct LegFootfall {
    /// Number and name of the leg.
    pub leg: String,
    /// Whether the leg misses a link.
    pub is_damaged: bool,
    /// From when to when, in seconds of the cycle.
    pub stances_s: Vec<[f64; 2]>,
}

/// A foot stands that is not lifted by more than this share of the highest step, or so much.
const STANDING_SHARE: f64 = 0.08;
const STANDING_M: f64 = 0.002;
/// Steps of a cycle that are looked at.
const STEPS: usize = 240;

impl Footfalls {
    /// The footfalls of a gait on a robot of which this is left; `None` of a motion that ends, which
    /// has no cycle.
    ///
    /// # Errors
    /// [`ModelError`] when the robot cannot follow the gait.
    pub fn of(
        robot: &Robot,
        gait: &Gait,
        morphology: &Morphology,
    ) -> Result<Option<Self>, ModelError> {
        let Some(cycle_s) = gait.cycle_s() else {
            return Ok(None);
        };
        let commands = JointCommands::new(robot, gait, gait.first_pass_s())?;
        let step_s = cycle_s / STEPS as f64;
        let heights_m: Vec<Vec<f64>> = robot
            .legs()
            .iter()
            .enumerate()
            .map(|(index, leg)| {
                let height_m = |step: usize| {
                    let time_s = gait.steady_from_s() + step as f64 * step_s;
                    let links = 0..leg.links.len();
                    let angles_rad = links.map(|link| commands.angle_rad(index, link, time_s));
                    foot_tip(leg, &angles_rad.collect::<Vec<_>>()).z
                };
                (0..STEPS).map(height_m).collect()
            })
            .collect();
        let all_m = || heights_m.iter().flatten().copied();
        let ground_m = all_m().fold(f64::INFINITY, f64::min);
        let lift_m = all_m().fold(f64::NEG_INFINITY, f64::max) - ground_m;
        let standing_m = ground_m + STANDING_M.max(STANDING_SHARE * lift_m);
        let legs = robot.legs().iter().zip(&heights_m).enumerate();
        let legs = legs.map(|(index, (leg, heights_m))| {
            let is_damaged = morphology.remaining(index) < leg.links.len();
            let stands = |step: &usize| heights_m[*step] <= standing_m;
            let steps: Vec<usize> = (0..STEPS).filter(stands).collect();
            let stances = steps.chunk_by(|a, b| *b == a + 1);
            let stances_s = stances
                .map(|steps| [steps[0], steps[0] + steps.len()].map(|step| step as f64 * step_s));
            LegFootfall {
                leg: format!("{} {}", index + 1, leg.name),
                is_damaged,
                stances_s: if is_damaged {
                    Vec::new()
                } else {
                    stances_s.collect()
                },
            }
        });
        Ok(Some(Self {
            gait: gait.name.clone(),
            cycle_s,
            legs: legs.collect(),
        }))
    }

    /// Draws them.
    ///
    /// # Errors
    /// [`PictureError`] when the template cannot be filled.
    pub fn draw(&self, name: &str) -> Result<Picture, PictureError> {
        let across = |time_s: f64| LEFT + time_s / self.cycle_s * (WIDTH - LEFT - RIGHT);
        let rows = self.legs.iter().enumerate().map(|(index, leg)| Row {
            y: TOP + ROW * index as f64,
            leg: &leg.leg,
            is_damaged: leg.is_damaged,
            bars: leg
                .stances_s
                .iter()
                .map(|[from_s, to_s]| [across(*from_s), across(*to_s) - across(*from_s)])
                .collect(),
        });
        let bottom = TOP + ROW * self.legs.len() as f64;
        let ticks = (0..=4).map(|quarter| {
            let time_s = f64::from(quarter) / 4.0 * self.cycle_s;
            (across(time_s), format!("{time_s:.2}"))
        });
        let drawing = Drawing {
            rows: rows.collect(),
            ticks: ticks.collect(),
            left: LEFT,
            top: TOP,
            bottom,
            middle: f64::midpoint(LEFT, WIDTH - RIGHT),
            text: Ink::Text.hex(),
            grid: Ink::Grid.hex(),
            color: Ink::Measured.hex(),
            muted: Ink::Muted.hex(),
        };
        let size = [WIDTH as u32, (bottom + 44.0) as u32];
        Ok(Picture::new(
            name,
            "Footfalls of the recovery gait",
            "One row for each leg over one cycle of the gait: bars where its foot stands.",
            size,
            size,
            &drawing.render()?,
        ))
    }
}

const WIDTH: f64 = 440.0;
const LEFT: f64 = 120.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 8.0;
const ROW: f64 = 26.0;

#[derive(Template)]
#[template(path = "footfalls.svg", escape = "html")]
struct Drawing<'a> {
    rows: Vec<Row<'a>>,
    ticks: Vec<(f64, String)>,
    left: f64,
    top: f64,
    bottom: f64,
    middle: f64,
    text: String,
    grid: String,
    color: String,
    muted: String,
}

struct Row<'a> {
    y: f64,
    leg: &'a str,
    is_damaged: bool,
    /// Left end and width.
    bars: Vec<[f64; 2]>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tripods_stand_in_turn_and_damaged_legs_never() {
        let robot = Robot::jethexa();
        let morphology = Morphology::healthy(&robot.layout()).without_leg(2);
        let footfalls = Footfalls::of(&robot, &Gait::tripod(), &morphology);
        let footfalls = footfalls.unwrap().unwrap();
        let stands = |leg: usize, time_s: f64| {
            let mut stances = footfalls.legs[leg].stances_s.iter();
            stances.any(|[from_s, to_s]| (*from_s..*to_s).contains(&time_s))
        };
        for leg in [0, 3, 4] {
            assert!(!stands(leg, 0.25) && stands(leg, 0.75), "leg {}", leg + 1);
        }
        for leg in [1, 5] {
            assert!(stands(leg, 0.25) && !stands(leg, 0.75), "leg {}", leg + 1);
        }
        assert!(footfalls.legs[2].stances_s.is_empty());
        let picture = footfalls.draw("footfalls").unwrap();
        assert!(picture.svg().contains("3 middle left"));
        picture.png(1.0).unwrap();
    }
}
