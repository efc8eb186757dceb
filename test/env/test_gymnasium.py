# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The environment in Gymnasium's hands."""

from contextlib import closing
from functools import partial

import gymnasium
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv
import numpy as np
import pytest

from armsim_ros.env import ArmEnv
from armsim_ros.tasks import TASKS

statement = pytest.mark.statement


@statement('H1')
@pytest.mark.filterwarnings('ignore:.*(Box (action|observation) space|alternative render modes)')
@pytest.mark.parametrize('kind', ['position', 'velocity', 'twist'])
def test_passes_gymnasiums_checker(kind):
    """``gymnasium.make`` makes it, and ``check_env`` finds nothing wrong."""
    env = gymnasium.make('armsim_ros.env:armsim/Arm-v0', action=kind)
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


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


@pytest.mark.parametrize('name', TASKS)
def test_the_spec_of_a_task_survives_json(name):
    """What is read back from ``to_json`` makes the same task, alone and as a vector."""
    with closing(gymnasium.make(f'armsim/{name}', robot='panda')) as env:
        text = env.spec.to_json()
    spec = gymnasium.envs.registration.EnvSpec.from_json(text)
    with closing(gymnasium.make(spec)) as again:
        assert type(again.unwrapped) is TASKS[name]
        assert again.unwrapped.joints == env.unwrapped.joints
    with closing(gymnasium.make_vec(spec, num_envs=1)) as vector:
        assert vector.call('task') == (TASKS[name].task,)
