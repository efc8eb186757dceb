# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects, frames and checks of a scene."""

import copy

from ball_message import ball_message
from moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    ObjectColor,
    PlanningSceneWorld,
)
from moveit_msgs.msg import RobotTrajectory as RobotTrajectoryMessage
import numpy as np
from octomap_msgs.msg import Octomap
import pytest
from trajectory_msgs.msg import JointTrajectoryPoint

from armsim_ros.errors import PlanningError
from armsim_ros.nodes.conversions.octomap import octomap_to_message
from armsim_ros.planning.scene.octomap import octomap_from_cells
from moveit.core.collision_detection import (
    AllowedCollisionMatrix,
    CollisionRequest,
    CollisionResult,
)
from moveit.core.kinematic_constraints import construct_joint_constraint
from moveit.core.robot_state import robotStateToRobotStateMsg
from moveit.core.robot_trajectory import RobotTrajectory

pytestmark = pytest.mark.statement('C4', 'C5')


@pytest.fixture
def in_hand(model, ready):
    """Return the message of a ball between the fingers."""
    place = ready.get_global_link_transform('panda_hand')[:3, 3]
    return ball_message(model.model_frame, 'ball', place, 0.05)


def test_the_current_state_is_that_of_the_scene(scene, ready):
    """What is changed in it is changed in the scene; it can be assigned."""
    state = scene.current_state
    state.set_joint_group_positions('panda_arm', np.full(7, -0.2))
    assert scene.current_state.joint_positions['panda_joint1'] == -0.2
    assert dict(zip(*_positions(scene), strict=True))['panda_joint1'] == -0.2
    scene.current_state = ready
    assert state.joint_positions == ready.joint_positions
    ready.joint_positions = {'panda_joint1': 0.4}
    scene.set_current_state(robot_state=robotStateToRobotStateMsg(ready))
    assert state.joint_positions['panda_joint1'] == 0.4


def _positions(scene):
    joints = scene.planning_scene_message.robot_state.joint_state
    return joints.name, joints.position


def test_objects_collide(scene, model, ready, in_hand):
    """An object is added, hit, allowed, and removed."""
    assert not scene.is_state_colliding('panda_arm')
    color = ObjectColor(id='ball')
    color.color.r = 1.0
    scene.apply_collision_object(in_hand, color)
    assert scene.planning_scene_message.object_colors[0].color.r == 1.0
    assert scene.is_state_colliding('panda_arm', True)
    assert scene.is_state_colliding(robot_state=ready, joint_model_group_name='panda_arm')
    assert not scene.is_state_valid(ready, 'panda_arm')
    matrix = scene.allowed_collision_matrix
    assert matrix.get_entry('ball', 'panda_hand') == (False, 'UNKNOWN')
    for link in model.get_joint_model_group('panda_arm').link_model_names:
        matrix.set_entry('ball', link, True)
    for link in ('panda_hand', 'panda_leftfinger', 'panda_rightfinger'):
        scene.allowed_collision_matrix.set_entry('ball', link, True)
    assert matrix.get_entry('panda_hand', 'ball') == (True, 'ALWAYS')
    assert not scene.is_state_colliding('')
    matrix.remove_entry('ball', 'panda_hand')
    assert scene.is_state_colliding('')
    scene.remove_all_collision_objects()
    assert not scene.is_state_colliding('')


def test_an_assigned_matrix(scene):
    """A matrix of names allows or forbids all pairs; cleared, it has none."""
    matrix = AllowedCollisionMatrix(['a', 'b'], default_entry=True)
    assert matrix.get_entry('b', 'a') == (True, 'ALWAYS')
    matrix.set_entry('a', 'b', False)
    assert matrix.get_entry('a', 'b') == (True, 'NEVER')
    scene.allowed_collision_matrix = matrix
    assert scene.allowed_collision_matrix.get_entry('b', 'a') == (True, 'NEVER')
    scene.allowed_collision_matrix.clear()
    assert scene.allowed_collision_matrix.get_entry('b', 'a') == (False, 'UNKNOWN')


def test_refused_operations_change_nothing(scene, in_hand):
    """They are logged, as upstream does, and return False where there is a result."""
    in_hand.header.frame_id = 'nowhere'
    scene.apply_collision_object(in_hand)
    assert not scene.planning_scene_message.world.collision_objects
    gone = AttachedCollisionObject(link_name='panda_hand')
    gone.object.id, gone.object.operation = 'ball', CollisionObject.REMOVE
    assert scene.process_attached_collision_object(gone) is False


def test_attached_objects_belong_to_the_state(scene, ready, in_hand):
    """A state without the object does not collide with it; a copy of the scene's carries it."""
    scene.apply_collision_object(in_hand)
    touch = ['panda_hand', 'panda_leftfinger', 'panda_rightfinger', 'panda_link8', 'panda_link7']
    assert scene.process_attached_collision_object(AttachedCollisionObject(
        link_name='panda_hand', touch_links=touch,
        object=CollisionObject(id='ball', operation=CollisionObject.ADD)))
    carried = copy.copy(scene.current_state)
    attached = robotStateToRobotStateMsg(carried).attached_collision_objects
    assert [each.object.id for each in attached] == ['ball']
    assert not robotStateToRobotStateMsg(carried, False).attached_collision_objects
    assert carried.get_frame_transform('ball') == pytest.approx(
        scene.get_frame_transform('ball'))
    assert not ready._attached
    scene.current_state.clear_attached_bodies()
    assert not scene.planning_scene_message.robot_state.attached_collision_objects


