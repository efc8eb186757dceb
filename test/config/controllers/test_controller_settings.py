# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which controllers the blocks of a file give, and what is said of them."""

import pytest

from armsim_ros.config.controllers.controller_settings import read_controller
from armsim_ros.config.yaml_node import node_of
from armsim_ros.errors import Location, Severity

TRAJECTORY = {'type': 'joint_trajectory_controller/JointTrajectoryController', 'joints': ['a']}
SCALED = {'type': 'ur_controllers/ScaledJointTrajectoryController', 'joints': ['a']}
GRIPPER = {'type': 'effort_controllers/GripperActionController', 'joint': 'a'}
PID = {'type': 'pid_controller/PidController', 'dof_names': ['a'], 'command_interface': 'effort',
       'reference_and_state_interfaces': ['position']}
COMPLIANT = {'type': 'crisp_controllers/CartesianController', 'joints': ['a'],
             'end_effector_frame': 'tip'}


@pytest.fixture
def read():
    """Return a function that reads a block and returns the controller and what is said of it."""

    def read(block, *, published=True):
        problems = []
        where = Location('controllers.yaml')
        found = read_controller('arm', node_of(block, where), problems, published=published)
        return found, problems

    return read


@pytest.mark.parametrize(('block', 'key', 'entry'), [
    (TRAJECTORY, 'constraints', {'goal': 0.1}),
    (TRAJECTORY, 'gains', {'p': 1.0}),
    (TRAJECTORY, 'velocity_ff', 0.5),
    (SCALED, 'constraints', {'goal': 0.1}),
    (GRIPPER, 'gains', {'p': 1.0}),
    (PID, 'gains', {'p': 1.0}),
])
def test_entries_for_foreign_joints_have_no_effect(read, block, key, entry):
    """The controller of a published file is loaded with those of its own joints."""
    found, problems = read({**block, key: {'a': entry, 'b': entry}})
    values = getattr(found.parameters, key)
    assert set(values if isinstance(values, dict) else values.joints) == {'a'}
    said = [one for one in problems if one.severity is not Severity.CHANGED]
    assert [one.severity for one in said] == [Severity.WARNING]
    assert f"{key}: 'b' is not among the controller's joints" in str(said[0])


@pytest.mark.parametrize('block', [TRAJECTORY, SCALED, GRIPPER, PID])
def test_entries_for_foreign_joints_are_mistakes_of_an_own_file(read, block):
    """Whoever writes the file can mend the name."""
    found, problems = read({**block, 'gains': {'a': {}, 'b': {}}}, published=False)
    assert found is None
    assert any(one.severity is Severity.ERROR and "'b'" in str(one) for one in problems)


@pytest.mark.parametrize('published', [True, False])
def test_an_unknown_constraint_is_an_unknown_key(read, published):
    """It is left out, and a warning names the keys that it may have meant."""
    found, problems = read(
        {**TRAJECTORY, 'constraints': {'goal_tim': 0.1, 'goal_time': 0.5}}, published=published)
    assert found.parameters.constraints.goal_time == 0.5
    (said,) = problems
    assert said.severity is Severity.WARNING
    assert "key 'constraints.goal_tim' is not known" in str(said)
    assert "'goal_time'" in str(said)


@pytest.mark.parametrize(('block', 'key', 'value'), [
    (TRAJECTORY, 'joints', 5),
    (TRAJECTORY, 'gains', 5),
    (PID, 'dof_names', 5),
    (PID, 'dof_names', [['a']]),
    (PID, 'gains', 5),
    (PID, 'gains', 'x'),
    (PID, 'gains', ['x']),
    (COMPLIANT, 'joints', 5),
    (COMPLIANT, 'joints', [['a']]),
    (COMPLIANT, 'nullspace', {'weights': 5}),
    (COMPLIANT, 'nullspace', {'weights': 'x'}),
])
def test_a_value_of_the_wrong_type_is_an_error_of_its_key(read, block, key, value):
    """Defaults per joint are filled in only where the names and the entries have their types."""
    found, problems = read({**block, key: value})
    assert found is None
    (said,) = [one for one in problems if one.severity is Severity.ERROR]
    assert f"'{key}" in str(said)
    assert 'allowed: a ' in str(said)


@pytest.mark.parametrize(('block', 'filled'), [
    (PID, lambda parameters: parameters.gains),
    (COMPLIANT, lambda parameters: parameters.nullspace.weights),
])
def test_each_joint_has_an_entry(read, block, filled):
    """Clients get every parameter before they set it."""
    found, _ = read(block)
    assert set(filled(found.parameters)) == {'a'}
