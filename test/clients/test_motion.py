# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Requests of motions and their answers."""

from moveit_msgs.msg import MoveItErrorCodes
import pytest

from armsim_ros.clients.motion import code_text


@pytest.mark.parametrize(('code', 'message', 'text'), [
    (MoveItErrorCodes.PLANNING_FAILED, 'out of reach', 'PLANNING_FAILED: out of reach'),
    (MoveItErrorCodes.PREEMPTED, '', 'PREEMPTED: stopped'),
    (MoveItErrorCodes.SENSOR_INFO_STALE, '', 'SENSOR_INFO_STALE'),
    (12345, '', '12345'),
])
def test_a_code_has_its_name_and_a_sentence(code, message, text):
    """The sentence is the server's, else that of the code, else there is none."""
    assert code_text(MoveItErrorCodes(val=code, message=message)) == text
