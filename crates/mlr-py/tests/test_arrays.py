"""Arrays as NumPy has them: read-only, with strides, in other types and byte orders."""

import copy
import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mlr

NAMES = ("t", "roll", "pitch", "yaw")


@pytest.mark.parametrize("form", ["read-only", "strided", "reversed twice", "big-endian", "list", "column", "masked"])
def test_any_form_of_the_same_numbers(form: str, long_walk: Any) -> None:
    def of(array: Any) -> Any:
        match form:
            case "read-only":
                array = array.copy()
                array.flags.writeable = False
                return array
            case "strided":
                wide = np.full(3 * len(array), np.nan)
                wide[::3] = array
                return wide[::3]
            case "reversed twice":
                return array[::-1].copy()[::-1]
            case "big-endian":
                return array.astype(">f8")
            case "list":
                return array.tolist()
            case "column":
                return np.asfortranarray(np.stack([array, array], axis=1))[:, 1]
            case _:
                return np.ma.masked_invalid(array)

    forms = {name: of(array) for name, array in long_walk.items()}
    assert mlr.detect(**forms) == mlr.detect(**long_walk)


def test_single_precision_is_taken_at_its_value(long_walk: Any) -> None:
    single = {name: array.astype(np.float32) for name, array in long_walk.items()}
    double = {name: array.astype(np.float64) for name, array in single.items()}
    assert mlr.detect(**single) == mlr.detect(**double)
    assert mlr.detect(**single)["max_fluctuation_deg"] != mlr.detect(**long_walk)["max_fluctuation_deg"]


def test_whole_numbers_are_numbers() -> None:
    still = [0] * 8
    with pytest.raises(mlr.CannotAnswer, match="sampled too slowly: 1.0 Hz"):
        mlr.detect(range(8), still, still, still)


def test_the_arrays_of_a_caller_stay_as_they_are(long_walk: Any) -> None:
    before = copy.deepcopy(long_walk)
    mlr.detect(**long_walk)
    for name in NAMES:
        assert np.array_equal(long_walk[name], before[name])


def test_raw_samples_may_be_missing_in_a_few_rows(logs: Path) -> None:
    read: Any = mlr.read_log(logs / "detect-legs3-4.csv.gz")
    read["acceleration"][100:103] = np.nan
    answer = mlr.detect(**read)
    assert any("3 of " in warning for warning in answer["warnings"]), answer["warnings"]


def test_an_answer_is_plain_data(long_walk: Any) -> None:
    answer = mlr.detect(**long_walk, log="walk")
    assert answer["log"] == "walk"
    for same in (pickle.loads(pickle.dumps(answer)), copy.deepcopy(answer), json.loads(json.dumps(answer))):
        assert same == answer
