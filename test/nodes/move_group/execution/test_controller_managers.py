# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where move_group knows its controllers from."""

from types import SimpleNamespace

from controller_manager_msgs.msg import ControllerState
from controller_manager_msgs.srv import ListControllers, SwitchController
import pytest
from rclpy.task import Future

from armsim_ros.config.trajectory_execution import TrajectoryExecutionSettings
from armsim_ros.errors import PlanningError
from armsim_ros.nodes.move_group.execution import controller_managers
from armsim_ros.nodes.move_group.execution.controller_managers import controller_manager

INTERFACE = 'moveit_ros_control_interface/'
TRAJECTORY = 'joint_trajectory_controller/JointTrajectoryController'


class Pulse:
    """What a coroutine awaits; meanwhile a second passes."""

    def __init__(self, context):
        self.context = context

    def __await__(self):
        self.context.time += 1.0
        yield


class Manager:
    """Services of a controller_manager with a trajectory controller and a forward controller."""

    def __init__(self):
        self.running, self.asked, self.requests, self.well = 'slider', 0, [], True

    def list_controllers(self, request):
        self.asked += 1
        both = [ControllerState(
            name=name, type=kind, state='active' if name == self.running else 'inactive',
            required_command_interfaces=['a/position'],
            claimed_interfaces=['a/position'] if name == self.running else [])
            for name, kind in (('arm', TRAJECTORY), ('slider', 'some/Forward'))]
        return ListControllers.Response(controller=both)

    def switch_controller(self, request):
        self.requests.append(request)
        if self.well:
            self.running = request.activate_controllers[0]
        return SwitchController.Response(ok=self.well, message='' if self.well else 'jammed')


@pytest.fixture
def managers():
    """Return the namespaces in which controller_managers run."""
    return {'': Manager(), '/left': Manager()}


@pytest.fixture
def manager_of(managers, monkeypatch):
    """Return a function that makes what knows the controllers."""
    monkeypatch.setattr(
        controller_managers, 'ControllerHandle',
        lambda node, settings, wake: SimpleNamespace(settings=settings))

    def create_client(kind, name, callback_group):
        namespace, _, service = name.rpartition('/controller_manager/')

        def call_async(request):
            future = Future()
            future.set_result(getattr(managers[namespace], service)(request))
            return future

        return SimpleNamespace(service_is_ready=lambda: namespace in managers,
                               call_async=call_async)

    def make(name, **options):
        lines = []
        log = SimpleNamespace(info=lines.append, warning=lines.append)
        context = SimpleNamespace(time=0.0, ending='', logger=log, group=None, lines=lines)
        context.clock = lambda: context.time
        context.ticker = SimpleNamespace(next=lambda: Pulse(context), wake=None)
        context.settings = SimpleNamespace(moveit_controllers=())
        context.execution_settings = TrajectoryExecutionSettings(
            moveit_controller_manager=name, **options)
        context.node = SimpleNamespace(
            create_client=create_client, get_service_names_and_types=lambda: [
                (f'{namespace}/controller_manager/list_controllers', [])
                for namespace in managers])
        return context, controller_manager(context)

    return make


def run(coroutine):
    """Run a coroutine to its end."""
    try:
        while True:
            coroutine.send(None)
    except StopIteration:
        pass


@pytest.mark.parametrize(('name', 'expected'), [
    ('Ros2ControlManager', {'/arm'}), ('MoveItControllerManager', {'/arm'}),
    ('Ros2ControlMultiManager', {'/arm', '/left/arm'}),
    ('MoveItMultiControllerManager', {'/arm', '/left/arm'}),
])
def test_managers_that_are_asked(manager_of, name, expected):
    """
    All loaded controllers of known types are known, inactive ones too; old names are deprecated.

    Upstream: controller_manager_plugin.cpp, discover; trajectory_execution_manager.cpp,
    initialize.
    """
    context, manager = manager_of(f'{INTERFACE}{name}')
    run(manager.refresh())
    assert {one.name for one in manager.controllers} == expected
    assert manager.active >= {'/slider'}
    assert any('deprecated' in line for line in context.lines) is ('Ros2' not in name)


def test_the_namespace_of_the_manager(manager_of):
    """
    Parameter ros_control_namespace says which manager is asked.

    Upstream: controller_manager_plugin.cpp, initialize.
    """
    _, manager = manager_of(f'{INTERFACE}Ros2ControlManager', ros_control_namespace='left')
    run(manager.refresh())
    assert [one.action_name for one in manager.controllers] == [
        '/left/arm/follow_joint_trajectory']


def test_the_list_is_read_once_a_second(manager_of, managers):
    """
    What was read is used for a second.

    Upstream: controller_manager_plugin.cpp, discover.
    """
    context, manager = manager_of(f'{INTERFACE}Ros2ControlManager')
    for time, asked in ((0.0, 1), (0.9, 1), (1.1, 2)):
        context.time = time
        run(manager.refresh())
        assert managers[''].asked == asked


def test_a_manager_that_does_not_answer(manager_of):
    """
    After controller_service_call_timeout there is a warning, and no controller is known.

    Upstream: controller_manager_plugin.cpp, discover.
    """
    context, manager = manager_of(f'{INTERFACE}Ros2ControlManager',
                                  ros_control_namespace='/absent',
                                  controller_service_call_timeout=5.0)
    run(manager.refresh())
    assert (manager.controllers, context.time) == ((), 6.0)
    assert '/absent/controller_manager/list_controllers' in context.lines[0]


def test_one_strict_switch(manager_of, managers):
    """
    An inactive controller is activated in the switch that deactivates what holds its joints.

    Upstream: controller_manager_plugin.cpp, switchControllers.
    """
    _, manager = manager_of(f'{INTERFACE}Ros2ControlManager')
    run(manager.refresh())
    run(manager.switch(['/arm'], []))
    (request,) = managers[''].requests
    assert (request.activate_controllers, request.deactivate_controllers) == (['arm'], ['slider'])
    assert request.strictness == SwitchController.Request.STRICT
    assert manager.active == {'/arm'}
    managers[''].well, managers[''].running = False, 'slider'
    with pytest.raises(PlanningError, match='jammed'):
        run(manager.switch(['/arm'], []))
