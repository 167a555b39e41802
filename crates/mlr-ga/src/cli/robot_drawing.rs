//! A robot as SVG: from above, from the side, one leg with its angles, and when which foot swings.

use std::error::Error;

use anyhow::anyhow;
use mlr_ga::{stance_center_m, stance_joints_m};
use mlr_model::{Gait, JointAxis, Robot, kinematics::inverse};
use plotters::{
    coord::types::RangedCoordf64,
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

const WIDTH: u32 = 720;
const MARGIN: f64 = 0.16;
const BODY: RGBColor = RGBColor(0x59, 0x5f, 0x69);
const LINK: RGBColor = RGBColor(0x1f, 0x4e, 0x79);
const FOOT: RGBColor = RGBColor(0xd9, 0x6b, 0x0b);
const GROUND: RGBColor = RGBColor(0x9a, 0x9a, 0x9a);
const CENTER: RGBColor = RGBColor(0xb0, 0x1e, 0x2e);
const FONT: &str = "sans-serif";
/// Straight pieces of an arc.
const ARC: u32 = 24;

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
    in_plane(&all.collect::<Vec<_>>(), |plane| {
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
        for leg in &legs {
            plane.draw(&PathElement::new(leg.clone(), LINK.stroke_width(3)))?;
            for joint in leg {
                plane.draw(&Circle::new(*joint, 3, LINK.filled()))?;
            }
            if let Some(foot) = leg.last() {
                plane.draw(&Circle::new(*foot, 5, FOOT.filled()))?;
            }
        }
        for (foot, name) in names_of_feet(robot, &legs, from_above) {
            let away = if from_above && foot.1 > 0.0 {
                0.12
            } else {
                -0.12
            };
            text(
                plane,
                &name,
                (foot.0, foot.1 + away * scale),
                FOOT,
                HPos::Center,
            )?;
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
                text(plane, &format!(" {name}"), end, BLACK, HPos::Left)?;
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
                HPos::Center,
            )?;
        }
        Ok(())
    })
}

/// What stands beside each foot: from the side, one foot hides another.
fn names_of_feet(robot: &Robot, legs: &[Vec<Point>], from_above: bool) -> Vec<(Point, String)> {
    let mut named: Vec<(Point, String)> = Vec::new();
    for (number, foot) in (1..).zip(legs.iter().map(|leg| leg.last())) {
        let Some(foot) = foot else { continue };
        if from_above {
            named.push((*foot, robot.numbered_name(number)));
            continue;
        }
        let hidden = named
            .iter_mut()
            .find(|(other, _)| (other.0 - foot.0).abs() < 1e-3);
        match hidden {
            Some((_, name)) => *name += &format!(", {number}"),
            None => named.push((*foot, number.to_string())),
        }
    }
    named
}

/// The angles of a joint at zero and as it is, and what is said of it.
struct DrawnJoint {
    at: Point,
    /// Directions of the link from the level, at zero and as it is.
    pitch_rad: [f64; 2],
    length_m: f64,
    name: String,
}

/// So far from a point in this direction.
fn along(from: Point, length_m: f64, pitch_rad: f64) -> Point {
    (
        from.0 + length_m * libm::cos(pitch_rad),
        from.1 + length_m * libm::sin(pitch_rad),
    )
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
    let mut drawn_joints = Vec::new();
    for (link, angle_rad) in leg.links.iter().zip(&angles_rad) {
        let zero_rad = pitch_rad;
        let turns = match link.joint {
            JointAxis::Lift => {
                pitch_rad += angle_rad;
                "lift"
            }
            JointAxis::Yaw => "yaw",
        };
        drawn_joints.push(DrawnJoint {
            at,
            pitch_rad: [zero_rad, pitch_rad],
            length_m: link.length_m,
            name: format!("{}: {turns} {:.1}°", link.name, angle_rad.to_degrees()),
        });
        at = along(at, link.length_m, pitch_rad);
        joints.push(at);
    }
    let zeros = drawn_joints
        .iter()
        .map(|joint| along(joint.at, 0.6 * joint.length_m, joint.pitch_rad[0]));
    let points = joints.iter().copied().chain(zeros);
    let size_m: f64 = leg.links.iter().map(|link| link.length_m).sum();
    let title = format!("leg {}, angles of the stance", robot.numbered_name(1));
    let drawn = in_plane(&points.collect::<Vec<_>>(), |plane| {
        plane.draw(&PathElement::new(joints.clone(), LINK.stroke_width(4)))?;
        for joint in &drawn_joints {
            let [zero_rad, as_it_is_rad] = joint.pitch_rad;
            // Where the link would be with the joint at zero, and how far it is turned from there.
            let zero = along(joint.at, 0.6 * joint.length_m, zero_rad);
            plane.draw(&PathElement::new(vec![joint.at, zero], GROUND))?;
            let arc = (0..=ARC).map(|step| {
                let share = f64::from(step) / f64::from(ARC);
                let pitch_rad = zero_rad + share * (as_it_is_rad - zero_rad);
                along(joint.at, 0.3 * joint.length_m, pitch_rad)
            });
            plane.draw(&PathElement::new(arc.collect::<Vec<_>>(), CENTER))?;
            plane.draw(&Circle::new(joint.at, 4, LINK.filled()))?;
            // On the side of the joint where neither the link nor its zero is.
            let (up, place) = match as_it_is_rad - zero_rad {
                turned if turned > 0.0 => (-0.06, HPos::Left),
                turned if turned < 0.0 => (0.06, HPos::Right),
                _ => (0.06, HPos::Left),
            };
            let beside = (joint.at.0, joint.at.1 + up * size_m);
            text(plane, &joint.name, beside, BLACK, place)?;
        }
        plane.draw(&Circle::new(at, 5, FOOT.filled()))?;
        let below = (joints[0].0, at.1);
        text(plane, &title, below, BODY, HPos::Left)
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
    let drawn = in_plane(&corners, |plane| {
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
                (-0.04, low + 0.35 * row),
                BLACK,
                HPos::Right,
            )?;
        }
        for (share, name) in [
            (0.0, "0".to_string()),
            (1.0, format!("{} s", gait.period_s)),
        ] {
            text(plane, &name, (share, 0.6 * row), BLACK, HPos::Center)?;
        }
        text(
            plane,
            "orange: the foot swings",
            (0.5, 0.6 * row),
            FOOT,
            HPos::Center,
        )
    })?;
    Ok(Some(drawn))
}

/// A text whose place is its left end, its middle or its right end.
fn text(plane: &Plane<'_>, text: &str, at: Point, color: RGBColor, place: HPos) -> Drawn {
    let style = (FONT, 17).into_font().color(&color);
    let style = style.pos(Pos::new(place, VPos::Center));
    plane.draw(&Text::new(text.to_string(), at, style))?;
    Ok(())
}

/// An SVG in which a metre is as long in both directions, with room for all these points.
fn in_plane(points: &[Point], draw: impl FnOnce(&Plane<'_>) -> Drawn) -> anyhow::Result<String> {
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
