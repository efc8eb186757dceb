# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot in its namespace: controller manager, controllers, their topics, events and faults."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
import json
import time
from typing import Any

from rclpy.executors import Executor
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import SetBool

from armsim_ros.config.simulation import JointFault, JointFaults
from armsim_ros.control.arm_state import Mode, NUMBERS, Safety
from armsim_ros.control.faults import FaultInjector
from armsim_ros.control.joint_state_broadcaster import JointStateBroadcaster
from armsim_ros.control.mailbox import CAPACITY, ControllerEvent
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.model.cell import Robot
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.parameters import SettingsParameters
from armsim_ros.nodes.qos import publish_descriptions
from armsim_ros.nodes.simulation.controllers.controller_nodes import ControllerNode
from armsim_ros.nodes.simulation.controllers.diagnostics import Activity, Diagnostics
from armsim_ros.nodes.simulation.controllers.manager_services import (
    ControllerManagerQueries,
    ControllerManagerServices,
)
from armsim_ros.nodes.simulation.controllers.registry import (
    ControllerDescriptions,
    ControllerRegistry,
)
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.sim_time import SimTime
from armsim_ros.nodes.vendors import ArmNodes, endpoints_of
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.vacuum_control import finger_switches, VacuumControl, wire_signals

_REFUSALS = ('goal_rejected', 'trajectory_rejected')


class EventLog:
    """
    Logs the events of controllers under their nodes' names, and passes on refusals.

    :param node: the manager's node, for what belongs to no controller.
    :param sides: controller -> its ROS side; looked up at every event.
    """

    def __init__(
        self, node: Node, manager: ControllerManager, sides: Mapping[str, ControllerNode]
    ) -> None:
        self._node, self._manager, self._sides = node, manager, sides
        #: The last events, for recordings.
        self.recent: deque[ControllerEvent] = deque(maxlen=CAPACITY)

    def drain(self) -> None:
        """Log all events since the last call."""
        for event in self._manager.poll_events():
            self.recent.append(event)
            side = self._sides.get(event.source)
            logger = (side.node if side is not None else self._node).get_logger()
            if event.level == 'error':
                logger.error(event.text)
            elif event.level == 'warning':
                logger.warning(event.text)
            else:
                logger.info(event.text)
            if side is not None and event.kind in _REFUSALS:
                side.refused(event.text)


class FaultParameters:
    """
    Injects joint faults; only if ``fault_injection`` of simulation.yaml is set.

    :param injector: makes the joints fail.
    :param joints: those of the manager's robot.
    """

    def __init__(self, node: Node, injector: FaultInjector, joints: Sequence[str]) -> None:
        """Declare the parameters of every joint that can be commanded, without faults."""
        self._node, self._injector = node, injector
        self._shown = JointFaults(faults={name: JointFault() for name in joints})
        SettingsParameters(node, self._shown, self._changed)
        node.get_logger().warning('faults of joints can be injected by the parameters faults.*')

    def _changed(self, settings: JointFaults) -> None:
        for joint, fault in settings.faults.items():
            if fault != self._shown.faults[joint]:
                self._injector.set_fault(joint, fault)
                self._node.get_logger().warning(f"fault of joint '{joint}': {fault}")
        self._shown = settings


#: How long another simulation is searched after the start [s]; discovery takes a few tenths.
WATCH_TIME = 2.0


class DomainWatch:
    """
    Searches for a second controller manager of our name in the ROS graph.

    On one machine a lock keeps the second away; this finds those of other machines. Only the
    latest searches: an older one no longer does. Two that start at the same time
    both find the other and both give up.

    :param found: called once with the message for the user.
    """

    def __init__(self, node: Node, found: Callable[[str], None]) -> None:
        self._node, self._found = node, found
        self._end = time.monotonic() + WATCH_TIME

    def look(self) -> None:
        """Check once; does nothing after the watch time."""
        if time.monotonic() > self._end:
            return
        own = (self._node.get_name(), self._node.get_namespace())
        if self._node.get_node_names_and_namespaces().count(own) > 1:
            self._end = 0.0
            name = self._node.get_fully_qualified_name()
            self._found(
                f'another simulation already runs as {name} on this ROS domain, and both '
                'publish the same topics. Stop it, or set another ROS_DOMAIN_ID, or start this '
                'simulation with namespace:=NAME')


