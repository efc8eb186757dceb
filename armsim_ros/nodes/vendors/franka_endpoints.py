# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All endpoints of an arm of Franka."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from control_msgs.action import GripperCommand
from franka_msgs.action import ErrorRecovery, Grasp, Homing, Move
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from sensor_msgs.msg import JointState

from armsim_ros.control.command_controllers.hand_drive import HandDrive, HandGoal
from armsim_ros.control.controller import Controller, Rate
from armsim_ros.control.mailbox import GoalStatus
from armsim_ros.errors import ControllerError, SimulationError
from armsim_ros.model.robot_model import JointType
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.simulation.controllers.actions import GoalServer
from armsim_ros.nodes.vendors.endpoints import ArmNodes, Endpoints
from armsim_ros.nodes.vendors.franka_services import ArmParameters, ParameterServices
from armsim_ros.nodes.vendors.franka_state_broadcaster import StateTopics

#: A width that is nearer than this needs no motion [m].
SAME_WIDTH = 1e-4
#: How far a grasp without an epsilon may be from its width.
EPSILONS = 'default_grasp_epsilon.inner', 'default_grasp_epsilon.outer'
#: Parameters of a hand: widths [m], a speed of the width [m/s], rates [Hz].
DEFAULTS: dict[str, Any] = {
    'robot_ip': '', **dict.fromkeys(EPSILONS, 0.005), 'default_speed': 0.1,
    'state_publish_rate': 30, 'feedback_publish_rate': 10}


class HandAction(GoalServer):
    """
    An action of the hand; goals are always accepted, as upstream, and fail where they cannot be.

    :param goal_of: from a request to the goal of the drive.
    """

    def __init__(self, nodes: ArmNodes, node: Node, hand: HandDrive, kind: Any, name: str,
                 goal_of: Callable[[Any], HandGoal]) -> None:
        self._hand, self._kind, self._goal_of = hand, kind, goal_of
        super().__init__(node, nodes.dispatcher, kind, name)

    def publish_feedback(self) -> None:
        """Publish the width to the clients of running goals."""
        for running in self.running:
            if not running.goal.done:
                running.handle.publish_feedback(self._feedback())

    def _feedback(self) -> Any:
        return self._kind.Feedback(current_width=self._hand.width)

    def _send(self, request: Any) -> HandGoal:
        goal = self._goal_of(request)
        return goal if goal.done else self._hand.send(goal)

    def _cancel_goal(self, goal: HandGoal) -> bool:
        return self._hand.cancel(goal)

    def _result(self, goal: HandGoal) -> Any:
        return self._kind.Result(success=goal.status is GoalStatus.SUCCEEDED, error=goal.error)

    def _aborted(self, sentence: str) -> Any:
        return self._kind.Result(success=False, error=sentence)


class HandCommand(HandAction):
    """``gripper_action``: its results and feedback have the width as position."""

    def _feedback(self) -> Any:
        return GripperCommand.Feedback(position=self._hand.width)

    def _result(self, goal: HandGoal) -> Any:
        return GripperCommand.Result(
            position=self._hand.width, reached_goal=goal.status is GoalStatus.SUCCEEDED)

    def _aborted(self, sentence: str) -> Any:
        return GripperCommand.Result()


