# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services of the controller manager, its parameters, and what it tells by itself."""

from __future__ import annotations

from collections.abc import Callable, Iterator
import re
from typing import Any

from builtin_interfaces.msg import Duration, Time
from controller_bench import Bench, BROADCASTER, TrajectoryController
from controller_manager_msgs.msg import ControllerManagerActivity
from controller_manager_msgs.srv import (
    ReloadControllerLibraries,
    SetHardwareComponentState,
    SwitchController,
)
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import State
import pytest
from rcl_interfaces.msg import ParameterEvent
from rosgraph_msgs.msg import Clock
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import SetSimulationState

from armsim_ros.clients.client_node import Collector, LATCHED
from armsim_ros.clients.controller_manager import BEST_EFFORT, ParameterClient, STRICT
from armsim_ros.clients.trajectory import SUCCEEDED

statement = pytest.mark.statement
upstream = pytest.mark.upstream
TRAJECTORY = 'joint_trajectory_controller/JointTrajectoryController'
SERVICES = {
    'list_controllers': 'ListControllers',
    'list_controller_types': 'ListControllerTypes',
    'load_controller': 'LoadController',
    'configure_controller': 'ConfigureController',
    'switch_controller': 'SwitchController',
    'cleanup_controller': 'CleanupController',
    'unload_controller': 'UnloadController',
    'list_hardware_components': 'ListHardwareComponents',
    'list_hardware_interfaces': 'ListHardwareInterfaces',
    'set_hardware_component_state': 'SetHardwareComponentState',
    'reload_controller_libraries': 'ReloadControllerLibraries',
}


@pytest.fixture
def paused(bench: Bench, arm: TrajectoryController) -> Iterator[None]:
    """Pause the physics for the time of a test, where the server can."""
    services = dict(bench.client.node.get_service_names_and_types())
    if '/set_simulation_state' not in services:
        pytest.skip('the server cannot be paused by simulation_interfaces')

    def become(state: int) -> None:
        request = SetSimulationState.Request(state=SimulationState(state=state))
        bench.client.call('/set_simulation_state', SetSimulationState, request)

    become(SimulationState.STATE_PAUSED)
    yield
    become(SimulationState.STATE_PLAYING)


@statement('P1', 'P12', 'P14')
def test_names_and_types_of_the_services(bench: Bench) -> None:
    """Every service of Jazzy that `ros2 control` uses is there, with its type."""
    bench.manager.states()
    services = dict(bench.client.node.get_service_names_and_types())
    for name, kind in SERVICES.items():
        found = services[bench.name(f'controller_manager/{name}')]
        assert found == [f'controller_manager_msgs/srv/{kind}']


@statement('P1', 'P6', 'P12')
@upstream('list_controllers_srv', 'check_interface_names')
def test_list_controllers_tells_claims(bench: Bench, arm: TrajectoryController) -> None:
    """State, type, claims of an active controller; no claims after it was deactivated."""
    commands = ['axis_1/position', 'axis_2/position']
    active = bench.manager.controllers()['arm']
    assert (active.state, active.type) == ('active', TRAJECTORY)
    assert active.update_rate == 100
    assert not active.is_async
    assert sorted(active.claimed_interfaces) == commands
    assert sorted(active.required_command_interfaces) == commands
    assert 'axis_1/velocity' in active.required_state_interfaces
    bench.activate()
    inactive = bench.manager.controllers()['arm']
    assert inactive.state == 'inactive'
    assert list(inactive.claimed_interfaces) == []
    assert sorted(inactive.required_command_interfaces) == commands


@statement('P1', 'C8')
@upstream('list_controller_types')
def test_list_controller_types(bench: Bench) -> None:
    """Types and their base classes."""
    response = bench.manager.controller_types()
    bases = dict(zip(response.types, response.base_classes, strict=True))
    plain = 'controller_interface::ControllerInterface'
    assert bases[TRAJECTORY] == bases['joint_state_broadcaster/JointStateBroadcaster'] == plain
    for kind in ('pid_controller/PidController', 'admittance_controller/AdmittanceController',
                 'force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster'):
        assert bases[kind] == 'controller_interface::ChainableControllerInterface'


