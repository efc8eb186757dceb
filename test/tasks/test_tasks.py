# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tasks by id: checkers, experts, what counts as success and what does not."""

from contextlib import closing
from dataclasses import replace
import subprocess
import sys
import warnings

import gymnasium
from gymnasium.utils.env_checker import check_env
import numpy as np
import pytest

from armsim_ros.errors import ConfigError
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.stack import ArmSim
from armsim_ros.tasks import PickCube, PlaceCube, PushCube, Reach, StackCubes, TASKS
from armsim_ros.tasks.hand import Hand, HandModel
from armsim_ros.tasks.task_observations import OBS_TYPES
from armsim_ros.tasks.workspace import workspace_of


@pytest.fixture(scope='module', params=['sunday', 'panda'])
def cell(request):
    """Return the checked files of an arm with a cup, and of an arm with fingers."""
    return load_cell(request.param)


@pytest.fixture(scope='module')
def sunday():
    """Return the checked files of the arm with a cup."""
    return load_cell('sunday')


def hold(env):
    """Return the action that leaves joints and gripper as they are commanded."""
    units = env._target.copy()
    if env.hand.model.cup:
        units = np.append(units, env.hand.level)
    return (units - env._middle) / env._half


def steps(env, count=8):
    """Hold for some steps; return whether the task was done."""
    done = False
    for _ in range(count):
        *_, terminated, _, info = env.step(hold(env))
        done |= info['is_success']
        assert terminated == info['is_success']
    return done


def put_item(env, name, xyz):
    """Put a cube somewhere, at rest and straight."""
    pose = np.eye(4)
    pose[:3, 3] = xyz
    env.sim.simulation.world.set_pose(name, pose)
    env.sim.simulation._plant.wake()


def run(env, seed):
    """Run the expert; return the steps, and whether it succeeded."""
    _, info = env.reset(seed=seed)
    assert not info['is_success']
    for count in range(env._max_episode_steps):
        *_, terminated, _, info = env.step(env.expert())
        if terminated:
            return count + 1, True
    return count + 1, False


@pytest.mark.parametrize('obs_type', OBS_TYPES[:2])
@pytest.mark.parametrize('name', TASKS)
def test_gymnasiums_checker_finds_nothing(sunday, name, obs_type):
    """No error and no warning of its checker."""
    env = gymnasium.make(f'armsim_ros.tasks:armsim/{name}', robot=sunday, obs_type=obs_type)
    with closing(env), warnings.catch_warnings():
        warnings.simplefilter('error')
        check_env(env.unwrapped, skip_render_check=True)


@pytest.mark.parametrize('name', TASKS)
@pytest.mark.parametrize('action', ['position', 'twist'])
def test_the_expert_succeeds(cell, name, action):
    """With default randomisation, for three seeds."""
    with closing(TASKS[name](cell, action=action)) as env:
        assert [run(env, seed)[1] for seed in range(3)] == [True] * 3


@pytest.mark.parametrize('name', TASKS)
def test_zero_and_random_actions_do_not(sunday, name):
    """Neither holding still nor actions by chance solve a task."""
    with closing(TASKS[name](sunday)) as env:
        for sample in (lambda: np.zeros(7), env.action_space.sample):
            env.action_space.seed(3)
            env.reset(seed=3)
            assert not any(env.step(sample())[4]['is_success'] for _ in range(60))


def test_the_expert_depends_on_the_state_alone(sunday):
    """From a restored state it gives the same actions and ends in the same digest."""
    with closing(PlaceCube(sunday)) as env, closing(PlaceCube(sunday)) as other:
        env.reset(seed=4)
        for _ in range(20):
            env.step(env.expert())
        state = env.save_state()
        other.reset(seed=9)
        other.restore_state(state)
        for _ in range(20):
            ours, theirs = env.expert(), other.expert()
            assert ours.tobytes() == theirs.tobytes()
            env.step(ours)
            other.step(theirs)
        assert env.digest() == other.digest()


