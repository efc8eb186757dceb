# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Positions, velocities and poses of a state."""

import copy
from types import SimpleNamespace

from geometry_msgs.msg import Pose
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject
import numpy as np
import pytest
from shape_msgs.msg import SolidPrimitive

from armsim_ros.config.robot_folder import find_files
from armsim_ros.errors import PlanningError
from armsim_ros.kinematics import inverse
from armsim_ros.kinematics.inverse import StartTable
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.moveit_py import robot_state
from armsim_ros.nodes.conversions.geometry import pose_to_message
from moveit.core.robot_model import RobotModel
from moveit.core.robot_state import RobotState, robotStateToRobotStateMsg

pytestmark = pytest.mark.statement('C3')

STEP = 1e-6


def test_named_states(ready):
    """A state of the SRDF sets its group; an unknown name is False and changes nothing."""
    before = ready.joint_positions
    assert before['panda_joint4'] == -2.356
    group = ready.robot_model.get_joint_model_group('panda_arm')
    assert ready.set_to_default_values(joint_model_group_name='panda_arm', name='up') is False
    assert ready.joint_positions == before
    assert ready.set_to_default_values(joint_model_group=group, name='extended')
    ready.set_to_default_values()
    assert ready.joint_positions['panda_joint1'] == 0.0


def test_at_its_defaults_a_state_is_at_rest(ready):
    """Without velocities, accelerations and efforts (robot_state.cpp: setToDefaultValues)."""
    ready.joint_velocities = {'panda_joint1': 1.0}
    ready.joint_accelerations = {'panda_joint1': 1.0}
    ready.joint_efforts = {'panda_joint1': 1.0}
    ready.set_to_default_values('panda_arm', 'ready')
    assert ready.joint_velocities['panda_joint1'] == 1.0
    ready.set_to_default_values()
    assert not any([*ready.joint_velocities.values(), *ready.joint_accelerations.values(),
                    *ready.joint_efforts.values()])


def test_values_that_are_not_named_stay(ready):
    """Dictionaries set some joints; a mimic joint follows its driver."""
    ready.joint_positions = {'panda_finger_joint1': 0.02}
    ready.joint_velocities = {'panda_joint1': 0.5}
    ready.joint_efforts = {'panda_joint2': 3.0}
    assert ready.joint_positions['panda_finger_joint2'] == 0.02
    assert ready.joint_positions['panda_joint4'] == -2.356
    assert ready.joint_velocities == {
        name: 0.5 if name == 'panda_joint1' else 0.0 for name in ready.joint_positions}
    assert ready.joint_efforts['panda_joint2'] == 3.0
    with pytest.raises(PlanningError, match='panda_joint9'):
        ready.joint_positions = {'panda_joint9': 0.0}


def test_values_of_groups(ready):
    """A group has a value per movable joint, active ones are fewer."""
    ready.set_joint_group_positions('hand', [0.01, 0.0])
    assert ready.get_joint_group_positions('hand').tolist() == [0.01, 0.01]
    ready.set_joint_group_active_positions('hand', np.array([0.03]))
    assert ready.get_joint_group_positions('hand').tolist() == [0.03, 0.03]
    ready.set_joint_group_velocities('panda_arm', np.arange(7.0))
    ready.set_joint_group_accelerations('panda_arm', np.ones(7))
    assert ready.get_joint_group_velocities('panda_arm').tolist() == list(range(7))
    assert ready.get_joint_group_accelerations('panda_arm').tolist() == [1.0] * 7
    with pytest.raises(ValueError, match='takes 7 values'):
        ready.set_joint_group_positions('panda_arm', [0.0])


def test_a_copy_is_a_state_of_its_own(ready):
    """Both ways to copy."""
    for made in (copy.copy(ready), copy.deepcopy(ready)):
        made.joint_positions = {'panda_joint1': 1.0}
        made.joint_velocities = {'panda_joint1': 1.0}
        assert made.robot_model is ready.robot_model
    assert ready.joint_positions['panda_joint1'] == 0.0
    assert ready.joint_velocities['panda_joint1'] == 0.0


def test_dirty_until_it_is_updated(ready):
    """Poses are right before, too."""
    ready.update()
    assert not ready.dirty
    before = ready.get_global_link_transform('panda_link8')
    ready.joint_positions = {'panda_joint1': 0.5}
    assert ready.dirty
    assert not np.allclose(before, ready.get_global_link_transform('panda_link8'))
    with pytest.raises(ValueError, match='links_only'):
        ready.update(type='some')


def test_poses(ready):
    """A pose is the transform as a message; frames are links too; unknown links are refused."""
    matrix = ready.get_global_link_transform('panda_link8')
    pose = ready.get_pose('panda_link8')
    assert matrix.shape == (4, 4)
    assert (pose.position.x, pose.position.y, pose.position.z) == tuple(matrix[:3, 3])
    assert np.array_equal(ready.get_frame_transform('panda_link8'), matrix)
    with pytest.raises(PlanningError, match='panda_link8'):
        ready.get_pose('panda_link88')
    assert 'panda_link8' in ready.state_tree
    assert 'panda_joint7' in ready.state_info


