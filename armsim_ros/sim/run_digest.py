# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A hash of a whole run's present, to compare two runs."""

from __future__ import annotations

from collections.abc import Mapping
import hashlib

from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.sim.simulation import Simulation


def run_digest(simulation: Simulation, managers: Mapping[str, ControllerManager]) -> str:
    """
    Return a hash of plant, drives, time, and what controllers are loaded, active and follow.

    :param managers: robot -> its controller manager.
    """
    parts = hashlib.sha256(simulation.digest().encode())
    for robot, manager in managers.items():
        for info in manager.list_controllers():
            parts.update(f'{robot}/{info.name} {info.type} {info.state}'.encode())
            controller = manager.controllers[info.name]
            if isinstance(controller, JointTrajectoryController):
                goal = controller.active_goal
                if goal is not None:
                    parts.update(goal.trajectory.times.tobytes())
                    parts.update(goal.trajectory.positions.tobytes())
    return parts.hexdigest()
