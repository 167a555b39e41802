//! Long jobs in parts: what is merged is what one process makes, whatever the number of parts.

use std::fs;

use crate::{
    atlas::{CRAWL, QUADRUPED},
    program::{Folder, HEADER},
};

#[test]
fn an_atlas_of_parts_has_the_bytes_of_one_that_was_built_at_once() {
    let folder = Folder::new();
    let robot = folder.write("robot.toml", QUADRUPED);
    let gait = folder.write("gait.toml", CRAWL);
    let config = folder.write("config.toml", "variations = [{}]\n");
    let build = |output: &str, more: &[&str]| {
        let of = ["atlas", "build", "--most-damaged-legs", "1", "-o", output];
        let model = ["--robot", &robot, "--gait", &gait, "--config", &config];
        folder.succeeds(&[&of[..], &model, more].concat());
    };
    let whole = folder.path("whole.atlas");
    build(&whole, &[]);
    let parts_of = |count: usize| -> Vec<String> {
        let parts = (1..=count).map(|number| {
            let part = folder.path(&format!("{number}-of-{count}"));
            build(&part, &["--shard", &format!("{number}/{count}")]);
            part
        });
        parts.collect()
    };
    let merge = |parts: &[&str], output: &str| -> Vec<String> {
        let arguments = [&["atlas", "merge", "-o", output][..], parts].concat();
        arguments.into_iter().map(Into::into).collect()
    };
    for count in [1, 3, 8] {
        let parts = parts_of(count);
        // In any order.
        let parts: Vec<&str> = parts.iter().rev().map(String::as_str).collect();
        let merged = folder.path(&format!("merged-{count}.atlas"));
        let arguments = merge(&parts, &merged);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        folder.succeeds(&arguments);
        assert!(
            fs::read(&merged).unwrap() == fs::read(&whole).unwrap(),
            "{count} parts"
        );
    }
    let refused = |parts: &[&str], words: &[&str]| {
        let paths: Vec<String> = parts.iter().map(|part| folder.path(part)).collect();
        let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
        let merged = folder.path("refused.atlas");
        let arguments = merge(&paths, &merged);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        folder.fails(&arguments, 2, words);
        assert!(fs::metadata(&merged).is_err(), "nothing is left behind");
    };
    refused(&["1-of-3", "3-of-3"], &["parts are missing: 2/3"]);
    refused(
        &["1-of-3", "2-of-3", "1-of-3"],
        &["part 1/3 was named before"],
    );
    refused(&["1-of-3", "2-of-8"], &["2-of-8", "number of parts is 8"]);
    refused(
        &["whole.atlas"],
        &["is an atlas, expected a part of an atlas"],
    );
    let other = folder.path("other-gait");
    let slower = folder.write(
        "slower.toml",
        CRAWL.replace("period_s = 1.0", "period_s = 1.1"),
    );
    let of = [
        "atlas",
        "build",
        "--most-damaged-legs",
        "1",
        "-o",
        &other,
        "--shard",
        "2/3",
    ];
    let model = ["--robot", &robot, "--gait", &slower, "--config", &config];
    folder.succeeds(&[&of[..], &model].concat());
    refused(
        &["1-of-3", "other-gait", "3-of-3"],
        &["other-gait", "another atlas", "gait"],
    );
    // A part is no atlas.
    let log = folder.write(
        "log.csv",
        format!("{HEADER}0,0,0,0\n0.01,0,0,0\n0.02,0,0,0\n"),
    );
    let part = folder.path("1-of-3");
    let identify = [
        "identify", &log, "--atlas", &part, "--robot", &robot, "--gait", &gait,
    ];
    folder.fails(&identify, 2, &["is a part of an atlas, expected an atlas"]);
}

/// Eleven logs that are too short to answer, which takes no time.
fn logs(folder: &Folder) {
    let healthy = "[[1,1,1],[1,1,1],[1,1,1],[1,1,1],[1,1,1],[1,1,1]]";
    let names: Vec<String> = (1..=11).map(|number| format!("log-{number:02}")).collect();
    let truths = names
        .iter()
        .map(|name| format!("\"{name}\": {{\"morphology\": {healthy}, \"effects\": []}}"));
    folder.write(
        "truth.json",
        format!("{{{}}}", truths.collect::<Vec<_>>().join(",")),
    );
    for (name, samples) in names.iter().zip(3..) {
        let rows = (0..samples).map(|sample| format!("{},0,0,0\n", f64::from(sample) / 100.0));
        let log = format!(
            "t_s,roll_rad,pitch_rad,yaw_rad\n{}",
            rows.collect::<String>()
        );
        folder.write(&format!("{name}.csv"), log);
    }
}

#[test]
fn evaluations_of_parts_print_what_one_process_prints() {
    for (command, counts) in [("evaluate", &[3][..]), ("evaluate-effects", &[1, 3, 8])] {
        let folder = Folder::new();
        logs(&folder);
        let directory = folder.path("");
        let run =
            |more: &[&str]| folder.succeeds(&[&[command, &directory, "--json"], more].concat());
        let whole = run(&[]);
        assert!(whole.contains("log-11"), "{whole}");
        for &count in counts {
            let parts: Vec<String> = (1..=count)
                .map(|number| {
                    let file = folder.path(&format!("{number}-of-{count}.jsonl"));
                    let said = run(&["--shard", &format!("{number}/{count}"), "--resume", &file]);
                    assert!(said.contains(" of 11"), "{said}");
                    file
                })
                .collect();
            let parts: Vec<&str> = parts.iter().rev().map(String::as_str).collect();
            assert_eq!(
                run(&[&["--merge"], &parts[..]].concat()),
                whole,
                "{count} parts"
            );
        }
        let [one, two, three] =
            [1, 2, 3].map(|number| folder.path(&format!("{number}-of-3.jsonl")));
        let refused = |more: &[&str], words: &[&str]| {
            folder.fails(&[&[command, &directory], more].concat(), 2, words);
        };
        refused(
            &["--merge", &one, &three],
            &["no result of 4 of 11 logs, such as", "log-02"],
        );
        refused(
            &["--merge", &one, &two, &three, &two],
            &["has a result already, expected each part once"],
        );
        refused(
            &["--seed", "2", "--merge", &one, &two, &three],
            &["(seed: 1; this one: 2)"],
        );
        refused(&["--shard", "1/3"], &["--resume"]);
        refused(
            &["--shard", "4/3", "--resume", &one],
            &["4/3", "expected part K of N"],
        );
    }
}
