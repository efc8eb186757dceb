# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One hardware for several robots: windows into its arrays, claims kept apart."""

import numpy as np
import pytest

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.config.simulation import JointFault
from armsim_ros.control.controllers import ManagerGroup
from armsim_ros.control.faults import FaultInjector
from armsim_ros.control.hardware_interface import SharedHardware
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.errors import SimulationError

POSITION = frozenset({'position'})
TRAJECTORY = 'joint_trajectory_controller/JointTrajectoryController'


@pytest.fixture
def whole(hardware_class):
    """Return the hardware of two robots with two joints each."""
    return hardware_class(('l1', 'l2', 'r1', 'r2'))


def test_a_part_is_a_window(whole):
    """What is written in one is read in the other; nothing is copied."""
    part = SharedHardware(whole).part(('r1', 'r2'))
    part.command.position[:] = [0.3, 0.4]
    whole.state.velocity[:] = [1.0, 2.0, 3.0, 4.0]
    np.testing.assert_array_equal(whole.command.position, [np.nan, np.nan, 0.3, 0.4])
    np.testing.assert_array_equal(part.state.velocity, [3.0, 4.0])
    assert np.shares_memory(part.feedforward.velocity, whole.feedforward.velocity)


def test_a_part_has_the_interfaces_of_its_joints(whole):
    """And none of the others."""
    part = SharedHardware(whole).part(('l1', 'l2'))
    assert set(part.command_interfaces) == set(part.state_interfaces) == {'l1', 'l2'}
    assert part.index == {'l1': 0, 'l2': 1}


def test_a_part_hides_what_others_own(whole):
    """Sensors and gpios of other robots are no states of this one."""
    whole.given_states.update({'l_wrist/force.x': 1.0, 'r_wrist/force.x': 2.0, 'sun/light': 3.0})
    part = SharedHardware(whole).part(('l1', 'l2'), {'r_wrist'})
    assert dict(part.other_states) == {'l_wrist/force.x': 1.0, 'sun/light': 3.0}


def test_a_part_knows_its_sensors_links(hardware_class):
    """Those that nobody else owns, with the links on which they sit."""
    class Measuring(hardware_class):
        sensor_links = {'l_wrist': 'l_tool', 'r_wrist': 'r_tool', 'scale': 'table'}  # noqa: RUF012

    whole = Measuring(('l1', 'r1'))
    part = SharedHardware(whole).part(('l1',), {'r_wrist'})
    assert part.sensor_links == {'l_wrist': 'l_tool', 'scale': 'table'}


def test_what_a_controller_sets_is_its_robots(whole):
    """The pace that slows one robot's trajectories is none of the other's."""
    shared = SharedHardware(FaultInjector(whole))
    left, right = shared.part(('l1', 'l2')), shared.part(('r1', 'r2'))
    left.given_states['speed_scaling/speed_scaling_factor'] = 0.0
    right.given_states['speed_scaling/speed_scaling_factor'] = 1.0
    assert left.other_states == {'speed_scaling/speed_scaling_factor': 0.0}
    assert right.other_states == {'speed_scaling/speed_scaling_factor': 1.0}
    assert whole.given_states_of_parts == [left.given_states, right.given_states]


def test_gpios_of_another_robot_cannot_be_commanded(whole):
    """A robot's own can, and those that belong to nobody."""
    whole.other_commands.update({'l_lamp/on': 0.0, 'r_lamp/on': 0.0, 'sun/on': 0.0})
    part = SharedHardware(whole).part(('l1', 'l2'), {'r_lamp'})
    assert part.commands_of('l_lamp') == part.commands_of('sun') == ('on',)
    assert part.commands_of('r_lamp') == ()


