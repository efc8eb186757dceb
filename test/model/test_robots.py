"""The robots that the package brings: each fits its files, and its states are usable."""

import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.errors import Severity
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.tree import link_poses
from armsim_ros.resources import robot_names

ROBOTS = robot_names()
EXPECTED_WARNINGS = {
    'bot': ["controller 'bot_gripper_controller' is to be spawned, but no file describes it"],
}


def load(name):
    """Return settings, model and all warnings."""
    settings = load_robot_settings(name)
    problems = list(settings.remarks)
    model = load_robot_model(settings, report=problems.append)
    return settings, model, [str(one) for one in problems if one.severity is Severity.WARNING]


@pytest.mark.parametrize('name', ROBOTS)
def test_files_urdf_and_srdf_fit(name):
    """There is no warning but the ones that the published files earn."""
    settings, model, warnings = load(name)
    expected = EXPECTED_WARNINGS.get(name, [])
    assert len(warnings) == len(expected)
    assert all(text in warning for text, warning in zip(expected, warnings, strict=True))
    assert model.name == name
    covered = {joint for one in settings.moveit_controllers for joint in one.joints}
    assert covered == set(model.active_joints)


@pytest.mark.parametrize('name', ROBOTS)
def test_named_states_touch_nothing(near_pairs, name):
    """In every named state no two links overlap that are checked."""
    _, model, _ = load(name)
    for states in model.semantic.named_states.values():
        for state, positions in states.items():
            assert near_pairs(model, positions, 0.0) == [], state


def test_the_seeds_namespaces():
    """Where each system of the published posts has its controllers."""
    found = {name: load_robot_settings(name).namespace for name in ROBOTS}
    assert {name: found[name] for name in ('sunday', 'bot', 'ROBOT', 'leg', 'magician')} == {
        'sunday': '/sunday', 'bot': '/bot', 'ROBOT': '/ROBOT', 'leg': '', 'magician': ''}


def test_the_magician_keeps_its_hand_level():
    """Two parallelograms: whatever joints 2 and 3 do, the hand does not tilt or turn."""
    _, model, _ = load('magician')
    for joints in ((0.0, 0.4, 0.7), (0.9, 1.2, 1.1), (-2.0, 1.5, 0.65)):
        positions = dict(zip(model.active_joints, joints, strict=True))
        hand = link_poses(model, positions)['magician_end_effector']
        assert hand[:3, 2] == pytest.approx((0, 0, 1), abs=1e-9)
        assert hand[:3, 0] == pytest.approx((0, -1, 0), abs=1e-9)


def test_the_magicians_passive_joints():
    """Those of the parallelograms follow others, so they are no variables of the group."""
    _, model, _ = load('magician')
    assert model.group('manipulator').active_joints == (
        'magician_joint1', 'magician_joint2', 'magician_joint3')


def test_the_legs_motors_are_noted():
    """Gazebo's transmissions stay in the text; the constraints are the post's."""
    settings, model, _ = load('leg')
    constraints = settings.controller('group_controller').parameters.constraints
    assert (constraints.goal_time, constraints.stopped_velocity_tolerance) == (0.6, 0.05)
    assert constraints.joints['knee'].trajectory == 0.1
    assert 'mechanicalReduction' in model.urdf


def test_one_group_over_two_controllers():
    """Arm and gripper can be planned for together, or apart."""
    settings, model, _ = load('ROBOT')
    both = model.group('arm_and_gripper').active_joints
    assert both == (*settings.moveit_controllers[0].joints, *settings.moveit_controllers[1].joints)
    assert model.semantic.end_effectors['hand'].parent_group == 'arm'
