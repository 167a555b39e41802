use askama::Template;
use mlr_model::{Gait, JointCommands, Leg, Morphology, Robot};

use crate::{Ink, Picture, PictureError};

/// Width in pixels, of which the names of the legs take as much on either side.
const WIDTH: f64 = 460.0;
const NAMES: f64 = 118.0;
/// Room above and below the robot.
const ABOVE: f64 = 34.0;
/// Height of a leg's name and probability.
const NAME_HEIGHT: f64 = 44.0;
/// Width of the strokes of the innermost link, and how much less those of the next are.
const STROKE: f64 = 11.0;
const THINNER: f64 = 2.0;

#[derive(Template)]
#[template(path = "robot_from_above.svg", escape = "html")]
struct Drawing {
    body: Rectangle,
    legs: Vec<DrawnLeg>,
    text: String,
}

struct Rectangle {
    x: f64,
    y: f64,
    width: f64,
    height: f64,
}

struct DrawnLeg {
    number: usize,
    name: String,
    /// In words, or nothing where it is not known.
    probability: String,
    /// In percent, for the colour.
    percent: f64,
    color: String,
    links: Vec<DrawnLink>,
    foot: [f64; 2],
    is_whole: bool,
    is_left: bool,
    name_at: [f64; 2],
}

struct DrawnLink {
    from: [f64; 2],
    to: [f64; 2],
    width: f64,
    is_lost: bool,
}

/// The robot from above in the stance of its gait, forward up: legs with their numbers and names,
/// coloured by the probability that they are damaged; lost links are dashed.
///
/// # Errors
/// [`PictureError`] when the template cannot be filled.
pub fn robot_from_above(
    name: &str,
    robot: &Robot,
    gait: &Gait,
    morphology: &Morphology,
    leg_damage_probability: &[f64],
) -> Result<Picture, PictureError> {
    let stance = JointCommands::new(robot, gait, 0.0).ok();
    let legs: Vec<Vec<[f64; 2]>> = (0..)
        .zip(robot.legs())
        .map(|(index, leg)| joints_m(index, leg, stance.as_ref()))
        .collect();
    let half_m = [robot.body().size_m.y / 2.0, robot.body().size_m.x / 2.0];
    let reach = |axis: usize| {
        let joints = legs.iter().flatten();
        joints.fold(half_m[axis], |most, joint| most.max(joint[axis].abs()))
    };
    let [reach_x_m, reach_y_m] = [reach(0), reach(1)].map(|reach_m| reach_m.max(1e-3));
    let pixels_per_m = (WIDTH / 2.0 - NAMES) / reach_x_m;
    let most_on_a_side = robot.legs().len().div_ceil(2) as f64 * NAME_HEIGHT;
    let height = (2.0 * reach_y_m * pixels_per_m).max(most_on_a_side) + 2.0 * ABOVE;
    let place = |[x_m, y_m]: [f64; 2]| {
        [
            WIDTH / 2.0 + x_m * pixels_per_m,
            height / 2.0 + y_m * pixels_per_m,
        ]
    };
    let mut drawn = Vec::new();
    for (index, (leg, joints)) in robot.legs().iter().zip(&legs).enumerate() {
        let at: Vec<[f64; 2]> = joints.iter().copied().map(place).collect();
        let links = at.windows(2).enumerate().map(|(link, ends)| DrawnLink {
            from: ends[0],
            to: ends[1],
            width: (STROKE - THINNER * link as f64).max(3.0),
            is_lost: !morphology.exists(index, link),
        });
        let known = leg_damage_probability.get(index).copied();
        let damage = known.unwrap_or(0.0).clamp(0.0, 1.0);
        let foot = at.last().copied().unwrap_or_default();
        let is_left = leg.hip_m.y > 0.0;
        drawn.push(DrawnLeg {
            number: index + 1,
            name: leg.name.clone(),
            probability: known.map_or(String::new(), crate::words::percent),
            percent: 100.0 * damage,
            color: mixed(damage),
            links: links.collect(),
            foot,
            is_whole: morphology.remaining(index) == leg.links.len(),
            is_left,
            name_at: [foot[0] + if is_left { -20.0 } else { 20.0 }, foot[1]],
        });
    }
    for is_left in [true, false] {
        spread(
            drawn.iter_mut().filter(|leg| leg.is_left == is_left),
            height,
        );
    }
    let corner = place([-half_m[0], -half_m[1]]);
    let drawing = Drawing {
        body: Rectangle {
            x: corner[0],
            y: corner[1],
            width: 2.0 * half_m[0] * pixels_per_m,
            height: 2.0 * half_m[1] * pixels_per_m,
        },
        text: Ink::Text.hex(),
        legs: drawn,
    };
    let size = [WIDTH as u32, height.ceil() as u32];
    Ok(Picture::new(
        name,
        "The robot from above",
        &described(&drawing.legs),
        size,
        size,
        &drawing.render()?,
    ))
}

