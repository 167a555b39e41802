use crate::report::Report;

/// Something that a page could show, and does not.
pub(crate) struct Missing {
    pub(crate) what: &'static str,
    pub(super) why: String,
    /// What to type for it.
    pub(super) cure: Option<&'static str>,
}

/// What was not computed.
pub(crate) fn of(report: &Report<'_>) -> Vec<Missing> {
    let mut missing = Vec::new();
    if report.explanation.is_none() {
        missing.push(Missing {
            what: "What else is wrong with the robot",
            why: "no explanation was given. Payloads, weak legs, tilted sensors and the like were not \
                  looked for."
                .into(),
            cure: Some(
                "mlr-ga explain LOG -o explanation.json && mlr-ga report LOG --explanation explanation.json …",
            ),
        });
    }
    if report.footfalls.is_none() {
        missing.push(Missing {
            what: "A gait that walks again",
            why: "no recovery gait was given.".into(),
            cure: Some(
                "mlr-ga recover LOG -o gait.toml && mlr-ga report LOG --recovery gait.toml …",
            ),
        });
    }
    let course = &report.identification.cost_per_generation;
    if course.iter().all(Option::is_none) {
        missing.push(Missing {
            what: "The best cost per generation",
            why: "the search was no genetic algorithm: it has no generations.".into(),
            cure: None,
        });
    }
    for walk in &report.walks {
        if let Err(reason) = &walk.detector {
            missing.push(Missing {
                what: "When damage struck",
                why: format!("the damage detector has no answer: {reason}."),
                cure: None,
            });
        }
    }
    missing
}
