"""The wheel answers what the command line answers, bit for bit."""

import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mlr

from conftest import Answers

RAW = ("ax_mps2", "ay_mps2", "az_mps2", "gx_radps", "gy_radps", "gz_radps")


def without(answer: Any, *keys: str) -> dict[str, Any]:
    """An answer less what may differ: times and names."""
    return {key: value for key, value in answer.items() if key not in keys}


def columns(log: Path) -> dict[str, np.ndarray[Any, np.dtype[np.float64]]]:
    """The numbers of a log as NumPy reads them."""
    with gzip.open(log, "rt") as file:
        names = file.readline().strip().split(",")
        values = np.loadtxt(file, delimiter=",", unpack=True)
    return dict(zip(names, values, strict=True))


@pytest.mark.parametrize("name", ["legs2-3-lost", "healthy"])
def test_an_identification_of_angles_and_raw_samples(
    name: str, logs: Path, quick: Path, answer_of: Answers
) -> None:
    log = logs / f"{name}.csv.gz"
    theirs = answer_of("identify", log, "--config", quick, "--seed", "7")
    read = columns(log)
    raw = np.stack([read[column] for column in RAW], axis=1)
    ours = mlr.identify(
        read["t_s"],
        read["roll_rad"],
        read["pitch_rad"],
        read["yaw_rad"],
        acceleration=raw[:, :3],
        angular_rate=raw[:, 3:],
        config=quick,
        seed=7,
    )
    assert without(ours, "elapsed_s", "log") == without(theirs, "elapsed_s", "log")


def test_an_identification_of_raw_samples_alone(
    tmp_path: Path, logs: Path, quick: Path, answer_of: Answers
) -> None:
    read = columns(logs / "leg2-lost.csv.gz")
    log = tmp_path / "raw.csv"
    names = ("t_s", *RAW)
    rows = np.stack([read[name] for name in names], axis=1)
    np.savetxt(log, rows, delimiter=",", header=",".join(names), comments="", fmt="%.17g")
    theirs = answer_of("identify", log, "--config", quick)
    ours = mlr.identify(read["t_s"], acceleration=rows[:, 1:4], angular_rate=rows[:, 4:], config=quick)
    assert without(ours, "elapsed_s", "log") == without(theirs, "elapsed_s", "log")
    recording = mlr.read_log(log)
    assert "roll" not in recording
    again = mlr.identify(**recording, config=quick, threads=1)
    assert without(again, "elapsed_s") == without(theirs, "elapsed_s")


def test_the_mounting_of_a_configuration_is_applied(
    tmp_path: Path, quick: Path, short_log: Path, walk: mlr.ReadRecording, answer_of: Answers
) -> None:
    mounted = tmp_path / "mounted.toml"
    mounted.write_text(quick.read_text() + "[mounting]\nyaw_deg = 30.0\n")
    theirs = answer_of("identify", short_log, "--config", mounted)
    ours = mlr.identify(**walk, config=mounted)
    assert without(ours, "elapsed_s") == without(theirs, "elapsed_s")
    walk_in_body_axes: mlr.ReadRecording = {**walk, "in_body_axes": True}
    as_it_is = mlr.identify(**walk_in_body_axes, config=mounted)
    assert as_it_is["cost_rad"] == mlr.identify(**walk, config=quick)["cost_rad"] != ours["cost_rad"]


def test_options_of_an_identification(
    quick: Path, short_log: Path, walk: mlr.ReadRecording, answer_of: Answers
) -> None:
    theirs = answer_of(
        "identify", short_log, "--config", quick, "--window-s", "1.5", "--from-s", "2", "--lost-links", "absent",
        "--friction", "0.6", "--repeats", "2", "--search", "ga", "--gait", "tripod",
    )  # fmt: skip
    ours = mlr.identify(
        **walk, config=quick, window_s=1.5, from_s=2.0, lost_links="absent", friction=0.6, repeats=2,
        search="ga", gait="tripod", threads=1,
    )  # fmt: skip
    assert without(ours, "elapsed_s") == without(theirs, "elapsed_s")


def test_an_identification_of_several_logs(
    quick: Path, short_log: Path, walk: mlr.ReadRecording, answer_of: Answers
) -> None:
    theirs = answer_of("identify", short_log, short_log, "--config", quick)
    ours = mlr.identify_together([walk, walk], config=quick)
    assert without(ours, "elapsed_s") == without(theirs, "elapsed_s")
    assert len(ours["logs"]) == 2