class RobotNodes:
    """
    The nodes of a robot and their endpoints.

    :param faults: makes joints fail, where that is possible.
    :param time: makes the nodes, and sets their clocks.
    """

    def __init__(
        self, robot: Robot, manager: ControllerManager, loop: ControlLoop, executor: Executor,
        dispatcher: Dispatcher, faults: FaultInjector | None, time: SimTime
    ) -> None:
        """Create what others must discover early: the manager and its controllers."""
        namespace = robot.settings.namespace or '/'
        self.node = time.node(
            'controller_manager', namespace=namespace, allow_undeclared_parameters=True)
        executor.add_node(self.node)
        self._robot, self._manager, self._loop, self._dispatcher = robot, manager, loop, dispatcher
        self._faults = faults
        self._kept: list[Any] = []
        def new_node(name: str) -> Node:
            node = time.node(name, namespace=namespace)
            executor.add_node(node)
            return node

        self._arm_nodes = ArmNodes(robot, manager, loop, dispatcher, self.node, new_node)
        self._vendor = endpoints_of(self._arm_nodes)
        self._registry = ControllerRegistry(
            manager, ControllerDescriptions(self.node, robot.settings), executor, dispatcher,
            namespace, time, self._vendor.open)
        for controller in manager.controllers.values():
            self._registry.add(controller)
        self._events = EventLog(self.node, manager, self._registry)

    def publish_descriptions(self) -> None:
        """Publish URDF and SRDF of this robot beside those of the whole cell."""
        model = self._robot.model
        self._kept = publish_descriptions(self.node, model.urdf, model.srdf)

    def create_services(self, name: str, refuse: Callable[[str], None]) -> None:
        """
        Create the rest: parameters, the manager's services, diagnostics.

        Not while the loop runs: each new endpoint holds the interpreter for milliseconds.

        :param name: of the manager in ``/diagnostics``.
        :param refuse: ends the program where another program has these names.
        """
        node, manager = self.node, self._manager
        for side in self._registry.sides:
            side.declare_parameters()
        settings = self._robot.settings.controller_manager
        joints = self._robot.model.active_joints
        if settings.overruns.print_warnings is None:
            overruns = settings.overruns.model_copy(
                update={'print_warnings': not node.get_parameter('use_sim_time').value})
            settings = settings.model_copy(update={'overruns': overruns})
        parameters = SettingsParameters(node, settings)
        if self._faults is not None:
            FaultParameters(node, self._faults, joints)
        ControllerManagerQueries(node, manager, settings.update_rate)
        ControllerManagerServices(node, manager, self._registry, self._dispatcher)
        self._activity = Activity(node, manager)
        self._safety = SafetyServices(self._arm_nodes)
        self._vendor.create()
        self._watch_domain = DomainWatch(node, refuse)
        self._diagnostics = Diagnostics(
            node, name, manager, self._loop, lambda: parameters.settings, self._faults, joints)

    def wire(self, cups: Mapping[str, VacuumControl]) -> None:
        """Connect inputs and outputs of the arm with grippers, as its settings have it."""
        wires = self._robot.settings.simulation.hardware.io
        fingers = finger_switches(self._manager, self._robot.model) if wires else {}
        for line in wire_signals(self._manager.arm.signals, wires, cups, fingers):
            self.node.get_logger().warning(line)

    def controller_states(self) -> Sequence[tuple[str, str]]:
        """Return name and state of each controller."""
        return [(info.name, info.state) for info in self._manager.list_controllers()]

    def publish(self, time_ns: int) -> None:
        """Publish what is due at the rate of /clock [ns]."""
        for side in self._registry.sides:
            if side.opened:
                side.publish(time_ns)
        self._vendor.publish(time_ns)
        self._arm_nodes.check_waiting()
        self._events.drain()

    def watch(self, time_ns: int) -> None:
        """Check what rarely changes, also while time [ns] is paused."""
        self._registry.open_due_soon()
        self._events.drain()
        self._activity.publish_if_changed(time_ns)
        self._safety.publish_if_changed()
        self._vendor.publish(time_ns)
        self._arm_nodes.check_waiting()
        self._watch_domain.look()

    @property
    def pending(self) -> int:
        """Goals without a result."""
        return self._vendor.pending + sum(side.pending for side in self._registry.sides)

    def end(self, sentence: str) -> None:
        """Abort running goals and accept no more; only from the executor's thread."""
        self._arm_nodes.end(sentence)
        self._vendor.end(sentence)
        for side in self._registry.sides:
            side.end(sentence)

    @property
    def recent_events(self) -> tuple[ControllerEvent, ...]:
        """The controllers' latest events."""
        return tuple(self._events.recent)

    def sample_joint_states(self, time_ns: int) -> None:
        """Publish the joint states of this time [ns]; in the control loop's thread."""
        for controller in self._manager.controllers.values():
            if isinstance(controller, JointStateBroadcaster) and controller.active:
                controller.sample(time_ns)

    def publish_diagnostics(self) -> None:
        """Publish the robot's diagnostics."""
        self._diagnostics.publish()


