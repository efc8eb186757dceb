# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The servo_node program from start to end."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, ClassVar

from pydantic import ValidationError
import rclpy
from rclpy.executors import SingleThreadedExecutor

from armsim_ros.config.controllers.controller_settings import SCALED_TRAJECTORY, TRAJECTORY
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.servo import ARRAY, ServoNodeSettings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.cell import Cell
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.executor_program import ExecutorProgram, failures_logged
from armsim_ros.nodes.move_group.scene.transforms import Transforms
from armsim_ros.nodes.parameters import reason, SettingsParameters
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.nodes.servo.inputs import (
    CommandServices,
    CommandTopics,
    JointPositions,
    SceneFollower,
    StreamClock,
)
from armsim_ros.nodes.servo.output import ControllerWatch, JointCommands, StatusTopic
from armsim_ros.nodes.servo.streaming import Streaming
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.scene_sources.simulated_world import initial_scene
from armsim_ros.servo.assembly import (
    arm_group,
    build_stream,
    check_parameters,
    commanded_robot,
    ServoSettingsError,
)
from armsim_ros.servo.commands import CommandInbox

READY = 'Servo initialized successfully'
TRAJECTORY_CONTROLLERS = (TRAJECTORY, SCALED_TRAJECTORY)
DEFAULT_JOINT_STATES = '/joint_states'


class ServoNode:
    """
    Every endpoint of the program, and the thread that streams.

    :raises ServoSettingsError: the parameters do not fit each other or the robot; all errors.
    """

    def __init__(self, node: PollingNode, cell: Cell) -> None:
        self.node = node
        self.robot: RobotModel = cell.model
        self._warned: set[str] = set()
        kinematics = KinematicModel(
            planning_robot(commanded_robot(cell.model), cell.settings.joint_limits))
        settings = self._settings(node, cell.settings, kinematics)
        parameters = settings.moveit_servo
        self.scene: PlanningScene = initial_scene(
            kinematics, cell.settings, cell.settings.planning_parameters, name='servo')
        stream, warnings = build_stream(
            kinematics, self.scene, CollisionChecker(self.scene), settings, self._group)
        for text in warnings:
            node.get_logger().warning(text)
        topic = parameters.command_out_topic
        clock = StreamClock(node)
        inbox = CommandInbox(round(parameters.incoming_command_timeout * 1e9))
        # Where no topic is given, the parameter is the first of the robot's own.
        own = _joint_topics(cell.settings)
        topics = own if parameters.joint_topic == own[0] else (parameters.joint_topic,)
        self._frames = Transforms(self, moving=False)
        states = JointPositions(node, kinematics, topics, stream.target.names)
        self._follower = SceneFollower(
            node, self.scene, states, parameters.monitored_planning_scene_topic,
            serves=parameters.is_primary_planning_scene_monitor)
        controller = ControllerWatch(node, topic, stream.target.names)
        self._streaming = Streaming(
            node=node, clock=clock, inbox=inbox,
            commands=CommandTopics(node, inbox, parameters, clock.now_ns, self._frame_named),
            states=states, controller=controller, stream=stream,
            output=JointCommands(node, topic, stream.target.names, parameters),
            status=StatusTopic(node, parameters.status_topic), parameters=parameters,
            ready=lambda: node.get_logger().info(READY))
        self._services = CommandServices(
            node, inbox, self._streaming.pause, controller.follow_state)
        self._kinematics = kinematics

    @property
    def failure(self) -> str:
        """Why the streaming thread has ended by itself, '' while it runs."""
        return self._streaming.failure

    def start(self) -> None:
        """Start to stream."""
        self._streaming.start()

    def stop(self) -> None:
        """End the streaming thread."""
        self._streaming.stop()

    def subscribe(
        self, kind: Any, name: str, receive: Callable[[Any], None], profile: Any = 10
    ) -> None:
        """Subscribe to a topic that comes seldom."""
        self.node.create_subscription(kind, name, receive, profile)

    def warn_once(self, text: str) -> None:
        """Log a warning once."""
        if text not in self._warned:
            self._warned.add(text)
            self.node.get_logger().warning(text)

    def _frame_named(self, frame: str) -> None:
        """Follow ``/tf`` from the first command on whose frame is not the robot's own."""
        if frame not in self.robot.links and frame != self.robot.model_frame:
            self._frames.follow_moving()

    def _settings(
        self, node: PollingNode, robot: RobotSettings, kinematics: KinematicModel
    ) -> ServoNodeSettings:
        """Declare all parameters and return their values."""
        moved = [controller.joints for controller in robot.moveit_controllers
                 if controller.type == 'FollowJointTrajectory']
        own = robot.servo.moveit_servo

        def given(name: str) -> str:
            return _override(node, f'moveit_servo.{name}') or str(getattr(own, name))

        def objection(settings: ServoNodeSettings) -> str:
            block = settings.moveit_servo
            return '; '.join(check_parameters(kinematics, block.move_group_name, block))

        # What is empty in the files is looked up, so that no client reads back an empty text.
        group = given('move_group_name') or arm_group(kinematics, moved)
        known = group in kinematics.robot.semantic.groups
        joints = kinematics.robot.semantic.groups[group].active_joints if known else ()
        start = robot.servo.model_copy(update={'moveit_servo': own.model_copy(update={
            'move_group_name': group,
            'command_out_topic': given('command_out_topic') or (
                _command_topic(robot, joints, given('command_out_type')) if known else ''),
            'joint_topic': given('joint_topic') or _joint_topics(robot)[0],
        })})
        try:
            self._parameters = SettingsParameters(node, start, self._changed, objection)
        except ValidationError as error:
            raise ServoSettingsError(f'servo: {reason(error)}') from None
        settings: ServoNodeSettings = self._parameters.settings
        wrong = objection(settings)
        if wrong:
            raise ServoSettingsError(f'servo: {wrong}')
        self._group = settings.moveit_servo.move_group_name
        return settings

    def _changed(self, settings: ServoNodeSettings) -> None:
        if hasattr(self, '_streaming'):
            stream, _ = build_stream(
                self._kinematics, self.scene, CollisionChecker(self.scene), settings, self._group)
            self._streaming.change(settings.moveit_servo, stream)


