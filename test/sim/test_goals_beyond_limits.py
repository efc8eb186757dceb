# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories and commands beyond the joints' limits: the physics bounds them, nothing else."""

from types import SimpleNamespace

import numpy as np
import pytest

from armsim_ros.control.trajectory.tolerances import JointTolerance
from armsim_ros.stack import ArmSim
from armsim_ros.testing.stacks import built_cell
from armsim_ros.trajectory import JointTrajectory

JOINTS = tuple(f'joint_{i}' for i in range(1, 7))


@pytest.fixture
def arm():
    """Return the sunday arm and its trajectory controller."""
    sim = ArmSim(built_cell('sunday', None, {}))
    sim.step(20)
    return sim, sim.manager.controllers['arm_joint_controller']


def motion(seconds, first):
    """Return a trajectory of the first joint."""
    return JointTrajectory(JOINTS, np.array([seconds]), np.array([[first, 0, 0, 0, 0, 0]], float))


def run(sim, seconds):
    """Run; return the first joint's largest position and speed."""
    fastest = furthest = 0.0
    for _ in range(round(seconds * 1000)):
        sim.step()
        state = sim.simulation.state
        furthest = max(furthest, float(state.position[0]))
        fastest = max(fastest, float(abs(state.velocity[0])))
    return furthest, fastest


def test_a_goal_beyond_the_position_limit_ends_at_the_limit(arm):
    """Without tolerances it succeeds (joint_trajectory_controller.cpp, update)."""
    sim, controller = arm
    limit = sim.simulation.model.joints['joint_1'].limits.upper
    goal = controller.send_goal(
        motion(limit / 1.5, limit + 0.5),
        path_tolerances=[JointTolerance(name, position=-1.0) for name in JOINTS],
        goal_tolerances=[JointTolerance(name, position=-1.0) for name in JOINTS],
    ).goal
    furthest, _ = run(sim, limit / 1.5 + 0.2)
    assert goal.status.name == 'SUCCEEDED'
    assert furthest == pytest.approx(limit, abs=0.02)


def test_a_goal_beyond_the_position_limit_violates_its_path_tolerance(arm):
    """With a path tolerance it is aborted where the joint stops (the same function)."""
    sim, controller = arm
    limit = sim.simulation.model.joints['joint_1'].limits.upper
    path = [JointTolerance('joint_1', position=0.1)]
    goal = controller.send_goal(motion(limit / 1.5, limit + 0.5), path_tolerances=path).goal
    run(sim, limit / 1.5 + 0.2)
    assert (goal.status.name, goal.result.code) == ('ABORTED', -4)


def test_a_goal_that_is_too_fast_goes_as_fast_as_the_drive(arm):
    """It is followed late, no faster than the drive moves, and succeeds without tolerances."""
    sim, controller = arm
    limit = sim.simulation.model.joints['joint_1'].limits.velocity
    erased = [JointTolerance(name, position=-1.0) for name in JOINTS]
    goal = controller.send_goal(motion(0.1, 1.0), erased, erased).goal
    furthest, fastest = run(sim, 2.0)
    assert goal.status.name == 'SUCCEEDED'
    assert furthest < 1.3
    assert fastest < 1.6 * limit
    assert sim.simulation.state.position[0] == pytest.approx(1.0, abs=5e-3)


@pytest.fixture
def streaming(arm):
    """Return a function that gives the arm to a group controller and sends it a command."""
    sim, _ = arm

    def send(kind, first):
        name = f'{kind}_stream'
        controller = sim.manager.load(SimpleNamespace(
            name=name, parameters={'joints': JOINTS},
            type=f'{kind}_controllers/JointGroup{kind.title()}Controller'))
        sim.manager.configure(name)
        result = sim.manager.switch(activate=[name], deactivate=['arm_joint_controller'])
        assert result.ok, result.message
        assert controller.receive([first, 0.0, 0.0, 0.0, 0.0, 0.0]) == ''
        return sim

    return send


def test_a_far_position_command_goes_as_fast_as_the_drive(streaming):
    """It is a step for the drive (forward_controllers_base.cpp, update), which stays stable."""
    sim = streaming('position', 1.0)
    furthest, fastest = run(sim, 2.0)
    assert furthest < 1.3
    assert fastest < 1.6 * sim.simulation.model.joints['joint_1'].limits.velocity
    assert sim.simulation.state.position[0] == pytest.approx(1.0, abs=5e-3)


def test_a_velocity_command_ends_at_the_position_limit(streaming):
    """It stands (the same function); the joint stops where its mechanics end."""
    sim = streaming('velocity', 1.0)
    limit = sim.simulation.model.joints['joint_1'].limits.upper
    furthest, _ = run(sim, limit + 2.0)
    assert furthest == pytest.approx(limit, abs=0.02)
    assert sim.simulation.state.position[0] == pytest.approx(limit, abs=0.01)
