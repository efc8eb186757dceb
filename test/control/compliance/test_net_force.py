# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controllers of FZI's cartesian_controllers, with the gains of their examples."""

from types import SimpleNamespace

import numpy as np
import pytest

from armsim_ros.errors import ControllerError
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.model.transforms import quat_xyzw_from_matrix, rotation_angle
from armsim_ros.stack import ArmSim

MOTION = 'cartesian_motion_controller/CartesianMotionController'
FORCE = 'cartesian_force_controller/CartesianForceController'
COMPLIANCE = 'cartesian_compliance_controller/CartesianComplianceController'
AXES = ('trans_x', 'trans_y', 'trans_z', 'rot_x', 'rot_y', 'rot_z')
COMMON = {'robot_base_link': 'panda_link0', 'end_effector_link': 'panda_hand_tcp',
          'joints': [f'panda_joint{number}' for number in range(1, 8)],
          'command_interfaces': ['position'], 'update_rate': 100}
SENSOR = {'ft_sensor_ref_link': 'panda_hand'}
YIELDING = {**SENSOR, 'compliance_ref_link': 'panda_hand_tcp',
            'stiffness': {**dict.fromkeys(AXES[:3], 500.0), **dict.fromkeys(AXES[3:], 20.0)}}


def gains(linear, angular, damping=0.0):
    """Return pd_gains with the same numbers for all axes of a kind."""
    rows = zip(AXES, [linear] * 3 + [angular] * 3, [damping] * 3 + [0.0] * 3, strict=True)
    return {axis: {'p': p, 'd': d} for axis, p, d in rows}


class Moved:
    """The arm with one of the controllers active."""

    def __init__(self, cell, kind, **parameters):
        self.sim = ArmSim(cell)
        self.manager = self.sim.managers['panda']
        self.controller = self.manager.load(SimpleNamespace(
            name='tool', type=kind, parameters={**COMMON, **parameters}))
        self.manager.configure('tool')
        result = self.manager.switch(activate=['tool'], deactivate=['panda_arm_controller'])
        assert result.ok, result.message

    @property
    def tip(self):
        return self.sim.simulation.link_pose('panda_hand_tcp')

    def aim(self, place, frame='panda_link0'):
        return self.controller.receive_pose(
            frame, place, quat_xyzw_from_matrix(self.tip[:3, :3]))

    def run(self, seconds):
        self.sim.step(round(seconds * 500))

    @property
    def warnings(self):
        return [event.text for event in self.manager.poll_events()
                if event.source == 'tool' and event.level == 'warning']


@pytest.fixture
def moved(panda):
    """Return a function that makes the arm with a controller of a type active."""
    return lambda kind, **parameters: Moved(panda, kind, **parameters)


@pytest.mark.parametrize(('interface', 'gain', 'iterations'), [
    ('position', 1.0, 10),
    # A velocity is that of the internal model, ten times slower than ten of its steps.
    ('velocity', 20.0, 1)])
def test_a_target_is_reached(moved, interface, gain, iterations):
    """A tenth of a metre away: within 2 mm in three seconds, and without turning."""
    arm = moved(MOTION, command_interfaces=[interface], pd_gains=gains(gain, 0.5 * gain),
                solver={'iterations': iterations})
    start, goal = arm.tip, arm.tip[:3, 3] + np.array((0.0, 0.1, 0.0))
    assert arm.aim(goal) == ''
    arm.run(3.0)
    assert np.linalg.norm(arm.tip[:3, 3] - goal) < 0.002
    assert rotation_angle(start[:3, :3], arm.tip[:3, :3]) < 0.02


@pytest.mark.parametrize(('solver', 'gain'), [
    ('jacobian_transpose', 300.0), ('damped_least_squares', 2.0),
    ('selectively_damped_least_squares', 1.0)])
def test_the_other_solvers_reach_it_too(moved, solver, gain):
    """With gains of their own."""
    arm = moved(MOTION, ik_solver=solver, pd_gains=gains(gain, gain), solver={'iterations': 10})
    goal = arm.tip[:3, 3] + np.array((0.03, 0.03, -0.03))
    arm.aim(goal)
    arm.run(4.0)
    assert np.linalg.norm(arm.tip[:3, 3] - goal) < 0.005


@pytest.mark.parametrize(('kind', 'parameters'), [(FORCE, SENSOR), (COMPLIANCE, YIELDING)])
def test_without_contact_it_does_not_drift(moved, kind, parameters):
    """No more than a millimetre in ten seconds."""
    arm = moved(kind, pd_gains=gains(0.05, 1.5), solver={'error_scale': 0.5}, **parameters)
    start = arm.tip[:3, 3].copy()
    arm.run(10.0)
    assert np.linalg.norm(arm.tip[:3, 3] - start) < 0.001


@pytest.fixture
def sensing():
    """Return the arm with a sensor in its wrist and one of the controllers active."""
    cell = load_cell('panda', overrides={
        'simulation.sensors.wrist': {'type': 'force_torque', 'link': 'panda_hand'}})
    return lambda kind, **parameters: Moved(cell, kind, **parameters)