def _override(node: PollingNode, name: str) -> str:
    """Return what ``--ros-args`` give a parameter that is yet to be declared, '' for nothing."""
    value = node.declare_parameter(name, '').value
    node.undeclare_parameter(name)
    return str(value or '')


def _joint_topics(robot: RobotSettings) -> tuple[str, ...]:
    """Return the topics on which the robot's joint states may come."""
    return tuple(dict.fromkeys(
        robot.planning_parameters.joint_state_topics
        or (robot.joint_states_topic, DEFAULT_JOINT_STATES)))


def _command_topic(robot: RobotSettings, joints: tuple[str, ...], kind: str) -> str:
    """Return where the robot's own controller of these joints takes commands."""
    if kind == ARRAY:
        for controller in robot.controllers:
            forwards = 'forward' in controller.type or 'JointGroup' in controller.type
            if forwards and tuple(controller.joints) == joints:
                return f'{robot.namespace}/{controller.name}/commands'
        raise ServoSettingsError(
            'servo: command_out_topic is empty, and no forward controller has exactly the joints '
            f'{", ".join(joints)}')
    for mapped in robot.moveit_controllers:
        if mapped.type == 'FollowJointTrajectory' and set(joints) <= set(mapped.joints):
            return f"/{mapped.name.strip('/')}/joint_trajectory"
    for controller in robot.controllers:
        if controller.type in TRAJECTORY_CONTROLLERS and set(joints) <= set(controller.joints):
            return f'{robot.namespace}/{controller.name}/joint_trajectory'
    raise ServoSettingsError(
        'servo: command_out_topic is empty, and no trajectory controller has the joints '
        f'{", ".join(joints)}')


class ServoProgram(ExecutorProgram):
    """Streams in a thread of its own; services are answered in the main thread."""

    NODE = 'servo_node'
    NODE_OPTIONS: ClassVar[dict[str, Any]] = {'clock_when_asked': True}

    def _serve(
        self, executor: SingleThreadedExecutor, node: PollingNode, afterwards: ExitStack
    ) -> int:
        servo = ServoNode(node, self._cell)
        try:
            servo.start()
            while not self._stop_wanted() and rclpy.ok():
                if servo.failure:
                    node.get_logger().error(f'the stream has ended; please report this:\n'
                                            f'{servo.failure}')
                    return 1
                with failures_logged(node):
                    callback, *_ = executor.wait_for_ready_callbacks(1.0, None, self._stop_wanted)
                    callback()
                    callback.result()  # raises what the callback raised
        finally:
            servo.stop()
        return 0
