# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services that stop an arm, clear a stop and switch its drives; and the topic ``safety``."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
import json
from typing import Any

from std_msgs.msg import String
from std_srvs.srv import SetBool

from armsim_ros.control.arm_state import Mode, NUMBERS, Safety
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.vendors import ArmNodes

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
