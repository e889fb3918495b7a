"""Sweeps: one digest by every engine that is installed, any number of workers, and after a kill."""

import contextlib
import importlib.util
import json
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

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
    of_routine = {"python": "routines:cartesian", "convention": {"length": 0.001}}
    for plan in (pintle.sweep_plan(), pintle.sweep_plan("CARTESIAN", **of_routine)):
        task = pickle.dumps((_sweep.chunk, plan, (0, 10**6), {"out": None, "threads": 1, "timeout": 10.0}))
        assert len(task) < 8000, len(task)
        function, *arguments = pickle.loads(task)
        assert function is _sweep.chunk and arguments[0] == plan


HERE = Path(__file__).parent
OF_ROUTINE = {"states": 3000, "chunk_states": 1000, "oracle_share": 0.002}


def digest_of_command(words, folder):
    """By the command of the package, as it begins where a routine lies."""
    command = [Path(sys.executable).parent / "pintle", "sweep", "CARTESIAN", "--states", "3000", "--oracle-share", "0.002"]
    told = subprocess.run([*command, "--format", "json", *words], cwd=folder, capture_output=True, text=True)
    return json.loads(told.stdout)["digest"]


def swept_in(folder, **how):
    """The digest of a sweep by a Python that begins there, and at how many states it is wrong."""
    program = f"import pintle; found = pintle.sweep('CARTESIAN', **{({**OF_ROUTINE, **how})!r}); print(found.digest, found.wrong, found.compared)"
    ran = subprocess.run([sys.executable, "-c", program], cwd=folder, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    digest, *counts = ran.stdout.split()
    return digest, *map(int, counts)


@pytest.fixture(scope="module")
def of_command():
    return digest_of_command(["--python", "routines:cartesian"], HERE)


@pytest.mark.parametrize("engine", [None, "joblib", "dask", "ray"])
def test_a_routine_is_swept_by_every_engine_as_by_the_command(of_command, engine):
    if engine is not None:
        needs(engine)
    assert swept_in(HERE, python="routines:cartesian", engine=engine, workers=2) == (of_command, 0, 3000)


def test_a_wrong_routine_and_one_of_another_convention(of_command, tmp_path):
    assert swept_in(HERE, python="routines:without_arm")[1:] == (3000, 3000)
    (tmp_path / "body.toml").write_text("rotations = \"body\" # not so\n")
    of_file = swept_in(HERE, python="routines:cartesian", convention=str(tmp_path / "body.toml"))
    of_words = swept_in(HERE, python="routines:cartesian", convention={"rotations": "body"})
    words = ["--python", "routines:cartesian", "--convention", tmp_path / "body.toml"]
    assert of_file == of_words and of_file[0] == digest_of_command(words, HERE) != of_command
    assert of_file[1] > 2900
    (tmp_path / "none.py").write_text("def here(state, connector):\n    return {'out_of_domain': 'not here'}\n")
    assert swept_in(tmp_path, python="none:here")[1:] == (0, 0)


def test_a_library_and_a_command_are_swept(of_command, tmp_path):
    driver = "import sys; sys.argv[1:] = ['routines', 'cartesian']; from pintle import _check; _check._driver.main()"
    command = f'exec {sys.executable} -c "{driver}"'
    found = swept_in(HERE, with_=command)
    assert found[1:] == (0, 3000) and found[0] == digest_of_command(["--with", command], HERE) != of_command
    if shutil.which("cc") is None:
        pytest.skip("there is no C compiler")
    elements = HERE.parents[1] / "examples" / "elements"
    header = subprocess.run([Path(sys.executable).parent / "pintle", "check", "--header"], capture_output=True, check=True)
    (tmp_path / "pintle_element.h").write_bytes(header.stdout)
    build = ["cc", "-O2", "-shared", "-fPIC", "-I", tmp_path, elements / "cartesian.c", "-o", tmp_path / "cartesian.so", "-lm"]
    subprocess.run(build, check=True)
    found = swept_in(tmp_path, library="./cartesian.so", engine="joblib", workers=2)
    assert found == (digest_of_command(["--library", "./cartesian.so"], tmp_path), 0, 3000)


def test_routines_that_cannot_be_swept(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    few = {"states": 40, "oracle_share": 0}
    for of, how, says in (
        (("CARTESIAN",), {"python": "a:b", "library": "c.so"}, "python, library or with_ name one"),
        (("CARTESIAN",), {"convention": {"length": 2}}, "a convention is that of a routine"),
        ((), {"python": "a:b"}, "name a connection type, or a scene"),
        (("CARTESIAN",), {"python": "a"}, "is not MODULE:FUNCTION"),
        (("CARTESIAN",), {"python": "a:b", "convention": {"lenght": 2}}, "unknown field `lenght`"),
        (("CARTESIAN",), {"python": "none_such:b"}, "the process"),
        (("CARTESIAN",), {"python": "a:b", "timeout": 0}, "timeout is 0"),
    ):
        with pytest.raises(ValueError, match=says):
            pintle.sweep(*of, **few, **how)
    plan = pintle.sweep_plan("CARTESIAN", python="a:b")
    kept = pintle.sweep_left(plan, states=40, out=tmp_path / "kept")
    assert kept == [(0, 40)]
    with pytest.raises(ValueError, match="the numbers of another routine"):
        pintle.sweep("CARTESIAN", states=40, python="a:c", out=tmp_path / "kept")


def test_the_time_left_is_told(monkeypatch, capsys):
    told = _sweep._Left()
    monkeypatch.setattr(_sweep.time, "monotonic", lambda: told.begun + 20)
    told(2, 8)
    told(3, 8)
    assert capsys.readouterr().err == "2 of 8 chunks, about 0:01:00 left\n"
    monkeypatch.undo()
    monkeypatch.setattr(_sweep, "OFTEN", 0)
    pintle.sweep("HINGE", states=200, chunk_states=100, progress=True)
    first, last = capsys.readouterr().err.splitlines()
    assert first.startswith("1 of 2 chunks, about 0:") and last == "2 of 2 chunks, about 0:00:00 left"


class Column(list):
    """A column of a batch of records, as Arrow has it."""

    to_pylist = list.copy


def batch_of_lists(first, count):
    return {"first": Column([first]), "count": Column([count])}


def batch_of_arrow(first, count):
    arrow = pytest.importorskip("pyarrow")
    return arrow.record_batch({"first": [first], "count": [count]})


class Spark:
    """So much of Spark as the recipe of the page calls: each row goes to a worker by itself."""

    def __init__(self, batch):
        self.batch = batch

    def createDataFrame(self, rows, schema):
        self.rows, self.schema = rows, schema
        return self

    def repartition(self, count):
        assert count == len(self.rows)
        return self

    def mapInArrow(self, work, schema):
        # What Spark sends to a worker.
        cloudpickle = pytest.importorskip("cloudpickle")
        work = cloudpickle.loads(cloudpickle.dumps(work))
        self.done = list(work(self.batch(*row) for row in self.rows))
        return self

    def count(self):
        assert len(self.done) == len(self.rows)


@pytest.mark.parametrize("batch", [batch_of_lists, batch_of_arrow])
def test_the_recipe_for_spark_sweeps(batch, tmp_path):
    page = (HERE.parents[1] / "docs" / "how-to" / "sweep.md").read_text()
    (recipe,) = re.findall(r"```python\n(import pintle\n\nplan.*?)```", page, re.DOTALL)
    assert "_pintle" not in recipe and "_sweep" not in recipe
    small = recipe.replace("/shared/all", str(tmp_path)).replace("states=1e9", "states=4000, chunk_states=1000")
    exec(small, {"spark": Spark(batch), "__name__": "recipe"})
    assert len(list(tmp_path.glob("chunk-*.json"))) == 4
    merged = pintle.sweep_merged(pintle.sweep_plan(), out=tmp_path)
    assert merged.states == 4000 and merged.digest == pintle.sweep(states=4000).digest


def test_what_workers_give_is_merged():
    plan = pintle.sweep_plan("HINGE", oracle_share=0.01)
    parts = pintle.sweep_left(plan, states=1000, chunk_states=400)
    assert parts == [(0, 400), (400, 400), (800, 200)]
    texts = [pintle.sweep_chunk(plan, part) for part in reversed(parts)]
    assert pintle.sweep_merged(plan, texts).digest == pintle.sweep("HINGE", states=1000, oracle_share=0.01).digest
    with pytest.raises(ValueError):
        pintle.sweep_merged(plan, texts[:1] * 2)


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
