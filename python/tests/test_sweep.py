"""Sweeps: one digest by every engine that is installed, any number of workers, and after a kill."""

import importlib.util
import os
import pickle
import signal
import subprocess
import sys
import time

import pytest

import pintle
from pintle import _sweep

SMALL = {"states": 12_000, "chunk_states": 1500, "oracle_share": 0.002}
NEEDS = {"joblib": "joblib", "dask": "distributed", "ray": "ray"}


@pytest.fixture(scope="module")
def alone():
    return pintle.sweep(**SMALL)


def test_a_sweep_says_what_it_found(alone):
    assert alone.states == 12_000 and alone.wrong == 0 and len(alone.digest) == 64
    subjects = alone.summary["subjects"]
    assert len(subjects) == 31
    assert sum(sum(of["places"].values()) for of in subjects) == 12_000
    assert sum(of["judged"] for of in subjects) > 10
    assert alone.picture().startswith("<svg") and repr(alone).endswith(f"{alone.digest}>")


@pytest.mark.parametrize("engine", ["joblib", "dask", "ray"])
@pytest.mark.parametrize("workers", [1, 2])
def test_every_engine_gives_the_same_digest(alone, engine, workers, tmp_path):
    if importlib.util.find_spec(NEEDS[engine]) is None:
        pytest.skip(f"{engine} is not installed: pip install pintle[{engine}]")
    assert pintle.sweep(**SMALL, engine=engine, workers=workers).digest == alone.digest
    kept = pintle.sweep(**SMALL, engine=engine, workers=workers, out=tmp_path)
    assert kept.digest == alone.digest and len(list(tmp_path.glob("chunk-*.json"))) == 8


def test_any_chunks_and_threads_give_the_same_digest(alone):
    assert pintle.sweep(**{**SMALL, "chunk_states": 5001}, threads=3).digest == alone.digest
    assert pintle.sweep(**{**SMALL, "oracle_share": 0.003}).digest != alone.digest


def test_what_an_engine_carries_is_small_and_pickles():
    plan = pintle._pintle.sweep_plan([], "pintle", 1e-3)
    task = pickle.dumps((_sweep.chunk, plan, (0, 10**6), None, 1))
    assert len(task) < 8000, len(task)
    function, *arguments = pickle.loads(task)
    assert function is _sweep.chunk and arguments[0] == plan


def test_a_killed_sweep_goes_on_where_it_was(alone, tmp_path):
    program = f"import pintle; pintle.sweep(**{SMALL!r}, out={str(tmp_path)!r})"
    killed = subprocess.Popen([sys.executable, "-c", program])
    deadline = time.monotonic() + 120
    while not list(tmp_path.glob("chunk-*.json")) and time.monotonic() < deadline:
        time.sleep(0.001)
    os.kill(killed.pid, signal.SIGKILL)
    killed.wait()
    before = len(list(tmp_path.glob("chunk-*.json")))
    assert before > 0
    told = []
    resumed = pintle.sweep(**SMALL, out=tmp_path, progress=lambda done, all: told.append((done, all)))
    assert resumed.digest == alone.digest
    assert told == [(i, 8 - before) for i in range(1, 9 - before)]


def test_wrong_words_are_refused(tmp_path):
    with pytest.raises(ValueError, match="there is no engine 'spark'"):
        pintle.sweep(engine="spark")
    with pytest.raises(ValueError, match="did you mean HINGE"):
        pintle.sweep("HINGEE")
    pintle.sweep("HINGE", states=100, out=tmp_path)
    with pytest.raises(ValueError, match="give another folder"):
        pintle.sweep("WELD", states=100, out=tmp_path)
