# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.policies`` and ``moveit.servo_client``: nodes that command servo_node."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
import threading
from typing import Any

from control_msgs.msg import JointJog
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from moveit_msgs.srv import ServoCommandType
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import Image, Joy
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


#: How long servo_node is waited for [s].
_SERVICE_TIMEOUT = 10.0


class TeleopDevice(ABC, Node):
    """
    A node that turns the messages of ``/joy`` into twists for servo_node.

    :param node_name: of the node.
    :param device_name: of the device.
    :param device_config: which axes and buttons it has.
    :param ee_frame_name: the frame of the twists.
    """

    def __init__(
        self, node_name: str, device_name: str, device_config: Any, ee_frame_name: str
    ) -> None:
        super().__init__(node_name=node_name)
        self.device_name, self.device_config = device_name, device_config
        self.ee_frame_name = ee_frame_name
        self.joy_subscriber = self.create_subscription(Joy, '/joy', self.publish_command, 10)
        self.twist_publisher = self.create_publisher(
            TwistStamped, '/servo_node/delta_twist_cmds', 10)
        #: Of Jazzy's servo_node, which starts by itself and is paused and resumed.
        self.servo_node_start_client = self.create_client(
            ServoCommandType, '/servo_node/switch_command_type')
        self.servo_node_stop_client = self.create_client(SetBool, '/servo_node/pause_servo')
        self.teleop_thread: threading.Thread | None = None
        self._teleop_executor: MultiThreadedExecutor | None = None

    def start_teleop(self) -> None:
        """Have servo_node take twists, and spin this node in a thread."""
        for client, name in ((self.servo_node_start_client, 'switch_command_type'),
                             (self.servo_node_stop_client, 'pause_servo')):
            if not client.wait_for_service(_SERVICE_TIMEOUT):
                self.get_logger().error(
                    f"no service '/servo_node/{name}' within {_SERVICE_TIMEOUT:g} s; does "
                    'servo_node run (bringup servo:=true)?')
                return
        self.servo_node_start_client.call_async(
            ServoCommandType.Request(command_type=ServoCommandType.Request.TWIST))
        self.servo_node_stop_client.call_async(SetBool.Request(data=False))
        executor = self._teleop_executor = MultiThreadedExecutor(context=self.context)
        executor.add_node(self)
        self.teleop_thread = threading.Thread(target=self._spin, name='teleop', daemon=True)
        self.teleop_thread.start()

    def _spin(self) -> None:
        executor = self._teleop_executor
        try:
            if executor is not None:
                executor.spin()
        except ExternalShutdownException:
            pass

    def stop_teleop(self) -> None:
        """Pause servo_node, and end the thread."""
        if self.teleop_thread is None or self._teleop_executor is None:
            return
        sent = self.servo_node_stop_client.call_async(SetBool.Request(data=True))
        paused = threading.Event()
        sent.add_done_callback(lambda _: paused.set())
        paused.wait(_SERVICE_TIMEOUT)
        self._teleop_executor.shutdown(0.0)
        self._teleop_executor.remove_node(self)
        self.teleop_thread.join(1.0)
        self.teleop_thread = self._teleop_executor = None

    @abstractmethod
    def publish_command(self, data: Joy) -> None:
        """Publish the command of a message."""

    @abstractmethod
    def record(self) -> None:
        """Record trajectories."""


@dataclass
class DualShockAxes:
    """Axis -> its place in the message."""

    LEFT_STICK_X: int = 0
    LEFT_STICK_Y: int = 1
    LEFT_TRIGGER: int = 2
    RIGHT_STICK_X: int = 3
    RIGHT_STICK_Y: int = 4
    RIGHT_TRIGGER: int = 5
    D_PAD_X: int = 6
    D_PAD_Y: int = 7


@dataclass
class DualShockButtons:
    """Button -> its place in the message."""

    X: int = 0
    O: int = 1  # noqa: E741 - the button's name
    TRIANGLE: int = 2
    SQUARE: int = 3
    L1: int = 4
    R1: int = 5
    L2: int = 6
    R2: int = 7
    SHARE: int = 8
    OPTIONS: int = 9
    HOME: int = 10
    LEFT_STICK_TRIGGER: int = 11
    RIGHT_STICK_TRIGGER: int = 12


@dataclass
class PS4DualShock:
    """Axes and buttons of the device."""

    Axes: DualShockAxes = field(default_factory=DualShockAxes)
    Buttons: DualShockButtons = field(default_factory=DualShockButtons)


class PS4DualShockTeleop(TeleopDevice):
    """
    The right stick moves in y and z, the triggers in x; the left stick and L1, R1 turn.

    :param ee_frame_name: the frame of the twists.
    """

    def __init__(
        self, ee_frame_name: str, node_name: str = 'ps4_dualshock_teleop',
        device_name: str = 'ps4_dualshock', device_config: PS4DualShock = PS4DualShock(),  # noqa: B008
    ) -> None:
        super().__init__(node_name, device_name, device_config, ee_frame_name)
        self.logger = self.get_logger()

    def publish_command(self, data: Joy) -> None:
        """Publish the twist of a message; one with too few axes or buttons is left out."""
        axes, buttons = self.device_config.Axes, self.device_config.Buttons
        if len(data.axes) <= axes.RIGHT_TRIGGER or len(data.buttons) <= buttons.R1:
            self.logger.warning(
                f'{len(data.axes)} axes and {len(data.buttons)} buttons are too few for a '
                f'{self.device_name}', once=True)
            return
        message = TwistStamped()
        message.header.frame_id = self.ee_frame_name
        message.header.stamp = self.get_clock().now().to_msg()
        linear, angular = message.twist.linear, message.twist.angular
        linear.x = 0.5 * (data.axes[axes.LEFT_TRIGGER] - data.axes[axes.RIGHT_TRIGGER])
        linear.y = data.axes[axes.RIGHT_STICK_X]
        linear.z = data.axes[axes.RIGHT_STICK_Y]
        angular.x = data.axes[axes.LEFT_STICK_X]
        angular.y = data.axes[axes.LEFT_STICK_Y]
        angular.z = float(data.buttons[buttons.R1] - data.buttons[buttons.L1])
        self.twist_publisher.publish(message)

    def record(self) -> None:
        """Do nothing, as upstream."""