@statement('P1')
@upstream('list_hardware_components', 'list_hardware_interfaces_srv')
def test_list_hardware(bench: Bench, arm: TrajectoryController) -> None:
    """Components are active; interfaces are named joint/interface, claimed ones marked."""
    (component,) = bench.manager.hardware_components().component
    assert component.state.label == 'active'
    assert component.type == 'system'
    commands = ['axis_1/position', 'axis_2/position']
    assert [one.name for one in component.command_interfaces if one.is_claimed] == commands
    interfaces = bench.manager.hardware_interfaces()
    claimed = {i.name for i in interfaces.command_interfaces if i.is_claimed}
    assert claimed == {'axis_1/position', 'axis_2/position'}
    assert all(i.is_available for i in interfaces.command_interfaces)
    assert 'twin/position' in {i.name for i in interfaces.state_interfaces}
    assert 'twin/position' not in {i.name for i in interfaces.command_interfaces}


@statement('P1')
@upstream('load_controller_srv', 'unload_controller_srv', 'configure_controller_srv',
          'cleanup_controller_srv')
def test_what_the_services_refuse(bench: Bench, arm: TrajectoryController) -> None:
    """Unknown, loaded already, active: ok is false, and nothing changes."""
    manager = bench.manager
    before = manager.states()
    assert not manager.load('nobody')
    assert not manager.load('arm')
    assert not manager.configure('nobody')
    assert not manager.configure('arm')
    assert not manager.unload('nobody')
    assert not manager.unload('arm')
    assert not manager.cleanup('arm')
    assert manager.states() == before


@statement('P1', 'B22')
@pytest.mark.parametrize('kind', ['', 'nobody/Knows'])
def test_a_controller_needs_a_known_type(
    bench: Bench, load: Callable[..., bool], kind: str
) -> None:
    """Without a type, or with an unknown one, it is not loaded."""
    if kind:
        assert not load('typeless', kind)
    else:
        assert not bench.manager.load('typeless')


@statement('C11')
def test_ros_arguments_that_cannot_be_read(bench: Bench, load: Callable[..., bool]) -> None:
    """A controller whose node_options_args are wrong is not loaded; the server serves on."""
    parameters = ParameterClient(bench.client, bench.name('controller_manager'))
    assert parameters.set('misled.node_options_args', ['-r', 'nothing']) == ''
    assert not load('misled')
    assert 'misled' not in bench.manager.states()
    assert parameters.set('misled.node_options_args', ['-r', '~/elsewhere:=/elsewhere']) == ''
    assert load('misled')


@statement('P1')
@upstream('reload_controller_libraries_srv')
def test_reload_refuses_while_controllers_are_active(
    bench: Bench, arm: TrajectoryController
) -> None:
    """Without force_kill active controllers are left alone."""
    service = bench.name('controller_manager/reload_controller_libraries')
    assert not bench.client.call(service, ReloadControllerLibraries).ok
    assert bench.manager.states()['arm'] == 'active'


@statement('P3')
@upstream('switch_controller_failure_behaviour_on_unknown_controller')
@pytest.mark.parametrize('list_name', ['activate', 'deactivate'])
def test_strict_switches_all_or_nothing(
    bench: Bench, arm: TrajectoryController, list_name: str
) -> None:
    """STRICT with an unknown name: nothing is switched, and the message names it."""
    lists: dict[str, list[str]] = {'activate': [], 'deactivate': ['arm']}
    lists[list_name] = [*lists[list_name], 'nobody']
    response = bench.manager.switch(strictness=STRICT, **lists)
    assert not response.ok
    assert 'nobody' in response.message
    assert bench.manager.states()['arm'] == 'active'


@statement('P3')
@upstream('switch_controller_failure_behaviour_on_unknown_controller')
@pytest.mark.parametrize('strictness', [0, BEST_EFFORT, 3, 4])
def test_best_effort_does_what_it_can(
    bench: Bench, arm: TrajectoryController, strictness: int
) -> None:
    """Bad entries are dropped; 0, AUTO and FORCE_AUTO are best effort too."""
    response = bench.manager.switch(deactivate=['arm', 'nobody'], strictness=strictness)
    assert response.ok
    assert bench.manager.states()['arm'] == 'inactive'
    assert bench.manager.switch(activate=[], deactivate=[], strictness=strictness).ok


