# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The admittance controller: what passes, how far the arm yields, what it refuses."""

from types import SimpleNamespace

import numpy as np
import pytest

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.control.command_controllers.admittance_rule import LinkMotion
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.errors import ControllerError
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.model.transforms import rotation_vector
from armsim_ros.model.tree import link_poses

ADMITTANCE = 'admittance_controller/AdmittanceController'
TRAJECTORY = 'joint_trajectory_controller/JointTrajectoryController'
JOINTS = tuple(f'joint_{number}' for number in range(1, 7))
PLACE = np.array([0.0, 0.3, 1.5, 0.5, 1.0, 0.0])
AXES = [f'wrist/{kind}.{axis}' for kind in ('force', 'torque') for axis in 'xyz']
PERIOD_NS = 10_000_000


@pytest.fixture(scope='module', name='model')
def _model():
    """Return the sunday arm."""
    return load_cell('sunday').model


class Yielding:
    """Joints without physics, a sensor that says what it is told, one admittance controller."""

    def __init__(self, hardware, model, **parameters):
        self.hardware, self.model = hardware, model
        hardware.state.position[:6] = PLACE
        self.push(np.zeros(6))
        self.manager = ControllerManager(hardware, ControllerManagerParameters(), model)
        self.now_ns = self.manager.time_ns = 5_000_000_000
        frame = {'frame': {'id': 'base_link'}}
        self.controller = self.load('soft', ADMITTANCE, **{
            'joints': JOINTS,
            'kinematics': {'base': 'base_link', 'tip': 'link_6', 'alpha': 1e-6},
            'ft_sensor': {'name': 'wrist', 'frame': {'id': 'link_6'}, 'filter_coefficient': 1.0},
            'control': frame, 'fixed_world_frame': frame, 'gravity_compensation': frame,
            'admittance': {
                'selected_axes': [True] * 6, 'mass': [5.0] * 3 + [0.5] * 3,
                'damping_ratio': [1.0] * 6, 'stiffness': [200.0] * 3 + [20.0] * 3,
                'joint_damping': 0.0},
            **parameters})

    def load(self, name, type, **parameters):  # noqa: A002
        controller = self.manager.load(
            SimpleNamespace(name=name, type=type, parameters=parameters))
        self.manager.configure(name)
        return controller

    def activate(self, *names):
        result = self.manager.switch(activate=names or ('soft',))
        assert result.ok, result.message
        return self

    def push(self, wrench):
        """Let the sensor measure (6,) in its own axes."""
        self.hardware.given_states.update(zip(AXES, map(float, wrench), strict=True))

    def run(self, seconds):
        for _ in range(round(seconds * 1e9 / PERIOD_NS)):
            self.manager.update(self.now_ns, PERIOD_NS * 1e-9)
            self.hardware.step(PERIOD_NS * 1e-9)
            self.now_ns += PERIOD_NS

    @property
    def positions(self):
        return self.hardware.state.position[:6].copy()

    def tip(self, positions=None):
        """Return the pose of the sensor's frame in the base."""
        positions = self.positions if positions is None else positions
        poses = link_poses(self.model, dict(zip(JOINTS, positions, strict=True)))
        return np.linalg.inv(poses['base_link']) @ poses['link_6']


@pytest.fixture
def soft(hardware_class, model):
    """Return a function that makes one, by what differs from the usual parameters."""
    return lambda **parameters: Yielding(
        hardware_class(tuple(model.movable_joints)), model, **parameters)


def test_jacobian_is_the_derivative(model):
    """Small steps of each joint move the link as the Jacobian says."""
    links = LinkMotion(model, JOINTS, 'base_link', ('link_5',))
    here, step = links.poses(PLACE)['link_5'], 1e-6
    for column, found in enumerate(links.jacobian('link_5', PLACE).T):
        there = links.poses(PLACE + step * np.eye(6)[column])['link_5']
        moved = (there[:3, 3] - here[:3, 3]) / step
        turned = rotation_vector(there[:3, :3] @ here[:3, :3].T) / step
        np.testing.assert_allclose(found, [*moved, *turned], atol=1e-5)


def test_references_pass_without_a_wrench(soft):
    """Where nothing pushes, what is commanded is the reference, to the last bit."""
    made = soft().activate()
    goal = PLACE + 0.1
    made.run(0.1)
    assert made.controller.receive(goal, []) == ''
    made.run(1.0)
    np.testing.assert_array_equal(made.hardware.command.position[:6], goal)


