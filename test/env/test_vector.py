# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Environments in processes of their own."""

from functools import partial
import os
import signal

import numpy as np
import pytest

from armsim_ros.env import ArmEnv, ProcessVector
from armsim_ros.errors import ArmsimError

statement = pytest.mark.statement
RANGES = {'objects': {'cube': {'mass': (0.1, 0.5)}}, 'joints': {'joint_1': (-0.3, 0.3)}}
TURN = np.array([0.5, 0.1, 0.0, 0.0, 0.2, 0.0, 0.0])
make = partial(ArmEnv, action='velocity', randomize=RANGES, max_steps=6)


@statement('H2')
def test_equal_seeds_give_equal_digests(new_env):
    """Each process ends in the digest of one environment with its seed, after resets, too."""
    with ProcessVector([make, make]) as vector:
        observed = vector.reset(seed=20)
        assert observed['joint_positions'].shape == (2, 6)
        for _ in range(9):  # the seventh resets
            observed, rewards, terminated, truncated = vector.step(np.stack([TURN, TURN]))
        assert rewards.shape == terminated.shape == truncated.shape == (2,)
        digests = vector.digests()
    for place, digest in enumerate(digests):
        env = new_env(action='velocity', randomize=RANGES)
        env.reset(seed=20 + place)
        for _ in range(6):
            env.step(TURN)
        env.reset()
        for _ in range(2):
            one, *_ = env.step(TURN)
        assert env.digest() == digest
        assert one['tip_pose'].tobytes() == observed['tip_pose'][place].tobytes()
    assert digests[0] != digests[1]


def test_mistakes_name_the_environment():
    """A wrong action, and an environment that cannot be made, are told with their number."""
    with ProcessVector([make]) as vector:
        vector.reset(seed=0)
        with pytest.raises(ArmsimError, match='environment 0: an action is 7 finite numbers'):
            vector.step(np.zeros((1, 3)))
        vector.step(TURN[None])
    with pytest.raises(ArmsimError, match=r'environment 0: .*sundy'):
        ProcessVector([partial(ArmEnv, 'sundy')])


def test_a_process_that_is_killed_is_told():
    """Where a process is gone its number and status are said, and closing still works."""
    with ProcessVector([make]) as vector:
        os.kill(vector._processes[0].pid, signal.SIGKILL)
        vector._processes[0].join()
        with pytest.raises(ArmsimError, match='environment 0: its process has ended'):
            vector.reset(seed=0)
