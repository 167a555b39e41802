//! The atlas, through the program: a quadruped's, which is small.

use std::{fs, sync::LazyLock};

use crate::program::Folder;
use serde_json::Value;

pub(crate) const QUADRUPED: &str = include_str!("../../../mlr-model/tests/quadruped.toml");

pub(crate) const CRAWL: &str = r#"
name = "crawl"
period_s = 1.0
ramp_s = 1.0
stride_m = 0.04
lift_m = 0.02
body_height_m = 0.16
swing_fraction = 0.25
phase_offsets = [0.0, 0.5, 0.25, 0.75]
"#;

/// A quadruped, its gait, an atlas of both under two variations of the model, and a
/// log of the robot without its first leg.
struct Scene {
    folder: Folder,
    robot: String,
    gait: String,
    config: String,
    atlas: String,
    log: String,
}

/// The atlas of every scene, which takes ten seconds to build.
static ATLAS: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let scene = Scene::without_atlas();
    let build = scene.with_files(&["atlas", "build", "-o", &scene.atlas]);
    let said = scene.folder.succeeds(&build);
    assert!(said.contains("MB"), "{said}");
    fs::read(&scene.atlas).unwrap()
});

impl Scene {
    fn new() -> Self {
        let scene = Self::without_atlas();
        fs::write(&scene.atlas, &*ATLAS).unwrap();
        scene.simulate("1", &scene.gait, &scene.log);
        scene
    }

    fn without_atlas() -> Self {
        let folder = Folder::new();
        let robot = folder.write("robot.toml", QUADRUPED);
        let gait = folder.write("gait.toml", CRAWL);
        let config = folder.write("config.toml", "variations = [{}, { friction = 0.7 }]\n");
        let atlas = folder.path("crawl.atlas");
        let log = folder.path("log.csv");
        Self {
            folder,
            robot,
            gait,
            config,
            atlas,
            log,
        }
    }

    /// Writes six seconds of its walk without these legs.
    fn simulate(&self, legs_lost: &str, gait: &str, log: &str) {
        let without = ["simulate", "--legs-lost", legs_lost, "--walk-s", "6"];
        let model = ["--robot", &self.robot, "--gait", gait, "-o", log];
        self.folder.succeeds(&[&without[..], &model].concat());
    }