def test_references_of_interfaces_that_are_not_exported(soft):
    """Re-enacts admittance_controller.cpp, update_reference_from_subscribers: they are ignored."""
    made = soft(chainable_command_interfaces=['position']).activate()
    goal = PLACE + 0.1
    assert made.controller.receive(goal, [0.5] * 6) == ''
    made.run(0.1)
    np.testing.assert_array_equal(made.hardware.command.position[:6], goal)
    assert 'no value for position' in made.controller.receive([], [0.5] * 6)


def test_a_reference_that_is_not_a_number_stays(soft):
    """Re-enacts admittance_controller.cpp, read_state_reference_interfaces."""
    made = soft().activate()
    first, second = PLACE + 0.1, PLACE + 0.2
    made.controller.receive(first, [])
    made.run(0.1)
    assert made.controller.receive([np.nan, *second[1:]], []) == ''
    made.run(0.1)
    np.testing.assert_array_equal(
        made.hardware.command.position[:6], [first[0], *second[1:]])


@pytest.mark.parametrize('axis', range(3))
def test_yields_by_force_over_stiffness(soft, axis):
    """A lasting force moves the tip by force / stiffness along itself, and no other way."""
    made = soft().activate()
    before, force = made.tip(), np.zeros(3)
    force[axis] = 4.0
    for _ in range(40):
        # The sensor turns with the tip; the force stays as it is in the base.
        made.push([*(made.tip()[:3, :3].T @ force), 0.0, 0.0, 0.0])
        made.run(0.1)
    moved = made.tip()[:3, 3] - before[:3, 3]
    np.testing.assert_allclose(moved, force / 200.0, atol=5e-4)
    made.push(np.zeros(6))
    made.run(4.0)
    np.testing.assert_allclose(made.positions, PLACE, atol=1e-4)


def test_motion_of_mass_spring_and_damper(soft):
    """The way to the new place is that of a critically damped oscillator."""
    made = soft(kinematics={'base': 'base_link', 'alpha': 1e-9}).activate()
    before = made.tip()
    force = np.array([0.0, 0.0, 1.0])
    made.push([*(before[:3, :3].T @ force), 0.0, 0.0, 0.0])
    rate = np.sqrt(200.0 / 5.0)
    for _ in range(8):
        made.run(0.05)
        time = made.now_ns * 1e-9 - 5.0
        wanted = (1.0 - (1.0 + rate * time) * np.exp(-rate * time)) / 200.0
        assert made.tip()[2, 3] - before[2, 3] == pytest.approx(wanted, abs=4e-4)


def test_axes_that_are_not_selected(soft):
    """Forces along an axis that is not selected move nothing."""
    made = soft(admittance={
        'selected_axes': [True, True, False, True, True, True], 'mass': [5.0] * 6,
        'damping_ratio': [1.0] * 6, 'stiffness': [200.0] * 6}).activate()
    before = made.tip()
    made.push([*(before[:3, :3].T @ [0.0, 0.0, 5.0]), 0.0, 0.0, 0.0])
    made.run(1.0)
    np.testing.assert_allclose(made.tip(), before, atol=1e-6)


def test_a_wrench_reference_is_added(soft):
    """
    What comes from the topic is added to the measured wrench until it is replaced.

    admittance_controller.cpp, update_and_write_commands; a wrong frame is ignored (on_configure).
    """
    made = soft().activate()
    before = made.tip()
    force = before[:3, :3].T @ [0.0, 0.0, 2.0]
    assert 'expected' in made.controller.receive_wrench('link_1', [9.0] * 6)
    assert 'finite' in made.controller.receive_wrench('', [np.nan] * 6)
    assert made.controller.receive_wrench('link_6', [*force, 0.0, 0.0, 0.0]) == ''
    made.run(3.0)
    assert made.tip()[2, 3] - before[2, 3] == pytest.approx(0.01, abs=5e-4)
    assert made.controller.receive_wrench('', [0.0] * 6) == ''
    made.run(3.0)
    np.testing.assert_allclose(made.tip(), before, atol=1e-3)


def test_a_wrench_that_is_not_a_number_counts_as_none(soft):
    """Re-enacts admittance_controller.cpp, read_state_from_hardware."""
    made = soft().activate()
    made.push([np.nan, 0.0, 20.0, 0.0, 0.0, 0.0])
    made.run(0.1)
    np.testing.assert_array_equal(made.hardware.command.position[:6], PLACE)
    made.push(np.zeros(6))
    made.run(0.1)
    np.testing.assert_array_equal(made.hardware.command.position[:6], PLACE)