def test_passing_the_target_is_not_reaching_it(sunday):
    """At the target but moving does not count; at rest there it does."""
    with closing(Reach(sunday)) as env:
        env.reset(seed=0)
        for _ in range(3):
            env.step(env.expert())
        assert env.hand.speed > 0.05
        site = env.sim.simulation.mujoco_model.site('target')
        site.pos[:] = env.hand.point
        assert not env.solved()
        for _ in range(6):
            env.step(hold(env))
        site.pos[:] = env.hand.point
        assert steps(env)


def test_a_dense_reward_grows_towards_the_target(sunday):
    """Between -1 and 0 on the way, more at each step of the expert but the last; then 1."""
    with closing(Reach(sunday, reward_type='dense')) as env:
        env.reset(seed=0)
        rewards, done = [], False
        while not done:
            _, reward, done, _, _ = env.step(env.expert())
            rewards.append(reward)
    assert rewards[-1] == 1.0
    assert all(-1.0 < reward < 0.0 for reward in rewards[:-1])
    assert rewards[:8] == sorted(rewards[:8])


def test_a_cube_in_the_air_that_is_not_held_is_not_picked(cell):
    """Thrown up by 0.2 m it falls without success."""
    with closing(PickCube(cell)) as env:
        env.reset(seed=0)
        put_item(env, 'cube', env.item_xyz('cube') + np.array([0, 0, 0.3]))
        assert not steps(env, 10)


def test_placing_is_resting_on_the_mark(cell):
    """On the mark it counts, 0.03 m beside it does not."""
    with closing(PlaceCube(cell)) as env:
        for aside, success in ((0.03, False), (0.015, True)):
            env.reset(seed=1)
            put_item(env, 'cube', env.target + np.array([aside, 0.0, 0.02]))
            assert steps(env) == success


def test_a_cube_held_over_the_mark_is_not_placed(sunday):
    """Success comes only after the cube was let go."""
    with closing(PlaceCube(sunday)) as env:
        env.reset(seed=1)
        held = 0
        for _ in range(env._max_episode_steps):
            *_, terminated, _, info = env.step(env.expert())
            if env.hand.holds('cube'):
                held += 1
                assert not info['is_success']
            if terminated:
                break
        assert terminated
        assert held > 5


def test_a_carried_cube_is_not_pushed(cell):
    """At the mark at rest counts; not after it was lifted by more than 0.02 m."""
    with closing(PushCube(cell)) as env:
        for lifted, success in ((False, True), (True, False)):
            env.reset(seed=2)
            if lifted:
                put_item(env, 'cube', env.item_xyz('cube') + np.array([0, 0, 0.06]))
                env.step(hold(env))
            put_item(env, 'cube', env.target + np.array([0.01, 0.0, 0.02]))
            assert steps(env, 12) == success


def test_stacking_is_red_on_green(cell):
    """Red beside green does not count, nor green on red; red on green does."""
    with closing(StackCubes(cell)) as env:
        for lower, upper, side, success in (
                ('green', 'red', (0.045, 0, 0), False), ('red', 'green', (0, 0, 0.04), False),
                ('green', 'red', (0.005, 0, 0.04), True)):
            env.reset(seed=3)
            base = np.array([*env.place.centre, env.place.surface + 0.02])
            put_item(env, lower, base)
            put_item(env, upper, base + side)
            assert steps(env, 12) == success


def test_a_robot_without_a_place_of_its_own_works_below_its_hand():
    """The area is about the point of the grasp at the start, with room between."""
    panda = load_cell('panda')
    cell = replace(panda, robots=tuple(replace(one, name='mine') for one in panda.robots))
    place, hand = workspace_of(cell), Hand(ArmSim(cell), HandModel.of(cell))
    np.testing.assert_allclose(place.centre, hand.point[:2], atol=1e-3)
    assert hand.point[2] - place.surface == pytest.approx(0.15, abs=1e-3)


def test_the_start_never_solves_the_task(sunday):
    """A draw that is solved already is drawn again; where all are, it is an error."""
    place = PlaceCube(sunday).place
    x, y = place.centre
    near = {'objects.cube.xyz': (x, y, place.surface + 0.02),
            'target.xyz': ((x, y, place.surface), (x + 0.04, y, place.surface))}
    with closing(PlaceCube(sunday, randomize=near)) as env:
        for seed in range(5):
            _, info = env.reset(seed=seed)
            assert info['randomization']['target.xyz'][0] > x + 0.02
        with pytest.raises(ConfigError, match='no start of PlaceCube'):
            env.reset(options={'target.xyz': (x, y, place.surface)})


def test_observations_have_the_kinds_of_lerobot(sunday):
    """Keys, shapes and names agree."""
    with closing(StackCubes(sunday, obs_type='environment_state_agent_pos')) as env:
        observation, _ = env.reset(seed=0)
        assert set(observation) == {'agent_pos', 'environment_state'}
        assert observation['agent_pos'].shape == (len(env.state_names),)
        assert observation['environment_state'].shape == (len(env.environment_state_names),)
        names = dict(zip(env.environment_state_names, observation['environment_state'],
                         strict=True))
        np.testing.assert_allclose(
            [names['red.x'], names['red.y'], names['red.z']], env.item_xyz('red'), atol=1e-6)


def test_actions_are_scaled_to_the_bounds(sunday):
    """The bounds of the space are those of ``ArmEnv``; unscaled actions do the same."""
    with (closing(Reach(sunday)) as env,
          closing(Reach(sunday, normalize_actions=False)) as plain):
        np.testing.assert_allclose(env.to_units(np.ones(7)), plain.action_space.high)
        for each in (env, plain):
            each.reset(seed=1)
        for _ in range(5):
            action = env.expert()
            env.step(action)
            plain.step(env.to_units(action))
        assert env.digest() == plain.digest()


@pytest.mark.parametrize(('arguments', 'complaint'), [
    ({'obs_type': 'pixel'}, "did you mean 'pixels'"), ({'cameras': ('frnt',)}, "mean 'front'"),
    ({'image_size': (0, 96)}, '1 to 640'), ({'randomize': 'all'}, 'default, none'),
    ({'robot': 'two_bots'}, 'for one robot'), ({'robot': 'bot'}, 'nothing to grasp with'),
    ({'randomize': {'target.xy': 1}}, "no 'target.xy'"),
])
def test_wrong_arguments_are_told(sunday, arguments, complaint):
    """Each is one message that says what is allowed."""
    with pytest.raises(ConfigError) as told:
        PlaceCube(**{'robot': sunday, **arguments})
    assert complaint in str(told.value)


def test_an_id_works_in_a_process_that_knows_nothing(sunday):
    """``module:id`` registers the tasks; seeds and actions give the same bytes there."""
    program = """
import gymnasium
env = gymnasium.make('armsim_ros.tasks:armsim/PickCube-v1').unwrapped
env.reset(seed=6)
for _ in range(10):
    env.step(env.expert())
print(env.digest())
"""
    child = subprocess.run([sys.executable, '-c', program], check=True, capture_output=True,
                           text=True)
    with closing(PickCube(sunday)) as env:
        run(env, 1)
        env.reset(seed=6)
        for _ in range(10):
            env.step(env.expert())
        assert child.stdout.strip() == env.digest()


def test_a_vector_of_tasks_ends_episodes():
    """``make_vec`` truncates after the steps of the id, and reports success of each row."""
    vector = gymnasium.make_vec(
        'armsim_ros.tasks:armsim/Reach-v1', num_envs=2, max_episode_steps=3,
        vectorization_mode='vector_entry_point', obs_type='environment_state_agent_pos')
    with closing(vector):
        observation, info = vector.reset(seed=0)
        assert observation['agent_pos'].shape == (2, 7)
        assert info['is_success'].tolist() == [False, False]
        assert vector.call('_max_episode_steps') == (3, 3)
        ends = [vector.step(np.zeros((2, 7)))[3].tolist() for _ in range(3)]
        assert ends == [[False, False], [False, False], [True, True]]
