# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is drawn for an episode is what the physics has."""

import mujoco
import numpy as np
import pytest

from armsim_ros.env import ArmEnv
from armsim_ros.env.ranges import drawn, Quantity, ranges_from
from armsim_ros.env.variation import Variation


def physics(env):
    """Return the compiled physics of an environment."""
    return env.sim.simulation.mujoco_model


def test_another_range_changes_no_other_draw():
    """Each name has its own stream: with a second range the first draws what it drew before."""
    known = {'a.mass': Quantity(), 'b.xyz': Quantity(3)}
    one = ranges_from({'a.mass': (0, 1)}, known, 'test')
    both = ranges_from({'a.mass': (0, 1), 'b.xyz': ((0, 0, 0), (1, 1, 1))}, known, 'test')
    first, second = (drawn(ranges, np.random.default_rng(5)) for ranges in (one, both))
    assert first.values['a.mass'] == second.values['a.mass']
    assert len(set(second.values['b.xyz'])) == 3


def test_the_physics_has_what_was_drawn(new_env):
    """Mass, size, friction, joints, gravity and gains, to the last digit; then the base again."""
    env = new_env(randomize={})
    base = {name: getattr(physics(env), name).copy()
            for name in ('body_mass', 'body_inertia', 'geom_size', 'geom_friction', 'dof_damping',
                         'dof_armature', 'dof_frictionloss', 'body_invweight0')}
    cube = {'mass': 0.5, 'size': 1.5, 'friction': 0.3, 'color': (0.1, 0.2, 0.3)}
    env.reset(options={
        'objects': {'cube': cube}, 'gravity': (0, 0, -3.0), 'gains': 0.5,
        'joints': {'joint_1': {'damping': 0.7, 'friction': 0.2, 'armature': 0.9}}})
    model = physics(env)
    body = model.body('object/cube')
    geom = int(body.geomadr[0])
    dof = int(model.joint('sunday/joint_1').dofadr[0])
    assert body.mass[0] == 0.5
    np.testing.assert_allclose(model.geom_size[geom], 1.5 * base['geom_size'][geom], rtol=1e-12)
    inertia = base['body_inertia'][body.id] * 1.5**2 * 0.5 / base['body_mass'][body.id]
    np.testing.assert_allclose(body.inertia, inertia, rtol=1e-9)
    assert model.geom_friction[geom, 0] == 0.3
    np.testing.assert_allclose(model.geom_rgba[geom, :3], cube['color'], atol=1e-7)
    assert model.opt.gravity.tolist() == [0, 0, -3.0]
    assert [model.dof_damping[dof], model.dof_frictionloss[dof], model.dof_armature[dof]] == [
        0.7, 0.2, 0.9]
    env.reset()
    for name, values in base.items():
        assert np.array_equal(getattr(physics(env), name), values), name


def test_a_reset_does_not_compile_the_physics(new_env):
    """The compiled model stays the same object."""
    env = new_env()
    before = physics(env)
    env.reset(seed=1)
    env.reset(seed=2)
    assert physics(env) is before


def test_the_world_that_was_edited_is_made_anew(new_env):
    """A reset after an edit of the world begins with the world of the files."""
    from armsim_ros import Box, pose_matrix, WorldObject

    env = new_env()
    env.reset(seed=1)
    digest = env.digest()
    env.sim.add_object(WorldObject.of_shape(
        'post', Box((0.1, 0.1, 0.1)), pose_matrix((2.0, 2.0, 0.05))))
    env.reset(seed=1)
    assert 'post' not in env.sim.simulation.world.names
    assert env.digest() == digest


def test_info_given_back_as_options_is_the_same_episode(new_env):
    """Values of ``randomization`` as options give the same start without the seed."""
    env, other = new_env(), new_env()
    _, info = env.reset(seed=8)
    other.reset(seed=9, options=info['randomization'])
    assert env.digest() == other.digest()