def test_velocities_alone_are_commanded(soft):
    """Positions need not be among the command interfaces (write_state_to_hardware)."""
    made = soft(command_interfaces=['velocity'])
    assert made.controller.required_command_interfaces[0] == 'joint_1/velocity'
    before = made.activate().tip()
    made.push([*(before[:3, :3].T @ [0.0, 0.0, 2.0]), 0.0, 0.0, 0.0])
    made.run(3.0)
    assert made.tip()[2, 3] - before[2, 3] == pytest.approx(0.01, abs=1e-3)


def test_control_frame_turns_the_axes(soft):
    """Stiffness belongs to the axes of the control frame."""
    made = soft(control={'frame': {'id': 'link_6'}}, admittance={
        'selected_axes': [True] * 6, 'mass': [5.0] * 6, 'damping_ratio': [1.0] * 6,
        'stiffness': [1e6, 1e6, 200.0, 1e4, 1e4, 1e4]}).activate()
    before = made.tip()
    made.push([2.0, 2.0, 2.0, 0.0, 0.0, 0.0])
    made.run(4.0)
    moved = before[:3, :3].T @ (made.tip()[:3, 3] - before[:3, 3])
    np.testing.assert_allclose(moved, [0.0, 0.0, 0.01], atol=5e-4)


def test_mass_is_that_of_the_base_axes(soft):
    """Re-enacts admittance_rule_impl.hpp, calculate_admittance_rule: mass_inv is not turned."""
    made = soft(control={'frame': {'id': 'link_6'}}, admittance={
        'selected_axes': [True] * 6, 'mass': [1.0, 1.0, 100.0, 0.5, 0.5, 0.5],
        'damping_ratio': [0.0] * 6, 'stiffness': [0.0] * 6, 'joint_damping': 0.0},
        kinematics={'base': 'base_link', 'tip': 'link_6', 'alpha': 1e-9}).activate()
    made.push([*(made.tip()[:3, :3].T @ [5.0, 0.0, 0.0]), 0.0, 0.0, 0.0])
    made.run(0.01)
    np.testing.assert_allclose(
        made.controller.snapshot().twist_rate[:3], [5.0, 0.0, 0.0], atol=1e-3)


def test_gravity_is_taken_away(soft):
    """The weight of what hangs there is no force to yield to."""
    made = soft(gravity_compensation={
        'frame': {'id': 'link_6'}, 'CoG': {'pos': [0.0, 0.0, 0.1], 'force': 10.0}}).activate()
    turn = made.tip()[:3, :3]
    weight = turn.T @ [0.0, 0.0, -10.0]
    made.push([*weight, *np.cross([0.0, 0.0, 0.1], weight)])
    made.run(1.0)
    np.testing.assert_allclose(made.positions, PLACE, atol=1e-6)


def test_stiff_and_light_stays_stable(soft):
    """Values that an explicit step would blow up are followed calmly."""
    made = soft(admittance={
        'selected_axes': [True] * 6, 'mass': [1e-4] * 6, 'damping_ratio': [0.5] * 6,
        'stiffness': [1e6] * 6}).activate()
    made.push([5.0] * 6)
    made.run(2.0)
    np.testing.assert_allclose(made.positions, PLACE, atol=1e-3)


def test_bounds_hold(soft, model):
    """A push that never ends leads no joint over its bound."""
    made = soft(admittance={
        'selected_axes': [True] * 6, 'mass': [1.0] * 6, 'damping_ratio': [0.1] * 6,
        'stiffness': [0.0] * 6}).activate()
    made.push([0.0, 0.0, 50.0, 0.0, 0.0, 0.0])
    bounds = [model.joints[name].limits for name in JOINTS]
    lower, upper = np.array([(limits.lower, limits.upper) for limits in bounds]).T
    distances = []
    for _ in range(50):
        made.run(0.1)
        distances.append(np.minimum(made.positions - lower, upper - made.positions).min())
    assert min(distances) == pytest.approx(0.0, abs=1e-9)


def test_live_parameters(soft):
    """A new stiffness counts at once."""
    made = soft().activate()
    before = made.tip()
    made.push([*(before[:3, :3].T @ [0.0, 0.0, 2.0]), 0.0, 0.0, 0.0])
    made.run(3.0)
    made.controller.set_parameters({'admittance.stiffness': (400.0,) * 3 + (20.0,) * 3})
    made.run(3.0)
    assert made.tip()[2, 3] - before[2, 3] == pytest.approx(0.005, abs=3e-4)


