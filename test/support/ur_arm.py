# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An arm of Universal Robots: names of its joints and controllers, and a motion of it."""

import numpy as np

from armsim_ros.trajectory import JointTrajectory

JOINTS = tuple(f'joint_{i}' for i in range(1, 7))
ARM, SCALED = 'arm_joint_controller', 'scaled_joint_trajectory_controller'
PACE = 'speed_scaling/speed_scaling_factor'


def positions(sim):
    """Return where the arm's joints are (6,)."""
    return np.array([sim.joint_positions[name] for name in JOINTS])


def swing(sim, controller, duration=1.0):
    """Send a motion of all joints by 0.5 rad; return the goal."""
    here = positions(sim)
    there = here + np.where(here > 0.0, -0.5, 0.5)
    goal = sim.manager.controllers[controller].send_goal(JointTrajectory(
        JOINTS, np.array([duration]), there[None], np.zeros((1, 6)))).goal
    assert goal is not None
    return goal
