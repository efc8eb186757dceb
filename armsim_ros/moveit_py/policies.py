# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.policies``: a learned policy as a node between sensors and servo_node."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from control_msgs.msg import JointJog
from geometry_msgs.msg import PoseStamped, Twist
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import Image
from std_srvs.srv import SetBool

from armsim_ros.nodes.parameters import parameters_by_prefix

_SENSORS = {'sensor_msgs/Image': Image}
_COMMANDS = {'geometry_msgs/PoseStamped': PoseStamped, 'geometry_msgs/Twist': Twist,
             'control_msgs/JointJog': JointJog}


class Policy(ABC, Node):
    """
    A node whose ``forward`` gets the messages of all sensors that belong together.

    :param params: a module of generate_parameter_library, with ``ParamListener``.
    :param node_name: of the node.
    """

    def __init__(self, params: Any, node_name: str = 'policy_node') -> None:
        super().__init__(node_name)
        self.logger = self.get_logger()
        self.param_listener = params.ParamListener(self)
        self.params = self.param_listener.get_params()
        self._is_active = False
        self.activate_policy_service = self.create_service(
            SetBool, 'activate_policy', self.activate_policy)
        self.register_sensors()
        self.register_command()

    @property
    def is_active(self) -> bool:
        """Whether the policy is active; ``active`` sets it."""
        return self._is_active

    @property
    def active(self) -> bool:
        """Whether the policy is active."""
        return self._is_active

    @active.setter
    def active(self, value: bool) -> None:
        self._is_active = bool(value)

    def activate_policy(
        self, request: SetBool.Request, response: SetBool.Response
    ) -> SetBool.Response:
        """Set whether the policy is active."""
        self._is_active = bool(request.data)
        response.success = True
        return response

    def get_sensor_msg_type(self, msg_type: str) -> Any:
        """Return the class of a sensor's messages; ValueError for an unknown type."""
        return _known(_SENSORS, msg_type, 'sensor')

    def get_command_msg_type(self, msg_type: str) -> Any:
        """Return the class of the commands; ValueError for an unknown type."""
        return _known(_COMMANDS, msg_type, 'command')

    def register_sensors(self) -> None:
        """Subscribe to the sensors ``sensor1``, ``sensor2`` ... of the parameters."""
        import message_filters

        self.sensor_subs = []
        for number in range(1, self.params.num_sensors + 1):
            values = parameters_by_prefix(self, f'sensor{number}')
            self.sensor_subs.append(message_filters.Subscriber(
                self, self.get_sensor_msg_type(values['type'].value),
                str(values['topic'].value), qos_profile=QoSProfile(depth=values['qos'].value)))
        self.sensor_sync = message_filters.ApproximateTimeSynchronizer(
            self.sensor_subs, self.params.sensor_queue, self.params.sensor_slop)
        self.sensor_sync.registerCallback(self.forward)

    def register_command(self) -> None:
        """Create the publisher of the commands."""
        command = self.params.command
        self.command_pub = self.create_publisher(
            self.get_command_msg_type(command.type), command.topic, QoSProfile(depth=command.qos))

    @abstractmethod
    def forward(self, *messages: Any) -> None:
        """Compute and publish a command."""


def _known(types: dict[str, Any], name: str, what: str) -> Any:
    if name not in types:
        raise ValueError(f"{what} type '{name}' is not supported; allowed: {', '.join(types)}")
    return types[name]