@pytest.mark.parametrize('link', [None, 'panda_link5'])
def test_the_jacobian_is_the_rate_of_the_pose(ready, link):
    """Of a point beside a link, in the axes of the group's base; of its quaternion likewise."""
    point, name = np.array([0.1, -0.2, 0.3]), link or 'panda_link8'
    arguments = ('panda_arm', point) if link is None else ('panda_arm', link, point)
    jacobian = ready.get_jacobian(*arguments)
    with_turn = ready.get_jacobian('panda_arm', name, point, use_quaternion_representation=True)
    assert (jacobian.shape, with_turn.shape) == ((6, 7), (7, 7))
    q = ready.get_joint_group_positions('panda_arm')
    same_turn = quat_xyzw_from_matrix(ready.get_global_link_transform(name))
    for column in range(7):
        ends = []
        for sign in (1.0, -1.0):
            moved = q.copy()
            moved[column] += sign * STEP
            ready.set_joint_group_positions('panda_arm', moved)
            pose = ready.get_global_link_transform(name)
            turn = quat_xyzw_from_matrix(pose)
            x, y, z, w = turn if turn @ same_turn > 0.0 else -turn
            ends.append(np.concatenate([(pose @ [*point, 1.0])[:3], [w, x, y, z]]))
        rate = (ends[0] - ends[1]) / (2.0 * STEP)
        assert jacobian[:3, column] == pytest.approx(rate[:3], abs=1e-6)
        assert with_turn[:, column] == pytest.approx(rate, abs=1e-6)


def test_only_chains_have_a_jacobian(ready):
    """Upstream prints an error and returns what was in memory."""
    with pytest.raises(ValueError, match='chain'):
        ready.get_jacobian('hand', [0.0, 0.0, 0.0])


def test_inverse_kinematics_begins_at_the_state(ready):
    """A solution is near; where there is none, the state stays as it was."""
    pose = ready.get_pose('panda_link8')
    pose.position.z -= 0.05
    before = ready.get_joint_group_positions('panda_arm')
    assert ready.set_from_ik('panda_arm', pose, 'panda_link8')
    assert np.abs(ready.get_joint_group_positions('panda_arm') - before).max() < 0.3
    assert ready.get_pose('panda_link8').position.z == pytest.approx(pose.position.z, abs=1e-5)
    pose.position.x = 5.0
    found = ready.joint_positions
    assert ready.set_from_ik('panda_arm', pose, 'panda_link8', timeout=0.01) is False
    assert ready.joint_positions == found


def test_the_time_limit_is_that_of_the_search(monkeypatch):
    """What is made at the first need is made before the time counts."""
    now = [0.0]

    def slow_table(*arguments):
        now[0] += 1.0
        return StartTable(*arguments)

    monkeypatch.setattr(robot_state, 'time', SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(inverse, 'StartTable', slow_table)
    files = find_files('panda')
    state = RobotState(RobotModel(str(files.urdf_file), str(files.srdf_file)))
    state.set_to_default_values('panda_arm', 'extended')
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = 0.25, 0.25, 0.5
    assert state.set_from_ik('panda_arm', pose, 'panda_hand')
    assert now == [1.0]


def test_a_link_that_the_solver_does_not_position(ready, monkeypatch):
    """Another link of the chain is refused, and so is an unknown one, which is named."""
    pose, lines = ready.get_pose('panda_link8'), []
    monkeypatch.setattr(robot_state, 'logger', lambda: SimpleNamespace(error=lines.append))
    assert ready.set_from_ik('panda_arm', pose, 'panda_link3') is False
    assert ready.set_from_ik('panda_arm', pose, 'panda_link9') is False
    assert 'panda_link9' in lines[-1]


@pytest.mark.parametrize('tip', ['tool', 'tool/tip'])
def test_an_object_of_the_robot_can_be_the_tip(scene, tip):
    """And its subframes (robot_state.cpp: setFromIK), whatever other states carry."""
    tool = AttachedCollisionObject(link_name='panda_hand')
    tool.object.id, tool.object.header.frame_id = 'tool', 'panda_hand'
    tool.object.operation = CollisionObject.ADD
    tool.object.primitives = [SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.02])]
    tool.object.primitive_poses = [Pose()]
    tool.object.pose.position.z = 0.1
    tool.object.subframe_names, tool.object.subframe_poses = ['tip'], [Pose()]
    tool.object.subframe_poses[0].position.x = 0.05
    assert scene.process_attached_collision_object(tool)
    state = copy.copy(scene.current_state)
    matrix = state.get_frame_transform(tip)
    matrix[2, 3] += 0.01
    assert state.set_from_ik('panda_arm', pose_to_message(matrix), tip)
    assert state.get_frame_transform(tip) == pytest.approx(matrix, abs=1e-4)


def test_random_positions_are_within_bounds(ready):
    """All joints, or those of a group."""
    model = ready.robot_model
    hand, arm = model.joint_model_groups
    for _ in range(20):
        ready.set_to_random_positions(arm)
        assert arm.satisfies_position_bounds(ready.get_joint_group_positions('panda_arm'))
    assert ready.get_joint_group_positions('hand').tolist() == [0.0, 0.0]
    ready.set_to_random_positions()
    assert hand.satisfies_position_bounds(ready.get_joint_group_positions('hand')[:1])


def test_the_message_of_a_state(ready):
    """It names every movable joint; velocities are there where something moves."""
    message = robotStateToRobotStateMsg(ready)
    assert dict(zip(message.joint_state.name, message.joint_state.position, strict=True)) == \
        ready.joint_positions
    assert not message.joint_state.velocity
    assert not message.is_diff
    ready.joint_velocities = {'panda_joint1': 0.2}
    assert robotStateToRobotStateMsg(state=ready).joint_state.velocity[0] == 0.2


def test_a_new_state_is_valid(model):
    """Upstream's holds whatever was in memory."""
    state = RobotState(model)
    arm = model.get_joint_model_group('panda_arm')
    assert arm.satisfies_position_bounds(state.get_joint_group_positions('panda_arm'))