try:
    from industrial_msgs.msg import RobotMode, RobotStatus, TriState
    HAS_STATUS = True
except ImportError:  # without its package the topic is left out
    HAS_STATUS = False

#: A joint that is faster is in motion [rad/s or m/s].
MOTION = 1e-3


class RobotStatusTopic:
    """``robot_status``, as drivers of ROS-Industrial publish it."""

    def __init__(self, nodes: ArmNodes) -> None:
        self._nodes = nodes
        self._publisher = nodes.node.create_publisher(RobotStatus, 'robot_status', 10)

    def publish(self) -> None:
        """Publish the present state, if it has subscribers."""
        if not self._publisher.get_subscription_count():
            return
        nodes, arm = self._nodes, self._nodes.arm
        message = RobotStatus(
            mode=RobotMode(val=RobotMode.AUTO),
            error_codes=[NUMBERS[arm.cause.kind]] if arm.cause is not None else [])
        fill_time(message.header.stamp, nodes.time_ns)
        velocity = nodes.manager.hardware.state.velocity
        for field, value in (
            ('e_stopped', arm.safety is Safety.EMERGENCY_STOP),
            ('drives_powered', arm.mode is not Mode.POWER_OFF),
            ('motion_possible', not arm.obstacle),
            ('in_motion', bool((abs(velocity) > MOTION).any())),
            ('in_error', arm.stopped),
        ):
            setattr(message, field, TriState(val=int(value)))
        self._publisher.publish(message)


class SafetyServices:
    """The state of an arm's drives and safety, in the robot's namespace."""

    def __init__(self, nodes: ArmNodes) -> None:
        self._arm = arm = nodes.arm
        self._nodes = nodes
        self._published = -1
        self._topic = nodes.node.create_publisher(String, 'safety', qos.LATCHED)
        self._status = RobotStatusTopic(nodes) if HAS_STATUS else None
        pressed: dict[str, tuple[Callable[[], Any], Callable[[], Any]]] = {
            'protective_stop': (arm.protective_stop, arm.clear_stop),
            'emergency_stop': (arm.emergency_stop, arm.release_emergency_stop),
        }
        for name, (press, release) in pressed.items():
            nodes.service(nodes.node, SetBool, name, partial(self._switch, press, release))
        nodes.trigger(nodes.node, 'clear_stop', arm.clear_stop)
        for name, mode in (('power_on', Mode.RUNNING), ('power_off', Mode.POWER_OFF)):
            nodes.trigger(nodes.node, name, partial(arm.power_to, mode))
        self.publish_if_changed()

    def publish_if_changed(self) -> None:
        """Publish the state if it is another than before; called ten times a second."""
        arm = self._arm
        if self._status is not None:
            self._status.publish()
        if arm.generation == self._published:
            return
        self._published = arm.generation
        state = {'mode': arm.mode.value, 'safety': arm.safety.value,
                 'cause': '' if arm.cause is None else str(arm.cause),
                 'since': arm.since_ns * 1e-9, 'program': arm.program.value}
        self._topic.publish(String(data=json.dumps(state)))

    def _switch(self, press: Callable[[], Any], release: Callable[[], Any], request: Any,
                response: Any) -> None:
        refusal = (press if request.data else release)() or ''
        response.success = not refusal
        response.message = refusal or f'{self._arm.mode.value}, {self._arm.safety.value}'
