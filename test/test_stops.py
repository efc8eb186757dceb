# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Stops of an arm: what ends, how the joints come to rest, and what moves afterwards."""

import numpy as np
import pytest

from armsim_ros.control.mailbox import GoalStatus
from armsim_ros.errors import ControllerError
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory

JOINTS = tuple(f'joint_{i}' for i in range(1, 7))
TURN = np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])


@pytest.fixture
def sim(arm):
    """Return the stack of the test's arm."""
    return arm.sim


def positions(sim):
    """Return where the arm's joints are (6,)."""
    return np.array([sim.joint_positions[name] for name in JOINTS])


def swing(sim, duration=2.0):
    """Return a motion to the other side, from where the arm is."""
    here = positions(sim)
    there = here + np.where(here > 0.0, -0.6, 0.6)
    return JointTrajectory(JOINTS, np.array([duration]), there[None], np.zeros((1, 6)))


def controller_of(sim):
    """Return the trajectory controller of the arm."""
    return sim.manager.controllers['arm_joint_controller']


def test_a_stop_ends_the_goal_with_its_cause(sim):
    """
    A running goal ends within 100 ms, aborted, with the words protective stop and the cause.

    HW-B3.
    """
    (goal,) = sim.send_trajectory(swing(sim))
    sim.run_until(sim.time + 0.8)
    sim.protective_stop('a person is near')
    sim.run_until(sim.time + 0.1)
    assert goal.status is GoalStatus.ABORTED
    assert goal.result.message == 'protective stop: injected: a person is near'
    assert set(sim.safety.values()) == {'PROTECTIVE_STOP'}


def test_goals_are_taken_as_soon_as_the_stop_is_cleared(sim):
    """HW-B5: Also before the next update."""
    sim.protective_stop()
    sim.run_until(sim.time + 0.5)
    sim.clear_stop()
    (goal,) = sim.send_trajectory(swing(sim))
    sim.run_until(sim.time + 2.5)
    assert goal.status is GoalStatus.SUCCEEDED


def test_the_joints_brake_along_the_path_and_rest(sim):
    """HW-B2: The joints keep their ratio of speeds while they slow down, and rest within 0.5 s."""
    start = positions(sim)
    motion = swing(sim)
    way = motion.positions[0] - start
    sim.send_trajectory(motion)
    sim.run_until(sim.time + 1.0)
    before = np.abs(sim.simulation.state.velocity).max()
    sim.protective_stop()
    sim.run_until(sim.time + 0.02)
    fast = np.abs(sim.simulation.state.velocity).max()
    sim.run_until(sim.time + 0.48)
    rest = positions(sim)
    assert fast < 0.9 * before
    assert fast > 0.3 * before
    share = float((rest - start) @ way / (way @ way))
    assert share > 0.5
    assert np.abs(rest - start - share * way).max() < 1e-3
    sim.run_until(sim.time + 1.0)
    assert np.abs(positions(sim) - rest).max() < 1e-4


def test_goals_are_rejected_until_the_stop_is_cleared(sim):
    """HW-B5: A stopped arm rejects goals with the reason; afterwards it takes them."""
    sim.protective_stop()
    response = controller_of(sim).send_goal(swing(sim))
    assert response.reason == 'protective stop: injected'
    sim.step(5)
    assert not controller_of(sim).send_goal(swing(sim)).accepted
    sim.clear_stop()
    sim.step(20)
    sim.execute(swing(sim))
    assert set(sim.safety.values()) == {'NORMAL'}


def test_an_emergency_stop_is_released_before_it_is_cleared(sim):
    """HW-B4: A pressed button refuses to be cleared, and its release alone lets nothing move."""
    arm = sim.manager.arm
    arm.emergency_stop()
    sim.step(20)
    with pytest.raises(ControllerError, match='release it first'):
        sim.clear_stop()
    arm.release_emergency_stop()
    sim.step(20)
    assert 'emergency stop' in controller_of(sim).send_goal(swing(sim)).reason
    sim.clear_stop()
    sim.step(20)
    sim.execute(swing(sim))


