"""What is said of bad input is what the command line says, and its exit status is told."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mlr

from conftest import CommandLine

TIMES = np.arange(0.0, 8.0, 0.01)
STILL = np.zeros_like(TIMES)


def test_the_hierarchy() -> None:
    for kind, status in ((mlr.BadInput, 2), (mlr.CannotAnswer, 1)):
        assert issubclass(kind, mlr.Error)
        assert kind.exit_status == status
    assert issubclass(mlr.BadInput, ValueError)
    error = pickle.loads(pickle.dumps(mlr.CannotAnswer("no motion")))
    assert isinstance(error, mlr.CannotAnswer) and str(error) == "no motion"


def write(path: Path, times: Any, angles: Any) -> Path:
    rows = np.stack([times, angles, angles, angles], axis=1)
    np.savetxt(path, rows, delimiter=",", header="t_s,roll_rad,pitch_rad,yaw_rad", comments="", fmt="%.17g")
    return path


@pytest.mark.parametrize("command", ["identify", "detect", "explain"])
@pytest.mark.parametrize(
    "times", [TIMES, np.random.default_rng(1).permutation(TIMES)], ids=["no motion", "unsorted"]
)
def test_a_recording_that_cannot_answer(
    command: str, times: Any, tmp_path: Path, mlr_ga: CommandLine
) -> None:
    log = write(tmp_path / "log.csv", times, STILL)
    ran = mlr_ga(command, log)
    with pytest.raises(mlr.Error) as raised:
        getattr(mlr, command)(times, STILL, STILL, STILL, log=str(log))
    assert type(raised.value) is mlr.CannotAnswer and ran.returncode == 1
    assert ran.stderr == f"mlr-ga: {raised.value}\n"
    with pytest.raises(mlr.CannotAnswer) as unnamed:
        getattr(mlr, command)(times, STILL, STILL, STILL)
    assert str(raised.value) == f"{log}: {unnamed.value}"


@pytest.mark.parametrize(
    ("option", "file", "text"),
    [
        ("config", "bad.toml", "[identification]\nwindow_s = 0\n"),
        ("config", "absent.toml", None),
        ("robot", "absent.toml", None),
        ("robot", "bad.toml", "name = 3\n"),
        ("gait", "bad.toml", "period_s = 'long'\n"),
        ("atlas", "absent.atlas", None),
        ("atlas", "bad.atlas", "no atlas\n"),
    ],
)
def test_files_that_cannot_be_used(
    option: str, file: str, text: str | None, tmp_path: Path, short_log: Path, walk: Any, mlr_ga: CommandLine
) -> None:
    path = tmp_path / file
    if text is not None:
        path.write_text(text)
    ran = mlr_ga("identify", short_log, f"--{option}", path)
    named: dict[str, Any] = {option: path}
    with pytest.raises(mlr.BadInput) as raised:
        mlr.identify(**walk, **named)
    assert ran.returncode == 2 and file in ran.stderr
    assert ran.stderr == f"mlr-ga: {raised.value}\n"


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("window_s", -1.0),
        ("window_s", float("nan")),
        ("friction", -0.5),
        ("repeats", 0),
        ("from_s", 1e13),
        ("threads", 0),
    ],
)
def test_numbers_that_make_no_sense(
    option: str, value: float, short_log: Path, walk: Any, mlr_ga: CommandLine
) -> None:
    name = "--" + option.replace("_", "-")
    ran = mlr_ga("identify", short_log, name, repr(value))
    named: dict[str, Any] = {option: value}
    with pytest.raises(mlr.BadInput) as raised:
        mlr.identify(**walk, **named)
    assert ran.returncode == 2
    assert ran.stderr.removeprefix("mlr-ga: ").replace(name, option) == f"{raised.value}\n"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"seed": -1}, "seed: -1 is not valid, expected 0 to 9007199254740991"),
        ({"repeats": -1}, "repeats: -1 is not valid, expected a whole number from 1 on"),
        ({"search": "fast"}, "search: \"fast\" is not valid, expected ga, exact or atlas"),
        ({"method": "mine"}, "method: \"mine\" is not valid, expected mlr or paper"),
        ({"lost_links": "gone"}, "lost_links: \"gone\" is not valid, expected absent, locked or either"),
    ],
)
def test_names_and_whole_numbers(options: dict[str, Any], message: str, walk: Any) -> None:
    with pytest.raises(mlr.BadInput) as raised:
        mlr.identify(**walk, **options)
    assert str(raised.value) == message


def test_an_earlier_answer_to_something_else(walk: Any, quick: Path) -> None:
    identification: Any = mlr.identify(**walk, config=quick)
    with pytest.raises(mlr.BadInput, match="^after: "):
        mlr.explain(**walk, config=quick, after=identification)


def test_a_simulation_that_makes_no_sense(tmp_path: Path, mlr_ga: CommandLine) -> None:
    options: tuple[tuple[str, Any], ...] = (
        ("walk_s", -1.0),
        ("slope_deg", 89.0),
        ("rubble_m", -1.0),
        ("legs_lost", 9),
        ("morphology", "110"),
    )
    for option, value in options:
        name = "--" + option.replace("_", "-")
        ran = mlr_ga("simulate", name, str(value), "-o", tmp_path / "log.csv")
        with pytest.raises(mlr.BadInput) as raised:
            mlr.simulate(**{option: value})
        assert ran.returncode == 2
        assert ran.stderr.removeprefix("mlr-ga: ").replace(name, option) == f"{raised.value}\n"
    with pytest.raises(mlr.BadInput, match="not both"):
        mlr.simulate(legs_lost=3, morphology="111 111 000 111 111 111")


def test_an_unreadable_log(tmp_path: Path, mlr_ga: CommandLine) -> None:
    log = tmp_path / "log.csv"
    log.write_text("t_s,roll_rad,yaw_rad\n0,0,0\n")
    ran = mlr_ga("detect", log)
    with pytest.raises(mlr.BadInput) as raised:
        mlr.read_log(log)
    assert ran.returncode == 2
    assert ran.stderr == f"mlr-ga: {raised.value}\n"


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"roll": [0.0, np.nan, 0.0]}, "sample 1 of roll is NaN, expected a finite number"),
        ({"t": [0.0, 1.0, np.inf]}, "sample 2 of time is inf, expected a finite number"),
        ({"yaw": [0.0, 0.0]}, "3 time stamps but 2 samples of yaw"),
        ({"roll": np.zeros((3, 1))}, r"roll: has the shape \(3, 1\), expected \(n,\)"),
        ({"t": 0.0}, r"t: has the shape \(\), expected \(n,\)"),
        ({"roll": ["a", "b", "c"]}, "roll: is an array of <U1, expected real numbers"),
        ({"t": np.array(["2026-01-01"] * 3, "M8[s]")}, "t: is an array of datetime64"),
        ({"pitch": np.zeros(3, complex)}, "pitch: is an array of complex128"),
        ({"roll": np.ma.masked_equal([1, 0, 1], 0)}, "sample 1 of roll is NaN"),
        ({"yaw": None}, "yaw: not given, expected roll and pitch and yaw together"),
        ({"acceleration": np.zeros((3, 3))}, "angular_rate: not given"),
        ({"roll": None, "pitch": None, "yaw": None}, "no samples, expected roll, pitch and yaw"),
        (
            {"acceleration": np.zeros((3, 2)), "angular_rate": np.zeros((3, 3))},
            r"acceleration: has the shape \(3, 2\), expected \(n, 3\)",
        ),
        (
            {"acceleration": np.zeros((2, 3)), "angular_rate": np.zeros((3, 3))},
            "3 time stamps but 2 samples of ax",
        ),
    ],
)
def test_arrays_that_are_no_recording(arrays: dict[str, Any], message: str) -> None:
    whole: dict[str, Any] = {"t": [0.0, 1.0, 2.0], "roll": [0.0] * 3, "pitch": [0.0] * 3, "yaw": [0.0] * 3}
    with pytest.raises(mlr.BadInput, match=message):
        mlr.detect(**{**whole, **arrays})


def test_recordings_that_are_not_there(walk: Any, quick: Path) -> None:
    with pytest.raises(mlr.BadInput, match="no log, expected at least one"):
        mlr.identify_together([])
    with pytest.raises(mlr.BadInput, match="recordings: none"):
        mlr.calibrate([])
    untimed: Any = {name: walk[name] for name in ("roll", "pitch", "yaw")}
    with pytest.raises(mlr.BadInput, match="t: not given"):
        mlr.identify_together([untimed])
    with pytest.raises(mlr.BadInput, match="2 gaits for 1 logs"):
        mlr.identify_together([walk], gait=["tripod", "tripod"], config=quick)


def test_other_types_are_type_errors(walk: Any) -> None:
    others: tuple[dict[str, Any], ...] = ({"window_s": "long"}, {"robot": 3}, {"seed": 1.5})
    for other in others:
        with pytest.raises(TypeError):
            mlr.identify(**walk, **other)
