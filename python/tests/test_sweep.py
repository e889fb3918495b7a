"""Sweeps: one digest by every engine that is installed, any number of workers, and after a kill."""

import contextlib
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
    assert [of["name"] for of in subjects] == list(pintle.catalog())
    assert sum(sum(of["places"].values()) for of in subjects) == 12_000
    assert sum(of["judged"] for of in subjects) > 10
    assert alone.picture().startswith("<svg") and repr(alone).endswith(f"{alone.digest}>")


def needs(engine):
    if importlib.util.find_spec(NEEDS[engine]) is None:
        pytest.skip(f"{engine} is not installed: pip install pintle[{engine}]")


@pytest.mark.parametrize("engine", ["joblib", "dask", "ray"])
@pytest.mark.parametrize("workers", [1, 2, 8])
def test_every_engine_gives_the_same_digest(alone, engine, workers, tmp_path):
    needs(engine)
    assert pintle.sweep(**SMALL, engine=engine, workers=workers).digest == alone.digest
    kept = pintle.sweep(**SMALL, engine=engine, workers=workers, out=tmp_path)
    assert kept.digest == alone.digest and len(list(tmp_path.glob("chunk-*.json"))) == 8


def test_any_chunks_and_threads_give_the_same_digest(alone):
    assert pintle.sweep(**{**SMALL, "chunk_states": 5001}, threads=3).digest == alone.digest
    assert pintle.sweep(**{**SMALL, "oracle_share": 0.003}).digest != alone.digest
    even = pintle.sweep(**SMALL, generator="sobol")
    assert even.digest != alone.digest and even.wrong == 0
    assert pintle.sweep(**{**SMALL, "chunk_states": 5001}, generator="sobol").digest == even.digest


def test_what_an_engine_carries_is_small_and_pickles():
    plan = pintle._pintle.sweep_plan([], "philox", "pintle", 1e-3)
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


LARGE = {"states": 100_000, "chunk_states": 2500, "oracle_share": 0.002}
CHUNKS = 40


@pytest.fixture(scope="module")
def large():
    return pintle.sweep(**LARGE, threads=2).digest


def family(pid):
    """The processes that a process has started, and those that they have, with itself: their commands by their numbers."""
    # Dask and Ray bring it.
    import psutil

    found = {}
    with contextlib.suppress(psutil.NoSuchProcess):
        parent = psutil.Process(pid)
        for one in [parent, *parent.children(recursive=True)]:
            with contextlib.suppress(psutil.Error):
                found[one.pid] = " ".join(one.cmdline())
    return found


# How the command of a process begins that computes chunks, or what it contains.
WORKERS = {"dask": "--multiprocessing-fork", "ray": "ray::chunk"}


@pytest.mark.parametrize("victims", ["a worker", "the scheduler and all else"])
@pytest.mark.parametrize("engine", ["dask", "ray"])
def test_whoever_of_an_engine_is_killed(large, engine, victims, tmp_path):
    needs(engine)
    call = {**LARGE, "out": str(tmp_path), "engine": engine, "workers": 2}
    words = [sys.executable, "-c", f"import pintle; print(pintle.sweep(**{call!r}).digest)"]
    written = lambda: len(list(tmp_path.glob("chunk-*.json")))
    begun = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    deadline = time.monotonic() + 120
    # A worker of Ray that is between two chunks has another name.
    all, some = {}, []
    while not (written() and some) and time.monotonic() < deadline:
        time.sleep(0.001)
        all = family(begun.pid)
        some = [pid for pid, command in all.items() if WORKERS[engine] in command]
    assert some, all
    killed = some[:1] if victims == "a worker" else list(all)
    for pid in killed:
        os.kill(pid, signal.SIGKILL)
    before = written()
    assert 0 < before < CHUNKS, before
    told, _ = begun.communicate(timeout=240)
    if victims == "a worker":
        assert (begun.returncode, told.split()[-1:]) == (0, [large])
    else:
        assert begun.returncode == -signal.SIGKILL
        counted = []
        resumed = pintle.sweep(**call, progress=lambda done, all: counted.append(all))
        # A chunk that was being renamed may have become whole.
        assert resumed.digest == large and CHUNKS - before - 2 <= len(counted) <= CHUNKS - before
    assert written() == CHUNKS


def test_wrong_words_are_refused(tmp_path):
    with pytest.raises(ValueError, match="there is no engine 'spark'"):
        pintle.sweep(engine="spark")
    with pytest.raises(ValueError, match="there is no generator 'halton': choose 'philox', 'sobol'"):
        pintle.sweep(generator="halton")
    with pytest.raises(ValueError, match="did you mean HINGE"):
        pintle.sweep("HINGEE")
    pintle.sweep("HINGE", states=100, out=tmp_path)
    with pytest.raises(ValueError, match="give another folder"):
        pintle.sweep("WELD", states=100, out=tmp_path)
