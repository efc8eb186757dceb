# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A policy's view of a running arm: it takes the joints over and gives them back."""

from __future__ import annotations

from contextlib import closing
import math

import numpy as np
import pytest
from sensor_msgs.msg import JointState
from streaming_bench import ARM, JOINTS, MANAGER, PLACE, Streamed

from armsim_ros.clients.controller_manager import ControllerManagerClient
from armsim_ros.clients.streamed_arm import LatestMessage, StreamedArm
from armsim_ros.errors import ControllerError, SimulationError
from armsim_ros.model.cell import Cell
from armsim_ros.model.cell_loading import load_cell


@pytest.fixture(scope='module')
def cell() -> Cell:
    """Give the robot's files."""
    return load_cell('sunday')


def active(arm: Streamed) -> set[str]:
    """Return the active controllers that have claimed something."""
    states = ControllerManagerClient(arm.client, MANAGER).controllers()
    return {name for name, state in states.items()
            if state.state == 'active' and state.claimed_interfaces}


def test_it_moves_joints_and_hand_and_gives_them_back(arm: Streamed, cell: Cell) -> None:
    """Positions are clipped to the limits; the controller of before is active afterwards."""
    with closing(StreamedArm(arm.client, cell)) as streamed:
        assert streamed.joints == JOINTS
        assert active(arm) == {'position_stream'}
        assert streamed.positions['joint_3'] == pytest.approx(PLACE[2], abs=3e-3)
        goal = {'joint_1': 0.1, 'joint_6': 99.0}
        sent = streamed.send(goal, 1.0)
        assert sent['joint_6'] == cell.model.joints['joint_6'].limits.upper
        assert streamed.level == 1.0
        sent = streamed.send({'joint_6': 0.0}, 0.0)
        assert sent['joint_1'] == 0.1
        assert streamed.level == 0.0
        arm.until(lambda: np.abs(arm.positions - list(sent.values())).max() < 2e-3, 'it is there')
        ahead = streamed.moved_by(np.array((0.0, 0.0, 0.01)), 0.05)
        assert 0.0 < max(abs(ahead[name] - sent[name]) for name in JOINTS) < 0.1
    assert active(arm) == {ARM}
    arm.rest()
    assert arm.positions[0] == pytest.approx(0.1, abs=3e-3)


def test_what_is_missing_is_named(arm: Streamed, cell: Cell) -> None:
    """A topic without messages, and a controller that does not forward the joints' positions."""
    with closing(LatestMessage(arm.client, JointState, '/nowhere/states', 'start it')) as topic:
        with pytest.raises(SimulationError, match=r"'/nowhere/states' within 0.1 s; start it"):
            topic.get(0.1)
        assert topic.age == math.inf
    with pytest.raises(ControllerError, match=r'velocity_stream.*joint_6.*position_stream'):
        StreamedArm(arm.client, cell, controller='velocity_stream')
    with pytest.raises(SimulationError, match=r"'/nowhere/image' within .* camera:=true"):
        StreamedArm(arm.client, cell, cameras={'front': '/nowhere/image'}, timeout=0.5)
    assert active(arm) == {ARM}
