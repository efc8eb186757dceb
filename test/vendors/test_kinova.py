# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Answers of Kinova's endpoints, without a middleware between client and arm.

As ``picknik_reset_fault_controller.cpp`` (update, resetFault).
"""

from types import SimpleNamespace

from direct_nodes import Node, Nodes
from example_interfaces.msg import Bool
from geometry_msgs.msg import Twist, Vector3
import numpy as np
import pytest

from armsim_ros.control.controller import LifecycleState
from armsim_ros.nodes.vendors.kinova import KinovaEndpoints
from armsim_ros.stack import ArmSim


class Recorder(Node):
    """Keeps what is published, and the callback of a subscription."""

    def __init__(self):
        self.messages = []

    def create_publisher(self, *_):
        return SimpleNamespace(publish=self.messages.append, get_subscription_count=lambda: 1)

    def create_subscription(self, kind, name, callback, _):
        self.receive = callback


@pytest.fixture
def sim():
    """Return an arm with Kinova's table, whose tool is the last link here."""
    return ArmSim('panda', overrides={'simulation.hardware.vendor': 'kinova'})


def controller(kind):
    """Return an active controller of PickNik's packages."""
    return SimpleNamespace(name=kind, type=f'picknik/{kind}', active=True,
                           state=LifecycleState.ACTIVE)


def test_a_stop_is_a_fault_until_it_is_reset(sim):
    """HW-E1: reset_fault clears a stop; while the button is pressed it fails with the reason."""
    nodes, node = Nodes(sim), Recorder()
    endpoints = KinovaEndpoints(nodes)
    endpoints.open(controller('PicknikResetFaultController'), node)
    sim.protective_stop()
    endpoints.publish(0)
    assert nodes.call('reset_fault').success
    endpoints.publish(0)
    assert node.messages == [Bool(data=True), Bool(data=False)]
    sim.manager.arm.emergency_stop()
    answer = nodes.call('reset_fault')
    assert (answer.success, answer.message) == (
        False, 'the button of the emergency stop is pressed; release it first')


def test_commands_move_the_tool_while_the_controller_is_active(sim):
    """HW-E1: A twist along the tool's z axis, in its own frame; inactive nothing moves."""
    nodes, node = Nodes(sim), Recorder()
    nodes.arm.vendor = SimpleNamespace(tool='panda_hand_tcp')
    assert sim.manager.switch([], ['panda_arm_controller']).ok
    twist = controller('PicknikTwistController')
    KinovaEndpoints(nodes).open(twist, node)
    sim.loop.tick()
    for active, way in ((True, 0.055), (False, 0.0)):
        twist.active = active
        before = sim.simulation.link_pose('panda_hand_tcp')
        for _ in range(25):
            node.receive(Twist(linear=Vector3(z=0.1)))
            sim.run_until(sim.time + 0.02)
        sim.run_until(sim.time + 0.5)
        moved = np.linalg.inv(before) @ sim.simulation.link_pose('panda_hand_tcp')
        assert moved[:3, 3] == pytest.approx([0.0, 0.0, way], abs=0.01)