@pytest.mark.parametrize('active', [True, False])
@pytest.mark.parametrize('name', [
    'ft_sensor.frame.id', 'control.frame.id', 'fixed_world_frame.frame.id',
    'gravity_compensation.frame.id'])
def test_a_frame_changes_while_loaded(soft, name, active):
    """Re-enacts AdmittanceRule::apply_parameters_update, in update and in on_activate."""
    made = soft()
    if active:
        made.activate().run(0.1)
    made.controller.set_parameters({name: 'link_5'})
    if not active:
        made.activate()
    made.run(0.1)
    assert made.controller.active


@pytest.mark.parametrize(('changes', 'words'), [
    ({'control.frame.id': 'link_66'}, "'link_66' is not a link"),
    ({'ft_sensor.frame.id': ''}, 'ft_sensor.frame.id'),
])
def test_parameters_that_are_refused_while_loaded(soft, changes, words):
    """The reason is given, and the controller goes on as before."""
    made = soft().activate()
    before = made.controller.parameters
    with pytest.raises(ControllerError, match=words):
        made.controller.set_parameters(changes)
    made.run(0.1)
    assert made.controller.active
    assert made.controller.parameters is before


def test_behind_a_trajectory_controller(soft, trajectory):
    """References of position and velocity come from a trajectory, and pass."""
    made = soft()
    arm = made.load('arm', TRAJECTORY, joints=JOINTS,
                    command_joints=[f'soft/{joint}' for joint in JOINTS],
                    command_interfaces=['position', 'velocity'])
    made.activate('arm', 'soft')
    made.run(0.1)
    goal = PLACE + 0.2
    assert arm.send_goal(trajectory((1.0, goal), joints=JOINTS)).accepted
    made.run(1.5)
    np.testing.assert_allclose(made.positions, goal, atol=1e-9)
    assert arm.active_goal is None


def test_what_it_tells(soft):
    """The state holds the wrench, how far the arm has yielded, and the parameters."""
    made = soft().activate()
    assert made.controller.snapshot() is None
    made.push([*(made.tip()[:3, :3].T @ [0.0, 0.0, 2.0]), 0.0, 0.0, 0.0])
    made.run(3.0)
    snapshot = made.controller.snapshot()
    np.testing.assert_allclose(snapshot.wrench[:3], [0.0, 0.0, 2.0], atol=0.05)
    np.testing.assert_allclose(snapshot.yielded[2], 0.01, atol=3e-4)
    np.testing.assert_allclose(snapshot.offset, made.positions - PLACE, atol=1e-6)
    assert snapshot.damping[0] == pytest.approx(2.0 * np.sqrt(5.0 * 200.0))


@pytest.mark.parametrize(
    ('positions', 'velocities', 'word'),
    [([0.1], [], 'position'), ([np.nan] * 6, [], 'no value'), ([], [np.inf] * 6, 'inf'),
     ([], [], 'no value'), (list(PLACE), [0.1], 'velocity')],
)
def test_garbage(soft, positions, velocities, word):
    """What is no reference moves nothing, and the reason is said."""
    made = soft().activate()
    assert word in made.controller.receive(positions, velocities)
    made.run(0.3)
    np.testing.assert_allclose(made.positions, PLACE, atol=1e-9)
    assert any(word in event.text for event in made.manager.poll_events())


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'ft_sensor': {'frame': {'id': 'link_6'}}}, 'ft_sensor.name'),
        ({'control': {'frame': {'id': 'link_66'}}}, "'link_66' is not a link"),
        ({'kinematics': {}}, 'kinematics.base'),
        ({'kinematics': {'base': 'link_1'}}, "'link_1' moves with 'joint_1'"),
        ({'admittance': None}, "'admittance'"),
        ({'command_joints': ['x/a']}, 'command_joints'),
        ({'joints': ['nowhere']}, "'nowhere' is not a joint"),
        ({'admittance': {'selected_axes': [True] * 6, 'mass': [0.0] * 6,
                         'damping_ratio': [1.0] * 6, 'stiffness': [1.0] * 6}}, 'mass'),
        ({'admittance': {'selected_axes': [True] * 6, 'mass': [1.0] * 6,
                         'damping_ratio': [1.0] * 6, 'stiffness': [-1.0] * 6}}, 'stiffness'),
    ],
)
def test_parameters_that_do_not_fit(soft, changes, words):
    """What is missing or wrong is named before anything starts."""
    with pytest.raises(ControllerError, match=words):
        soft(**changes)