@statement('P3')
def test_strict_refuses_what_is_active_already(bench: Bench, arm: TrajectoryController) -> None:
    """To activate an active controller strictly is a mistake."""
    assert not bench.manager.switch(activate=['arm']).ok


@statement('P4')
@upstream('two_controllers_using_same_interface')
def test_a_claimed_interface_is_not_given_twice(bench: Bench, arm: TrajectoryController) -> None:
    """Another controller of the same joints is refused, and the message names what is taken."""
    response = bench.manager.switch(activate=['sampled'])
    assert not response.ok
    assert 'axis_1/position' in response.message
    assert bench.manager.states()['arm'] == 'active'
    both = bench.manager.switch(activate=['sampled', 'partial'], deactivate=['arm'])
    assert not both.ok
    assert bench.manager.states()['arm'] == 'active'


@statement('P4')
def test_a_swap_is_atomic(bench: Bench, arm: TrajectoryController) -> None:
    """One call swaps two controllers of the same joints, without a motion."""
    arm.go([0.2, 0.1])
    assert bench.manager.switch(activate=['sampled'], deactivate=['arm']).ok
    states = bench.manager.states()
    assert (states['arm'], states['sampled']) == ('inactive', 'active')
    state = bench.use('sampled', home=False).newest()
    assert list(state.reference.positions) == [0.2, 0.1]


@statement('P5')
@upstream('list_controllers_srv')
def test_a_switch_that_takes_too_long(bench: Bench, arm: TrajectoryController) -> None:
    """A timeout of 1 ns: either it says no, or the switch is done when it says yes."""
    service = bench.name('controller_manager/switch_controller')
    request = SwitchController.Request(
        deactivate_controllers=['arm'], strictness=STRICT, timeout=Duration(nanosec=1)
    )
    response = bench.client.call(service, SwitchController, request)
    if response.ok:
        assert bench.manager.states()['arm'] == 'inactive'
    else:
        assert response.message


@statement('P5')
@pytest.mark.usefixtures('paused')
def test_paused_it_serves_on(bench: Bench, arm: TrajectoryController) -> None:
    """While the physics stands still switches, goals, cancels and loading are answered."""
    assert bench.manager.switch(deactivate=['arm']).ok
    assert bench.manager.switch(activate=['arm']).ok
    assert bench.manager.cleanup('half_speed')
    assert bench.manager.configure('half_speed')
    goal = arm.goal(arm.to([1.0, 1.0], 1.0))
    assert goal.accepted()
    assert goal.cancel()
    assert goal.result().error_code == 0


@statement('P7', 'C10')
@pytest.mark.parametrize(
    ('name', 'value'),
    [('update_rate', 100), ('enforce_command_limits', False), ('arm.type', TRAJECTORY),
     ('defaults.switch_controller.strictness', 'best_effort'),
     ('defaults.allow_controller_activation_with_inactive_hardware', False),
     ('defaults.deactivate_controllers_on_hardware_self_deactivate', True),
     ('hardware_components_initial_state.inactive', []),
     ('hardware_components_initial_state.shutdown_on_initial_state_failure', True)],
)
def test_parameters_of_the_manager(bench: Bench, name: str, value: Any) -> None:
    """The manager's parameters have their values."""
    parameters = ParameterClient(bench.client, bench.name('controller_manager'))
    found = parameters.get(name)
    assert (list(found) if isinstance(value, list) else found) == value


@statement('P8', 'O8', 'A6')
def test_nodes_live_in_the_managers_namespace(bench: Bench, arm: TrajectoryController) -> None:
    """Each controller is a node of its name in the manager's namespace, with use_sim_time."""
    arm.wait_for_server()
    found = {f'{ns}/{name}' for name, ns in bench.client.node.get_node_names_and_namespaces()}
    assert {bench.name(one) for one in ('controller_manager', 'arm', BROADCASTER)} <= found
    for name in ('controller_manager', 'arm', BROADCASTER):
        assert ParameterClient(bench.client, bench.name(name)).get('use_sim_time') is True


def standing_time(clock: Collector) -> Time:
    """Return the time of a paused simulation; what came from before may differ."""
    first, second = clock.wait(2)[-2:]
    while first != second:
        clock.clear()
        first, second = clock.wait(2)[-2:]
    return second.clock


