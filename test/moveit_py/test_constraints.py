# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals as messages."""

import pytest

from moveit.core.kinematic_constraints import (
    construct_constraints_from_node,
    construct_joint_constraint,
    construct_link_constraint,
)

pytestmark = pytest.mark.statement('C7')


def test_joint_constraints(ready):
    """One per active joint, with a tolerance of 0.01 unless another is given."""
    arm = ready.robot_model.get_joint_model_group('panda_arm')
    made = construct_joint_constraint(robot_state=ready, joint_model_group=arm)
    assert [each.joint_name for each in made.joint_constraints] == arm.active_joint_model_names
    fourth = made.joint_constraints[3]
    assert (fourth.position, fourth.tolerance_above, fourth.tolerance_below) == (
        -2.356, 0.01, 0.01)
    assert construct_joint_constraint(ready, arm, 0.2).joint_constraints[0].tolerance_above == 0.2


def test_link_constraints():
    """Position, orientation (x, y, z, w), or both, with the tolerances that are given."""
    both = construct_link_constraint(
        'tool', 'base', [1.0, 2.0, 3.0], 0.01, [0.0, 0.0, 1.0, 0.0], 0.05)
    position, = both.position_constraints
    orientation, = both.orientation_constraints
    assert position.header.frame_id == orientation.header.frame_id == 'base'
    assert position.constraint_region.primitives[0].dimensions.tolist() == [0.01]
    assert position.constraint_region.primitive_poses[0].position.z == 3.0
    assert (orientation.orientation.z, orientation.absolute_y_axis_tolerance) == (1.0, 0.05)
    only = construct_link_constraint(
        'tool', 'base', orientation=[0.0, 0.0, 0.0, 1.0], orientation_tolerance=0.1)
    assert not only.position_constraints


@pytest.mark.parametrize(('arguments', 'text'), [
    ({}, 'cartesian_position, orientation'),
    ({'cartesian_position': [0.0, 0.0, 0.0]}, 'cartesian_position_tolerance'),
    ({'orientation': [0.0, 0.0, 0.0, 1.0]}, 'orientation_tolerance')])
def test_link_constraints_need_a_tolerance(arguments, text):
    """Upstream's C++ raises an error that does not name the argument."""
    with pytest.raises(ValueError, match=text):
        construct_link_constraint('tool', 'base', **arguments)


class Parameters:
    """A node's parameters."""

    def __init__(self, values):
        self._values = values

    def has_parameter(self, name):
        return name in self._values

    def get_parameter(self, name):
        return type('Parameter', (), {'value': self._values[name]})


def test_constraints_of_a_node():
    """A block for each constraint; a type that is not known is refused."""
    values = {
        'goal.constraint_ids': ['a', 'b', 'c'],
        'goal.constraints.a.type': 'joint', 'goal.constraints.a.joint_name': 'j',
        'goal.constraints.a.bounds': [0.0, 1.0],
        'goal.constraints.b.type': 'position', 'goal.constraints.b.link_name': 'tool',
        'goal.constraints.b.frame_id': 'base', 'goal.constraints.b.region.x': [0.0, 2.0],
        'goal.constraints.b.region.y': [0.0, 4.0], 'goal.constraints.b.region.z': [0.0, 6.0],
        'goal.constraints.c.type': 'orientation', 'goal.constraints.c.link_name': 'tool',
        'goal.constraints.c.frame_id': 'base', 'goal.constraints.c.orientation': [0.0, 0.0, 0.0],
        'goal.constraints.c.tolerances': [0.1, 0.2, 0.3],
    }
    made = construct_constraints_from_node(Parameters(values), 'goal')
    assert made.joint_constraints[0].tolerance_above == 0.5
    region = made.position_constraints[0].constraint_region
    assert region.primitives[0].dimensions.tolist() == [2.0, 4.0, 6.0]
    assert region.primitive_poses[0].position.z == 3.0
    assert made.orientation_constraints[0].absolute_z_axis_tolerance == 0.3
    values['goal.constraints.a.type'] = 'other'
    with pytest.raises(ValueError, match='joint, position, orientation'):
        construct_constraints_from_node(Parameters(values), 'goal')
