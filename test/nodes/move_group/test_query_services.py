# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the services answer that only read."""

from xml.etree import ElementTree

from armsim_ros.nodes.move_group.query_services import group_urdf

URDF = """<robot name="whole"><link name="base"/><link name="arm"/><link name="hand"/>
<joint name="turn" type="fixed"><parent link="base"/><child link="arm"/></joint>
<joint name="grip" type="fixed"><parent link="arm"/><child link="hand"/></joint></robot>"""


def test_the_urdf_of_a_group_has_the_name_of_the_group():
    """It holds the joints of the group and their links; get_group_urdf_capability.cpp."""
    robot = ElementTree.fromstring(group_urdf(URDF, 'gripper', ('grip',)))
    assert robot.get('name') == 'gripper'
    assert [joint.get('name') for joint in robot.findall('joint')] == ['grip']
    assert {link.get('name') for link in robot.findall('link')} == {'arm', 'hand'}