    fn with_files<'a>(&'a self, arguments: &[&'a str]) -> Vec<&'a str> {
        let mut all = arguments.to_vec();
        all.extend([
            "--robot",
            &self.robot,
            "--gait",
            &self.gait,
            "--config",
            &self.config,
        ]);
        all
    }

    fn identify<'a>(&'a self, more: &[&'a str]) -> Vec<&'a str> {
        let mut arguments = self.with_files(&["identify", &self.log, "--json"]);
        arguments.extend(more);
        arguments
    }
}

#[test]
fn answers_as_the_exact_search_and_is_refused_when_it_does_not_fit() {
    let scene = Scene::new();
    let answer = |more: &[&str]| -> Value {
        serde_json::from_str(&scene.folder.succeeds(&scene.identify(more))).unwrap()
    };
    let exact = answer(&["--search", "exact"]);
    let instant = answer(&["--atlas", &scene.atlas]);
    assert_eq!(instant["search"], "atlas");
    assert_eq!(exact["damaged_legs"], Value::from(vec![1]));
    assert_eq!(instant["morphology"], exact["morphology"]);
    let probabilities = |answer: &Value| -> Vec<f64> {
        let legs = answer["leg_damage_probability"].as_array().unwrap();
        legs.iter().map(|p| p.as_f64().unwrap()).collect()
    };
    for (ours, theirs) in probabilities(&instant).iter().zip(probabilities(&exact)) {
        assert!((ours - theirs).abs() < 0.01, "{instant} {exact}");
    }
    let genetic = answer(&["--atlas", &scene.atlas, "--search", "ga"]);
    assert_eq!(genetic["morphology"], exact["morphology"]);

    let refused = |arguments: &[&str], told: &[&str]| {
        scene.folder.fails(&scene.identify(arguments), 2, told);
    };
    refused(&["--search", "atlas"], &["no atlas"]);
    let build = scene.with_files(&["atlas", "build", "-o", &scene.atlas]);
    scene
        .folder
        .fails(&build, 2, &["crawl.atlas", "not overwritten"]);

    let slower = CRAWL.replace("period_s = 1.0", "period_s = 1.2");
    fs::write(&scene.gait, slower).unwrap();
    refused(&["--atlas", &scene.atlas], &["stale", "gait"]);
    fs::write(&scene.gait, CRAWL).unwrap();
    fs::write(&scene.robot, QUADRUPED.replace("mass_kg = ", "mass_kg = 1")).unwrap();
    refused(&["--atlas", &scene.atlas], &["stale", "robot"]);
    fs::write(&scene.robot, QUADRUPED).unwrap();

    let whole = fs::read(&scene.atlas).unwrap();
    let mut damaged = whole.clone();
    let middle = whole.len() / 2;
    damaged[middle] ^= 1;
    fs::write(&scene.atlas, &damaged).unwrap();
    refused(&["--atlas", &scene.atlas], &["check sum"]);
    fs::write(&scene.atlas, &whole[..middle]).unwrap();
    refused(&["--atlas", &scene.atlas], &["crawl.atlas"]);
    fs::write(&scene.atlas, "t_s,roll_rad\n").unwrap();
    refused(&["--atlas", &scene.atlas], &["is no atlas"]);
}

/// An atlas of one damaged leg at most, asked about a robot without one leg and about one
/// without two.
#[test]
fn a_smaller_atlas_knows_few_damaged_legs_and_says_so() {
    let scene = Scene::new();
    let small = scene.folder.path("small.atlas");
    let build = ["atlas", "build", "-o", &small, "--most-damaged-legs", "1"];
    scene.folder.succeeds(&scene.with_files(&build));
    let size = |path: &str| fs::metadata(path).unwrap().len();
    assert!(size(&small) < size(&scene.atlas) / 5);

    let two_lost = scene.folder.path("two.csv");
    scene.simulate("1,2", &scene.gait, &two_lost);
    let answer = |log: &str, more: &[&str]| -> Value {
        let mut arguments = scene.with_files(&["identify", log, "--json"]);
        arguments.extend(more);
        let output = scene.folder.program(&arguments).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        serde_json::from_slice(&output.stdout).unwrap()
    };
    for search in ["atlas", "ga"] {
        let from = |atlas: &str, log: &str| answer(log, &["--atlas", atlas, "--search", search]);
        let (all, few) = (from(&scene.atlas, &scene.log), from(&small, &scene.log));
        assert_eq!(few["morphology"], all["morphology"], "{search}");
        let warning = few["warnings"][0].as_str().unwrap();
        assert!(warning.contains("at most 1 damaged leg"), "{warning}");
        assert_eq!(all["warnings"], Value::Array(Vec::new()));

        let (all, few) = (from(&scene.atlas, &two_lost), from(&small, &two_lost));
        assert_eq!(all["damaged_legs"], Value::from(vec![1, 2]), "{search}");
        assert!(few["damaged_legs"].as_array().unwrap().len() <= 1);
        assert!(few["warnings"].to_string().contains("damaged leg"));
    }
    let none = scene.folder.path("none.atlas");
    let build = ["atlas", "build", "-o", &none, "--most-damaged-legs", "0"];
    let build = scene.with_files(&build);
    scene.folder.fails(&build, 2, &["--most-damaged-legs", "0"]);
}

/// Two logs with two gaits, of which the atlas has one: the other log is simulated.
#[test]
fn an_atlas_serves_the_logs_of_its_gait() {
    let scene = Scene::new();
    let slower = CRAWL.replace("period_s = 1.0", "period_s = 1.2");
    let slower = scene.folder.write("slower.toml", slower);
    let quick = "window_s = 3.0\nlost_links = \"absent\"\nvariations = [{}]\n\
                 [genetic]\nislands = 1\ngenerations = 1\ncomplete = false\n";
    let quick = scene.folder.write("quick.toml", quick);
    let other = scene.folder.path("slower.csv");
    scene.simulate("1", &slower, &other);
    let identify = |gaits: [&str; 2], more: &[&str]| -> Vec<String> {
        let both = [
            "identify", &scene.log, &other, "--json", "--gait", gaits[0], "--gait", gaits[1],
        ];
        let with = ["--robot", &scene.robot, "--config", &quick];
        let all = [&both[..], &with, more].concat();
        all.into_iter().map(String::from).collect()
    };
    let run = |arguments: &[String]| -> Value {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        serde_json::from_str(&scene.folder.succeeds(&arguments)).unwrap()
    };
    let gaits = [scene.gait.as_str(), &slower];
    let mixed = run(&identify(gaits, &["--atlas", &scene.atlas]));
    assert_eq!(mixed["search"], "ga", "not every log has an atlas");
    assert_eq!(mixed["damaged_legs"], Value::from(vec![1]));
    let simulated = run(&identify(gaits, &[]));
    assert_eq!(mixed["morphology"], simulated["morphology"]);
    // The control: where every log has its atlas, it is what is searched.
    let twice = scene.with_files(&["identify", &scene.log, &scene.log, "--json"]);
    let twice = [&twice[..], &["--atlas", &scene.atlas]].concat();
    let twice: Value = serde_json::from_str(&scene.folder.succeeds(&twice)).unwrap();
    assert_eq!(twice["search"], "atlas");
    assert_eq!(twice["logs"].as_array().unwrap().len(), 2);

    let fails = |arguments: &[String], message: &[&str]| {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        scene.folder.fails(&arguments, 2, message);
    };
    let searched = ["--atlas", &scene.atlas, "--search", "atlas"];
    fails(
        &identify(gaits, &searched),
        &["no atlas", "atlas build --gait"],
    );
    let third = CRAWL
        .replace("period_s = 1.0", "period_s = 1.1")
        .replace("crawl", "amble");
    let third = scene.folder.write("third.toml", third);
    fails(
        &identify([&slower, &third], &["--atlas", &scene.atlas]),
        &[
            "crawl.atlas",
            "a gait of none of the logs",
            "crawl or amble",
        ],
    );
}

#[test]
fn answers_are_scored_against_the_truth() {
    let scene = Scene::new();
    fs::write(
        scene.folder.path("truth.json"),
        r#"{"log": {"morphology": [[0,0],[1,1],[1,1,1],[1,1,1]]}}"#,
    )
    .unwrap();
    let directory = scene.folder.path("");
    let mut arguments = scene.with_files(&["evaluate", &directory, "--atlas", &scene.atlas]);
    let table = scene.folder.succeeds(&arguments);
    assert!(table.contains("legs right     1 of 1"), "{table}");
    arguments.push("--json");
    let report: Value = serde_json::from_str(&scene.folder.succeeds(&arguments)).unwrap();
    assert_eq!(report["schema"], "mlr.evaluation/1");
    assert_eq!(report["total"]["legs_right"], 1);
    assert_eq!(
        report["directories"][0]["logs"][0]["true_damaged_legs"],
        Value::from(vec![1])
    );
}
