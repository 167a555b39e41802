"""Other threads run while one computes, and Ctrl-C is heard."""

import multiprocessing
import os
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import mlr


def test_another_thread_runs_meanwhile(long_walk: Any) -> None:
    computing = threading.Thread(target=lambda: mlr.identify(**long_walk, window_s=2.0, lost_links="absent"))
    computing.start()
    ticks = 0
    while computing.is_alive():
        ticks += 1
        time.sleep(0.001)
    # One that had to wait for the interpreter would have seen the end only.
    assert ticks > 100


@pytest.mark.parametrize("function", ["identify", "explain"])
def test_ctrl_c_interrupts_within_a_second_and_the_computation_ends(function: str, long_walk: Any) -> None:
    sent: list[float] = []

    def interrupt() -> None:
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.7, interrupt)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            getattr(mlr, function)(**long_walk)
    finally:
        timer.cancel()
    assert time.monotonic() - sent[0] < 1.0
    # What computed ends at its next step: the processor comes to rest.
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline:
        used = time.process_time()
        time.sleep(0.5)
        if time.process_time() - used < 0.05:
            return
    pytest.fail("still computing a minute after it was interrupted")


def test_signal_handlers_run_and_need_not_interrupt(walk: Any, quick: Path) -> None:
    heard: list[int] = []
    before = signal.signal(signal.SIGUSR1, lambda number, _: heard.append(number))
    try:
        timer = threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGUSR1))
        timer.start()
        answer = mlr.identify(**walk, config=quick)
        timer.join()
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert heard == [signal.SIGUSR1]
    assert answer["damaged_legs"] == [2]


def test_progress_is_told(walk: Any, quick: Path) -> None:
    told: list[tuple[int, int]] = []
    callers = set()

    def progress(done: int, expected: int) -> None:
        told.append((done, expected))
        callers.add(threading.get_ident())

    mlr.identify(**walk, config=quick, progress=progress)
    assert told and callers == {threading.get_ident()}
    done = [one for one, _ in told]
    assert done == sorted(done)
    assert all(one <= expected for one, expected in told)


def test_progress_that_raises_ends_the_call(long_walk: Any) -> None:
    class Enough(Exception):
        pass

    def progress(done: int, _: int) -> None:
        if done > 10:
            raise Enough

    with pytest.raises(Enough):
        mlr.identify(**long_walk, progress=progress)


def test_many_threads_get_the_same_answers(walk: Any, quick: Path) -> None:
    def answer(_: int) -> Any:
        found: Any = mlr.identify(**walk, config=quick, threads=1)
        del found["elapsed_s"]
        return found

    with ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(answer, range(4)))
    assert all(one == answers[0] for one in answers)


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_computes_too(walk: Any, quick: Path) -> None:
    here: Any = mlr.identify(**walk, config=quick)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        there = pool.apply_async(mlr.identify, kwds={**walk, "config": quick}).get(timeout=120)
    assert there["cost_rad"] == here["cost_rad"]
