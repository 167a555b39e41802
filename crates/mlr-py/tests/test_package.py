"""What the package says of itself."""

import inspect
from pathlib import Path
from typing import Any

import pytest

import mlr

FUNCTIONS = ["calibrate", "detect", "explain", "identify", "identify_together", "read_log", "simulate"]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_argument_is_documented(name: str) -> None:
    function = getattr(mlr, name)
    documented = inspect.getdoc(function)
    assert documented is not None
    assert "Parameters\n----------" in documented and "Returns\n-------" in documented
    for argument in inspect.signature(function).parameters:
        assert argument in documented, argument


def test_types_name_the_keys_of_answers(walk: Any, quick: Path) -> None:
    answers: list[tuple[Any, type]] = [
        (mlr.identify(**walk, config=quick), mlr.answers.Identification),
        (mlr.detect(**walk), mlr.answers.Detection),
        (mlr.simulate(walk_s=0.2), mlr.SimulatedWalk),
        (mlr.calibrate([walk], healthy=True, config=quick), mlr.CalibratedRobot),
    ]
    for answer, of in answers:
        hints = of.__annotations__
        assert set(answer) <= set(hints), of
        assert set(hints) - set(answer) <= {"logs"}, of


def test_the_wheel_is_marked_as_typed_and_names_its_version() -> None:
    folder = Path(mlr.__file__).parent
    assert (folder / "py.typed").exists() and (folder / "_mlr.pyi").exists()
    assert mlr.__version__ == "0.1.0"