class Gripper:
    """
    The node of a hand.

    :param joint: of the finger that the other one mimics.
    :raises ControllerError: a parameter of the node that cannot be.
    """

    def __init__(self, nodes: ArmNodes, joint: str, name: str) -> None:
        model = nodes.robot.model
        node = nodes.new_node(name)
        self._node = node
        fingers = [name for name in model.movable_joints if model.driver_of(name)[0].name == joint]
        try:
            for parameter, default in (*DEFAULTS.items(), ('joint_names', fingers)):
                node.declare_parameter(parameter, default)
        except InvalidParameterTypeException as error:
            raise ControllerError(str(error)) from None
        names = list(node.get_parameter('joint_names').value)
        if len(names) != len(fingers):
            raise ControllerError(f"parameter 'joint_names' is {names}; allowed: names of "
                                  f'{len(fingers)} joints')
        self.hand = hand = HandDrive.of(name, joint, nodes.manager.context)
        nodes.manager.attach(hand)
        self._states = JointState(name=names)
        for field in ('velocity', 'effort'):
            setattr(self._states, field, [0.0] * len(names))
        self._publisher = node.create_publisher(JointState, '~/joint_states', 1)
        self._state_rate = Rate(self._parameter('state_publish_rate'))
        self._feedback_rate = Rate(self._parameter('feedback_publish_rate'))
        self._actions = [
            HandAction(nodes, node, hand, Homing, '~/homing',
                       lambda _: HandGoal((0.0, hand.widest), self._default_speed)),
            HandAction(nodes, node, hand, Move, '~/move',
                       lambda goal: HandGoal((goal.width,), goal.speed)),
            HandAction(nodes, node, hand, Grasp, '~/grasp', lambda goal: _grasp(
                goal.width, goal.speed, goal.force, goal.epsilon.inner, goal.epsilon.outer)),
            HandCommand(nodes, node, hand, GripperCommand, '~/gripper_action', self._command),
        ]
        nodes.trigger(node, '~/stop', hand.halt)

    def publish(self, time_ns: int) -> None:
        """Publish joint states and feedback, as far as they are due."""
        if self._feedback_rate.due(time_ns):
            for action in self._actions:
                action.publish_feedback()
        if self._state_rate.due(time_ns) and self._publisher.get_subscription_count():
            fill_time(self._states.header.stamp, time_ns)
            self._states.position = [0.5 * self.hand.width] * len(self._states.name)
            self._publisher.publish(self._states)

    @property
    def pending(self) -> int:
        """Goals without a result."""
        return sum(len(action.running) for action in self._actions)

    def end(self, sentence: str) -> None:
        """Abort the goals."""
        for action in self._actions:
            action.end(sentence)

    @property
    def _default_speed(self) -> float:
        return self._parameter('default_speed')

    def _parameter(self, name: str) -> float:
        return float(self._node.get_parameter(name).value)

    def _command(self, request: GripperCommand.Goal) -> HandGoal:
        """Return a motion to open, or a grasp to close, as upstream decides it."""
        hand, command = self.hand, request.command
        width, present = 2.0 * command.position, hand.width
        if abs(width - present) < SAME_WIDTH:
            return hand.pass_over(HandGoal((present,), self._default_speed))
        if width >= present or width < 0.0:
            return HandGoal((width,), self._default_speed)
        inner, outer = map(self._parameter, EPSILONS)
        return _grasp(width, self._default_speed, command.max_effort, inner, outer)


def _grasp(width: float, speed: float, force: float, inner: float, outer: float) -> HandGoal:
    """Return a goal that closes the hand and succeeds where it then holds such a width."""
    return HandGoal((width,), speed, force, (width - inner, width + outer))


#: Of an arm.
JOINTS = 7


class FrankaEndpoints(Endpoints):
    """Error recovery, the services of parameters, the hand, and the state of the arm."""

    def __init__(self, nodes: ArmNodes) -> None:
        super().__init__(nodes)
        model = nodes.robot.model
        self._joints = tuple(name for name in model.active_joints
                             if model.joints[name].type is not JointType.PRISMATIC)[:JOINTS]
        self._parameters = ArmParameters()
        self._gripper: Gripper | None = None

    def create(self) -> None:
        """Create the nodes that the driver has beside its controllers."""
        nodes = self.nodes
        node = nodes.new_node('action_server')
        self._logger = node.get_logger()
        self._server = ActionServer(
            node, ErrorRecovery, '~/error_recovery', self._recover,
            callback_group=ReentrantCallbackGroup(), **qos.ACTION_SERVICES)
        ParameterServices(nodes, self._joints, self._parameters)
        end = nodes.arm.vendor.finger
        finger = next((name for name in nodes.robot.model.active_joints if name.endswith(end)), '')
        if finger:
            name = nodes.arm.settings.gripper or f'{finger.removesuffix(end)}_gripper'
            try:
                self._gripper = Gripper(nodes, finger, name)
            except ControllerError as error:
                self._logger.error(f'no hand {name}: {error}')

    def open(self, controller: Controller[Any], node: Node) -> None:
        """Create the topics of a broadcaster of the arm's state."""
        if controller.type.endswith('/FrankaRobotStateBroadcaster') and self._joints:
            try:
                self.add(controller, StateTopics(
                    self.nodes, controller, node, self._joints, self._parameters))
            except ControllerError as error:
                node.get_logger().error(f'no state of the arm: {error}')

    def publish(self, time_ns: int) -> None:
        """Publish states and feedback."""
        super().publish(time_ns)
        if self._gripper is not None:
            self._gripper.publish(time_ns)

    @property
    def pending(self) -> int:
        """Goals of the hand without a result."""
        return self._gripper.pending if self._gripper is not None else 0

    def end(self, sentence: str) -> None:
        """Abort the goals of the hand."""
        if self._gripper is not None:
            self._gripper.end(sentence)

    async def _recover(self, handle: ServerGoalHandle) -> Any:
        try:
            refusal = await self.nodes.change(self.nodes.arm.clear_stop)
        except SimulationError as error:
            refusal = str(error)
        if refusal:
            self._logger.error(f'no recovery: {refusal}')
            handle.abort()
        else:
            handle.succeed()
        return ErrorRecovery.Result()
