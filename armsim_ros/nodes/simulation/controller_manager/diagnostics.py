# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``/diagnostics``."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from armsim_ros.control.faults import FaultInjector
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.sim.control_loop import ControlLoop

#: Real-time factor below which the loop is reported as slow.
SLOW_PACE = 0.95


class Diagnostics:
    """
    Publishes the health of controllers, hardware and loop, with the reference's names.

    :param node: the manager's node.
    :param name: precedes every status.
    :param faults: what makes joints fail on purpose, where that is possible.
    :param joints: those of the manager's robot.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        manager: ControllerManager,
        loop: ControlLoop,
        faults: FaultInjector | None,
        joints: Collection[str],
    ) -> None:
        self._faults = faults
        self._joints = joints
        self._name = name
        self._node = node
        self._manager = manager
        self._loop = loop
        self._publisher = node.create_publisher(
            DiagnosticArray, '/diagnostics', qos.DIAGNOSTICS
        )

    def publish(self) -> None:
        """Publish the current state, if anybody subscribes."""
        if not self._publisher.get_subscription_count():
            return
        message = DiagnosticArray(status=[self._controllers(), self._hardware(), self._pace()])
        if self._faults is not None:
            message.status.append(self._injected(self._faults))
        fill_time(message.header.stamp, self._loop.clock.now_ns)
        self._publisher.publish(message)

    def _controllers(self) -> DiagnosticStatus:
        states = {info.name: info.state for info in self._manager.list_controllers()}
        idle = [name for name, state in states.items() if state != 'active']
        if not states:
            return self._status('Controllers Activity', 'No controllers are loaded', {}, True)
        text = 'Not all controllers are active' if idle else 'All controllers are active'
        return self._status('Controllers Activity', text, states)

    def _hardware(self) -> DiagnosticStatus:
        states = {info.name: info.state for info in self._manager.list_hardware_components()}
        idle = [name for name, state in states.items() if state != 'active']
        text = 'Not all hardware components are active' if idle else (
            'All hardware components are active'
        )
        return self._status('Hardware Components Activity', text, states, bool(idle))

    def _injected(self, faults: FaultInjector) -> DiagnosticStatus:
        active = {
            joint: str(fault) for joint, fault in faults.active.items() if joint in self._joints
        }
        text = f'Joints fail on purpose: {", ".join(active)}' if active else (
            'Joints can be made to fail, none does'
        )
        return self._status('Fault Injection', text, active, bool(active))

    def _pace(self) -> DiagnosticStatus:
        name = 'Controller Manager Activity'
        statistics = self._loop.statistics()
        if statistics is None:
            return self._status(name, 'The control loop does not run in real time', {})
        clock = self._loop.clock
        factor = statistics.pace * clock.real_time_factor
        values = {
            'real_time_factor': f'{0.0 if clock.paused else factor:.4f}',
            'lateness_p50_us': f'{statistics.p50_ns / 1e3:.1f}',
            'lateness_p99_us': f'{statistics.p99_ns / 1e3:.1f}',
            'lateness_max_us': f'{statistics.max_ns / 1e3:.1f}',
            'overruns': str(statistics.overruns),
            'dropped_s': f'{statistics.dropped_ns / 1e9:.6f}',
            'priority': 'SCHED_FIFO' if self._loop.has_priority else 'normal',
            'paused': str(clock.paused).lower(),
        }
        slow = statistics.pace < SLOW_PACE
        text = 'The control loop is slower than asked for' if slow else (
            'The control loop keeps its rate'
        )
        return self._status(name, text, values, slow)

    def _status(
        self, task: str, text: str, values: Mapping[str, str], warn: bool = False
    ) -> DiagnosticStatus:
        return DiagnosticStatus(
            level=DiagnosticStatus.WARN if warn else DiagnosticStatus.OK,
            name=f'{self._name}: {task}',
            message=text,
            hardware_id=self._node.get_fully_qualified_name(),
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )
