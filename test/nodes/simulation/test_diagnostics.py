# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What /diagnostics reports of the loop, controllers and hardware."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
import pytest

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.control.mailbox import EventQueue
from armsim_ros.control.manager.controller_manager import any_arm
from armsim_ros.nodes.simulation.controllers.diagnostics import Diagnostics
from armsim_ros.sim.clock import SimClock
from armsim_ros.sim.pacer import PaceStatistics

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


class Stage:
    """Diagnostics of a loop, controllers and hardware that a test makes up."""

    def __init__(self) -> None:
        self.pace, self.dropped_ns = 1.0, 0
        self.controllers, self.hardware = {'arm': 'active'}, {'Arm': 'active'}
        self.parameters = ControllerManagerParameters(update_rate=100)
        self.arm = any_arm(EventQueue('arm'), lambda: None)
        self.sent: list[Any] = []
        self.lines: list[str] = []
        publisher = SimpleNamespace(
            get_subscription_count=lambda: 1, publish=self.sent.append)
        node: Any = SimpleNamespace(
            create_publisher=lambda *words: publisher,
            get_logger=lambda: SimpleNamespace(warning=self.lines.append))
        manager: Any = SimpleNamespace(
            list_controllers=lambda: self.states(self.controllers),
            list_hardware_components=lambda: self.states(self.hardware), arm=self.arm)
        loop: Any = SimpleNamespace(
            clock=SimClock(1_000_000), has_priority=False,
            statistics=lambda: PaceStatistics(1, 0, 0, 0, 0, self.dropped_ns, self.pace))
        self.diagnostics = Diagnostics(
            node, 'controller_manager', manager, loop, lambda: self.parameters, None, ())

    @staticmethod
    def states(given: dict[str, str]) -> list[Any]:
        """Return infos of these names and states."""
        return [SimpleNamespace(name=name, state=state) for name, state in given.items()]

    def published(self) -> dict[str, Any]:
        """Publish, and return task -> status."""
        self.diagnostics.publish()
        return {one.name.partition(': ')[2]: one for one in self.sent[-1].status}


@pytest.fixture
def stage() -> Stage:
    """Give made-up parts."""
    return Stage()


@pytest.mark.parametrize(('pace', 'level'), [
    (1.0, OK), (0.96, OK), (0.94, WARN), (1.06, WARN), (0.89, ERROR)])
def test_the_rate_of_the_loop_has_thresholds(stage: Stage, pace: float, level: bytes) -> None:
    """
    A mean error above 5 Hz is a warning, above 10 Hz an error; both are parameters.

    Upstream: controller_manager.cpp, controller_manager_diagnostic_callback.
    """
    stage.pace = pace
    status = stage.published()['Controller Manager Activity']
    assert status.level == level, status.message
    values = {one.key: one.value for one in status.values}
    assert float(values['periodicity.average']) == pytest.approx(100.0 * pace)
    stage.parameters = ControllerManagerParameters.model_validate({
        'update_rate': 100, 'diagnostics': {'threshold': {'controller_manager': {
            'periodicity': {'mean_error': {'warn': 50.0, 'error': 60.0}}}}}})
    assert stage.published()['Controller Manager Activity'].level == OK


def test_lost_time_is_a_warning_where_it_is_asked_for(stage: Stage) -> None:
    """
    Time that is given up is a warning with the rate, once; overruns.print_warnings ends that.

    Upstream: sleeping_policies.cpp, sleep_for_periodic_cycle.
    """
    stage.parameters = ControllerManagerParameters.model_validate({
        'update_rate': 100, 'overruns': {'print_warnings': True}})
    for stage.dropped_ns in (0, 30_000_000, 30_000_000):
        stage.published()
    (line,) = stage.lines
    assert 'missed its desired rate of 100 Hz: 30.0 ms' in line
    stage.parameters = ControllerManagerParameters.model_validate({
        'update_rate': 100, 'overruns': {'print_warnings': False}})
    stage.dropped_ns = 60_000_000
    stage.published()
    assert len(stage.lines) == 1


@pytest.mark.parametrize(('controllers', 'hardware', 'levels'), [
    ({'arm': 'active'}, {'A': 'active', 'B': 'active'}, (OK, OK)),
    ({'arm': 'inactive'}, {'A': 'active', 'B': 'inactive'}, (OK, OK)),
    ({}, {'A': 'active'}, (WARN, OK)),
    ({'arm': 'inactive'}, {'A': 'inactive'}, (ERROR, WARN)),
])
def test_levels_of_controllers_and_hardware(
    stage: Stage, controllers: dict[str, str], hardware: dict[str, str],
    levels: tuple[bytes, bytes],
) -> None:
    """
    No controllers are a warning; hardware warns where none is active, controllers are an error.

    Upstream: controller_manager.cpp, controller_activity_diagnostic_callback and
    hardware_components_diagnostic_callback.
    """
    stage.controllers, stage.hardware = controllers, hardware
    found = stage.published()
    assert found['Controllers Activity'].level == levels[0]
    assert found['Hardware Components Activity'].level == levels[1]


def test_the_names_of_values_are_those_of_upstream(stage: Stage) -> None:
    """
    The hardware is ros2_control, and states of controllers and components have a suffix.

    Upstream: controller_manager.cpp, init_controller_manager,
    controller_activity_diagnostic_callback and hardware_components_diagnostic_callback.
    """
    stage.controllers = {'arm': 'active', 'spare': 'inactive'}
    found = stage.published()
    assert {status.hardware_id for status in found.values()} == {'ros2_control'}
    assert {value.key: value.value for value in found['Controllers Activity'].values} == {
        'arm.state': 'active', 'spare.state': 'inactive'}
    assert {value.key: value.value for value in found['Hardware Components Activity'].values} == {
        'Arm.state': 'active'}


def test_a_stopped_arm_is_an_error_with_its_cause(stage: Stage) -> None:
    """The safety of the arm is reported, a stop as an error."""
    assert stage.published()['Arm Safety'].level == DiagnosticStatus.OK
    stage.arm.protective_stop()
    status = stage.published()['Arm Safety']
    assert (status.level, status.message) == (
        DiagnosticStatus.ERROR, 'protective stop: injected')
