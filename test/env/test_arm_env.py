# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arm as an environment."""

import pickle

import numpy as np
import pytest

from armsim_ros.errors import ConfigError, SimulationError

KINDS = ('position', 'velocity', 'twist')
statement = pytest.mark.statement


def actions(env, count, share=0.2):
    """Return actions by chance, equal ones at each call."""
    env.action_space.seed(7)
    return [share * env.action_space.sample() for _ in range(count)]


def run(env, chosen):
    """Do actions; return the last observation."""
    for action in chosen:
        observation, *_ = env.step(action)
    return observation


@statement('H1')
@pytest.mark.parametrize('kind', KINDS)
def test_equal_seeds_and_actions_give_equal_bytes(new_env, kind):
    """Two environments end in one digest; what one did before does not matter."""
    first, second = new_env(action=kind), new_env(action=kind)
    second.reset(seed=1)
    run(second, actions(second, 5, 1.0))
    digests = []
    for env in (first, second):
        env.reset(seed=42)
        run(env, actions(env, 30))
        digests.append(env.digest())
    assert digests[0] == digests[1]


@statement('H2')
def test_seeds_decide_what_differs(new_env):
    """Pose, mass, friction, colour and start are in their ranges, other seeds draw others."""
    env = new_env()
    seen = []
    for seed in range(3):
        observation, info = env.reset(seed=seed)
        drawn = info['randomization']
        assert 0.1 <= drawn['objects.cube.mass'] <= 0.5
        assert 0.3 <= drawn['objects.cube.friction'] <= 1.0
        assert -0.3 <= observation['joint_positions'][0] <= 0.3
        place = env.sim.simulation.world.pose('cube')
        np.testing.assert_allclose(place[:3, 3], drawn['objects.cube.xyz'], atol=1e-12)
        seen.append(map(str, drawn.values()))
    assert len({value for values in seen for value in values}) == 18


@statement('H2')
def test_what_has_no_range_stays(new_env):
    """Other objects and joints begin as their files say."""
    env = new_env()
    env.reset(seed=3)
    world = env.cell.settings.world.objects
    for name in ('star', 'triangle', 'table'):
        np.testing.assert_allclose(
            env.sim.simulation.world.pose(name)[:3, 3], world[name].xyz, atol=1e-12)
    assert env.sim.joint_positions['joint_2'] == 0.0


@statement('H1')
def test_options_hold_for_one_episode(new_env):
    """An option of reset wins over the ranges, for this episode only."""
    env = new_env()
    options = {'objects': {'cube': {'mass': 0.25}}, 'joints': {'joint_2': 0.4}}
    _, info = env.reset(seed=3, options=options)
    assert info['randomization']['objects.cube.mass'] == 0.25
    assert env.sim.joint_positions['joint_2'] == pytest.approx(0.4)
    _, info = env.reset(seed=3)
    assert env.sim.joint_positions['joint_2'] == 0.0
    assert info['randomization']['objects.cube.mass'] != 0.25


@statement('H1')
@pytest.mark.parametrize('kind', KINDS)
def test_a_state_is_restored_bit_by_bit(new_env, kind):
    """Digest, observation and future are what they were, in the same environment."""
    env = new_env(action=kind)
    env.reset(seed=5)
    chosen = actions(env, 40)
    run(env, chosen[:20])
    state, digest = env.save_state(), env.digest()
    seen, end = run(env, chosen[20:]), None
    end = env.digest()
    env.restore_state(state)
    assert env.digest() == digest
    again = run(env, chosen[20:])
    assert env.digest() == end != digest
    assert all(seen[name].tobytes() == again[name].tobytes() for name in seen)


@statement('H1')
def test_a_state_travels_between_processes(new_env):
    """A pickled state goes on elsewhere as it would have here, with the objects asleep too."""
    env, other = new_env(), new_env()
    env.reset(seed=5)
    chosen = actions(env, 80)
    run(env, chosen[:60])
    assert (env.sim.simulation.mujoco_data.tree_asleep >= 0).any()
    packed = pickle.dumps(env.save_state())
    run(env, chosen[60:])
    other.reset(seed=9)
    other.restore_state(pickle.loads(packed))
    run(other, chosen[60:])
    assert other.digest() == env.digest()
    assert other.reset()[0]['joint_positions'].tolist() == env.reset()[
        0]['joint_positions'].tolist()


