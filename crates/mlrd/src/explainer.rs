//! From a walk to its explanation.

use std::time::Instant;

use mlr_ga::{ExplainError, ExplainSettings, ExplanationReport, IdentifySettings, explain};
use mlr_model::Robot;
use mlr_residual::walk::{EvidenceSettings, Sensing};

use crate::{
    monitor::{Request, RequestNumber, WalkStretch},
    robot_model::RobotModel,
};

/// What an explanation came to.
#[derive(Debug)]
pub struct Explained {
    /// Which request it answers.
    pub number: RequestNumber,
    /// The report, or why there is none.
    pub report: Result<ExplanationReport, ExplainError>,
    /// The sensor's faults that the recording was rid of beforehand.
    pub corrected: Sensing,
}

/// Explains what this sensor recorded on a robot known like this.
pub(crate) fn explain_request(
    request: Request,
    sensing: Sensing,
    robot: &Robot,
    known: &RobotModel,
    settings: &EvidenceSettings,
) -> Explained {
    let Request { number, stretch } = request;
    Explained {
        number,
        report: report(&stretch.corrected(&sensing), robot, known, settings),
        corrected: sensing,
    }
}

fn report(
    stretch: &WalkStretch,
    robot: &Robot,
    known: &RobotModel,
    settings: &EvidenceSettings,
) -> Result<ExplanationReport, ExplainError> {
    let begin = Instant::now();
    let identify = IdentifySettings {
        walk_start: stretch.walk_start,
        from_s: Some(stretch.from_s),
        ..known.identification.clone()
    };
    let settings = ExplainSettings {
        identify: &identify,
        explanation: settings,
    };
    let explained = explain(&stretch.recording, known.model(robot), settings, &())?;
    Ok(ExplanationReport::of(
        known.source.clone(),
        known.identification.seed,
        explained,
        begin.elapsed(),
    ))
}

#[cfg(test)]
pub(crate) mod tests {
    use std::{
        collections::BTreeMap,
        sync::{Arc, mpsc},
        time::Duration,
    };

    use mlr_residual::walk::{
        AxisResidual, ByAxis, RemainingResidual, Reported, StretchErrors, StretchesS, TracedEffect,
        WalkExplanation,
    };

    use mlr_filter::{Axes, OrientationSeries};
    use mlr_ga::WalkStart;
    use mlr_imu::quality::LogQuality;
    use mlr_model::{Morphology, Robot};
    use mlr_recover::RecoverSettings;

    use super::*;
    use crate::{
        Settings,
        background::{Background, Done, Job},
        output::Messages,
    };

    const ERRORS: StretchErrors = StretchErrors {
        fit_deg: 0.5,
        validation_deg: 0.6,
        fit_axes_deg: [0.5; 3],
        validation_axes_deg: [0.6; 3],
    };

    fn by_axis() -> ByAxis {
        let axis = AxisResidual {
            standing_deg: None,
            walking_deg: 0.0,
            drift_dps: 0.0,
            harmonics: Vec::new(),
            group_deg: 0.0,
            with_heading_deg: None,
            irregular_deg: 0.1,
            irregular_hz: None,
            irregular_amplitude_deg: None,
            fast_deg: 0.05,
            whiteness_p_value: 0.5,
            independence_p_value: 0.5,
        };
        ByAxis {
            roll: axis.clone(),
            pitch: axis.clone(),
            yaw: axis,
        }
    }

