"""Very many states, by any engine: a chunk is a text and two numbers, and its result a summary that merges exactly."""

import datetime
import itertools
import json
import os
import sys
import time
import tomllib
from pathlib import Path

from . import _command, _pintle

# How many chunks wait at an engine at a time, and how many summaries are held before they are merged.
WAITING = 1000
HELD = 64

# Where a line cannot be written over, one is written so often, in s.
OFTEN = 10


class Sweep:
    """What a sweep found: `digest`, `states`, `wrong`, and the `summary` as `pintle sweep --format json` writes it."""

    def __init__(self, text, digest):
        self.text, self.digest, self.summary = text, digest, json.loads(text)

    @property
    def states(self):
        """How many states it holds."""
        return sum(end - first for first, end in self.summary["states"])

    @property
    def wrong(self):
        """At how many states something is wrong: a number that is not finite, or beyond its bound."""
        return sum(of["wrong"] for of in self.summary["subjects"])

    @property
    def compared(self):
        """At how many states numbers were compared: at all, unless a routine covers few."""
        passed = ("outside", "elsewhere", "undefined")
        return self.states - sum(of.get(key, 0) for of in self.summary["subjects"] for key in passed)

    def picture(self):
        """The worst errors over the distance to singular sets, as SVG."""
        return _pintle.sweep_picture(self.text)

    def _repr_svg_(self):
        return self.picture()

    def __repr__(self):
        return f"<Sweep of {self.states} states, wrong at {self.wrong}, digest {self.digest}>"


def _count(name, number):
    if int(number) != number or number < 1:
        raise ValueError(f"{name} is {number!r}, and no count from 1 on")
    return int(number)


def _folder(out):
    return None if out is None else str(out)


def sweep_plan(
    *of,
    oracle_share=1e-3,
    generator="philox",
    seed="pintle",
    python=None,
    library=None,
    with_=None,
    convention=None,
):
    """What is swept, as a text that any worker can be given. The arguments are those of `sweep`."""
    if not 0 <= oracle_share <= 1:
        raise ValueError(f"oracle_share is {oracle_share!r}, and no share between 0 and 1")
    doors = {"python": python, "library": library, "with": with_}
    start = {name: str(one) for name, one in doors.items() if one is not None}
    if len(start) > 1 or (convention is not None and not start):
        raise ValueError(f"a convention is that of a routine, and python, library or with_ name one; given are {list(start)}")
    if start and not of:
        raise ValueError("a routine is swept as what it is: name a connection type, or a scene")
    routine = {"start": start} if start else None
    if isinstance(convention, (str, os.PathLike)):
        convention = tomllib.loads(Path(convention).read_text(encoding="utf-8"))
    if convention is not None:
        routine["convention"] = dict(convention)
    return _pintle.sweep_plan([str(one) for one in of], generator, seed, oracle_share, routine)


def sweep_left(plan, *, states=10**6, chunk_states=10**6, out=None):
    """The chunks that are left of `states`, as pairs of first index and count: all, unless the folder `out` holds some."""
    return _pintle.sweep_left(plan, _count("states", states), _count("chunk_states", chunk_states), _folder(out))


def sweep_chunk(plan, part, *, out=None, threads=1, timeout=10.0):
    """Computes one chunk, and gives its summary as text; with `out` it is kept in that folder instead, and None is given.

    It is what a worker calls. The interpreter is free meanwhile. A routine of the plan is started here.
    """
    if not 0 < timeout < 1e6:
        raise ValueError(f"timeout is {timeout!r}, and no time in seconds")
    programs = _command.PYTHON, _command.COMMAND, timeout
    return _pintle.sweep_chunk(plan, tuple(part), _folder(out), _count("threads", threads), programs)


def sweep_merged(plan, texts=(), *, out=None):
    """The `Sweep` of the summaries of chunks, and of what the folder `out` holds."""
    return Sweep(*_pintle.sweep_merged(plan, list(texts), _folder(out)))


class _Left:
    """Tells on stderr how many chunks are done, and how long the others take if they go on like these."""

    def __init__(self):
        self.begun = self.said = time.monotonic()

    def __call__(self, done, all):
        now, is_over = time.monotonic(), sys.stderr.isatty()
        if is_over or now - self.said >= OFTEN:
            self.said = now
            left = datetime.timedelta(seconds=round((now - self.begun) / done * (all - done)))
            end = "\n" if done == all or not is_over else "\r"
            print(f"{done} of {all} chunks, about {left} left", end=end, file=sys.stderr, flush=True)


