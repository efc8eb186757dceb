# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The pose of the tool that the hardware of Universal Robots has."""

import numpy as np
import pytest
from ros2_control_tags import joint, start

from armsim_ros.model.transforms import pose_from_quat_xyzw

FIXED = ('<link name="{1}"/><joint name="{1}_joint" type="fixed"><parent link="{0}"/>'
         '<child link="{1}"/><origin xyz="0 0 0.1" rpy="0 0 {2}"/></joint>')
HARDWARE = ('<ros2_control name="ur" type="system"><hardware>'
            '<plugin>ur_robot_driver/URPositionHardwareInterface</plugin>'
            '<param name="tf_prefix">ur_</param></hardware>{}</ros2_control>')
#: As an ur_sensors.xacro of ur_description has it.
SENSOR = '<sensor name="ur_tcp_pose">' + ''.join(
    f'<state_interface name="{name}"/>' for name in (
        'position.x', 'position.y', 'position.z',
        'orientation.r', 'orientation.p', 'orientation.y')) + '</sensor>'


@pytest.mark.parametrize('sensor', ['', SENSOR])
def test_the_pose_of_the_tool_is_in_the_frame_of_the_arms_controller(small_package, sensor):
    """
    That is ``base``, turned half about the root; its states are there whatever a URDF has.

    As ``export_state_interfaces`` and ``extractToolPose`` (hardware_interface.cpp of
    ur_robot_driver).
    """
    arm = small_package.description / 'urdf/arm.urdf'
    arm.write_text(arm.read_text().replace('</robot>', ''.join((
        FIXED.format('base', 'ur_base', np.pi), FIXED.format('finger', 'ur_tool0', 0.5),
        HARDWARE.format(sensor + joint('shoulder', 'position') + joint('elbow', 'position')),
        '</robot>'))))
    simulation, _, _ = start(small_package)
    simulation.set_positions({'shoulder': 0.6, 'elbow': 0.3})
    simulation.step()
    states = simulation.other_states
    found = pose_from_quat_xyzw(*(
        [states[f'ur_tcp_pose/{what}.{axis}'] for axis in axes]
        for what, axes in (('position', 'xyz'), ('orientation', 'xyzw'))))
    expected = np.linalg.inv(simulation.link_pose('ur_base')) @ simulation.link_pose('ur_tool0')
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert found[0, 3] < -0.1
