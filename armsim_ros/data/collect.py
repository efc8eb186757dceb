# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Collects episodes of a task: with one process, many, or a Ray cluster; runs them again."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context
import os
from pathlib import Path
import signal
from typing import Any

import numpy as np

from armsim_ros.data.dataset import DataSet, EpisodeData, INFO, OWN, read_json
from armsim_ros.data.episodes import EpisodeRunner, made, Source, versions
from armsim_ros.data.features import ACTION, features_of, frames_of, STATE, whole_fps
from armsim_ros.errors import ArmsimError, ConfigError, extras_hint, Problem, ResourceError

#: Episodes that wait for each worker, so that none is idle.
_AHEAD = 2
_RAY_WORKERS = 2
#: So many episodes in a row may fail where only successes are kept.
_MOST_FAILURES = 200
#: States that differ by no more are the same.
TOLERANCE = 1e-6
RAY = 'ray'
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


@dataclass(frozen=True)
class Plan:
    """
    What is to be collected.

    :param source: environment and policy.
    :param episodes: how many the set shall have.
    :param seed: of the first; each next has the next seed.
    :param only_successes: whether episodes without success are left out.
    :param workers: processes, or ``ray`` for the workers of a Ray cluster.
    """

    source: Source
    episodes: int
    seed: int = 0
    only_successes: bool = False
    workers: int | str = 1


@dataclass(frozen=True)
class Collected:
    """
    What a data set has.

    :param episodes: in the set, those of earlier calls included.
    :param frames: in all of them.
    :param successes: episodes that ended in success.
    :param dropped: what was found of an unfinished episode, '' for nothing.
    """

    episodes: int
    frames: int
    successes: int
    dropped: str = ''


def collect(
    plan: Plan, folder: Path, progress: Callable[[DataSet], object] = lambda data: None
) -> Collected:
    """
    Collect episodes; a set that is there is completed. What is finished stays, whatever happens.

    :param progress: is called with the set when it is open, and after each episode.
    :returns: what the set has then.
    :raises ConfigError: a plan that is not possible, or a folder with something else.
    """
    if plan.episodes < 1:
        raise ConfigError(Problem(f'--episodes {plan.episodes}', allowed='at least 1'))
    if plan.workers != RAY and not (isinstance(plan.workers, int) and plan.workers >= 1):
        raise ConfigError(Problem(f'--workers {plan.workers}', allowed=f'at least 1, or {RAY}'))
    runner = EpisodeRunner(plan.source)
    try:
        data = opened(plan, folder, runner)
        progress(data)
        for episode in _kept(plan, data, runner):
            data.add(episode)
            progress(data)
    finally:
        runner.close()
    return Collected(data.episodes, data.frames,
                     sum(bool(facts['success']) for facts in data.facts), data.dropped)


def opened(plan: Plan, folder: Path, runner: EpisodeRunner) -> DataSet:
    """
    Return the data set of a plan, which is begun or goes on.

    :raises ConfigError: the folder has something else.
    """
    task = runner.task
    facts: Mapping[str, Any] = {
        'env_id': plan.source.env_id, 'arguments': _plain(runner.source.arguments),
        'policy': plan.source.policy, 'seed': plan.seed, 'only_successes': plan.only_successes,
        'versions': versions()}
    return DataSet(folder, features_of(task), whole_fps(task.period), task.cell.model.name, facts)


def _kept(plan: Plan, data: DataSet, runner: EpisodeRunner) -> Iterator[EpisodeData]:
    """Yield the episodes that the set does not have yet, in the order of their seeds."""
    missing = plan.episodes - data.episodes
    if missing <= 0:
        return
    first = data.facts[-1]['seed'] + 1 if data.episodes else plan.seed
    failures = 0
    seeds = iter(range(first, first + missing) if not plan.only_successes else range(first, 2**31))
    if plan.workers == RAY:
        found = on_ray(plan.source, seeds)
    elif plan.workers == 1:
        found = map(runner.run, seeds)
    else:
        found = in_processes(plan.source, seeds, int(plan.workers))
    for episode in found:
        if plan.only_successes and not episode.facts['success']:
            failures += 1
            if failures >= _MOST_FAILURES:
                raise ArmsimError(
                    f'no success in {failures} episodes in a row up to seed '
                    f"{episode.facts['seed']}; without --only-successes all are kept")
            continue
        failures = 0
        yield episode
        missing -= 1
        if not missing:
            return


def _plain(value: Any) -> Any:
    """Return a value as JSON has it."""
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return value


@dataclass(frozen=True)
class Replayed:
    """
    How an episode went again.

    :param number: of the episode.
    :param deviation: largest difference of ``observation.state``.
    :param success: whether it ended as in the data set.
    """

    number: int
    deviation: float
    success: bool

    @property
    def same(self) -> bool:
        """Whether states and success are those of the data set."""
        return self.deviation <= TOLERANCE and self.success


def other_versions(folder: Path) -> list[str]:
    """Return a line for each version that differs from that of the data set."""
    then, now = read_json(folder / OWN)['versions'], versions()
    return [f'the data set was made with {name} {version}, this is {now.get(name)}'
            for name, version in then.items() if now.get(name) != version]


def replay(folder: Path, numbers: Iterable[int] | None = None) -> Iterator[Replayed]:
    """
    Yield how the episodes of a data set go again.

    :param numbers: of the episodes; all by default.
    :raises ResourceError: there is no data set of ``armsim collect``.
    :raises ConfigError: it has no such episode, or no ``observation.state``.
    """
    from pyarrow import compute, parquet

    own, info = read_json(folder / OWN), read_json(folder / INFO)
    if 'env_id' not in own:
        raise ResourceError(f"'{folder}' was not made by armsim collect and cannot be replayed")
    count = int(info['total_episodes'])
    chosen = list(range(count) if numbers is None else numbers)
    for number in chosen:
        if not 0 <= number < count:
            raise ConfigError(Problem(f'--episode {number}', allowed=f'0 to {count - 1}'))
    if STATE not in info['features']:
        raise ConfigError(Problem(f"'{folder}' has no {STATE} to compare"))
    rows = parquet.read_table(folder / 'data', columns=['episode_index', STATE, ACTION],
                              partitioning=None)
    env = made(Source(own['env_id'], own['arguments']))
    try:
        for number in chosen:
            part = rows.filter(compute.equal(rows['episode_index'], number))
            yield _again(env, number, own['episodes'][number], np.array(part[STATE].to_pylist()),
                         np.array(part[ACTION].to_pylist(), dtype=np.float32))
    finally:
        env.close()


def _again(env: Any, number: int, facts: Any, states: Any, actions: Any) -> Replayed:
    observation, info = env.reset(seed=facts['seed'])
    deviation = 0.0
    for state, action in zip(states, actions, strict=True):
        deviation = max(deviation, float(np.abs(frames_of(observation)[STATE] - state).max()))
        observation, _, _, _, info = env.step(action)
    return Replayed(number, deviation, bool(info['is_success']) == facts['success'])