def test_a_detection(logs: Path, answer_of: Answers) -> None:
    log = logs / "detect-legs3-4.csv.gz"
    ours = mlr.detect(**mlr.read_log(log))
    assert ours == answer_of("detect", log)
    assert ours["flagged"]


def test_an_explanation(
    tmp_path: Path, quick: Path, short_log: Path, walk: mlr.ReadRecording, answer_of: Answers
) -> None:
    theirs = answer_of("explain", short_log, "--config", quick, "--start-s", "1.0")
    ours = mlr.explain(**walk, config=quick, start_s=1.0)
    assert without(ours, "elapsed_s") == without(theirs, "elapsed_s")
    assert ours["error_after"]["fit_deg"] > 0.0
    earlier = tmp_path / "earlier.json"
    earlier.write_text(json.dumps(theirs))
    theirs = answer_of("explain", short_log, "--config", quick, "--start-s", "1.0", "--after", earlier)
    ours = mlr.explain(**walk, config=quick, start_s=1.0, after=ours)
    assert without(ours, "elapsed_s") == without(theirs, "elapsed_s")


def test_a_calibration(
    tmp_path: Path, quick: Path, short_log: Path, walk: mlr.ReadRecording, answer_of: Answers
) -> None:
    arguments = ("--healthy", "--config", quick, "--measured", "body_mass=1.41+-0.01")
    theirs = answer_of("calibrate", short_log, *arguments, "-o", tmp_path / "theirs.toml")
    output = tmp_path / "ours.toml"
    ours = mlr.calibrate([walk], healthy=True, config=quick, measured=["body_mass=1.41+-0.01"], output=output)
    assert output.read_text() == ours["description"]
    # Arrays have no bytes of a file to take a check sum of.
    for report in (ours, theirs):
        for one in report["walks"]:
            one["sha256"] = ""
    assert without(ours, "description") == theirs
    file = (tmp_path / "theirs.toml").read_text().splitlines()
    differ = [line for line in file if line not in ours["description"].splitlines()]
    assert all("sha256" in line for line in differ), differ
    again = mlr.simulate(robot=output, walk_s=0.5)
    assert again["samples"] > 0
    with pytest.raises(mlr.BadInput, match="ours.toml"):
        mlr.calibrate([walk], healthy=True, config=quick, output=output)


def test_a_simulated_log(tmp_path: Path, answer_of: Answers) -> None:
    log = tmp_path / "walk.csv"
    theirs = answer_of(
        "simulate", "--morphology", "111 110 000 111 111 111", "--lost-links", "locked", "--stand-s", "0.5",
        "--walk-s", "1.5", "--time-step-s", "0.004", "--friction", "0.6", "--slope-deg", "3", "--uphill-deg", "90",
        "--rubble-m", "0.005", "--seed", "3", "--joint-friction-nm", "0.1", "--backlash-rad", "0.01", "-o", log,
    )  # fmt: skip
    ours = mlr.simulate(
        morphology=theirs["morphology"], lost_links="locked", stand_s=0.5, walk_s=1.5, time_step_s=0.004,
        friction=0.6, slope_deg=3.0, uphill_deg=90.0, rubble_m=0.005, seed=3, joint_friction_nm=0.1,
        backlash_rad=0.01,
    )  # fmt: skip
    samples = ("t", "roll", "pitch", "yaw")
    assert without(ours, "log", *samples) == without(theirs, "log")
    written = mlr.read_log(log)
    for name, array in (("t", ours["t"]), ("roll", ours["roll"]), ("pitch", ours["pitch"]), ("yaw", ours["yaw"])):
        assert np.array_equal(array, np.asarray(dict(written)[name])), name
    assert np.array_equal(mlr.simulate(legs_lost=[3], walk_s=0.5)["yaw"], mlr.simulate(legs_lost=3, walk_s=0.5)["yaw"])


def test_foreign_columns_are_mapped(tmp_path: Path) -> None:
    log = tmp_path / "foreign.csv"
    log.write_text("ms,r,p,y\n0,90,0,0\n10,91,0,0\n")
    read = mlr.read_log(log, column=["t=ms,ms", "roll=r,deg", "pitch=p,deg", "yaw=y,deg"])
    assert read["t"].tolist() == [0.0, 0.01]
    assert read["roll"].tolist() == np.radians([90.0, 91.0]).tolist()
    assert read["log"] == str(log)
