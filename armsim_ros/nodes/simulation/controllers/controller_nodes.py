# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Each controller's node: its parameters and the endpoints of its kind."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar

from control_msgs.msg import SpeedScalingFactor
from control_msgs.srv import QueryTrajectoryState
from rclpy.node import Node
from std_msgs.msg import Float64
from trajectory_msgs.msg import JointTrajectory

from armsim_ros.control.broadcaster import (
    Broadcaster,
    ForceTorqueSensorBroadcaster,
    SensorBroadcaster,
    TipBroadcaster,
)
from armsim_ros.control.command_controllers.admittance_controller import AdmittanceController
from armsim_ros.control.command_controllers.forward_command_controller import ForwardController
from armsim_ros.control.command_controllers.gpio_command_controller import GpioCommandController
from armsim_ros.control.command_controllers.gripper_controller import (
    GripperController,
    ParallelGripperController,
)
from armsim_ros.control.command_controllers.pid_controller import PidController
from armsim_ros.control.compliance.cartesian_controller import ComplianceController
from armsim_ros.control.compliance.net_force_controllers import NetForceController
from armsim_ros.control.controller import Controller, LifecycleState, Rate
from armsim_ros.control.joint_state_broadcaster import JointStateBroadcaster, JointStateSnapshot
from armsim_ros.control.manager.controller_factory import StandInController
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.errors import ControllerError
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.trajectory import trajectory_from_message
from armsim_ros.nodes.parameters import SettingsParameters
from armsim_ros.nodes.simulation.controllers.actions import (
    answer_query,
    FollowJointTrajectoryServer,
    GoalServer,
    GripperCommandServer,
    ParallelGripperCommandServer,
    RejectedGoals,
)
from armsim_ros.nodes.simulation.controllers.sensor_topics import (
    ComplianceTopics,
    NetForceTopics,
    tare_service,
    TipTopic,
    TOPICS,
)
from armsim_ros.nodes.simulation.controllers.state_topics import (
    AdmittanceTopics,
    Commands,
    ControllerStatePublisher,
    DynamicJointStates,
    GpioTopics,
    JointStates,
    PidTopics,
)
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.sim_time import ToldNode

#: The speed scaling of a robot at full speed [%].
FULL_SPEED = 100.0


class ControllerNode:
    """
    The ROS side of a controller: a node of its name in the manager's namespace.

    The endpoints exist from the time at which the controller is configured, as upstream's do.
    """

    #: States of the controller in which the endpoints are created; they stay from then on.
    opening_states: ClassVar[tuple[LifecycleState, ...]] = (
        LifecycleState.INACTIVE, LifecycleState.ACTIVE)

    def __init__(
        self, controller: Controller[Any], node: ToldNode, dispatcher: Dispatcher
    ) -> None:
        """Parameters are declared later, by ``declare_parameters``."""
        self.controller, self.node, self.dispatcher = controller, node, dispatcher
        self.opened = False
        self._parameters: SettingsParameters[Any] | None = None

    @property
    def due(self) -> bool:
        """Whether the endpoints are to be created now."""
        return not self.opened and self.controller.state in self.opening_states

    def open(self) -> None:
        """Create the endpoints; only from the executor's thread, or before it runs."""
        self._open(self.node)
        self.opened = True

    def _open(self, node: Node) -> None:
        """Create the endpoints of the controller's kind."""

    def follow_parameters(self) -> None:
        """
        Adapt the endpoints, if there are any, to what the controller was configured with.

        Only from the executor's thread.
        """

    def declare_parameters(self) -> None:
        """Declare the controller's parameters; later changes go to the controller."""
        self._parameters = SettingsParameters(
            self.node, self.controller.parameters, self._parameters_changed, self._objection)

    def publish(self, time_ns: int) -> None:
        """
        Publish what is due at the rate of /clock.

        Called in the publishing thread once the endpoints are there.
        """

    def refused(self, reason: str) -> None:
        """Publish why a goal or trajectory was refused."""

    @property
    def pending(self) -> int:
        """Goals without a result."""
        return 0

    def end(self, sentence: str) -> None:
        """Abort running goals and accept no more; only from the executor's thread."""

    def destroy(self) -> None:
        """Destroy the node and its endpoints."""
        self.node.destroy_node()

    def _objection(self, settings: Any) -> str:
        try:
            self.controller.check_parameters(settings)
        except ControllerError as error:
            return str(error)
        return ''

    def _parameters_changed(self, settings: Any) -> None:
        try:
            self.controller.set_parameters(settings)
        except ControllerError as error:
            self.node.get_logger().error(f'the parameters were not accepted: {error}')


