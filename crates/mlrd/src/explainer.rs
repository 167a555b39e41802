//! Explains when nothing else is to be done.

use std::{
    sync::{
        Arc,
        mpsc::{self, Receiver, Sender},
    },
    thread,
    time::Instant,
};

use mlr_ga::{ExplainError, ExplainSettings, ExplanationReport, IdentifySettings, explain};
use mlr_residual::walk::{EvidenceSettings, Sensing};

use crate::{
    monitor::{Request, RequestNumber},
    output::Messages,
    priority,
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

/// Explains walks one after the other, on one thread of the lowest priority.
pub struct Explainer {
    requests: Sender<(Request, Sensing)>,
}

/// What explains.
struct Bench {
    pool: rayon::ThreadPool,
    known: Arc<RobotModel>,
    explanation: EvidenceSettings,
}

impl Explainer {
    /// An explainer that answers to `done`.
    ///
    /// # Errors
    /// When no thread is to be had.
    pub fn new(
        known: Arc<RobotModel>,
        explanation: EvidenceSettings,
        messages: Messages,
        done: Sender<Explained>,
    ) -> anyhow::Result<Self> {
        let bench = Bench {
            // Everything parallel within an explanation stays in this pool.
            pool: rayon::ThreadPoolBuilder::new()
                .num_threads(1)
                .thread_name(|index| format!("explain-{index}"))
                .start_handler(move |_| {
                    // An explanation at ordinary priority is better than none.
                    if let Err(error) = priority::lower_this_thread() {
                        messages.say(&format!("explanations at ordinary priority: {error}"));
                    }
                })
                .build()?,
            known,
            explanation,
        };
        let (requests, to_explain) = mpsc::channel();
        thread::Builder::new()
            .name("explain".into())
            .spawn(move || bench.serve(&to_explain, &done))?;
        Ok(Self { requests })
    }

    /// Asks for an explanation of what this sensor recorded; the answer comes when it is
    /// done, or never where a later walk was asked about before its turn came. Whether
    /// there is anybody to ask.
    #[must_use]
    pub fn explain(&self, request: Request, sensing: Sensing) -> bool {
        self.requests.send((request, sensing)).is_ok()
    }
}

impl Bench {
    fn serve(&self, to_explain: &Receiver<(Request, Sensing)>, done: &Sender<Explained>) {
        while let Ok(next) = to_explain.recv() {
            let (request, corrected) = to_explain.try_iter().last().unwrap_or(next);
            let number = request.number;
            let report = self
                .pool
                .install(|| self.report(&request.corrected(&corrected)));
            let explained = Explained {
                number,
                report,
                corrected,
            };
            if done.send(explained).is_err() {
                return;
            }
        }
    }

    fn report(&self, request: &Request) -> Result<ExplanationReport, ExplainError> {
        let begin = Instant::now();
        let known = &self.known;
        let identify = IdentifySettings {
            walk_start: request.walk_start,
            from_s: Some(request.from_s),
            ..known.identification.clone()
        };
        let settings = ExplainSettings {
            identify: &identify,
            explanation: &self.explanation,
        };
        let explained = explain(
            &request.recording.clone().into(),
            known.model(),
            settings,
            &(),
        )?;
        Ok(ExplanationReport::new(
            known.source.clone(),
            known.identification.seed,
            explained.explanation,
            explained.identification.log_quality,
            begin.elapsed(),
        ))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::{collections::BTreeMap, time::Duration};

    use mlr_residual::walk::{
        AxisResidual, ByAxis, RemainingResidual, Reported, StretchErrors, StretchesS, TracedEffect,
        WalkExplanation,
    };

    use mlr_filter::{Axes, OrientationSeries};
    use mlr_ga::WalkStart;
    use mlr_imu::quality::LogQuality;
    use mlr_model::{Morphology, Robot};

    use super::*;
    use crate::Settings;

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
        let known = RobotModel::new(&Settings::default(), "imu".into()).unwrap();
        let (send, answers) = mpsc::channel();
        let messages = Messages::to_stderr().unwrap();
        let explanation = EvidenceSettings::default();
        let explainer = Explainer::new(Arc::new(known), explanation, messages, send).unwrap();
        let times_s: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.005).collect();
        // A robot at rest, with a little noise.
        let still: Vec<f64> = (0..1000)
            .map(|i| f64::from(i * 7919 % 1009) * 1e-7)
            .collect();
        let request = Request {
            number: RequestNumber::default(),
            recording: OrientationSeries::new(times_s, Axes::from_fn(|_| still.clone())).unwrap(),
            walk_start: WalkStart::FoundInRecording,
            from_s: 2.0,
        };
        for scale in [1.0, 1.1] {
            let sensing = Sensing {
                scale,
                ..Sensing::default()
            };
            assert!(explainer.explain(request.clone(), sensing));
            // Half an hour ends a hang: threads of the lowest priority may be kept waiting.
            let explained = answers.recv_timeout(Duration::from_secs(1800)).unwrap();
            assert_eq!(explained.corrected, sensing);
            let error = explained.report.unwrap_err();
            assert!(error.to_string().contains("no motion"), "{error}");
        }
    }
}