/// Hip, joints and foot seen from above: to the right and backward.
fn joints_m(index: usize, leg: &Leg, stance: Option<&JointCommands>) -> Vec<[f64; 2]> {
    let from_above = |x_m: f64, y_m: f64| [-y_m, -x_m];
    let Some(stance) = stance else {
        // Links of a leg whose stance is not known lie in a line, as many parts as there are links.
        let links = leg.links.len() as f64;
        let [x_m, y_m] = leg.nominal_foot_m;
        return (0..=leg.links.len())
            .map(|link| link as f64 / links)
            .map(|s| {
                from_above(
                    leg.hip_m.x + s * (x_m - leg.hip_m.x),
                    leg.hip_m.y + s * (y_m - leg.hip_m.y),
                )
            })
            .collect();
    };
    let links = leg.links.iter().enumerate();
    let ends = links.scan(leg.hip_frame(), |frame, (link, part)| {
        *frame *= part.tip_frame(stance.angle_rad(index, link, 0.0));
        Some(*frame)
    });
    std::iter::once(leg.hip_frame())
        .chain(ends)
        .map(|frame| from_above(frame.translation.x, frame.translation.y))
        .collect()
}

/// Moves names apart that would lie on each other, and into the picture.
fn spread<'a>(legs: impl Iterator<Item = &'a mut DrawnLeg>, height: f64) {
    let mut legs: Vec<&mut DrawnLeg> = legs.collect();
    legs.sort_by(|a, b| a.name_at[1].total_cmp(&b.name_at[1]));
    let mut lowest = NAME_HEIGHT / 2.0;
    for leg in &mut legs {
        leg.name_at[1] = leg.name_at[1].max(lowest);
        lowest = leg.name_at[1] + NAME_HEIGHT;
    }
    let mut highest = height - NAME_HEIGHT / 2.0;
    for leg in legs.iter_mut().rev() {
        leg.name_at[1] = leg.name_at[1].min(highest);
        highest = leg.name_at[1] - NAME_HEIGHT;
    }
}

/// Colour of a leg that is damaged with this probability.
fn mixed(damage: f64) -> String {
    let [from, to] = [Ink::Measured, Ink::Simulated].map(Ink::rgb);
    let parts = (0..3).map(|k| {
        let [from, to] = [from[k], to[k]].map(f64::from);
        format!("{:02X}", (from + damage * (to - from)).round() as u8)
    });
    format!("#{}", parts.collect::<String>())
}

fn described(legs: &[DrawnLeg]) -> String {
    let legs = legs.iter().map(|leg| {
        let lost = leg.links.iter().filter(|link| link.is_lost).count();
        let state = match lost {
            0 => "whole".to_string(),
            lost if lost == leg.links.len() => "lost".into(),
            1 => "without its outermost link".into(),
            lost => format!("without its {lost} outermost links"),
        };
        format!(
            "leg {}, {}, is {state}, damaged with a probability of {}",
            leg.number, leg.name, leg.probability
        )
    });
    let legs: Vec<String> = legs.collect();
    format!("Forward is up; {}.", legs.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn octopod() -> (Robot, Gait) {
        let robot = include_str!("../../../../data/robot/octopod.toml");
        let gait = include_str!("../../../../data/gait/octopod.toml");
        (
            Robot::from_toml(robot).unwrap(),
            Gait::from_toml(gait).unwrap(),
        )
    }

    #[test]
    fn every_leg_of_any_robot_is_there_and_lost_links_are_dashed() {
        for (robot, gait) in [(Robot::jethexa(), Gait::tripod()), octopod()] {
            let morphology = Morphology::healthy(&robot.layout())
                .without_leg(3)
                .with_remaining(1, 2);
            let damage: Vec<f64> = (0..robot.legs().len())
                .map(|leg| if leg == 3 { 1.0 } else { 0.0 })
                .collect();
            let picture = robot_from_above("robot", &robot, &gait, &morphology, &damage).unwrap();
            let svg = picture.svg();
            let links = robot.layout().total_links();
            assert_eq!(svg.matches("class=\"link").count(), links);
            assert_eq!(svg.matches("stroke-dasharray").count(), 4);
            for leg in robot.legs() {
                assert!(svg.contains(&format!(">{}<", leg.name)), "{}", leg.name);
            }
            assert!(svg.contains("leg 2, front right, is without its outermost link"));
            picture.png(1.0).unwrap();
        }
    }

    #[test]
    fn the_left_leg_is_on_the_left_and_the_front_is_up() {
        let robot = Robot::jethexa();
        let stance = JointCommands::new(&robot, &Gait::tripod(), 0.0).unwrap();
        let foot = |index: usize| {
            *joints_m(index, &robot.legs()[index], Some(&stance))
                .last()
                .unwrap()
        };
        // The nominal foot tips, seen from above.
        for (index, leg) in robot.legs().iter().enumerate() {
            let [x_m, y_m] = leg.nominal_foot_m;
            let [right, down] = foot(index);
            assert!((right + y_m).abs() < 1e-3 && (down + x_m).abs() < 1e-3);
        }
        assert!(foot(0)[0] < 0.0 && foot(0)[1] < 0.0);
    }

    #[test]
    fn names_of_many_legs_do_not_overlap() {
        let (robot, gait) = octopod();
        let whole = Morphology::healthy(&robot.layout());
        let picture = robot_from_above("robot", &robot, &gait, &whole, &[0.5; 8]).unwrap();
        let mut heights: Vec<f64> = picture
            .svg()
            .split("data-name-y=\"")
            .skip(1)
            .map(|rest| rest.split('"').next().unwrap().parse().unwrap())
            .collect();
        assert_eq!(heights.len(), 8);
        heights.sort_by(f64::total_cmp);
        for side in heights.chunks(2).collect::<Vec<_>>().windows(2) {
            assert!(side[1][0] - side[0][0] > NAME_HEIGHT - 1.0, "{heights:?}");
        }
    }
}