class BroadcasterNode(ControllerNode):
    """A broadcaster: publishes each sample as it comes from the loop."""

    controller: Broadcaster[Any, Any]

    def open(self) -> None:
        """Create the topics and listen to the controller."""
        super().open()
        post = self.dispatcher.bounded(1)  # one call takes all samples
        self.controller.listen(lambda: post(self._publish_samples))

    @abstractmethod
    def _publish_sample(self, sample: Any) -> None:
        """Publish a sample on them."""

    def destroy(self) -> None:
        """Destroy the node and stop listening to the controller."""
        self.controller.listen(None)
        super().destroy()

    def _publish_samples(self) -> None:
        while (sample := self.controller.poll()) is not None:
            self._publish_sample(sample)


class JointStateBroadcasterNode(BroadcasterNode):
    """The joint state broadcaster: both of its topics."""

    controller: JointStateBroadcaster

    def _open(self, node: Node) -> None:
        parameters = self.controller.parameters
        self._joint_states = JointStates(node, local=parameters.use_local_topics)
        self._dynamic: DynamicJointStates | None = None
        if parameters.publish_dynamic_joint_states:
            self._dynamic = DynamicJointStates(node, local=parameters.use_local_topics)

    def _publish_sample(self, sample: JointStateSnapshot) -> None:
        self._joint_states.publish(sample)
        if self._dynamic is not None:
            self._dynamic.publish(sample)
        if self.dispatcher.leaves_out:
            self.controller.calm = self._joint_states.calm(sample.time_ns) and not (
                self._dynamic is not None and self._dynamic.heard)


class ActionControllerNode(ControllerNode):
    """A controller with an action and a topic of rejected goals."""

    _action: GoalServer
    _rejected: RejectedGoals

    def _open(self, node: Node) -> None:
        self._rejected = RejectedGoals(node)

    def refused(self, reason: str) -> None:
        """Publish why a goal or trajectory was refused."""
        if self.opened:
            self._rejected.publish(reason)

    @property
    def pending(self) -> int:
        """Goals without a result."""
        return len(self._action.running) if self.opened else 0

    def end(self, sentence: str) -> None:
        """Abort running goals and accept no more."""
        if self.opened:
            self._action.end(sentence)

    def destroy(self) -> None:
        """Destroy the action server and the node."""
        if self.opened:
            self._action.destroy()
        super().destroy()


class TrajectoryControllerNode(ActionControllerNode):
    """The joint trajectory controller: action, topics, query."""

    controller: JointTrajectoryController
    _action: FollowJointTrajectoryServer

    def _open(self, node: Node) -> None:
        super()._open(node)
        controller = self.controller
        self._action = FollowJointTrajectoryServer(node, controller, self.dispatcher)
        self._state = ControllerStatePublisher(node, controller)
        self._inputs: list[Any] = [
            node.create_subscription(
                JointTrajectory, '~/joint_trajectory', self._take_trajectory, qos.COMMAND),
            node.create_service(
                QueryTrajectoryState, '~/query_state', partial(answer_query, controller)),
        ]
        if controller.subscribes_speed_scaling:
            self._inputs.append(node.create_subscription(
                SpeedScalingFactor, '~/speed_scaling_input', self._take_speed, qos.COMMAND))

    def publish(self, time_ns: int) -> None:
        """Publish state and feedback."""
        self._state.publish_if_due(time_ns)
        self._action.publish_feedback(time_ns)

    def _take_trajectory(self, message: JointTrajectory) -> None:
        self.controller.set_trajectory(trajectory_from_message(message))

    def _take_speed(self, message: SpeedScalingFactor) -> None:
        self.controller.set_speed_scaling(message.factor)