def chunk(plan, part, how):
    """What an engine calls."""
    return sweep_chunk(plan, part, **how)


def _alone(plan, parts, how, workers):
    return (chunk(plan, part, how) for part in parts)


def _joblib(plan, parts, how, workers):
    from joblib import Parallel, delayed

    parallel = Parallel(n_jobs=workers or -1, return_as="generator_unordered")
    return parallel(delayed(chunk)(plan, part, how) for part in parts)


def _dask(plan, parts, how, workers):
    """By the client that there is, or by processes of this machine with one thread each."""
    from distributed import Client, LocalCluster, as_completed, get_client

    try:
        client, cluster = get_client(), None
    except ValueError:
        cluster = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)
        client = Client(cluster)
    try:
        known = client.scatter(plan, broadcast=True)
        left = iter(parts)
        submit = lambda some: [client.submit(chunk, known, part, how, pure=False) for part in some]
        done = as_completed(submit(itertools.islice(left, WAITING)), with_results=True)
        for _, result in done:
            done.update(submit(itertools.islice(left, 1)))
            yield result
    finally:
        if cluster is not None:
            client.close()
            cluster.close()


def _ray(plan, parts, how, workers):
    """By the cluster that there is, or by one of this machine."""
    import ray

    is_ours = not ray.is_initialized()
    if is_ours:
        ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False)
    try:
        remote = ray.remote(num_cpus=how["threads"], max_retries=3)(chunk)
        known, left = ray.put(plan), iter(parts)
        submit = lambda some: [remote.remote(known, part, how) for part in some]
        waiting = submit(itertools.islice(left, WAITING))
        while waiting:
            done, waiting = ray.wait(waiting)
            waiting += submit(itertools.islice(left, len(done)))
            yield from ray.get(done)
    finally:
        if is_ours:
            ray.shutdown()


ENGINES = {None: _alone, "joblib": _joblib, "dask": _dask, "ray": _ray}


def sweep(
    *of,
    states=10**6,
    out=None,
    engine=None,
    workers=None,
    threads=1,
    chunk_states=10**6,
    oracle_share=1e-3,
    generator="philox",
    seed="pintle",
    python=None,
    library=None,
    with_=None,
    convention=None,
    timeout=10.0,
    progress=None,
):
    """Sweeps over states, as `pintle sweep` does: the same states, the same digest, by any engine.

    `of` are connection types, scenes, or connectors of scenes; without any, all types. `engine` is None for this
    process, "joblib", "dask" or "ray"; a client of Dask, or a cluster of Ray, that there is already is used.
    `generator` is "philox" for random states, or "sobol" for states that lie more evenly.

    With `out` each chunk is kept in that folder, which all workers must see. The same call again computes what is
    not there: whatever is killed, nothing that was written is lost. `progress(done, all)` is told of each chunk;
    True writes that and the time left to stderr.

    `python="module:function"`, `library=file` or `with_=command` name a routine whose numbers are swept, and `convention` what
    differs from pintle's conventions: a TOML file, or a dictionary. Each worker starts the routine by itself, for each chunk,
    and must find it. An answer may take `timeout` seconds. Notes on states without numbers go to the worker's stderr.
    """
    if engine not in ENGINES:
        known = ", ".join(repr(name) for name in ENGINES)
        raise ValueError(f"there is no engine {engine!r}: choose {known}")
    how = {"out": _folder(out), "threads": _count("threads", threads), "timeout": timeout}
    routine = {"python": python, "library": library, "with_": with_, "convention": convention}
    plan = sweep_plan(*of, oracle_share=oracle_share, generator=generator, seed=seed, **routine)
    parts = sweep_left(plan, states=states, chunk_states=chunk_states, out=out)
    tell = _Left() if progress is True else progress
    texts = []
    for done, text in enumerate(ENGINES[engine](plan, parts, how, workers), 1):
        if text is not None:
            texts.append(text)
        if len(texts) >= HELD:
            texts = [sweep_merged(plan, texts).text]
        if tell is not None:
            tell(done, len(parts))
    return sweep_merged(plan, texts, out=out)