def test_claims_of_the_others_stay(whole):
    """Each part says only what it claims itself; the hardware hears of all."""
    shared = SharedHardware(whole)
    left, right = shared.part(('l1', 'l2')), shared.part(('r1', 'r2'))
    left.perform_command_mode_switch({'l1': POSITION, 'l2': POSITION})
    right.perform_command_mode_switch({'r1': POSITION})
    assert whole.claimed == {'l1': POSITION, 'l2': POSITION, 'r1': POSITION}
    left.perform_command_mode_switch({'l2': POSITION})
    assert whole.claimed == {'l2': POSITION, 'r1': POSITION}


def test_a_refused_claim_changes_nothing(whole):
    """The next change of another robot does not bring it back."""
    shared = SharedHardware(whole)
    left, right = shared.part(('l1', 'l2')), shared.part(('r1', 'r2'))
    whole.refuse = 'no'
    with pytest.raises(SimulationError):
        left.perform_command_mode_switch({'l1': POSITION})
    whole.refuse = ''
    right.perform_command_mode_switch({'r1': POSITION})
    assert whole.claimed == {'r1': POSITION}


def test_joints_that_lie_apart_are_refused(whole):
    """A window needs joints that follow each other."""
    with pytest.raises(SimulationError, match='l1, r1 do not follow each other'):
        SharedHardware(whole).part(('l1', 'r1'))


def test_a_robot_without_movable_joints_has_an_empty_part(whole):
    """A camera on a stand may be in a cell too."""
    part = SharedHardware(whole).part(())
    assert len(part.state.position) == 0


def test_joints_of_a_part_can_fail(whole):
    """The faults lie between the parts and the hardware."""
    faults = FaultInjector(whole)
    part = SharedHardware(faults).part(('r1', 'r2'))
    part.command.position[:] = [1.0, 1.0]
    faults.set_fault('r1', JointFault(bias=0.5))
    faults.write(0.01)
    np.testing.assert_array_equal(whole.command.position, [np.nan, np.nan, 1.5, 1.0])


@pytest.fixture
def arms(whole):
    """Return the managers and trajectory controllers of both robots, active."""
    shared = SharedHardware(whole)
    made = []
    for joints, goal in ((('l1', 'l2'), 0.1), (('r1', 'r2'), -0.2)):
        part = shared.part(joints)
        manager = ControllerManager(part, ControllerManagerParameters(update_rate=100))
        controller = manager.load(Loadable('arm', joints))
        manager.configure('arm')
        assert manager.switch(activate=['arm']).ok
        part.command.position[:] = goal
        made.append((manager, controller))
    return made


def test_managers_run_side_by_side(whole, arms):
    """Controllers of the same name on two robots: each moves its own joints."""
    group = ManagerGroup([manager for manager, _ in arms])
    group.update(10_000_000, 0.01)
    group.process_requests(20_000_000)
    assert [controller.active for _, controller in arms] == [True, True]
    assert set(whole.claimed) == {'l1', 'l2', 'r1', 'r2'}
    assert all(manager.time_ns == 20_000_000 for manager, _ in arms)


def test_an_interruption_ends_the_goals_of_all_robots(whole, arms, trajectory):
    """Goals are aborted with the reason; the controllers hold the joints where they are then."""
    group = ManagerGroup([manager for manager, _ in arms])
    group.update(10_000_000, 0.01)
    goals = [controller.send_goal(trajectory((1.0, [0.1, 0.2]), joints=controller.joints)).goal
             for _, controller in arms]
    group.update(20_000_000, 0.01)
    assert {goal.status.name for goal in goals} == {'EXECUTING'}
    group.interrupt(30_000_000, 'the world starts again')
    whole.state.position[:] = (0.5, 0.6, 0.7, 0.8)
    group.resume(30_000_000)
    group.update(30_000_000, 0.01)
    assert {goal.status.name for goal in goals} == {'ABORTED'}
    assert all('the world starts again' in goal.result.message for goal in goals)
    np.testing.assert_array_equal(whole.command.position, (0.5, 0.6, 0.7, 0.8))


class Loadable:
    """A trajectory controller as a manager wants it."""

    def __init__(self, name, joints):
        self.name, self.type, self.parameters = name, TRAJECTORY, {'joints': list(joints)}
