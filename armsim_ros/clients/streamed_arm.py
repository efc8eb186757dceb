# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A running arm as a policy has it: observed by topics, moved by a forward controller."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
import time
from typing import Any

from control_msgs.action import GripperCommand, ParallelGripperCommand
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Empty

from armsim_ros.arrays import Vector
from armsim_ros.clients.client_node import (
    ClientNode,
    FIND_BACK,
    FIRST_MESSAGE,
    JointStates,
    LatestMessage,
)
from armsim_ros.clients.controller_manager import ControllerManagerClient
from armsim_ros.config.controllers.gripper_action_controller import (
    GripperParameters,
    ParallelGripperActionControllerParameters,
)
from armsim_ros.env.actions import Actions
from armsim_ros.errors import ControllerError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.cell import Cell
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.tasks.hand import HandModel

#: Types of controllers that give positions to the drives as they come.
FORWARD = ('forward_command_controller/ForwardCommandController',
           'position_controllers/JointGroupPositionController')
#: A gripper gets a goal where its level has changed by so much.
_LEVEL_CHANGE = 0.01


class StreamedArm:
    """
    A running arm that follows a stream of joint positions until it is closed.

    It activates a forward controller of the arm's joints in place of what has claimed them.

    :param client: the node to use; it stays open.
    :param cell: the files of the robot that runs.
    :param controller: forward controller; '' takes the first that is loaded.
    :param cameras: camera -> topic of its pictures.
    :param timeout: for the first messages of its topics [s].
    :raises SimulationError: a topic has no message.
    :raises ControllerError: no such controller is loaded, or its activation fails.
    """

    def __init__(
        self, client: ClientNode, cell: Cell, *, controller: str = '',
        cameras: Mapping[str, str] | None = None, timeout: float = FIRST_MESSAGE
    ) -> None:
        self._client, self._robot = client, cell.robots[0]
        self._namespace = self._robot.settings.namespace
        self.hand = HandModel.of(cell)
        self.joints: tuple[str, ...] = self.hand.arm_joints(cell.model)
        start = f'start the arm: armsim bringup robot:={self._robot.name}'
        states = self._robot.settings.joint_states_topic
        self._states = JointStates(client, states, start)
        self._pictures = {
            name: LatestMessage(client, Image, topic, f'{start} camera:=true')
            for name, topic in (cameras or {}).items()}
        try:
            deadline = time.monotonic() + timeout
            for topic in (self._states, *self._pictures.values()):
                topic.get(max(0.0, deadline - time.monotonic()))
            self._manager = ControllerManagerClient(
                client, f'{self._namespace}/controller_manager')
            self._controller, self._order = self._chosen(controller)
            self._goal = self.positions
            self._publisher = client.node.create_publisher(
                Float64MultiArray, f'{self._namespace}/{self._controller}/commands', 1)
            self._level = 0.0
            self._level = self.level
            self._prepare_hand()
            self._displaced = self._take_over()
        except BaseException:
            self._unsubscribe()
            raise

    @property
    def positions(self) -> dict[str, float]:
        """Joint -> position [rad or m], of the last message."""
        return self._states.positions

    @property
    def level(self) -> float:
        """1 for an open gripper or a cup that is on, 0 for a closed gripper or one that is off."""
        if self.hand.cup:
            return self._level
        return self.hand.level_of(self.positions[self.hand.joint])

    def pictures(self) -> dict[str, NDArray[np.uint8]]:
        """Return camera -> its last picture (h, w, 3)."""
        from armsim_ros.data.topic_map import picture_of

        return {name: picture_of(topic.get(), 'sensor_msgs/msg/Image', name)
                for name, topic in self._pictures.items()}

    def send(self, goals: Mapping[str, float], level: float | None = None) -> dict[str, float]:
        """
        Command joints and hand, and return what the joints are commanded within their limits.

        :param goals: joint -> position [rad or m]; the others stay where they are commanded.
        :param level: of the hand, see :attr:`level`; None leaves it as it is.
        """
        limits = {name: self._robot.model.joints[name].limits for name in self.joints}
        sent = {name: float(np.clip(goals.get(name, self._goal[name]), limits[name].lower,
                                    limits[name].upper)) for name in self.joints}
        self._goal = sent
        self._publisher.publish(Float64MultiArray(data=[sent[name] for name in self._order]))
        if level is not None:
            self._move_hand(level)
        return sent

    def moved_by(self, way: Vector, period: float) -> dict[str, float]:
        """
        Return the goals that move the tip without turning it, from where the joints are commanded.

        :param way: (3,) in world axes [m].
        :param period: in which it is done [s].
        """
        actions = self._actions
        start = np.array([self._goal[name] for name in self.joints])
        twist = np.concatenate((np.asarray(way) / period, np.zeros(3)))
        goals = start + period * actions.velocities(twist, start)
        return dict(zip(self.joints, goals.tolist(), strict=True))

    @cached_property
    def _actions(self) -> Actions:
        model, placement = self._robot.model, self._robot.settings.simulation.placement
        group = next(iter(model.semantic.groups))
        return Actions(
            'position', KinematicModel(model), self.joints, group, model.group(group).tips[0],
            pose_matrix(placement.xyz, placement.rpy)[:3, :3], twist=(1.0, 1.0), cups=(),
            period=1.0)

    def close(self) -> None:
        """Hold where the arm is, and activate what was active before."""
        try:
            if self._displaced is not None:
                self._switch(self._displaced, [self._controller])
        finally:
            self._unsubscribe()
            self._client.in_executor(lambda: self._client.node.destroy_publisher(self._publisher))

    def _chosen(self, name: str) -> tuple[str, list[str]]:
        """Return a forward controller of all joints, and its joints in order."""
        loaded = self._manager.controllers()
        wanted = {f'{joint}/position' for joint in self.joints}
        fits = [each for each, state in loaded.items() if state.type in FORWARD
                and set(state.required_command_interfaces) == wanted]
        if (name and name not in fits) or not fits:
            raise ControllerError(
                (f"'{name}' does not forward" if name else 'no loaded controller forwards')
                + f' positions of {", ".join(self.joints)}; loaded: '
                f"{', '.join(loaded)}; add a position_controllers/JointGroupPositionController "
                "to the robot's files, as docs/streaming.md does")
        chosen = name or fits[0]
        interfaces = loaded[chosen].required_command_interfaces
        return chosen, [interface.rpartition('/')[0] for interface in interfaces]

    def _take_over(self) -> list[str] | None:
        """Activate the controller; return what it displaces, None where it was active."""
        states = self._manager.controllers()
        displaced = None
        if states[self._controller].state != 'active':
            displaced = [name for name, state in states.items() if state.state == 'active' and any(
                interface.partition('/')[0] in self.joints
                for interface in state.claimed_interfaces)]
            self._switch([self._controller], displaced)
        for _ in range(round(FIRST_MESSAGE / FIND_BACK)):
            if self._publisher.get_subscription_count():
                return displaced
            self._client.settle()
        raise ControllerError(f"'{self._controller}' does not subscribe to its commands")

    def _switch(self, activate: Sequence[str], deactivate: Sequence[str]) -> None:
        answer = self._manager.switch(activate=activate, deactivate=deactivate)
        if not answer.ok:
            raise ControllerError(answer.message)

    def _prepare_hand(self) -> None:
        """Find the services of the cup, or the action of the gripper."""
        if self.hand.cup:
            place = f'{self._namespace}/{self.hand.cup}'
            self._client.connect({f'{place}/on': Empty, f'{place}/off': Empty})
            return
        controller = next(
            each for each in self._robot.settings.controllers
            if isinstance(each.parameters, GripperParameters)
            and each.parameters.joint == self.hand.joint)
        self._parallel = isinstance(
            controller.parameters, ParallelGripperActionControllerParameters)
        self._action = f'{self._namespace}/{controller.name}/gripper_cmd'

    def _move_hand(self, level: float) -> None:
        """Give the hand another goal where its level has changed."""
        if self.hand.cup:
            level = float(level > 0.5)
        if abs(level - self._level) < _LEVEL_CHANGE:
            return
        self._level = level
        if self.hand.cup:
            service = 'on' if level else 'off'
            self._client.call(f'{self._namespace}/{self.hand.cup}/{service}', Empty)
            return
        position = self.hand.closed + level * (self.hand.open - self.hand.closed)
        kind: Any = ParallelGripperCommand if self._parallel else GripperCommand
        goal = kind.Goal()
        goal.command.position = [position] if self._parallel else position
        self._client.goal(kind, self._action, goal)

    def _unsubscribe(self) -> None:
        for topic in (self._states, *self._pictures.values()):
            topic.close()