    /// The explanation of a walk about which nothing is unusual.
    pub(crate) fn nothing_unusual() -> WalkExplanation {
        let healthy = Morphology::healthy(&Robot::jethexa().layout());
        WalkExplanation {
            morphology_before: healthy.clone(),
            morphology: healthy,
            damaged_legs: Vec::new(),
            effects: Vec::new(),
            unexplained: false,
            error_before: ERRORS,
            error_calibrated: ERRORS,
            error_after: ERRORS,
            noise_floor_deg: 0.4,
            effect_probability: [("none".into(), 0.9), ("unknown".into(), 0.02)].into(),
            alternatives: Vec::new(),
            nuisance: BTreeMap::new(),
            candidates: Vec::new(),
            residual: RemainingResidual {
                axis: "roll",
                frequency_hz: None,
                amplitude_deg: None,
                locked_to_gait: false,
                body_torque_nm: None,
                remaining_deg: 0.2,
                usual_deg: 0.3,
                explains: "nothing more than usual".into(),
            },
            residual_before: by_axis(),
            residual_after: by_axis(),
            stretches_s: StretchesS {
                fit: [1.0, 7.0],
                validation: [7.0, 10.0],
            },
            warnings: Vec::new(),
        }
    }

    /// The explanation of a walk whose sensor has one fault.
    pub(crate) fn faulty_sensor(kind: &str, parameters: &[(&str, f64)]) -> WalkExplanation {
        let reported = |(name, value): &(&str, f64)| (name.to_string(), Reported::Quantity(*value));
        WalkExplanation {
            effects: vec![TracedEffect {
                kind: kind.into(),
                parameters: parameters.iter().map(reported).collect(),
                interval_95: BTreeMap::new(),
                at_bound: Vec::new(),
                undetermined: Vec::new(),
                explains: "what the sensor adds to the walk".into(),
                probability: 0.95,
                rivals: Vec::new(),
            }],
            ..nothing_unusual()
        }
    }

    #[test]
    fn a_report_has_the_fields_of_its_schema() {
        let explanation = faulty_sensor("imu_misalignment", &[("roll_deg", 2.0)]);
        let report = ExplanationReport::new(
            "/dev/imu".into(),
            1,
            explanation,
            LogQuality::default(),
            Duration::from_millis(9500),
        );
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(json["schema"], "mlr.explanation/1");
        assert_eq!(json["log"], "/dev/imu");
        assert_eq!(json["seed"], 1);
        assert_eq!(json["effects"][0]["parameters"]["roll_deg"], 2.0);
        assert_eq!(json["unexplained"], false);
        assert_eq!(json["elapsed_s"], 9.5);
    }

    #[test]
    fn every_request_in_turn_is_answered_with_what_was_corrected() {
        let known = Arc::new(RobotModel::new(&Settings::default(), "imu".into()).unwrap());
        let robot = Arc::clone(&known.robot);
        let (send, answers) = mpsc::channel();
        let messages = Messages::to_stderr().unwrap();
        let explanation = EvidenceSettings::default();
        let background = Background::new(
            1,
            known,
            explanation,
            RecoverSettings::default(),
            0.1,
            &messages,
            send,
        )
        .unwrap();
        let times_s: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.005).collect();
        // A robot at rest, with a little noise.
        let still: Vec<f64> = (0..1000)
            .map(|i| f64::from(i * 7919 % 1009) * 1e-7)
            .collect();
        let recording = OrientationSeries::new(times_s, Axes::from_fn(|_| still.clone()));
        let request = Request {
            number: RequestNumber::default(),
            stretch: WalkStretch {
                recording: recording.unwrap().into(),
                walk_start: WalkStart::FoundInRecording,
                motion_start_s: None,
                from_s: 2.0,
            },
        };
        for scale in [1.0, 1.1] {
            let sensing = Sensing {
                scale,
                ..Sensing::default()
            };
            assert!(background.ask(Job::Explain(
                Box::new(request.clone()),
                sensing,
                Arc::clone(&robot)
            )));
            // Half an hour ends a hang: threads of the lowest priority may be kept waiting.
            let done = answers.recv_timeout(Duration::from_secs(1800)).unwrap();
            let Done::Explained(explained) = done else {
                panic!("{done:?}");
            };
            assert_eq!(explained.corrected, sensing);
            let error = explained.report.unwrap_err();
            assert!(error.to_string().contains("no motion"), "{error}");
        }
    }
}
