"""The command line beside the wheel: `tools/python/test.sh` names both."""

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import mlr

# As little as still searches, weighs and explains.
QUICK = """
[identification]
window_s = 2.0
lost_links = "absent"
leaders = 2
variations = [{}]
[identification.genetic]
generations = 1
[identification.simulation]
time_step_s = 0.02
[explanation.effort]
bases = 1
screened = 1
entrants = 1
neighbours = 0
extended = 0
most_effects = 1
"""

CommandLine = Callable[..., "subprocess.CompletedProcess[str]"]
Answers = Callable[..., dict[str, Any]]


@pytest.fixture(scope="session")
def logs() -> Path:
    return Path(os.environ["MLR_DATA"]) / "logs" / "stand-in"


@pytest.fixture(scope="session")
def mlr_ga() -> CommandLine:
    """Runs the command line."""

    def run(*arguments: str | Path) -> "subprocess.CompletedProcess[str]":
        command = [os.environ["MLR_GA"], *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    return run


@pytest.fixture(scope="session")
def answer_of(mlr_ga: CommandLine) -> Answers:
    """What the command line prints with --json."""

    def answer(*arguments: str | Path) -> dict[str, Any]:
        ran = mlr_ga(*arguments, "--json")
        assert ran.returncode == 0, ran.stderr
        read: dict[str, Any] = json.loads(ran.stdout)
        return read

    return answer


@pytest.fixture(scope="session")
def quick(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Settings that answer within seconds."""
    path = tmp_path_factory.mktemp("settings") / "quick.toml"
    path.write_text(QUICK)
    return path


@pytest.fixture(scope="session")
def short_log(tmp_path_factory: pytest.TempPathFactory, mlr_ga: CommandLine) -> Path:
    """Four seconds of a robot that has lost leg 2."""
    path = tmp_path_factory.mktemp("logs") / "short.csv"
    ran = mlr_ga(
        "simulate", "--legs-lost", "2", "--stand-s", "1", "--walk-s", "4", "--time-step-s", "0.01", "-o", path
    )
    assert ran.returncode == 0, ran.stderr
    return path


@pytest.fixture(scope="session")
def walk(short_log: Path) -> mlr.ReadRecording:
    return mlr.read_log(short_log)


@pytest.fixture(scope="session")
def long_walk() -> dict[str, Any]:
    """Eight seconds of a robot that has lost legs 3 and 4."""
    walk = mlr.simulate(legs_lost=[3, 4], walk_s=8.0)
    return {"t": walk["t"], "roll": walk["roll"], "pitch": walk["pitch"], "yaw": walk["yaw"]}
