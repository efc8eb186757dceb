# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Collect episodes of an arm that picks up a cube, as a data set in LeRobot's layout (v2.1).

Where the cube lies, how it is turned, its mass, friction and colour come from the seed: the same
command writes the same episodes, and prints the same digest. Needs pyarrow, which
``make env EXTRAS=data`` installs.

    python examples/collect_episodes.py data/pick_cube --episodes 20 --seed 0
"""

import argparse
from collections.abc import Iterable
from dataclasses import dataclass
import hashlib
import json
import math
from pathlib import Path
import sys

import numpy as np

from armsim_ros import ArmsimError
from armsim_ros.env import ArmEnv

try:
    import pyarrow as pa
    from pyarrow import parquet
except ModuleNotFoundError:
    sys.exit('collect_episodes: pyarrow is not installed; make env EXTRAS=data installs it')

TASK = 'Pick up the cube.'
PERIOD = 0.05
STEPS = 80
CUBE_HALF_HEIGHT = 0.0125
CHUNK = 1000
RANGES = {'objects': {'cube': {
    'xyz': ((0.02, 0.14, 1.04), (0.20, 0.26, 1.04)), 'rpy': ((0, 0, -math.pi), (0, 0, math.pi)),
    'mass': (0.1, 0.4), 'friction': (0.5, 1.0), 'color': ((0, 0, 0), (1, 1, 1)),
}}}


@dataclass(frozen=True)
class Episode:
    """What was recorded: (steps, n) states, (steps, m) actions, and how it ended."""

    states: np.ndarray
    actions: np.ndarray
    success: bool
    digest: str


class PickCube(ArmEnv):
    """The arm looks down on the table; the task is done when the cube is 10 cm above it."""

    def __init__(self) -> None:
        super().__init__('sunday', action='twist', period=PERIOD, randomize=RANGES)
        states = self.cell.model.semantic.named_states['manipulator']
        self.start = {name: float(value) for name, value in states['scan_food'].items()}
        self.state_names = [*self.joints, 'tip_x', 'tip_y', 'tip_z', 'cube_x', 'cube_y', 'cube_z',
                            'held']

    def terminated(self, observation: dict) -> bool:
        """Return whether the cube is up."""
        return bool(observation['held'][0] and observation['object_poses'][2] > 1.14)

    def state(self, observation: dict) -> np.ndarray:
        """Return what the data set shows of an observation, see ``state_names``."""
        parts = (observation['joint_positions'], observation['tip_pose'][:3],
                 observation['object_poses'][:3], observation['held'])
        return np.concatenate(parts).astype(np.float32)


def expert(observation: dict) -> np.ndarray:
    """Return the action of one who sees the cube: over it, down with suction, up."""
    tip, cube = observation['tip_pose'][:3], observation['object_poses'][:3]
    aim = cube + np.array((0.0, 0.0, CUBE_HALF_HEIGHT))
    if observation['held'][0]:
        aim = tip + np.array((0.0, 0.0, 0.2))
    elif np.linalg.norm(aim[:2] - tip[:2]) > 0.01:
        aim[2] = max(aim[2] + 0.06, tip[2] - 0.1)
    velocity = np.clip(4.0 * (aim - tip), -0.25, 0.25)
    return np.concatenate((velocity, np.zeros(3), [1.0]))


def run_episode(env: PickCube, seed: int) -> Episode:
    """Return the episode of a seed; what the environment did before does not matter."""
    observation, _ = env.reset(seed=seed, options={'joints': env.start})
    states, actions, done = [], [], False
    while not done and len(actions) < STEPS:
        action = expert(observation)
        states.append(env.state(observation))
        actions.append(action.astype(np.float32))
        observation, _, done, _, _ = env.step(actions[-1])
    return Episode(np.stack(states), np.stack(actions), done, env.digest())


class DataSet:
    """
    Writes a data set: a Parquet file an episode, and what is known of all of them.

    :param folder: does not exist yet, or is empty.
    :param env: whose episodes they are.
    """

    def __init__(self, folder: Path, env: PickCube) -> None:
        if folder.exists() and any(folder.iterdir()):
            raise ArmsimError(f'{folder} is not empty; name a new folder')
        self.folder, self.env, self.lengths, self.digests = folder, env, [], []
        (folder / 'meta').mkdir(parents=True)
        self._episodes = (folder / 'meta' / 'episodes.jsonl').open('w', encoding='utf-8')
        self._stats = (folder / 'meta' / 'episodes_stats.jsonl').open('w', encoding='utf-8')

    def add(self, episode: Episode) -> None:
        """Write the next episode."""
        number, length, first = len(self.lengths), len(episode.actions), sum(self.lengths)
        frames = np.arange(length)
        columns = {
            'observation.state': episode.states, 'action': episode.actions,
            'timestamp': (frames * PERIOD).astype(np.float32), 'frame_index': frames,
            'episode_index': np.full(length, number), 'index': frames + first,
            'task_index': np.zeros(length, dtype=np.int64),
        }
        table = pa.table({
            name: pa.FixedSizeListArray.from_arrays(values.ravel(), values.shape[1])
            if values.ndim == 2 else pa.array(values)
            for name, values in columns.items()
        })
        path = self.folder / f'data/chunk-{number // CHUNK:03d}/episode_{number:06d}.parquet'
        path.parent.mkdir(parents=True, exist_ok=True)
        parquet.write_table(table, path)
        self._line(self._episodes, {
            'episode_index': number, 'tasks': [TASK], 'length': length,
            'success': episode.success, 'digest': episode.digest})
        self._line(self._stats, {'episode_index': number, 'stats': {
            name: {
                'min': values.min(axis=0).reshape(-1).tolist(),
                'max': values.max(axis=0).reshape(-1).tolist(),
                'mean': values.mean(axis=0).reshape(-1).tolist(),
                'std': values.std(axis=0).reshape(-1).tolist(), 'count': [length],
            } for name, values in columns.items()}})
        self.lengths.append(length)
        self.digests.append(episode.digest)

    def close(self) -> str:
        """Write what is known of all episodes; return a digest of them."""
        self._episodes.close()
        self._stats.close()
        meta, count = self.folder / 'meta', len(self.lengths)
        feature = {'dtype': 'int64', 'shape': [1], 'names': None}
        info = {
            'codebase_version': 'v2.1', 'robot_type': self.env.cell.model.name,
            'total_episodes': count, 'total_frames': sum(self.lengths), 'total_tasks': 1,
            'total_videos': 0, 'total_chunks': -(-count // CHUNK), 'chunks_size': CHUNK,
            'fps': round(1.0 / PERIOD), 'splits': {'train': f'0:{count}'},
            'data_path': 'data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet',
            'video_path': None,
            'features': {
                'observation.state': {'dtype': 'float32', 'shape': [len(self.env.state_names)],
                                      'names': self.env.state_names},
                'action': {'dtype': 'float32', 'shape': [len(self.env.action_names)],
                           'names': list(self.env.action_names)},
                'timestamp': {**feature, 'dtype': 'float32'},
                **dict.fromkeys(('frame_index', 'episode_index', 'index', 'task_index'), feature),
            },
        }
        (meta / 'info.json').write_text(json.dumps(info, indent=4), encoding='utf-8')
        task = json.dumps({'task_index': 0, 'task': TASK})
        (meta / 'tasks.jsonl').write_text(f'{task}\n', encoding='utf-8')
        return hashlib.sha256('\n'.join(self.digests).encode()).hexdigest()

    @staticmethod
    def _line(file: object, facts: dict) -> None:
        print(json.dumps(facts), file=file)


def arguments_of(description: str) -> argparse.Namespace:
    """Return the parsed command line."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument('folder', type=Path, help='where the data set is written')
    parser.add_argument('--episodes', type=int, default=10)
    parser.add_argument('--seed', type=int, default=0, help='of the first episode')
    return parser.parse_args()


def collect(folder: Path, env: PickCube, episodes: Iterable[Episode]) -> None:
    """Write episodes, and print what they are."""
    data, successes = DataSet(folder, env), 0
    for episode in episodes:
        data.add(episode)
        successes += episode.success
    digest = data.close()
    print(f'{len(data.lengths)} episodes, {sum(data.lengths)} frames, {successes} successes')
    print(f'digest {digest}')


def main() -> None:
    """Collect in this process."""
    arguments = arguments_of('Collect episodes as a data set.')
    env = PickCube()
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    collect(arguments.folder, env, (run_episode(env, seed) for seed in seeds))


if __name__ == '__main__':
    try:
        main()
    except ArmsimError as error:
        sys.exit(f'collect_episodes: {error}')