@statement('P8', 'O8')
def test_nodes_take_the_simulations_time(bench: Bench, arm: TrajectoryController) -> None:
    """While the simulation is paused time stands in the nodes of the controllers, too."""
    clock = bench.client.collect('/clock', Clock)
    events = bench.client.collect('/parameter_events', ParameterEvent)
    pause, play = (
        SetSimulationState.Request(state=SimulationState(state=state))
        for state in (SimulationState.STATE_PAUSED, SimulationState.STATE_PLAYING)
    )
    assert bench.client.call('/set_simulation_state', SetSimulationState, pause).result.result == 1
    try:
        now = standing_time(clock)
        for value in (1.0, 0.0):
            assert not arm.parameters.set('constraints.goal_time', value)
        stamps = [event.stamp for event in events.wait(2) if event.node == arm.controller]
    finally:
        bench.client.call('/set_simulation_state', SetSimulationState, play)
    assert stamps == [now, now]
    clock.close()
    events.close()


@statement('P9')
def test_activity_at_every_change(bench: Bench, arm: TrajectoryController) -> None:
    """~/activity tells the states of controllers and hardware, latched."""
    topic = bench.name('controller_manager/activity')
    activity = bench.client.collect(topic, ControllerManagerActivity, LATCHED)

    def tells(state: str) -> Callable[[ControllerManagerActivity], bool]:
        return lambda m: {c.name: c.state.label for c in m.controllers}.get('arm') == state

    message = activity.wait_for(tells('active'))
    assert [one.state.label for one in message.hardware_components] == ['active']
    bench.activate()
    activity.wait_for(tells('inactive'))
    activity.close()


@statement('P1')
@upstream('selective_activate_deactivate_components_set_state')
def test_hardware_states(bench: Bench) -> None:
    """
    An unknown component is refused; the robot's can rest and work again, steps between.

    A state is given by its label, or by its number, which counts before the label.
    """
    service = bench.name('controller_manager/set_hardware_component_state')

    def become(name: str, label: str, number: int = State.PRIMARY_STATE_UNKNOWN) -> Any:
        request = SetHardwareComponentState.Request(
            name=name, target_state=State(id=number, label=label))
        return bench.client.call(service, SetHardwareComponentState, request)

    bench.activate()
    (component,) = bench.manager.hardware_components().component
    assert not become('nobody', 'inactive').ok
    try:
        down = become(component.name, 'unconfigured')
        assert down.ok
        assert down.state.label == 'unconfigured'
        assert not bench.manager.switch(activate=['arm']).ok
    finally:
        up = become(component.name, 'inactive', State.PRIMARY_STATE_ACTIVE)
    assert up.ok
    assert up.state.label == 'active'
    c = bench.use('arm')
    assert c.run(c.to([0.1, 0.1], 0.1)).status == SUCCEEDED


@statement('P9')
def test_diagnostics_have_the_names_of_the_reference(bench: Bench) -> None:
    """Controllers, hardware, and the loop with overruns and real-time factor."""
    topic = bench.client.collect('/diagnostics', DiagnosticArray)
    message = topic.wait(1)[0]
    topic.close()
    statuses = {re.sub(r'^.*: ', '', status.name): status for status in message.status}
    assert {
        'Controllers Activity', 'Hardware Components Activity', 'Controller Manager Activity'
    } <= set(statuses)
    states = {v.key: v.value for v in statuses['Controllers Activity'].values}
    assert states[f'{BROADCASTER}.state'] == 'active'
    loop = {v.key for v in statuses['Controller Manager Activity'].values}
    assert {'overruns', 'real_time_factor'} <= loop


@statement('P2', 'P13')
def test_a_controller_of_ros_1_is_found_under_its_ros_2_type(
    bench: Bench, load: Callable[..., bool]
) -> None:
    """position_controllers/JointTrajectoryController is loaded as what ROS 2 calls it."""
    assert load(
        'of_old', 'position_controllers/JointTrajectoryController',
        command_interfaces=None, state_interfaces=None,
    )
    assert bench.manager.controllers()['of_old'].type == TRAJECTORY
    assert bench.manager.configure('of_old')
    commands = bench.manager.controllers()['of_old'].required_command_interfaces
    assert sorted(commands) == ['axis_1/position', 'axis_2/position']
