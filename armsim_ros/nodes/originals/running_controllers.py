# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Asks the controller manager which controllers move_group may use, as Ros2ControlManager does."""

from __future__ import annotations

from collections.abc import Iterable
import time
from typing import Any

from controller_manager_msgs.msg import ControllerState
from controller_manager_msgs.srv import ListControllers
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from armsim_ros.nodes.originals.node_parameters import NodeArguments

_BLOCK = 'moveit_simple_controller_manager'
#: Last part of a controller's type -> the action that it serves, and that action's name.
_ACTIONS = {
    'JointTrajectoryController': ('FollowJointTrajectory', 'follow_joint_trajectory'),
    'GripperActionController': ('GripperCommand', 'gripper_cmd'),
}
#: How often the manager is asked, how long it may take to answer, and for how long what it says
#: has to stay the same [s].
_PERIOD, _ANSWER, _SETTLED = 0.2, 1.0, 2.0
#: The user is told what is waited for at this rate [s].
_REMINDER = 5.0


def running_controllers(arguments: NodeArguments) -> dict[str, Any]:
    """
    Wait for active controllers that serve an action, and return parameters that name them.

    Spawners start one after the other: what is active has to stay the same for two seconds.
    """
    namespace = str(arguments.values.get('ros_control_namespace', '/')).strip('/')
    context = rclpy.Context()
    rclpy.init(args=arguments.ros_args(with_name=True), context=context)
    try:
        node = Node(f'{arguments.name}_waits', context=context, use_global_arguments=True,
                    enable_rosout=False, start_parameter_services=False)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        service = f'/{namespace}/controller_manager/list_controllers'.replace('//', '/')
        client = node.create_client(ListControllers, service)
        node.create_timer(_REMINDER, lambda: node.get_logger().info(
            f'waiting for active controllers of {service}'))
        found: dict[str, Any] = {}
        since = time.monotonic()
        while not found or time.monotonic() - since < _SETTLED:
            executor.spin_once(_PERIOD)
            if not client.service_is_ready():
                continue
            future = client.call_async(ListControllers.Request())
            executor.spin_until_future_complete(future, _ANSWER)
            if not future.done():
                client.remove_pending_request(future)
                continue
            listed = parameters_of(future.result().controller, namespace)
            if listed != found:
                found, since = listed, time.monotonic()
        node.destroy_node()
    finally:
        context.try_shutdown()
    return found


def parameters_of(controllers: Iterable[ControllerState], namespace: str = '') -> dict[str, Any]:
    """
    Return move_group's parameters for the controllers that are active and serve an action.

    :param namespace: of their manager, without slashes at its ends.
    """
    values: dict[str, Any] = {}
    names = []
    for one in controllers:
        action = next((action for ending, action in _ACTIONS.items()
                       if one.type.endswith(ending)), None)
        joints = list(dict.fromkeys(
            interface.rpartition('/')[0] for interface in one.claimed_interfaces))
        if one.state != 'active' or action is None or not joints:
            continue
        name = f'{namespace}/{one.name}'.strip('/')
        names.append(name)
        block = {'type': action[0], 'action_ns': action[1], 'default': True, 'joints': joints}
        values.update({f'{_BLOCK}.{name}.{key}': value for key, value in block.items()})
    return {f'{_BLOCK}.controller_names': names, **values} if names else {}
