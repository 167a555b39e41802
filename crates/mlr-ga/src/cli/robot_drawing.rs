//! A robot as SVG: from above, from the side, one leg with its angles, and when which foot swings.

use std::error::Error;

use anyhow::anyhow;
use mlr_ga::{stance_center_m, stance_joints_m};
use mlr_model::{Gait, JointAxis, Robot, kinematics::inverse};
use plotters::{coord::types::RangedCoordf64, prelude::*};

const WIDTH: u32 = 720;
const MARGIN: f64 = 0.12;
const BODY: RGBColor = RGBColor(0x59, 0x5f, 0x69);
const LINK: RGBColor = RGBColor(0x1f, 0x4e, 0x79);
const FOOT: RGBColor = RGBColor(0xd9, 0x6b, 0x0b);
const GROUND: RGBColor = RGBColor(0x9a, 0x9a, 0x9a);
const CENTER: RGBColor = RGBColor(0xb0, 0x1e, 0x2e);
const FONT: &str = "sans-serif";

type Drawn = Result<(), Box<dyn Error>>;
type Plane<'a> = DrawingArea<SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
/// A point of a drawing: to the right and upward, in metres.
type Point = (f64, f64);

/// All drawings, each with the name of its file.
pub(super) fn all(robot: &Robot, gait: &Gait) -> anyhow::Result<Vec<(&'static str, String)>> {
    let mut drawings = vec![
        (
            "above.svg",
            projected(robot, gait, &|[x, y, _]| (-y, x), true)?,
        ),
        (
            "side.svg",
            projected(robot, gait, &|[x, _, z]| (x, z), false)?,
        ),
    ];
    if let Some(leg) = leg_angles(robot, gait)? {
        drawings.push(("leg1.svg", leg));
    }
    if let Some(phases) = phases(robot, gait)? {
        drawings.push(("phases.svg", phases));
    }
    Ok(drawings)
}

/// The robot in its stance, seen along an axis of the body.
fn projected(
    robot: &Robot,
    gait: &Gait,
    onto: &dyn Fn([f64; 3]) -> Point,
    from_above: bool,
) -> anyhow::Result<String> {
    let legs: Vec<Vec<Point>> = robot
        .legs()
        .iter()
        .enumerate()
        .map(|(index, leg)| {
            let joints = stance_joints_m(robot, gait, index).unwrap_or_else(|| {
                // Out of reach: where it should stand.
                let [x, y] = leg.nominal_foot_m;
                let down = gait.feet().map_or(0.0, |feet| -feet.body_height_m);
                vec![leg.hip_m.into(), [x, y, down]]
            });
            joints.into_iter().map(onto).collect()
        })
        .collect();
    let half = robot.body().size_m / 2.0;
    let corners = [
        (1.0, 1.0),
        (1.0, -1.0),
        (-1.0, -1.0),
        (-1.0, 1.0),
        (1.0, 1.0),
    ];
    let body: Vec<Point> = corners
        .iter()
        .map(|(a, b)| match from_above {
            true => onto([a * half.x, b * half.y, 0.0]),
            false => onto([a * half.x, 0.0, b * half.z]),
        })
        .collect();
    let all = legs.iter().flatten().chain(&body).copied();
    let scale = half.norm();
    in_plane(all.collect(), |plane| {
        plane.draw(&Polygon::new(body.clone(), BODY.mix(0.25)))?;
        plane.draw(&PathElement::new(body.clone(), BODY))?;
        if from_above {
            // Convex or not: feet in the order of their direction.
            let mut feet: Vec<Point> = legs.iter().filter_map(|leg| leg.last().copied()).collect();
            feet.sort_by(|a, b| libm::atan2(a.1, a.0).total_cmp(&libm::atan2(b.1, b.0)));
            feet.extend(feet.first().copied());
            plane.draw(&PathElement::new(feet, GROUND))?;
        } else if let Some(feet) = gait.feet() {
            let (left, right) = (-10.0, 10.0);
            let ground = vec![(left, -feet.body_height_m), (right, -feet.body_height_m)];
            plane.draw(&PathElement::new(ground, GROUND))?;
        }
        for (number, leg) in (1..).zip(&legs) {
            plane.draw(&PathElement::new(leg.clone(), LINK.stroke_width(3)))?;
            for joint in leg {
                plane.draw(&Circle::new(*joint, 3, LINK.filled()))?;
            }
            if let Some(foot) = leg.last() {
                plane.draw(&Circle::new(*foot, 5, FOOT.filled()))?;
                let name = match from_above {
                    true => robot.numbered_name(number),
                    false => number.to_string(),
                };
                text(plane, &name, (foot.0, foot.1 - 0.08 * scale), FOOT)?;
            }
        }
        let axes = [
            ([scale, 0.0, 0.0], "x"),
            ([0.0, scale, 0.0], "y"),
            ([0.0, 0.0, scale], "z"),
        ];
        let origin = onto([0.0; 3]);
        for (end, name) in axes {
            let end = onto(end.map(|along| 0.5 * along));
            if end != origin {
                plane.draw(&PathElement::new(vec![origin, end], BLACK))?;
                text(plane, name, end, BLACK)?;
            }
        }
        if let Some(center) = stance_center_m(robot, gait) {
            let center = onto(center);
            plane.draw(&Circle::new(center, 5, CENTER.stroke_width(2)))?;
            text(
                plane,
                "centre of mass",
                (center.0, center.1 - 0.1 * scale),
                CENTER,
            )?;
        }
        Ok(())
    })
}