@statement('H1')
def test_a_state_of_another_world_is_refused(new_env):
    """An object that was added is named where the state does not know it."""
    from armsim_ros import Box, pose_matrix, WorldObject

    env = new_env()
    env.reset(seed=5)
    state = env.save_state()
    env.sim.add_object(WorldObject.of_shape(
        'post', Box((0.1, 0.1, 0.1)), pose_matrix((2.0, 2.0, 0.05))))
    with pytest.raises(SimulationError, match='post'):
        env.restore_state(state)


@statement('H1')
def test_positions_are_reached_at_the_end_of_the_step(new_env):
    """A position action within the speed limits is where the arm is a step later."""
    env = new_env(randomize={}, period=0.1)
    env.reset(seed=0)
    wanted = np.full(6, 0.05)
    env.step(np.append(wanted, 0.0))
    observation, *_ = env.step(np.append(wanted, 0.0))
    np.testing.assert_allclose(observation['joint_positions'], wanted, atol=1e-3)


@statement('H1')
def test_velocities_move_the_joints_so(new_env):
    """After half a second at 0.2 rad/s a joint is 0.1 rad further."""
    env = new_env(action='velocity', randomize={})
    env.reset(seed=0)
    observation = run(env, [np.array([0.2, 0, 0, 0, 0, 0, 0])] * 25)
    assert observation['joint_positions'][0] == pytest.approx(0.1, abs=2e-3)
    assert observation['joint_velocities'][0] == pytest.approx(0.2, abs=0.02)


@statement('H1')
def test_a_twist_moves_the_tip_in_the_world(new_env):
    """Half a second of 0.1 m/s up lifts the tip by 5 cm and does not turn it."""
    env = new_env(action='twist', randomize={})
    bent = dict(zip(env.joints, (0.5, 0.0, 1.2, 0.7, 0.8, -0.6), strict=True))
    before, _ = env.reset(seed=0, options={'joints': bent})
    after = run(env, [np.array([0, 0, 0.1, 0, 0, 0, 0])] * 25)
    np.testing.assert_allclose(
        after['tip_pose'][:3] - before['tip_pose'][:3], [0, 0, 0.05], atol=2e-3)
    assert abs(after['tip_pose'][3:] @ before['tip_pose'][3:]) == pytest.approx(1.0, abs=1e-3)


def test_actions_beyond_the_limits_are_taken_as_the_limits(new_env):
    """A joint stops at its limit, whatever the action says."""
    env = new_env(randomize={}, period=0.1)
    env.reset(seed=0)
    far = np.append(np.full(6, 100.0), 0.0)
    observation = run(env, [far] * 3)
    assert (observation['joint_positions'] <= env.action_space.high[:6] + 1e-3).all()


@pytest.mark.parametrize(('action', 'complaint'), [
    (np.zeros(6), r'7 numbers \(joint_1.*vacuum_gripper\); got shape \(6,\)'),
    (np.array([0, 0, np.nan, 0, 0, 0, 0]), "number 2 of the action, 'joint_3', is nan"),
])
def test_a_wrong_action_is_named(new_env, action, complaint):
    """The message names the number, or lists what an action is made of; nothing moves."""
    env = new_env()
    env.reset(seed=0)
    digest = env.digest()
    with pytest.raises(ValueError, match=complaint):
        env.step(action)
    assert env.digest() == digest


@pytest.mark.parametrize(('words', 'complaint'), [
    ({'action': 'torque'}, 'position, velocity, twist'),
    ({'period': 0.0123456}, 'whole number of control periods'),
    ({'randomize': {'objects': {'cub': {}}}}, "no 'objects.cub'"),
    ({'randomize': {'objects': {'cube': {'mas': 1.0}}}}, "did you mean 'objects.cube.mass'"),
    ({'randomize': {'objects': {'cube': {'mass': (2.0, 1.0)}}}}, 'a low above its high'),
    ({'randomize': {'objects.cube.mass': 0.0}}, 'must be above 0'),
    ({'randomize': {'objects.cube.friction': np.nan}}, 'is not finite'),
    ({'randomize': {'objects.cube.xyz': (1.0, 2.0)}}, '3 numbers, or (low, high) of these'),
    ({'randomize': {'objects': {'table': {'mass': (1.0, 2.0)}}}}, "no 'objects.table.mass'"),
    ({'randomize': {'objects.star.size': 2.0}}, "no 'objects.star.size'"),
    ({'randomize': {'joints': {'joint_9': (0, 1)}}}, "no 'joints.joint_9'"),
    ({'randomize': {'latency': 1.5}}, 'must be whole numbers'),
    ({'view': {'widht': 3}}, 'widht'),
])
def test_wrong_arguments_are_told(new_env, words, complaint):
    """Each mistake is one sentence that says what is allowed."""
    with pytest.raises(ConfigError) as told:
        new_env(**words)
    assert complaint in str(told.value)


def test_a_wrong_option_is_told(new_env):
    """Options of reset are checked like the ranges."""
    with pytest.raises(ConfigError, match=r"no option 'object'.*did you mean 'objects'"):
        new_env().reset(options={'object': {}})


def test_a_task_is_a_subclass(cell):
    """Reward and end come from a task; an episode is cut after its most steps."""
    from armsim_ros.env import ArmEnv

    class Turn(ArmEnv):
        def reward(self, observation):
            return float(observation['joint_positions'][0])

        def terminated(self, observation):
            return observation['joint_positions'][0] > 0.09

    env = Turn(cell, action='velocity', max_steps=30)
    env.reset(seed=0)
    turn = np.array([0.2, 0, 0, 0, 0, 0, 0])
    outcomes = [env.step(turn) for _ in range(30)]
    assert outcomes[10][1] == pytest.approx(0.044, abs=0.002)
    assert not outcomes[10][2]
    assert outcomes[-1][2]
    assert [one[3] for one in outcomes] == [False] * 29 + [True]


def test_a_plan_can_be_followed_by_actions(new_env):
    """An episode's stack plans; its trajectory, sampled, is a sequence of actions."""
    env = new_env()
    env.reset(seed=2)
    trajectory = env.sim.plan('scan_food')
    assert trajectory.joint_names == env.joints
    for positions in trajectory.positions[1:]:
        env.step(np.append(positions, 0.0))
    for _ in range(20):
        observation, *_ = env.step(np.append(trajectory.positions[-1], 0.0))
    np.testing.assert_allclose(
        observation['joint_positions'], trajectory.positions[-1], atol=1e-3)


@statement('H1')
@pytest.mark.parametrize('robot', ['bot', 'ROBOT', 'two_bots'])
def test_any_robot_is_an_environment(robot):
    """Arms of few axes, with mimic joints, and several at once: steps, and a state restored."""
    from armsim_ros.env import ArmEnv

    env = ArmEnv(robot, action='twist')
    observation, _ = env.reset(seed=1)
    assert observation in env.observation_space
    run(env, actions(env, 3))
    state, digest = env.save_state(), env.digest()
    run(env, actions(env, 3))
    assert env.digest() != digest
    env.restore_state(state)
    assert env.digest() == digest


def test_what_stops_an_arm_ends_the_episode_if_asked_to(new_env):
    """A load over the limit ends an episode with its cause; another begins without it."""
    env = new_env(robot='sunday', randomize={}, end_on_stop=True,
                  overrides={'simulation.hardware.collision.torque': 20.0})
    still = np.zeros(env.action_space.shape)
    env.reset(seed=1)
    *_, terminated, _, info = env.step(still)
    assert (terminated, info['stop']) == (False, '')
    env.sim.simulation.apply_wrench('link_6', force=(0.0, 150.0, 0.0))
    ends = [env.step(still + 0.01 * i) for i in range(1, 4)]
    *_, terminated, _, info = ends[-1]
    assert terminated
    assert 'limit' in info['stop']
    env.sim.simulation.apply_wrench('link_6')
    assert env.reset(seed=1)[1]['stop'] == ''
    assert not env.step(still)[2]
