# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Runs episodes beside each other: processes of this machine, or the workers of a Ray cluster."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
import os
import signal
from typing import Any

from armsim_ros.data.dataset import EpisodeData
from armsim_ros.data.episodes import EpisodeRunner, Source
from armsim_ros.errors import ArmsimError, extras_hint, ResourceError

#: Episodes that wait for each worker, so that none is idle.
_AHEAD = 2
_RAY_WORKERS = 2
_runner: EpisodeRunner | None = None


def in_processes(source: Source, seeds: Iterator[int], workers: int) -> Iterator[EpisodeData]:
    """
    Yield the episodes of seeds in their order.

    :param workers: processes.
    :raises ArmsimError: a process died.
    """
    pool = ProcessPoolExecutor(
        workers, mp_context=get_context('spawn'), initializer=_begin, initargs=(source,))
    waiting: deque[Future[EpisodeData]] = deque()
    try:
        for seed in seeds:
            waiting.append(pool.submit(_run, seed))
            if len(waiting) > _AHEAD * workers:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    except BrokenProcessPool:
        raise ArmsimError('a worker has ended before its episode (killed, or out of memory?); '
                          'the same command goes on with the episodes that are missing') from None
    finally:
        processes = list(getattr(pool, '_processes', None) or {})
        pool.shutdown(wait=False, cancel_futures=True)
        for number in processes:
            try:
                os.kill(number, signal.SIGKILL)
            except ProcessLookupError:
                continue


def on_ray(source: Source, seeds: Iterator[int]) -> Iterator[EpisodeData]:
    """
    Yield the episodes of seeds in their order, from the cluster that ``RAY_ADDRESS`` names.

    Without ``RAY_ADDRESS`` a cluster of two workers runs here.

    :raises ResourceError: Ray is not installed.
    """
    try:
        import ray
    except ImportError:
        raise ResourceError(
            'workers of a cluster need Ray, which is not installed: ' + extras_hint('ray')
        ) from None
    if 'RAY_ADDRESS' in os.environ:
        ray.init()
    else:
        ray.init(num_cpus=_RAY_WORKERS, include_dashboard=False)
    count = max(1, int(ray.cluster_resources().get('CPU', 1)))
    actor: Any = ray.remote(num_cpus=1)(EpisodeRunner)
    workers = [actor.remote(source) for _ in range(count)]
    waiting: deque[Any] = deque()
    try:
        for place, seed in enumerate(seeds):
            waiting.append(workers[place % count].run.remote(seed))
            if len(waiting) > _AHEAD * count:
                yield ray.get(waiting.popleft())
        while waiting:
            yield ray.get(waiting.popleft())
    finally:
        ray.shutdown()


def _begin(source: Source) -> None:
    """Make the environment of a process; Ctrl-C is for the process that writes."""
    global _runner
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _runner = EpisodeRunner(source)


def _run(seed: int) -> EpisodeData:
    assert _runner is not None
    return _runner.run(seed)
