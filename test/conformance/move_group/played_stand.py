# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""move_group beside controllers that the test plays."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
import shutil
import threading
from typing import Any

from control_msgs.action import GripperCommand
from lone_server import LoneServer, PlayedArm, PlayedController
from move_group_bench import seconds

from armsim_ros.resources import find_robot
from armsim_ros.testing.program import Program

START = {f'joint_{k}': 0.1 * k for k in range(1, 7)}
URDF = f"urdf:={find_robot('sunday').parent.parent / 'urdf' / 'sunday.urdf.xacro'}"
TWO = """
moveit_simple_controller_manager:
  controller_names: [lower, upper, whole, hand, absent, faulty]
  lower:
    type: FollowJointTrajectory
    action_ns: follow_joint_trajectory
    joints: [joint_1, joint_2, joint_3]
  upper:
    type: FollowJointTrajectory
    action_ns: follow_joint_trajectory
    allowed_execution_duration_scaling: 1.0
    allowed_goal_duration_margin: 0.3
    joints: [joint_4, joint_5]
  whole:
    type: FollowJointTrajectory
    action_ns: follow_joint_trajectory
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5]
  hand:
    type: GripperCommand
    action_ns: gripper_cmd
    joints: [joint_6]
  absent:
    type: FollowJointTrajectory
    action_ns: follow_joint_trajectory
    joints: [joint_2, joint_3]
  faulty:
    type: FollowJointTrajectory
    joints: [joint_2, joint_3]
"""


def split_robot(folder: Path) -> Path:
    """
    Make a folder of the default arm whose joints belong to several controllers, and return it.

    It has no acceleration limits.
    """
    shutil.copytree(find_robot('sunday'), folder)
    (folder / 'controllers_gazebo.yaml').unlink()
    (folder / 'trajectory_execution.yaml').unlink()
    (folder / 'moveit_controllers.yaml').write_text(TWO, encoding='utf-8')
    limits = folder / 'joint_limits.yaml'
    kept = [line for line in limits.read_text().splitlines() if 'acceleration' not in line]
    limits.write_text('\n'.join(kept))
    return folder


class Stand:
    """move_group, joint states and four of its five controllers."""

    def __init__(self, server: LoneServer) -> None:
        self.server = server
        self.played: PlayedArm = server.play(START)
        self.arm = self.played.arm
        self.whole = self.played.controller('/whole/follow_joint_trajectory')
        self.lower = self.played.controller('/lower/follow_joint_trajectory')
        self.upper = self.played.controller('/upper/follow_joint_trajectory')
        self.hand = self.played.controller('/hand/gripper_cmd', GripperCommand)

    @property
    def program(self) -> Program:
        """The running move_group."""
        return self.server.program

    @property
    def all(self) -> tuple[PlayedController, ...]:
        """The controllers."""
        return self.lower, self.upper, self.whole, self.hand

    def reset(self) -> None:
        """Forget what was sent, and let all controllers arrive."""
        self.played.shaking = {}
        self.played.positions.update(START)
        for one in self.all:
            one.behaviour = 'arrive'
            one.goals.clear()
            one.cancelled.clear()

    def move(self, joint: str, by: float) -> None:
        """Put a joint elsewhere, and wait until all know."""
        self.played.positions[joint] += by
        self.arm.joint_states.clear()
        self.arm.joint_states.wait(3)

    def trajectory(self, *joints: str) -> Any:
        """Return a trajectory of these joints, all where none is named."""
        self.arm.joint_states.clear()
        self.arm.joint_states.wait(3)
        whole = self.arm.planned({name: value + 0.1 for name, value in START.items()})
        keep = [k for k, name in enumerate(whole.joint_names) if not joints or name in joints]
        whole.joint_names = [whole.joint_names[k] for k in keep]
        for point in whole.points:
            for part in ('positions', 'velocities', 'accelerations'):
                values = getattr(point, part)
                setattr(point, part, [values[k] for k in keep])
        return whole


def wait_for(condition: Callable[[], object]) -> None:
    """Wait until something is so."""
    pause = threading.Event()
    for _ in range(1000):
        if condition():
            return
        pause.wait(0.01)
    raise AssertionError('it never came to be so')


def allowed(trajectory: Any) -> float:
    """Return how long the upper controller may take [s]."""
    return seconds(trajectory.points[-1].time_from_start) + 0.3


LOWER = ('joint_1', 'joint_2', 'joint_3')
UPPER = ('joint_4', 'joint_5')
