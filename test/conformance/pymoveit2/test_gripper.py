# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A gripper of two fingers as a user of pymoveit2 opens and closes it."""

from __future__ import annotations

from typing import Any

from arm_user import distance, TIMEOUT
from pymoveit2 import GripperInterface, MoveIt2Gripper
import pytest


def end(gripper: Any) -> None:
    """Wait for the end of a motion that must succeed."""
    assert gripper.wait_until_executed(TIMEOUT), gripper.last_failure()


@pytest.mark.statement('PM-5', 'EXE-3')
@pytest.mark.parametrize('action', [False, True])
def test_a_gripper_opens_and_closes(user: Any, action: bool) -> None:
    """Open, close and toggle, planned and sent to the gripper's own controller."""
    gripper = user.gripper(use_move_group_action=action)
    wanted = user.description.moveit2_gripper_kwargs()
    assert gripper.wait_for_joint_state(10.0)
    assert gripper.open()
    end(gripper)
    assert distance(gripper, wanted['open_gripper_joint_positions']) < 0.002
    assert gripper.is_open
    assert gripper.close()
    end(gripper)
    assert gripper.is_closed
    assert gripper()
    end(gripper)
    assert gripper.is_open


@pytest.mark.statement('PM-6')
def test_the_interface_finds_how_the_gripper_is_driven(user: Any) -> None:
    """Without a gripper_cmd action the interface plans with move_group."""
    gripper = user.gripper(GripperInterface)
    assert gripper.wait_until_executed(0.1) in (True, False)
    assert gripper.move_to_position(0.02)
    end(gripper)
    assert gripper.interface is MoveIt2Gripper


@pytest.mark.statement('EXE-4')
def test_arm_and_gripper_move_together(user: Any) -> None:
    """A goal for a group of both is split between two controllers."""
    description = user.description.group('arm_and_gripper')
    both = user.arm(group_name='arm_and_gripper', joint_names=list(description.joint_names))
    assert both.wait_for_joint_state(10.0)
    ready = list(user.description.joint_positions('ready'))
    for fingers in ([0.04, 0.04], [0.0, 0.0]):
        names = list(user.description.moveit2_kwargs()['joint_names'])
        values = dict(zip(names, ready, strict=True))
        values.update(zip(['finger_j1', 'finger_j2'], fingers, strict=True))
        goal = [values[name] for name in both.joint_names]
        assert both.move_to_configuration(goal), both.last_failure()
        end(both)
        assert distance(both, goal) < 0.01
        ready[0] += 0.3
