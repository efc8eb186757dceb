# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sends commands to a running servo_node, and halts it."""

from __future__ import annotations

import time

from control_msgs.msg import JointJog
from geometry_msgs.msg import TwistStamped
from moveit_msgs.msg import ServoStatus
from moveit_msgs.srv import ServoCommandType
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import Parameter, parameter_value_to_python
from std_srvs.srv import SetBool

from armsim_ros.clients.ros_client import RosClient
from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.teleop.commands import Command
from armsim_ros.nodes.verbs.terminal import call

TWIST, JOINTS = ServoCommandType.Request.TWIST, ServoCommandType.Request.JOINT_JOG
#: Largest speeds where servo takes speeds [m/s, rad/s, rad/s or m/s]; else they are servo's own.
LINEAR, ANGULAR, JOINT = 0.2, 0.5, 0.5
_NO_WARNING = 'No warnings'
_ANSWER = 1.0


class ServoLink:
    """
    A stream of commands to servo_node.

    :param frame: has the axes of twists; '' is the base of the planning group.
    :param speed: share of the largest speeds.
    :param patience: for servo_node to appear [s].
    :raises ArmsimError: there is no servo_node.
    """

    def __init__(self, client: RosClient, servo: str, robot: RobotModel, frame: str, speed: float,
                 patience: float) -> None:
        self._client, self._servo = client, servo
        self._pause_service = f'{servo}/pause_servo'
        self.paused = False
        #: Why servo does not move the arm, '' where it does; from the first command on.
        self.status = ''
        try:
            self._pause(False, patience)
        except ArmsimError:
            raise ArmsimError(f"there is no servo_node '{servo}'; start it with "
                              'armsim bringup servo:=true, or name it with --servo') from None
        kinds = ('command_in_type', 'move_group_name')
        found = call(client, GetParameters, f'{servo}/get_parameters', GetParameters.Request(
            names=[f'moveit_servo.{kind}' for kind in kinds]), patience).values
        type_in, group = [parameter_value_to_python(each) for each in found] or ['', '']
        group = group if group in robot.semantic.groups else next(iter(robot.semantic.groups))
        chain = robot.group(group).chain
        self._joints = robot.group(group).active_joints
        self._frame = frame or (chain[0] if chain else robot.root_link)
        self._scales = [speed * (largest if type_in == 'speed_units' else 1.0)
                        for largest in (LINEAR, ANGULAR, JOINT)]
        if client.node.count_publishers('/clock'):
            # Servo drops what is old by its own clock.
            client.node.set_parameters([Parameter('use_sim_time', value=True)])
        self._type, self._ask_again, self._last = -1, 0.0, Command()
        self._twists = client.in_thread(lambda: client.node.create_publisher(
            TwistStamped, f'{servo}/delta_twist_cmds', 10)).result(_ANSWER)
        self._jogs = client.in_thread(lambda: client.node.create_publisher(
            JointJog, f'{servo}/delta_joint_cmds', 10)).result(_ANSWER)
        client.subscribe(ServoStatus, f'{servo}/status', 1, self._status)

    def send(self, command: Command | None) -> None:
        """
        Send a command; without one, the arm is halted once, then nothing is sent.

        :raises ArmsimError: servo_node is gone.
        """
        if command is not None and not self._client.serves(SetBool, self._pause_service):
            raise ArmsimError(f"servo_node '{self._servo}' is gone")
        if command is None:
            if self._last != Command():
                self._publish(Command(joints=dict.fromkeys(self._last.joints, 0.0)))
            self._last = Command()
            return
        self._last = command
        self._choose(JOINTS if command.joints else TWIST)
        self._publish(command)

    def toggle_pause(self) -> None:
        """Pause servo, or have it follow commands again."""
        self._pause(not self.paused, _ANSWER)
        self.status = 'paused; p resumes' if self.paused else ''

    def halt(self) -> None:
        """Brake the arm at once, and leave servo paused; nothing where servo_node is gone."""
        if self._client.serves(SetBool, self._pause_service):
            self.send(None)
            self._pause(True, _ANSWER)

    def _pause(self, pause: bool, patience: float) -> None:
        call(self._client, SetBool, self._pause_service, SetBool.Request(data=pause), patience)
        self.paused = pause

    def _publish(self, command: Command) -> None:
        linear, angular, joint = self._scales
        stamp = self._client.node.get_clock().now().to_msg()
        if command.joints:
            jog = JointJog()
            jog.header.stamp = stamp
            moved = {place: share for place, share in command.joints.items()
                     if place < len(self._joints)}
            jog.joint_names = [self._joints[place] for place in moved]
            jog.velocities = [joint * share for share in moved.values()]
            if moved:
                self._jogs.publish(jog)
            return
        message = TwistStamped()
        message.header.stamp, message.header.frame_id = stamp, self._frame
        for axis, way, turn in zip('xyz', command.twist[:3], command.twist[3:], strict=True):
            setattr(message.twist.linear, axis, linear * way)
            setattr(message.twist.angular, axis, angular * turn)
        self._twists.publish(message)

    def _choose(self, kind: int) -> None:
        """Have servo follow a type of commands; the request is repeated without an answer."""
        now = time.monotonic()
        if kind == self._type or now < self._ask_again:
            return
        self._ask_again = now + _ANSWER
        answer = self._client.call(ServoCommandType, f'{self._servo}/switch_command_type',
                                   ServoCommandType.Request(command_type=kind))

        def chosen() -> None:
            if answer.exception() is None and answer.result().success:
                self._type, self._ask_again = kind, 0.0

        answer.add_done_callback(lambda _: chosen())

    def _status(self, message: ServoStatus) -> None:
        if self._type >= 0 and not self.paused:
            self.status = '' if message.message == _NO_WARNING else message.message