class GripperNode(ActionControllerNode):
    """A gripper controller of either kind: its action, from the first activation on."""

    controller: GripperController | ParallelGripperController
    opening_states: ClassVar[tuple[LifecycleState, ...]] = (LifecycleState.ACTIVE,)

    def _open(self, node: Node) -> None:
        super()._open(node)
        controller = self.controller
        if isinstance(controller, ParallelGripperController):
            self._action = ParallelGripperCommandServer(node, controller, self.dispatcher)
        else:
            self._action = GripperCommandServer(node, controller, self.dispatcher)


class SensorBroadcasterNode(BroadcasterNode):
    """A broadcaster of a sensor or of a link: its topic."""

    controller: SensorBroadcaster | TipBroadcaster

    def _open(self, node: Node) -> None:
        controller = self.controller
        self._topics: Any
        if isinstance(controller, GpioCommandController):
            self._topics = GpioTopics(node, controller)
        elif isinstance(controller, TipBroadcaster):
            self._topics = TipTopic(node, lambda: controller.parameters)
        else:
            kind = TOPICS[type(controller.parameters)]
            self._topics = kind(node, lambda: controller.parameters)
        if isinstance(controller, ForceTorqueSensorBroadcaster):
            self._service = tare_service(node, controller.tare)

    def _publish_sample(self, sample: Any) -> None:
        self._topics.publish(sample)


#: Kind of controller -> what receives its commands and publishes its state.
_TOPICS: tuple[tuple[type[Controller[Any]], Callable[[Node, Any], Any]], ...] = (
    (ForwardController, Commands),
    (ComplianceController, ComplianceTopics),
    (NetForceController, NetForceTopics),
    (PidController, PidTopics),
    (AdmittanceController, AdmittanceTopics))


class CommandedNode(ControllerNode):
    """A controller with topics of commands, and of its state while it is active."""

    def _open(self, node: Node) -> None:
        self._topics = next(topics for kind, topics in _TOPICS
                            if isinstance(self.controller, kind))(node, self.controller)

    def publish(self, time_ns: int) -> None:
        """Publish the state."""
        if self.controller.active:
            self._topics.publish(time_ns)


class PidNode(CommandedNode):
    """The PID controller."""

    _topics: PidTopics

    def follow_parameters(self) -> None:
        """Take measured states from where the parameters have them."""
        if self.opened:
            self._topics.follow_parameters()


class StandInNode(ControllerNode):
    """A replacement of a vendor's controller; that of a speed scaling broadcaster publishes."""

    controller: StandInController

    def _open(self, node: Node) -> None:
        """Create the publisher, if there is something to publish."""
        controller, self._scaling = self.controller, None
        if controller.type.endswith('/SpeedScalingStateBroadcaster'):
            self._scaling = node.create_publisher(Float64, '~/speed_scaling', 10)
        self._rate = Rate(controller.parameters.state_publish_rate)

    def publish(self, time_ns: int) -> None:
        """Publish the full speed."""
        if self._scaling is not None and self.controller.active and self._rate.due(time_ns):
            self._scaling.publish(Float64(data=FULL_SPEED))


_KINDS: tuple[tuple[type[Controller[Any]], Callable[..., ControllerNode]], ...] = (
    (JointTrajectoryController, TrajectoryControllerNode),
    (JointStateBroadcaster, JointStateBroadcasterNode),
    (GripperController, GripperNode),
    (ParallelGripperController, GripperNode),
    (SensorBroadcaster, SensorBroadcasterNode),
    (TipBroadcaster, SensorBroadcasterNode),
    (PidController, PidNode),
    (StandInController, StandInNode))


def create_controller_node(
    controller: Controller[Any], node: ToldNode, dispatcher: Dispatcher
) -> ControllerNode:
    """Return the ROS side of a controller, by its kind."""
    for kind, side in _KINDS:
        if isinstance(controller, kind):
            return side(controller, node, dispatcher)
    if isinstance(controller, tuple(kind for kind, _ in _TOPICS)):
        return CommandedNode(controller, node, dispatcher)
    return ControllerNode(controller, node, dispatcher)
