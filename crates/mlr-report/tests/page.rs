//! Pages of made-up walks: what they show, and what they do with hostile texts.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_filter::{
    DamageDetector, DetectorSettings, FilterSettings, FourierFilter, OrientationSeries,
    SamplingLimits, Window,
};
use mlr_model::{Gait, Morphology, Outcome, Robot, SimulationSettings, Simulator};
use mlr_report::{
    Manifest, Report, Walk,
    answer::{Explanation, Identification},
    plots::{DetectorRun, Footfalls, WalkSignals},
};
use serde_json::Value;

const IDENTIFICATION: &str = include_str!("answers/legs2-3-lost.identification.json");
const EXPLANATION: &str = include_str!("answers/undeclared-c.explanation.json");
const HOSTILE: &str = "<script>alert(1)</script>\"'&{{ 1 }}";

fn walk(lost: &str) -> OrientationSeries {
    let robot = Robot::jethexa();
    let morphology = Morphology::parse_legs_lost(lost, &robot.layout()).unwrap();
    let settings = SimulationSettings {
        stand_s: 1.0,
        duration_s: 5.5,
        ..Default::default()
    };
    let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
    let Outcome::Walked(walk) = simulator.simulate(&morphology) else {
        panic!("diverged");
    };
    walk.orientation
}

fn signals(measured: &OrientationSeries, simulated: &OrientationSeries) -> WalkSignals {
    let window = Window {
        start_s: measured.times_s()[0] + 1.0,
        duration_s: 5.0,
    };
    let filter = FilterSettings::default();
    let mut fourier = FourierFilter::new(filter, window.duration_s).unwrap();
    let [measured, simulated] =
        [measured, simulated].map(|walk| window.cut(walk, &SamplingLimits::default()).unwrap());
    WalkSignals {
        measured_filtered: fourier.condition(&measured),
        simulated_filtered: fourier.condition(&simulated),
        measured,
        simulated,
        filter,
        duration_s: window.duration_s,
    }
}

/// The page of a robot that lost legs 2 and 3, after `change` of what it is made of.
fn page(
    identification: &Value,
    explanation: Option<&Explanation>,
    robot: &Robot,
    change: impl FnOnce(&mut Report<'_>),
) -> String {
    let found: Identification = serde_json::from_value(identification.clone()).unwrap();
    let orientation = walk("2,3");
    let mut detector = DamageDetector::new(DetectorSettings::default()).unwrap();
    let angles = orientation.angles_rad();
    let times_s = orientation.times_s().iter().enumerate();
    let assessments: Vec<_> = times_s
        .filter_map(|(k, t)| detector.push(*t, angles.roll[k], angles.pitch[k]).unwrap())
        .collect();
    let gait = Gait::tripod();
    let mut report = Report {
        robot,
        identification: &found,
        walks: vec![Walk {
            log: "walk.csv".into(),
            sha256: Some("00".repeat(32)),
            gait: &gait,
            signals: signals(&orientation, &walk("3")),
            error_deg: 0.31,
            detector: Ok(DetectorRun {
                orientation: &orientation,
                assessments: &assessments,
                threshold_deg: 5.0,
                max_fluctuation_deg: 9.1,
                motion_start_s: Some(0.0),
                damage_s: assessments
                    .iter()
                    .find(|one| one.damaged)
                    .map(|one| one.time_s),
            }),
        }],
        explanation,
        footfalls: None,
        manifest: Manifest::default(),
    };
    change(&mut report);
    let page = report.page().unwrap();
    if let Some(folder) = std::env::var_os("MLR_REPORT_PAGES") {
        let name = std::thread::current()
            .name()
            .unwrap_or("page")
            .replace(':', "-");
        std::fs::write(std::path::Path::new(&folder).join(name + ".html"), &page).unwrap();
    }
    page
}

fn identification() -> Value {
    serde_json::from_str(IDENTIFICATION).unwrap()
}

#[test]
fn a_page_needs_no_other_file_and_says_what_it_lacks() {
    let page = page(&identification(), None, &Robot::jethexa(), |_| {});
    for shown in [
        "Damaged: leg 2 (front right) and leg 3 (middle left)",
        "111 100 000 111 111 111",
        "<h2 id=\"missing-head\">Not computed</h2>",
        "mlr-ga explain LOG",
        &"00".repeat(32),
    ] {
        assert!(page.contains(shown), "{shown}");
    }
    for foreign in [
        "<script",
        "<link rel=\"stylesheet",
        "src=",
        "@import",
        "url(",
    ] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    let links = page.split("href=\"").skip(1);
    for link in links.map(|rest| rest.split('"').next().unwrap()) {
        assert!(link.starts_with('#') || link == "data:,", "{link}");
    }
    assert!(page.len() < 1_000_000, "{} bytes", page.len());
}

#[test]
fn every_picture_has_a_name_of_its_own_for_those_who_cannot_see_it() {
    let explanation: Explanation = serde_json::from_str(EXPLANATION).unwrap();
    let robot = Robot::jethexa();
    let whole = Morphology::healthy(&robot.layout());
    let footfalls = Footfalls::of(&robot, &Gait::tripod(), &whole).unwrap();
    let page = page(&identification(), Some(&explanation), &robot, |report| {
        report.footfalls = footfalls;
    });
    let pictures: Vec<&str> = page.split("<svg ").skip(1).collect();
    assert_eq!(pictures.len(), 8);
    let mut names = Vec::new();
    for picture in pictures {
        let (head, rest) = picture.split_once('>').unwrap();
        assert!(head.contains("role=\"img\""), "{head}");
        let labels = head.split("aria-labelledby=\"").nth(1).unwrap();
        for label in labels.split('"').next().unwrap().split(' ') {
            assert!(rest.contains(&format!("id=\"{label}\">")), "{label}");
            names.push(label.to_string());
        }
    }
    let all = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), all);
    assert!(!page.contains("Not computed"));
    for shown in ["IMU misalignment", "with 95 %", "What remains", "Footfalls"] {
        assert!(page.contains(shown), "{shown}");
    }
}

