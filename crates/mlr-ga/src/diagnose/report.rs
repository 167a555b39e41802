//! What a diagnosis motion says of itself, as JSON.

use serde::Serialize;

use super::{DiagnosisMotion, OpenQuestion, OpenRobot};
use crate::ReportedSegment;

/// Version of the JSON form.
const SCHEMA: &str = "mlr.diagnosis/1";

/// What is open, and what is to be expected of the motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DiagnosisReport {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// What is to be told apart, most probable first.
    pub open: Vec<OpenRobot>,
    /// Whether the log leaves nothing open that is worth a motion: there is none then.
    pub sure: bool,
    /// Entropy by the logs of the robot and of what its lost links have become.
    pub entropy_before_nats: f64,
    /// Expected entropy after the motion; that before where there is none.
    pub entropy_after_nats: f64,
    /// How long the motion lasts; 0 where there is none.
    pub duration_s: f64,
    /// What it is made of, in order. `gain_nats` is what each adds to those before it.
    pub segments: Vec<ReportedSegment>,
    /// How many segments were looked at.
    pub candidates: usize,
    /// How many of them keep the bounds.
    pub bounded: usize,
}

impl DiagnosisReport {
    /// The report of a motion, or of a question that needs none.
    pub fn new(question: &OpenQuestion, motion: Option<&DiagnosisMotion>) -> Self {
        let before_nats = question.entropy_nats();
        let chosen = motion.map_or(&[][..], |motion| &motion.segments);
        let mut left_nats = before_nats;
        let segments = chosen.iter().map(|segment| {
            let gain_nats = left_nats - segment.entropy_nats;
            left_nats = segment.entropy_nats;
            ReportedSegment::new(&segment.motion, segment.duration_s, gain_nats)
        });
        let segments = segments.collect();
        let gait = motion.and_then(|motion| motion.gait.as_ref());
        Self {
            schema: SCHEMA,
            open: question.robots.clone(),
            sure: question.is_sure(),
            entropy_before_nats: before_nats,
            entropy_after_nats: left_nats,
            duration_s: gait
                .and_then(mlr_model::Gait::duration_s)
                .unwrap_or_default(),
            segments,
            candidates: motion.map_or(0, |motion| motion.candidates),
            bounded: motion.map_or(0, |motion| motion.bounded),
        }
    }
}
