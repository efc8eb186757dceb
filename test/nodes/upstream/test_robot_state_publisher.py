# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What robot_state_publisher reads of a description."""

from armsim_ros.model.robot_model import Mimic
from armsim_ros.nodes.upstream.robot_state_publisher import robot_of

URDF = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="i" type="continuous"><parent link="a"/><child link="b"/></joint>
<joint name="j" type="continuous"><parent link="b"/><child link="c"/><mimic joint="i"/></joint>
<ros2_control name="h" type="system"><joint name="j" mimic="false"/><joint name="lost"/>
</ros2_control></robot>"""


def test_hardware_does_not_bear_on_transforms() -> None:
    """
    A mimic joint that <ros2_control> frees follows its master; errors there stop nothing.

    robot_state_publisher/src/robot_state_publisher.cpp: setupURDF.
    """
    assert robot_of(URDF).joints['j'].mimic == Mimic('i')