def test_frames(scene, ready, in_hand):
    """Links and objects; an unknown frame is an error."""
    scene.apply_collision_object(in_hand)
    assert scene.knows_frame_transform('ball')
    assert scene.knows_frame_transform(robot_state=ready, frame_id='panda_link8')
    assert not scene.knows_frame_transform('table')
    assert scene.get_frame_transform('ball').shape == (4, 4)
    with pytest.raises(PlanningError, match='table'):
        scene.get_frame_transform('table')
    transforms = scene.transforms
    assert transforms.get_target_frame() == scene.planning_frame
    assert np.array_equal(transforms.get_all_transforms()[scene.planning_frame], np.eye(4))
    with pytest.raises(KeyError, match='table'):
        transforms.get_transform('table')


def test_what_a_check_finds(scene, ready, in_hand):
    """Contacts by pair, the distance, and whether the state collides with itself alone."""
    request, result = CollisionRequest(), CollisionResult()
    request.distance = True
    scene.check_collision(request, result)
    assert not result.collision
    assert 0.0 < result.distance < 1.0
    scene.apply_collision_object(in_hand)
    request.contacts, request.max_contacts = True, 2
    scene.check_collision(request, result, ready)
    assert result.collision
    assert result.distance < 0.0
    assert result.contact_count == len(result.contacts) <= 2
    pair, (contact,) = next(iter(result.contacts.items()))
    assert 'ball' in pair
    assert contact.depth > 0.0
    scene.check_self_collision(request, result, ready)
    assert not result.collision
    assert not result.contacts
    scene.check_collision_unpadded(req=request, result=result)
    assert result.collision
    everything = AllowedCollisionMatrix(
        ['ball', *scene.robot_model._kinematics.robot.links], default_entry=True)
    scene.check_collision(request, result, ready, everything)
    assert not result.collision


def test_constraints_of_a_state(scene, ready, model):
    """A state satisfies what was made of it, and not that of another."""
    arm = model.get_joint_model_group('panda_arm')
    constraints = construct_joint_constraint(ready, arm)
    assert scene.is_state_constrained(ready, constraints)
    ready.joint_positions = {'panda_joint1': 0.1}
    assert not scene.is_state_constrained(ready, constraints, True)


def test_which_waypoints_of_a_path_collide(scene, model, ready):
    """Their numbers are put into the list."""
    message = RobotTrajectoryMessage()
    message.joint_trajectory.joint_names = ['panda_joint1']
    message.joint_trajectory.points = [
        JointTrajectoryPoint(positions=[value]) for value in (0.0, 0.5, 1.0)]
    for number, point in enumerate(message.joint_trajectory.points):
        point.time_from_start.sec = number
    path = RobotTrajectory(model).set_robot_trajectory_msg(ready, message)
    found = [7]
    assert scene.is_path_valid(path, 'panda_arm', invalid_index=found)
    assert found == []
    place = path[2].get_global_link_transform('panda_hand')[:3, 3]
    scene.apply_collision_object(ball_message(model.model_frame, 'ball', place, 0.03))
    assert not scene.is_path_valid(path, 'panda_arm', False, found)
    assert found == [2]


def test_a_copy_is_a_scene_of_its_own(scene, in_hand):
    """Both ways to copy; name and objects of the copy are its own."""
    for made in (copy.copy(scene), copy.deepcopy(scene)):
        made.name = 'other'
        made.process_planning_scene_world(PlanningSceneWorld(collision_objects=[in_hand]))
        made.current_state.joint_positions = {'panda_joint1': 1.0}
        assert made.is_state_colliding('') or made.knows_frame_transform('ball')
        assert made.name == 'other'
    assert scene.name == ''
    assert not scene.knows_frame_transform('ball')
    assert scene.current_state.joint_positions['panda_joint1'] == 0.0


def test_files_of_a_script(scene, in_hand, tmp_path):
    """Objects are written anywhere, and read back."""
    file = str(tmp_path / 'objects.scene')
    scene.apply_collision_object(in_hand)
    assert scene.save_geometry_to_file(file)
    scene.remove_all_collision_objects()
    assert scene.load_geometry_from_file(file_path_and_name=file)
    assert scene.knows_frame_transform('ball')
    assert not scene.load_geometry_from_file(str(tmp_path / 'absent.scene'))


def test_cells_of_an_octomap_collide(scene, model):
    """process_octomap replaces the map; without data there is none. planning_scene.cpp."""
    cells = octomap_from_cells(
        np.zeros((1, 3), dtype=np.int64), np.ones(1, dtype=np.float32), 1.0, np.eye(4))
    scene.process_octomap(octomap_to_message(cells, model.model_frame).octomap)
    assert scene.is_state_colliding('panda_arm')
    scene.process_octomap(Octomap())
    assert not scene.is_state_colliding('panda_arm')


def test_an_octomap_is_not_part_of_a_self_collision(scene, model):
    """Robot and attached bodies only. planning_scene.cpp, checkSelfCollision."""
    cells = octomap_from_cells(
        np.zeros((1, 3), dtype=np.int64), np.ones(1, dtype=np.float32), 1.0, np.eye(4))
    scene.process_octomap(octomap_to_message(cells, model.model_frame).octomap)
    everything, itself = CollisionResult(), CollisionResult()
    scene.check_collision(CollisionRequest(), everything)
    scene.check_self_collision(CollisionRequest(), itself)
    assert (everything.collision, itself.collision) == (True, False)