@pytest.mark.parametrize(('kind', 'parameters'), [(FORCE, SENSOR), (COMPLIANCE, YIELDING)])
def test_the_weight_of_the_hand_moves_nothing(sensing, kind, parameters):
    """The robot's own sensor is read where nothing is published; no millimetre in ten seconds."""
    arm = sensing(kind, pd_gains=gains(0.05, 1.5), solver={'error_scale': 0.5}, **parameters)
    arm.run(1.0)  # the sensor measures inertia, too, until the arm is at rest
    start = arm.tip[:3, 3].copy()
    arm.run(10.0)
    assert np.linalg.norm(arm.tip[:3, 3] - start) < 0.001


def test_the_sensor_of_the_robot_is_read_until_a_message_comes(sensing):
    """
    Ten newtons on 500 N/m: 20 mm beyond where the push itself moves the arm.

    The model begins where the joints are, so that the arm creeps under a push in any case.
    """
    ways = []
    for message in (None, np.zeros(6)):
        arm = sensing(COMPLIANCE, pd_gains=gains(0.05, 1.5, 0.005), solver={'error_scale': 0.5},
                      **YIELDING)
        arm.run(1.0)
        if message is not None:
            arm.controller.receive_measured(message)
        start = arm.tip[:3, 3].copy()
        arm.sim.simulation.apply_wrench('panda_hand', force=(0.0, 10.0, 0.0))
        arm.run(4.0)
        ways.append(arm.tip[1, 3] - start[1])
    assert ways[0] - ways[1] == pytest.approx(0.02, abs=0.003)


def test_a_measured_force_moves_the_springs(moved):
    """Ten newtons on 500 N/m: 20 mm in the direction of the force, while the hand yields."""
    arm = moved(COMPLIANCE, pd_gains=gains(0.05, 1.5, 0.005), solver={'error_scale': 0.5},
                **YIELDING)
    start = arm.tip[:3, 3].copy()
    for _ in range(8):
        # The sensor turns with the hand; the force does not.
        turn = arm.sim.simulation.link_pose('panda_hand')[:3, :3]
        arm.controller.receive_measured((*(turn.T @ (10.0, 0.0, 0.0)), 0.0, 0.0, 0.0))
        arm.run(0.5)
    np.testing.assert_allclose(arm.tip[:3, 3] - start, (0.02, 0.0, 0.0), atol=2e-4)


def test_a_target_wrench_is_in_the_axes_of_the_hand(moved):
    """It moves along the hand's own axis; with hand_frame_control off along the base's."""
    ways = []
    for hand in (True, False):
        arm = moved(FORCE, pd_gains=gains(0.05, 1.5), hand_frame_control=hand, **SENSOR)
        start, axis = arm.tip[:3, 3].copy(), arm.tip[:3, 2]
        arm.controller.receive_wrench((0.0, 0.0, 1.0, 0.0, 0.0, 0.0))
        arm.run(1.0)
        way = arm.tip[:3, 3] - start
        ways.append(way @ (axis if hand else (0.0, 0.0, 1.0)) / np.linalg.norm(way))
    assert min(ways) > 0.98


def test_wrong_targets_are_dropped_and_named(moved):
    """Another frame, a position that is no number; the arm stays."""
    arm = moved(MOTION, pd_gains=gains(1.0, 0.5))
    start = arm.tip[:3, 3].copy()
    assert 'panda_link0' in arm.aim((0.5, 0.0, 0.5), frame='world')
    assert 'nan' in arm.aim((np.nan, 0.0, 0.5))
    arm.run(0.2)
    assert np.linalg.norm(arm.tip[:3, 3] - start) < 0.001
    assert any('target_frame' in text for text in arm.warnings)


def test_the_feedback_is_where_the_model_is(moved):
    """Pose and twist in the base link, once they are requested."""
    arm = moved(MOTION, pd_gains=gains(1.0, 0.5), solver={'publish_state_feedback': True})
    arm.run(0.1)
    _, pose, twist = arm.controller.feedback()
    np.testing.assert_allclose(pose[:3, 3], arm.tip[:3, 3], atol=1e-3)
    assert twist.shape == (6,)


@pytest.mark.parametrize(('kind', 'parameters', 'words'), [
    (MOTION, {'end_effector_link': ''}, 'end_effector_link'),
    (MOTION, {'robot_base_link': 'panda_lnk0'}, 'panda_lnk0'),
    (FORCE, {'ft_sensor_ref_link': 'panda_leftfinger'}, 'panda_leftfinger'),
    (COMPLIANCE, {**SENSOR, 'compliance_ref_link': 'nowhere'}, 'nowhere'),
    (MOTION, {'command_interfaces': ['effort']}, 'command_interfaces'),
])
def test_names_are_checked(moved, kind, parameters, words):
    """What is empty, unknown or outside of the chain is named."""
    with pytest.raises(ControllerError, match=words):
        moved(kind, **parameters)


def test_the_names_with_slashes(moved):
    """Upstream's parameters of the solvers are set by their names."""
    arm = moved(MOTION, **{'solver/forward_dynamics/link_mass': 0.5})
    assert arm.controller.parameters.link_mass == 0.5