def test_an_arm_without_power_takes_no_goals(sim):
    """HW-B1: Switched-off drives hold the arm, and reject goals until they run again."""
    arm = sim.manager.arm
    (goal,) = sim.send_trajectory(swing(sim))
    sim.run_until(sim.time + 0.5)
    arm.power_to(type(arm.mode).POWER_OFF)
    sim.step(20)
    assert goal.status is GoalStatus.ABORTED
    assert 'POWER_OFF' in controller_of(sim).send_goal(swing(sim)).reason
    arm.power_to(type(arm.mode).RUNNING)
    sim.step(20)
    sim.execute(swing(sim))


def test_a_reset_clears_a_stop(sim):
    """HW-B7: After a reset of the simulation the arm is as at the start."""
    sim.protective_stop()
    sim.step(20)
    sim.loop.restart('the simulation was reset')
    sim.step(20)
    sim.execute(swing(sim))
    assert set(sim.safety.values()) == {'NORMAL'}


@pytest.mark.parametrize('watch', ['always', 'never'])
def test_a_joint_that_is_too_fast_stops_the_arm(watch):
    """HW-B1: At more than 1.2 times its limit; unless the arm is not watched."""
    sim = ArmSim('sunday', overrides={'simulation.hardware.watch': watch})
    sim.step(20)
    joint = sim.simulation.mujoco_model.joint('sunday/joint_1')
    fast = 3.0 * sim.model.joints['joint_1'].limits.velocity
    sim.simulation.mujoco_data.qvel[joint.dofadr[0]] = fast
    sim.step(2)
    cause = sim.manager.arm.cause
    if watch == 'never':
        assert cause is None
    else:
        assert (cause.kind, cause.joint) == ('speed', 'joint_1')
        assert sim.manager.arm.since_ns <= 22_000_000  # within two control periods


def test_a_joint_outside_of_its_bounds_stops_the_arm():
    """HW-B1: By more than 0.01 rad; the text has position and bound."""
    sim = ArmSim('sunday', overrides={'simulation.hardware.watch': 'always'})
    upper = sim.model.joints['joint_1'].limits.upper
    sim.simulation.set_positions({'joint_1': upper + 0.005})
    sim.step(5)
    assert not sim.manager.arm.stopped
    sim.simulation.set_positions({'joint_1': upper + 0.05})
    sim.step(5)
    assert str(sim.manager.arm.cause).startswith("position: joint 'joint_1' ")


def hitting(force, torque=0.0):
    """Return an arm that a collision stops, with a block in its way."""
    overrides = {'simulation.hardware.collision.force': force,
                 'simulation.hardware.collision.torque': torque}
    sim = ArmSim('sunday', overrides=overrides)
    model = sim.scene.kinematic_model
    halfway = sim.joint_positions | {'joint_2': sim.joint_positions['joint_2'] + 0.5}
    tip = model.link_pose(model.vector(halfway), 'link_6')[:3, 3]
    pose = pose_matrix(tuple(tip), (0.0, 0.0, 0.0))
    sim.add_object(WorldObject.of_shape('block', Box((0.05, 0.05, 0.05)), pose))
    return sim


@pytest.mark.parametrize('limits', [{'force': 30.0}, {'force': 1e6, 'torque': 15.0}])
def test_a_collision_stops_the_arm(limits):
    """HW-B1: A contact force or an external torque over its limit ends the goal and names both."""
    sim = hitting(**limits)
    here = positions(sim)
    motion = JointTrajectory(JOINTS, np.array([2.0]), (here + TURN)[None])
    (goal,) = sim.send_trajectory(motion)
    sim.run_until(lambda: goal.done)
    assert goal.result.message.startswith('protective stop: collision: ')
    assert 'limit' in goal.result.message


def test_equal_runs_stop_in_the_same_step():
    """HW-B7: A collision stops the arm at the same time, however the steps are requested."""
    times = []
    for step in (1, 7, 100):
        sim = hitting(30.0)
        motion = JointTrajectory(
            JOINTS, np.array([2.0]), (positions(sim) + TURN)[None])
        sim.send_trajectory(motion)
        while sim.time < 2.0:
            sim.step(step)
        times.append(sim.manager.arm.since_ns)
    assert times[0] > 0
    assert len(set(times)) == 1
