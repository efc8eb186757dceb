# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topics ``/diagnostics`` and ``~/activity`` of the controller manager."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping

from controller_manager_msgs.msg import ControllerManagerActivity
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.control.faults import FaultInjector
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.control.manager.manager_info import ControllerInfo
from armsim_ros.control.manager.resources import HardwareComponentInfo
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.controller_manager import activity_message
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.sim.control_loop import ControlLoop

_OK, _WARN, _ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


class Diagnostics:
    """
    Publishes the health of controllers, hardware and loop, with the reference's names.

    :param name: precedes every status.
    :param parameters: the manager's, as they are now.
    :param faults: what makes joints fail on purpose, where that is possible.
    :param joints: those of the manager's robot.
    """

    def __init__(
        self, node: Node, name: str, manager: ControllerManager, loop: ControlLoop,
        parameters: Callable[[], ControllerManagerParameters], faults: FaultInjector | None,
        joints: Collection[str]
    ) -> None:
        self._faults, self._joints, self._name, self._node = faults, joints, name, node
        self._manager, self._loop, self._parameters = manager, loop, parameters
        self._dropped_ns = 0
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', qos.DIAGNOSTICS)

    def publish(self) -> None:
        """Publish the current state, if it has subscribers, and warn of lost time."""
        self._warn_of_overruns()
        if not self._publisher.get_subscription_count():
            return
        message = DiagnosticArray(status=[
            self._controllers(), self._hardware(), self._pace(), self._safety()])
        if self._faults is not None:
            message.status.append(self._injected(self._faults))
        fill_time(message.header.stamp, self._loop.clock.now_ns)
        self._publisher.publish(message)

    def _warn_of_overruns(self) -> None:
        statistics, parameters = self._loop.statistics(), self._parameters()
        if statistics is None:
            return
        lost_ns, self._dropped_ns = statistics.dropped_ns - self._dropped_ns, statistics.dropped_ns
        if lost_ns > 0 and parameters.overruns.print_warnings:
            self._node.get_logger().warning(
                'Overrun detected! The controller manager missed its desired rate of '
                f'{parameters.update_rate} Hz: {lost_ns * 1e-6:.1f} ms were given up')

    def _controllers(self) -> DiagnosticStatus:
        states = _states(self._manager.list_controllers())
        level, text = _OK, 'All controllers are active' if _all_active(states) else (
            'Not all controllers are active')
        if 'active' not in _states(self._manager.list_hardware_components()).values():
            level, text = _ERROR, (
                'No hardware components are currently active to activate controllers')
        elif not states:
            level, text = _WARN, 'No controllers are currently loaded'
        return self._status('Controllers Activity', text, states, level)

    def _hardware(self) -> DiagnosticStatus:
        states = _states(self._manager.list_hardware_components())
        level, text = _OK, 'All hardware components are active' if _all_active(states) else (
            'Not all hardware components are active')
        if 'active' not in states.values():
            level, text = _WARN, 'No hardware components are currently active'
        return self._status('Hardware Components Activity', text, states, level)

    def _safety(self) -> DiagnosticStatus:
        arm = self._manager.arm
        level = _ERROR if arm.stopped else _WARN if arm.obstacle else _OK
        cause = '' if arm.cause is None else str(arm.cause)
        return self._status('Arm Safety', arm.obstacle or 'The arm takes commands', {
            'mode': arm.mode.value, 'safety': arm.safety.value, 'program': arm.program.value,
            'cause': cause}, level)

    def _injected(self, faults: FaultInjector) -> DiagnosticStatus:
        active = {
            joint: str(fault) for joint, fault in faults.active.items() if joint in self._joints}
        text = f'Joints fail on purpose: {", ".join(active)}' if active else (
            'Joints can be made to fail, none does')
        return self._status('Fault Injection', text, active, _WARN if active else _OK)

    def _pace(self) -> DiagnosticStatus:
        name = 'Controller Manager Activity'
        statistics = self._loop.statistics()
        if statistics is None:
            return self._status(name, 'The control loop does not run in real time', {})
        clock = self._loop.clock
        factor = statistics.pace * clock.real_time_factor
        parameters = self._parameters()
        requested, bounds = parameters.update_rate, (
            parameters.diagnostics.threshold.controller_manager.periodicity.mean_error)
        mean = requested * statistics.pace
        values = {
            'update_rate': str(requested),
            'periodicity.average': f'{mean:.3f}',
            'real_time_factor': f'{0.0 if clock.paused else factor:.4f}',
            'lateness_p50_us': f'{statistics.p50_ns / 1e3:.1f}',
            'lateness_p99_us': f'{statistics.p99_ns / 1e3:.1f}',
            'lateness_max_us': f'{statistics.max_ns / 1e3:.1f}',
            'overruns': str(statistics.overruns),
            'dropped_s': f'{statistics.dropped_ns / 1e9:.6f}',
            'priority': 'SCHED_FIFO' if self._loop.has_priority else 'normal',
            'paused': str(clock.paused).lower(),
        }
        error = abs(mean - requested)
        level = _ERROR if error > bounds.error else _WARN if error > bounds.warn else _OK
        text = 'The control loop keeps its rate' if level == _OK else (
            f'Controller Manager has bad periodicity : {mean:.1f} Hz. '
            f'Expected consistent {requested} Hz')
        return self._status(name, text, values, level)

    def _status(
        self, task: str, text: str, values: Mapping[str, str], level: bytes = _OK
    ) -> DiagnosticStatus:
        return DiagnosticStatus(
            level=level, name=f'{self._name}: {task}', message=text,
            hardware_id='ros2_control',
            values=[KeyValue(key=key, value=value) for key, value in values.items()])


def _states(infos: Iterable[ControllerInfo | HardwareComponentInfo]) -> dict[str, str]:
    """Return the values that report states."""
    return {f'{info.name}.state': info.state for info in infos}


def _all_active(states: Mapping[str, str]) -> bool:
    return all(state == 'active' for state in states.values())


class Activity:
    """Publishes the states of controllers and hardware whenever any has changed."""

    def __init__(self, node: Node, manager: ControllerManager) -> None:
        self._manager = manager
        self._generation = -1
        self._publisher = node.create_publisher(
            ControllerManagerActivity, '~/activity', qos.LATCHED)

    def publish_if_changed(self, time_ns: int) -> None:
        """Publish the states if any of them has changed since the last call."""
        generation = self._manager.generation
        if generation == self._generation:
            return
        self._generation = generation
        self._publisher.publish(
            activity_message(
                time_ns, self._manager.list_controllers(),
                self._manager.list_hardware_components()))