def test_keys_of_others_are_ignored(new_env):
    """LeRobot's evaluation sends an option of its own."""
    env = new_env()
    env.reset(seed=1, options={'lerobot_new_rollout': True})


def test_actions_are_late_by_the_latency(new_env):
    """With a latency of two periods nothing moves in the first two steps; a state keeps them."""
    env = new_env(action='velocity', randomize={'latency': 2})
    env.reset(seed=0)
    turn = np.array([0.5, 0, 0, 0, 0, 0, 0])
    start = env.sim.joint_positions['joint_1']
    for _ in range(2):
        env.step(turn)
    assert env.sim.joint_positions['joint_1'] == pytest.approx(start, abs=1e-6)
    state = env.save_state()
    env.step(0 * turn)
    moved = env.sim.joint_positions['joint_1']
    assert moved > start + 1e-3
    env.restore_state(state)
    env.step(0 * turn)
    assert env.sim.joint_positions['joint_1'] == moved


def test_noise_is_on_the_observation_alone(new_env):
    """Observed positions spread by the given deviation; the physics is as without noise."""
    env = new_env(randomize={'noise.joint_positions': 0.01})
    quiet = new_env(randomize={})
    observation, _ = env.reset(seed=0)
    quiet.reset(seed=0)
    seen = [env.observe()['joint_positions'] for _ in range(200)]
    assert np.std(seen) == pytest.approx(0.01, rel=0.1)
    assert env.digest() == quiet.digest()
    assert np.array_equal(observation['joint_positions'], env.reset(seed=0)[0]['joint_positions'])


def test_branches_are_the_futures_of_a_state(new_env):
    """Each branch is what stepping from the state gives; the environment stays where it was."""
    env = new_env(action='velocity', randomize={})
    env.reset(seed=0)
    turn = np.array([0.5, 0, 0, 0, 0, 0, 0])
    state = env.save_state()
    env.step(turn)
    digest = env.digest()
    futures = env.branch(state, [[turn] * 3, [-turn] * 2])
    assert env.digest() == digest
    assert [len(future) for future in futures] == [3, 2]
    positions = [future[-1][0]['joint_positions'][0] for future in futures]
    assert positions[0] > 0.02 > -0.01 > positions[1]


def test_scaled_shapes_touch_where_they_are(cell):
    """A cube of twice the size rests at twice the height."""
    env = ArmEnv(cell, randomize={'objects.cube.size': 2.0,
                                  'objects.cube.xyz': (0.5, 0.3, 1.06)})
    observation, _ = env.reset(seed=0)
    hold = np.append(observation['joint_positions'], 0.0)
    for _ in range(40):
        observation, *_ = env.step(hold)
    assert observation['object_poses'][2] == pytest.approx(1.015 + 0.025, abs=1e-3)
    assert isinstance(env.sim.simulation.mujoco_model, mujoco.MjModel)
    assert Variation(env.sim, env.joints).known()['objects.cube.size'].above


def test_pushes_act_for_a_step_and_are_repeatable(new_env):
    """As strong and as often as drawn, in the same directions after a restored state."""
    env = new_env(randomize={'pushes': {'force': (20.0, 30.0), 'interval': 0.06}})
    force = env.reset(seed=3)[1]['randomization']['pushes.force']
    action = np.append([env.sim.joint_positions[name] for name in env.joints], 0.0)
    state = env.save_state()

    def run():
        env.restore_state(state)
        forces = []
        for _ in range(7):
            env.step(action)
            forces.append(np.linalg.norm(env.sim.simulation.mujoco_data.xfrc_applied))
        return forces, env.digest()

    forces, digest = run()
    assert 20.0 <= force <= 30.0
    np.testing.assert_allclose(forces, [0, 0, force, 0, 0, force, 0], atol=1e-9)
    assert run() == (forces, digest)
    env.reset(seed=3, options={'pushes.force': 0.0})
    for _ in range(7):
        env.step(action)
    assert not env.sim.simulation.mujoco_data.xfrc_applied.any()
    assert env.digest() != digest