#[test]
fn texts_from_files_stay_texts() {
    let mut found = identification();
    for field in ["description", "log"] {
        found[field] = HOSTILE.into();
    }
    found["method"] = HOSTILE.into();
    found["search"] = HOSTILE.into();
    found["warnings"] = vec![HOSTILE].into();
    found["log_quality"]["findings"] = serde_json::json!([{
        "kind": "held", "severity": "note", "from_s": 0.0, "to_s": 1.0,
        "reason": HOSTILE, "cure": HOSTILE
    }]);
    let mut explanation: Value = serde_json::from_str(EXPLANATION).unwrap();
    explanation["effects"][0]["kind"] = HOSTILE.into();
    explanation["effects"][0]["explains"] = HOSTILE.into();
    explanation["effects"][0]["parameters"][HOSTILE] = 1.0.into();
    explanation["effect_probability"][HOSTILE] = 0.5.into();
    explanation["residual"]["explains"] = HOSTILE.into();
    explanation["warnings"] = vec![HOSTILE].into();
    let explanation: Explanation = serde_json::from_value(explanation).unwrap();
    let described = Robot::JETHEXA_TOML
        .replace("\"front left\"", "'<script>alert(2)</script>'")
        .replacen("name = \"", "name = \"<script>", 1);
    let robot = Robot::from_toml(&described).unwrap();
    let page = page(&found, Some(&explanation), &robot, |report| {
        report.walks[0].log = HOSTILE.into();
        report.walks[0].detector = Err(HOSTILE.into());
        report.manifest = Manifest {
            program: HOSTILE.into(),
            identification: HOSTILE.into(),
            robot_file: Some(HOSTILE.into()),
        };
    });
    assert!(!page.to_lowercase().contains("<script"));
    // Everywhere, and once each.
    assert!(page.matches("alert(1)").count() >= 12);
    assert!(page.contains("alert(2)"));
    assert!(page.contains("{{ 1 }}"));
}

#[test]
fn numbers_that_make_no_sense_leave_a_page() {
    let mut found = identification();
    found["leg_damage_probability"] = serde_json::json!([-1.0, 2.0, 1e300]);
    found["cost_per_generation"] = serde_json::json!([null]);
    found["probability"] = (-0.5).into();
    let page = page(&found, None, &Robot::jethexa(), |_| {});
    assert!(page.contains("not known"));
    assert!(page.contains("it has no generations"));
    assert!(!page.contains("NaN"));
}

#[test]
fn an_endless_answer_makes_no_endless_page() {
    let mut found = identification();
    found["cost_per_generation"] = vec![1.25; 200_000].into();
    let alternative = found["alternatives"][0].clone();
    found["alternatives"] = vec![alternative; 2_000].into();
    let page = page(&found, None, &Robot::jethexa(), |_| {});
    assert!(page.len() < 1_000_000, "{} bytes", page.len());
}
