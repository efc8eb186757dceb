# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Collect the episodes of ``collect_episodes.py`` on a Ray cluster.

Each worker holds one environment and takes a block of seeds at a time; the data set is the same,
byte by byte, that one process writes. Needs ray and pyarrow: ``make env EXTRAS=ray``.

    python examples/collect_on_ray.py data/pick_cube --episodes 1000     # two workers, here
    RAY_ADDRESS=auto python examples/collect_on_ray.py ...               # a cluster that runs
"""

from collections.abc import Iterator
import os
import sys

from collect_episodes import arguments_of, collect, Episode, PickCube, run_episode
import ray

from armsim_ros import ArmsimError

WORKERS = 2
BLOCK = 10


@ray.remote(num_cpus=1)
class Worker:
    """One environment in a process of the cluster."""

    def __init__(self) -> None:
        self._env = PickCube()

    def run(self, seeds: range) -> list[Episode]:
        """Return the episodes of some seeds."""
        return [run_episode(self._env, seed) for seed in seeds]


def episodes(seeds: range) -> Iterator[Episode]:
    """Give the episodes in the order of their seeds, not of their ends."""
    workers = ray.util.ActorPool([Worker.remote() for _ in range(WORKERS)])
    blocks = [seeds[start : start + BLOCK] for start in range(0, len(seeds), BLOCK)]
    for done in workers.map(lambda worker, block: worker.run.remote(block), blocks):
        yield from done


def main() -> None:
    """Collect on the cluster that ``RAY_ADDRESS`` names, else on a local one."""
    arguments = arguments_of('Collect episodes on a Ray cluster.')
    if 'RAY_ADDRESS' in os.environ:
        ray.init()
    else:
        ray.init(num_cpus=WORKERS, include_dashboard=False)
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    collect(arguments.folder, PickCube(), episodes(seeds))
    ray.shutdown()


if __name__ == '__main__':
    try:
        main()
    except ArmsimError as error:
        sys.exit(f'collect_on_ray: {error}')
