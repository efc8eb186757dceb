# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Many environments at once."""

from contextlib import closing
from functools import partial
from multiprocessing import active_children
import os
import signal

from gymnasium.vector import AutoresetMode, SyncVectorEnv
import numpy as np
import pytest
from step_counter import FAILS, INTERRUPTED, StepCounter, UNPICKLABLE

from armsim_ros.env import ArmEnv, ArmVectorEnv
from armsim_ros.errors import ArmsimError, ConfigError

RANGES = {'objects': {'cube': {'mass': (0.1, 0.5)}}, 'joints': {'joint_1': (-0.3, 0.3)}}
TURN = np.array([0.5, 0.1, 0.0, 0.0, 0.2, 0.0, 0.0])
make = partial(ArmEnv, action='velocity', randomize=RANGES, max_steps=4)


@pytest.fixture
def counters():
    """Return a vector of an environment of this process and one of another, at step 1."""
    with closing(ArmVectorEnv(StepCounter, 2, workers=2)) as vector:
        vector.reset(seed=0)
        vector.step(np.zeros((2, 1)))
        yield vector


def steps_of(vector):
    """Return which step each environment is at after another one."""
    return vector.step(np.zeros((2, 1)))[0][:, 0].tolist()


def single(env, seed, mode):
    """Return what a single environment gives in seven steps, with its autoreset."""
    rows, ended = [env.reset(seed=seed)[0]], False
    for _ in range(7):
        if ended and mode is AutoresetMode.NEXT_STEP:
            rows.append(env.reset()[0])
            ended = False
            continue
        observation, _, terminated, truncated, _ = env.step(TURN)
        ended = terminated or truncated
        rows.append(env.reset()[0] if ended and mode is AutoresetMode.SAME_STEP else observation)
    return rows


@pytest.mark.parametrize('mode', [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_rows_equal_single_environments(new_env, mode):
    """Three environments in two processes give the bytes of single environments."""
    with closing(ArmVectorEnv(make, 3, workers=2, autoreset_mode=mode)) as vector:
        rows = [vector.reset(seed=20)[0]]
        for _ in range(7):
            observation, rewards, *_ = vector.step(np.stack([TURN] * 3))
            rows.append({name: values.copy() for name, values in observation.items()})
        digests = vector.call('digest')
        assert rewards.shape == (3,)
    env = new_env(action='velocity', randomize=RANGES, max_steps=4)
    for place in (0, 1, 2):
        for ours, row in zip(single(env, 20 + place, mode), rows, strict=True):
            assert all(ours[name].tobytes() == row[name][place].tobytes() for name in ours)
        assert env.digest() == digests[place]
    assert len(set(digests)) == 3


def test_mistakes_name_the_environment():
    """A wrong action, and an environment that cannot be made, are told with their number."""
    with closing(ArmVectorEnv(make, 2, workers=2)) as vector:
        vector.reset(seed=0)
        wrong = np.stack([TURN, np.full(7, np.nan)])
        with pytest.raises(ArmsimError, match="environment 1: number 0 of the action, 'velocity"):
            vector.step(wrong)
        vector.step(np.stack([TURN, TURN]))
        os.kill(vector._processes[0].pid, signal.SIGKILL)
        with pytest.raises(ArmsimError, match='environment 1: its process has ended'):
            vector.step(np.stack([TURN, TURN]))


def test_an_environment_that_cannot_be_made_is_told():
    """The message of its maker, with its number; a vector of none is refused."""
    with pytest.raises(ArmsimError, match=r'environment 0: .*sundy'):
        ArmVectorEnv(partial(ArmEnv, 'sundy'), 1)
    with pytest.raises(ConfigError, match='num_envs=0'):
        ArmVectorEnv(make, 0)


@pytest.mark.parametrize('place', [0, 1])
def test_an_exception_of_a_task_ends_the_call_alone(counters, place):
    """It is raised with its traceback; later calls return the answers of their own steps."""
    actions = np.zeros((2, 1))
    actions[place] = FAILS
    with pytest.raises(ArmsimError, match=(
            rf'(?s)environment {place}: Traceback .*step_counter.*RuntimeError: no reward')):
        counters.step(actions)
    counters.reset(seed=0)
    assert steps_of(counters) == [1.0, 1.0]
    assert steps_of(counters) == [2.0, 2.0]


def test_a_call_that_was_interrupted_is_never_answered_later(counters):
    """After Ctrl-C in a step, answers of that step are not taken for those of the next."""
    with pytest.raises(KeyboardInterrupt):
        counters.step(np.array([[INTERRUPTED], [0.0]]))
    with pytest.raises(ArmsimError, match='an earlier call was interrupted'):
        counters.reset(seed=0)


def test_an_answer_that_cannot_be_pickled_is_told(counters):
    """The process that has the environment goes on."""
    with pytest.raises(ArmsimError, match=r'(?s)environment 1: .*cannot pickle'):
        counters.get_attr(UNPICKLABLE)
    assert steps_of(counters) == [2.0, 2.0]


def test_an_argument_that_cannot_be_pickled_reaches_no_environment(counters):
    """The error is Python's, and no environment has done the step."""
    with pytest.raises(TypeError, match='cannot pickle'):
        counters.call('step', getattr(StepCounter, UNPICKLABLE))
    assert steps_of(counters) == [2.0, 2.0]


def test_an_exception_of_a_maker_leaves_no_process():
    """A wrong argument is told with the number of the environment, and all processes end."""
    before = set(active_children())
    with pytest.raises(ArmsimError, match=r"(?s)environment 0: .*TypeError.*'colour'"):
        ArmVectorEnv(partial(StepCounter, colour=1), 2, workers=2)
    assert set(active_children()) == before


@pytest.mark.parametrize('mode', [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_a_masked_reset_observes_the_others_where_they_are(mode):
    """As in Gymnasium (sync_vector_env.py, reset): also after an episode began by itself."""
    observed = []
    for vector in (SyncVectorEnv([StepCounter] * 2, autoreset_mode=mode),
                   ArmVectorEnv(StepCounter, 2, workers=1, autoreset_mode=mode)):
        with closing(vector):
            vector.reset(seed=0)
            for _ in range(StepCounter.length + 1):
                vector.step(np.zeros((2, 1)))
            mask = np.array([False, True])
            observed.append(vector.reset(options={'reset_mask': mask})[0].tolist())
    assert observed[0] == observed[1]