/// The first leg in its stance, its lifting joints seen from the side: along its plane, and up.
fn leg_angles(robot: &Robot, gait: &Gait) -> anyhow::Result<Option<String>> {
    let Some(leg) = robot.legs().first() else {
        return Ok(None);
    };
    let Some(target) = gait.foot_target(0, leg, 0.0) else {
        return Ok(None);
    };
    let Ok(angles_rad) = inverse(leg, target) else {
        return Ok(None);
    };
    // As if its joints about the vertical were at zero.
    let mut at: Point = (0.0, 0.0);
    let mut pitch_rad = 0.0;
    let mut joints = vec![at];
    let mut labels = Vec::new();
    for (link, angle_rad) in leg.links.iter().zip(&angles_rad) {
        let zero = (
            at.0 + 0.6 * link.length_m * libm::cos(pitch_rad),
            at.1 + 0.6 * link.length_m * libm::sin(pitch_rad),
        );
        let turns = match link.joint {
            JointAxis::Lift => {
                pitch_rad += angle_rad;
                "lift"
            }
            JointAxis::Yaw => "yaw",
        };
        let name = format!("{}: {turns} {:.1}°", link.name, angle_rad.to_degrees());
        labels.push((at, zero, name));
        at = (
            at.0 + link.length_m * libm::cos(pitch_rad),
            at.1 + link.length_m * libm::sin(pitch_rad),
        );
        joints.push(at);
    }
    let points = joints
        .iter()
        .copied()
        .chain(labels.iter().map(|(_, zero, _)| *zero));
    let title = format!("leg {}, angles of the stance", robot.numbered_name(1));
    let drawn = in_plane(points.collect(), |plane| {
        plane.draw(&PathElement::new(joints.clone(), LINK.stroke_width(4)))?;
        for (joint, zero, name) in &labels {
            // Where the link would be with the joint at zero.
            plane.draw(&PathElement::new(vec![*joint, *zero], GROUND))?;
            plane.draw(&Circle::new(*joint, 4, LINK.filled()))?;
            text(plane, name, (joint.0, joint.1 + 0.012), BLACK)?;
        }
        plane.draw(&Circle::new(at, 5, FOOT.filled()))?;
        text(plane, &title, (joints[0].0, joints[0].1 + 0.03), BODY)
    })?;
    Ok(Some(drawn))
}

/// When which foot swings, over one cycle.
fn phases(robot: &Robot, gait: &Gait) -> anyhow::Result<Option<String>> {
    let Some(feet) = gait.feet() else {
        return Ok(None);
    };
    let legs = feet.phase_offsets.len();
    let row = 0.1;
    let corners = vec![(-0.35, 0.0), (1.0, row * (legs + 1) as f64)];
    let drawn = in_plane(corners, |plane| {
        for (leg, offset) in feet.phase_offsets.iter().enumerate() {
            let low = row * (legs - leg) as f64;
            let bar = |from: f64, to: f64, style: ShapeStyle| {
                plane.draw(&Rectangle::new([(from, low), (to, low + 0.7 * row)], style))
            };
            bar(0.0, 1.0, GROUND.mix(0.35).filled())?;
            // It swings while time + offset is within the first share of the cycle.
            let from = 1.0 - offset;
            for begin in [from - 1.0, from] {
                let (from, to) = (begin.max(0.0), (begin + feet.swing_fraction).min(1.0));
                if from < to {
                    bar(from, to, FOOT.filled())?;
                }
            }
            text(
                plane,
                &robot.numbered_name(leg + 1),
                (-0.3, low + 0.6 * row),
                BLACK,
            )?;
        }
        for (share, name) in [
            (0.0, "0".to_string()),
            (0.9, format!("{} s", gait.period_s)),
        ] {
            text(plane, &name, (share, 0.7 * row), BLACK)?;
        }
        text(plane, "orange: the foot swings", (0.25, 0.7 * row), FOOT)
    })?;
    Ok(Some(drawn))
}

fn text(plane: &Plane<'_>, text: &str, at: Point, color: RGBColor) -> Drawn {
    let style = (FONT, 13).into_font().color(&color);
    plane.draw(&Text::new(text.to_string(), at, style))?;
    Ok(())
}

/// An SVG in which a metre is as long in both directions, with room for all these points.
fn in_plane(points: Vec<Point>, draw: impl FnOnce(&Plane<'_>) -> Drawn) -> anyhow::Result<String> {
    let bounds = |of: fn(&Point) -> f64| {
        let values = points.iter().map(of);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        (low, values.fold(f64::NEG_INFINITY, f64::max))
    };
    let ((left, right), (low, high)) = (bounds(|point| point.0), bounds(|point| point.1));
    let margin = MARGIN * (right - left).max(high - low).max(1e-3);
    let (wide, tall) = (right - left + 2.0 * margin, high - low + 2.0 * margin);
    let height = (f64::from(WIDTH) * tall / wide)
        .clamp(120.0, 4000.0)
        .round() as u32;
    let mut svg = String::new();
    let drawn = || -> Drawn {
        let area = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        area.fill(&WHITE)?;
        let plane = area.apply_coord_spec(Cartesian2d::<RangedCoordf64, RangedCoordf64>::new(
            left - margin..right + margin,
            low - margin..high + margin,
            (0..WIDTH as i32, height as i32..0),
        ));
        draw(&plane)?;
        plane.present()?;
        Ok(())
    };
    drawn().map_err(|error| anyhow!("drawing: {error}"))?;
    Ok(svg)
}
