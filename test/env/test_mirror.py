# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A simulation that shows what is measured of another arm."""

import gymnasium
import mujoco
import numpy as np
import pytest

from armsim_ros.env.motion import Mirror
import armsim_ros.tasks  # noqa: F401 - registers the ids


def measured(task):
    """Return what joint states and entity states report of a task's arm."""
    simulation = task.sim.simulation
    state, data = simulation.state, simulation.mujoco_data
    joints = [dict(zip(simulation.joint_names, values.tolist(), strict=True))
              for values in (state.position, state.velocity, state.effort)]
    objects = {}
    for name in task.objects:
        joint = simulation.mujoco_model.joint(f'object/{name}')
        at, dof = int(joint.qposadr[0]), int(joint.dofadr[0])
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, data.qpos[at + 3:at + 7])
        velocity = data.qvel[dof:dof + 6].copy()
        velocity[3:] = turn.reshape(3, 3) @ velocity[3:]
        objects[name] = data.qpos[at:at + 7].copy(), velocity
    return (*joints, objects)


@pytest.mark.parametrize('robot', ['sunday', 'panda'])
@pytest.mark.parametrize('task', ['Reach', 'PushCube', 'StackCubes'])
def test_the_expert_acts_the_same_on_measurements(task, robot):
    """What is held, by cup or fingers, and each action equal those of the arm itself."""
    arm, shown = (gymnasium.make(f'armsim/{task}-v1', robot=robot).unwrapped for _ in range(2))
    for env in (arm, shown):
        env.reset(seed=1)
    mirror = Mirror(shown.sim.simulation, shown.objects)
    for _ in range(150):
        action = arm.expert()
        assert np.array_equal(shown.expert(), action)
        arm.step(action)
        shown._target = arm._target.copy()
        for name, cup in arm.sim.simulation.vacuum_grippers.items():
            other = shown.sim.simulation.vacuum_grippers[name]
            if other.on != cup.on:
                (other.switch_on if cup.on else other.switch_off)()
        mirror.show(*measured(arm))
        assert [shown.hand.holds(name) for name in shown.objects] == [
            arm.hand.holds(name) for name in arm.objects]
        if arm.is_success:
            return
    pytest.fail('the expert did not solve the task')
