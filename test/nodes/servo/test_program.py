# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The endpoints that servo_node makes for a robot."""

from dataclasses import replace

import pytest
import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

from armsim_ros.model.cell_loading import load_cell
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.nodes.servo.program import ServoNode, ServoProgram
from armsim_ros.testing.program import private_domain


@pytest.fixture
def node():
    """Return a node that is alone in its domain."""
    context = Context()
    with private_domain() as domain:
        rclpy.init(context=context, domain_id=domain,
                   signal_handler_options=SignalHandlerOptions.NO)
        made = PollingNode('servo_node', context=context, **ServoProgram.NODE_OPTIONS)
        yield made
        made.destroy_node()
        context.try_shutdown()


def without(joint, controllers):
    """Return settings of controllers that lack a joint."""
    return tuple(
        each.model_copy(update={'joints': tuple(name for name in each.joints if name != joint)})
        for each in controllers)


def test_a_passive_joint_needs_no_controller(node):
    """Servo commands a group whose passive joint no controller has, without that joint."""
    cell = load_cell('sunday')
    semantic = replace(cell.model.semantic, passive_joints=('joint_6',))
    settings = cell.settings.model_copy(update={
        'moveit_controllers': without('joint_6', cell.settings.moveit_controllers),
        'controllers': ()})
    servo = ServoNode(node, replace(
        cell, settings=settings, model=replace(cell.model, semantic=semantic)))
    assert servo._parameters.settings.moveit_servo.command_out_topic == (
        '/sunday/arm_joint_controller/joint_trajectory')
    assert servo._streaming.stream.target.names == tuple(
        f'joint_{number}' for number in range(1, 6))
