"""Very many states, by any engine: a chunk is a text and two numbers, and its result a summary that merges exactly."""

import itertools
import json

from . import _pintle

# How many chunks wait at an engine at a time, and how many summaries are held before they are merged.
WAITING = 1000
HELD = 64


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

    def picture(self):
        """The worst errors over the distance to singular sets, as SVG."""
        return _pintle.sweep_picture(self.text)

    def _repr_svg_(self):
        return self.picture()

    def __repr__(self):
        return f"<Sweep of {self.states} states, wrong at {self.wrong}, digest {self.digest}>"


def chunk(plan, part, out, threads):
    """Computes one chunk: what an engine calls. The interpreter is free meanwhile."""
    return _pintle.sweep_chunk(plan, part, out, threads)


def _alone(plan, parts, out, threads, workers):
    return (chunk(plan, part, out, threads) for part in parts)


def _joblib(plan, parts, out, threads, workers):
    from joblib import Parallel, delayed

    parallel = Parallel(n_jobs=workers or -1, return_as="generator_unordered")
    return parallel(delayed(chunk)(plan, part, out, threads) for part in parts)


def _dask(plan, parts, out, threads, workers):
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
        submit = lambda some: [client.submit(chunk, known, part, out, threads, pure=False) for part in some]
        done = as_completed(submit(itertools.islice(left, WAITING)), with_results=True)
        for _, result in done:
            done.update(submit(itertools.islice(left, 1)))
            yield result
    finally:
        if cluster is not None:
            client.close()
            cluster.close()


def _ray(plan, parts, out, threads, workers):
    """By the cluster that there is, or by one of this machine."""
    import ray

    is_ours = not ray.is_initialized()
    if is_ours:
        ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False)
    try:
        remote = ray.remote(num_cpus=threads, max_retries=3)(chunk)
        known, left = ray.put(plan), iter(parts)
        submit = lambda some: [remote.remote(known, part, out, threads) for part in some]
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
    progress=None,
):
    """Sweeps over states, as `pintle sweep` does: the same states, the same digest, by any engine.

    `of` are connection types, scenes, or connectors of scenes; without any, all types. `engine` is None for this
    process, "joblib", "dask" or "ray"; a client of Dask, or a cluster of Ray, that there is already is used.
    `generator` is "philox" for random states, or "sobol" for states that lie more evenly.

    With `out` each chunk is kept in that folder, which all workers must see. The same call again computes what is
    not there: whatever is killed, nothing that was written is lost. `progress(done, all)` is told of each chunk.
    """
    if engine not in ENGINES:
        known = ", ".join(repr(name) for name in ENGINES)
        raise ValueError(f"there is no engine {engine!r}: choose {known}")
    for name, number in (("states", states), ("chunk_states", chunk_states), ("threads", threads)):
        if int(number) != number or number < 1:
            raise ValueError(f"{name} is {number!r}, and no count from 1 on")
    if not 0 <= oracle_share <= 1:
        raise ValueError(f"oracle_share is {oracle_share!r}, and no share between 0 and 1")
    out = None if out is None else str(out)
    plan = _pintle.sweep_plan([str(one) for one in of], generator, seed, oracle_share)
    parts = _pintle.sweep_left(plan, int(states), int(chunk_states), out)
    texts = []
    for done, text in enumerate(ENGINES[engine](plan, parts, out, threads, workers), 1):
        if text is not None:
            texts.append(text)
        if len(texts) >= HELD:
            texts = [_pintle.sweep_merged(plan, texts, None)[0]]
        if progress is not None:
            progress(done, len(parts))
    return Sweep(*_pintle.sweep_merged(plan, texts, out))
