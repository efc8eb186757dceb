# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The environment with Gymnasium, and without."""

from functools import partial
import os
from pathlib import Path
import subprocess
import sys

import gymnasium
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv
import numpy as np
import pytest

from armsim_ros.env import ArmEnv, own_gym

ROOT = Path(__file__).parents[2]
statement = pytest.mark.statement

WITHOUT = """
import sys
sys.modules['gymnasium'] = None
import importlib.util
find = importlib.util.find_spec
importlib.util.find_spec = lambda name, *more: None if name == 'gymnasium' else find(name, *more)

from armsim_ros.env import ArmEnv, own_gym

env = ArmEnv(action='velocity')
assert isinstance(env, own_gym.Env)
observation, info = env.reset(seed=3)
assert observation in env.observation_space
env.action_space.seed(1)
for _ in range(5):
    observation, *_ = env.step(env.action_space.low / 10)
print(env.digest())
"""


@statement('H1')
@pytest.mark.filterwarnings('ignore:.*(Box (action|observation) space|alternative render modes)')
@pytest.mark.parametrize('kind', ['position', 'velocity', 'twist'])
def test_passes_gymnasiums_checker(kind):
    """``gymnasium.make`` makes it, and ``check_env`` finds nothing wrong."""
    env = gymnasium.make('armsim_ros.env:armsim/Arm-v0', action=kind)
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


@statement('H1')
def test_works_without_gymnasium(new_env):
    """Without Gymnasium the same calls end in the same digest."""
    child = subprocess.run(
        [sys.executable, '-c', WITHOUT], check=False, capture_output=True, text=True,
        env={**os.environ, 'PYTHONPATH': str(ROOT)})
    assert child.returncode == 0, child.stderr
    env = new_env(action='velocity', randomize={})
    env.reset(seed=3)
    for _ in range(5):
        env.step(env.action_space.low / 10)
    assert child.stdout.strip() == env.digest()


@statement('H1')
def test_own_spaces_are_as_gymnasiums():
    """Our spaces have samples, bounds and membership as Gymnasium's."""
    low, high = np.array([-1.0, -np.inf]), np.array([2.0, np.inf])
    ours, theirs = own_gym.Box(low, high), gymnasium.spaces.Box(low, high, dtype=np.float64)
    ours.seed(1)
    for value in (ours.sample(), theirs.sample(), low, np.array([3.0, 0.0]), np.zeros(3)):
        assert ours.contains(value) == theirs.contains(value)
    both = own_gym.Dict({'b': ours, 'a': ours})
    assert both.sample() in both
    assert {'a': low} not in both


@statement('H2')
@pytest.mark.filterwarnings('ignore:.*Box (action|observation) space')
def test_gymnasiums_processes_give_equal_results(new_env):
    """AsyncVectorEnv with two processes observes what one process does, seed by seed."""
    make = partial(ArmEnv, action='velocity', randomize={'joints': {'joint_1': (-0.3, 0.3)}})
    vector = AsyncVectorEnv([make, make], context='spawn', shared_memory=False)
    try:
        observed, _ = vector.reset(seed=10)
        action = np.array([0.3, -0.1, 0.0, 0.1, 0.0, 0.2, 0.0])
        for _ in range(4):
            observed, *_ = vector.step(np.stack([action, action]))
    finally:
        vector.close()
    for place in range(2):
        env = new_env(action='velocity', randomize={'joints': {'joint_1': (-0.3, 0.3)}})
        env.reset(seed=10 + place)
        for _ in range(4):
            one, *_ = env.step(action)
        for name, values in one.items():
            assert values.tobytes() == observed[name][place].tobytes()
