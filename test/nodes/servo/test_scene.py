# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""SRV-19: whose planning scene servo follows, and when it serves one itself."""

from types import SimpleNamespace

from geometry_msgs.msg import Pose
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, PlanningSceneWorld
from moveit_msgs.msg import PlanningScene as PlanningSceneMessage
from moveit_msgs.srv import GetPlanningScene
import numpy as np
import pytest
from sensor_msgs.msg import JointState
from shape_msgs.msg import SolidPrimitive

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Sphere
from armsim_ros.model.loading import load_robot_model
from armsim_ros.nodes.conversions.octomap import octomap_to_message
from armsim_ros.nodes.conversions.planning_scene import scene_to_message
from armsim_ros.nodes.servo.inputs import JointPositions, SceneFollower
from armsim_ros.planning.scene.content import FixedFrame
from armsim_ros.planning.scene.objects import AttachedObject, ObjectShape
from armsim_ros.planning.scene.objects import CollisionObject as WorldObject
from armsim_ros.planning.scene.octomap import octomap_from_cells
from armsim_ros.planning.scene.planning_scene import PlanningScene


class Graph:
    """A node and who else is there; a timer that a test lets run."""

    def __init__(self):
        self.others, self.own, self.asked, self.wall = 0, [], 0, ''
        self.receive, self.errors, self.names = {}, [], set()
        self.joint_states = []

    def count_services(self, name):
        self.names.add(name)
        return self.others + len(self.own)

    def create_client(self, kind, name):
        self.names.add(name)
        return SimpleNamespace(service_is_ready=lambda: bool(self.others), call_async=self._ask)

    def poll(self, kind, topic, receive, qos):
        return receive

    def catch_up(self, receive):
        while self.joint_states:
            receive(self.joint_states.pop(0))

    def create_subscription(self, kind, topic, receive, qos):
        self.receive[topic] = receive

    def create_timer(self, period, look, clock):
        self.look = look

    def create_service(self, kind, name, answer):
        self.own.append(answer)
        return answer

    def destroy_service(self, service):
        self.own.remove(service)

    def get_logger(self):
        return SimpleNamespace(info=lambda text: None, error=self.errors.append)

    def _ask(self, request):
        self.asked += 1
        response = GetPlanningScene.Response()
        box = CollisionObject(id=self.wall, operation=CollisionObject.ADD)
        box.header.frame_id = 'world'
        box.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.1] * 3)]
        box.primitive_poses, box.pose.orientation.w = [Pose()], 1.0
        response.scene.world.collision_objects = [box]
        future = SimpleNamespace(result=lambda: response)
        return SimpleNamespace(message=box, add_done_callback=lambda take: take(future))


@pytest.fixture
def scene():
    """Return an empty scene."""
    return PlanningScene(KinematicModel(load_robot_model(load_robot_settings('sunday'))))


@pytest.fixture
def graph():
    """Return a graph in which nobody else is."""
    return Graph()


@pytest.fixture
def follow(graph, scene):
    """Return a function that lets the scene follow that graph."""
    def follow(topic='/monitored_planning_scene', *, serves=False):
        kinematics = scene.kinematic_model
        states = JointPositions(
            graph, kinematics, ('/joint_states',), kinematics.robot.active_joints)
        return SceneFollower(graph, scene, states, topic, serves=serves)

    return follow


def looks(graph, count):
    """Let some seconds pass."""
    for _ in range(count):
        graph.look()


@pytest.mark.parametrize('primary', [True, False])
def test_another_one_is_followed(graph, follow, scene, primary):
    """Where another node serves the scene it is taken once, whatever is_primary says."""
    graph.others, graph.wall = 1, 'wall'
    follow(serves=primary)
    looks(graph, 6)
    assert graph.asked == 1
    assert 'wall' in scene.objects
    assert not graph.own


def test_the_scene_is_that_of_the_same_namespace(graph, follow):
    """
    All names are relative.

    Upstream: planning_scene_monitor.cpp, DEFAULT_PLANNING_SCENE_SERVICE.
    """
    follow('/robot1/monitored_planning_scene')
    looks(graph, 6)
    assert graph.names == {'get_planning_scene'}


def test_alone_and_primary(graph, follow, scene):
    """Alone it serves the scene after a while; who comes later takes that over."""
    follow(serves=True)
    assert not graph.own
    looks(graph, 5)
    (answer,) = graph.own
    response = answer(GetPlanningScene.Request(), GetPlanningScene.Response())
    assert response.scene.robot_model_name == 'sunday'
    graph.others, graph.wall = 1, 'table'
    looks(graph, 2)
    assert not graph.own
    assert 'table' in scene.objects


def test_alone_and_not_primary(graph, follow):
    """Where it is not to be the primary one it serves nothing."""
    follow()
    looks(graph, 10)
    assert not graph.own


def test_followed_anew(graph, follow, scene):
    """A server that was away is asked again for all that it has."""
    graph.others, graph.wall = 1, 'wall'
    follow(serves=True)
    graph.others = 0
    looks(graph, 1)
    graph.others, graph.wall = 1, 'shelf'
    looks(graph, 1)
    assert graph.asked == 2
    assert 'shelf' in scene.objects


def test_the_octomap_of_the_scene_is_followed(follow, scene):
    """Cells of move_group's map count, as in planning_scene.cpp, setPlanningSceneDiffMsg."""
    follower = follow()
    message = PlanningSceneMessage(is_diff=True)
    message.robot_state.is_diff = True
    message.world.octomap = octomap_to_message(octomap_from_cells(
        np.zeros((1, 3), dtype=np.int64), np.ones(1, dtype=np.float32), 0.1, np.eye(4)),
        scene.model_frame)
    follower._receive(message)
    assert scene.octomap is not None


def test_a_full_scene_brings_what_is_attached_and_no_joints(graph, follow, scene):
    """
    Attached objects are those of the message; joint states report positions sooner.

    moveit_core conversions.cpp, robotStateMsgToRobotStateHelper.
    """
    follow()
    other = PlanningScene(scene.kinematic_model)
    other.apply_attached(AttachedObject('link_6', WorldObject(
        'tool', shapes=(ObjectShape(Sphere(0.01)),))))
    other.set_positions({'joint_1': 0.5})
    graph.receive['/monitored_planning_scene'](scene_to_message(other))
    assert set(scene.attached) == {'tool'}
    other.clear()
    graph.receive['/monitored_planning_scene'](scene_to_message(other))
    assert not scene.attached
    assert scene.kinematic_model.positions(scene.q)['joint_1'] == 0.0


def test_a_full_scene_leaves_the_frames_of_tf_on_their_links(graph, follow, scene):
    """
    A frame of TF moves with its link after the scene of move_group has been taken over.

    moveit_ros servo.cpp, getIsometryForFrame looks up TF.
    """
    follow()
    served = PlanningScene(scene.kinematic_model)
    for each in (served, scene):
        each.set_frames({'camera': FixedFrame('link_6', np.eye(4))})
    graph.receive['/monitored_planning_scene'](scene_to_message(served))
    scene.set_positions({'joint_1': 1.0})
    np.testing.assert_allclose(scene.frame_pose('camera'), scene.frame_pose('link_6'))


def test_topics_of_changes(graph, follow, scene):
    """
    Alone, servo knows of obstacles what MoveIt's topics bring.

    Upstream: utils/common.cpp, createPlanningSceneMonitor.
    """
    follow('/planning_scene', serves=True)
    graph.wall = 'wall'
    box = graph._ask(None).message
    graph.receive['collision_object'](box)
    attached = AttachedCollisionObject(link_name='link_6')
    attached.object.id, attached.object.operation = 'wall', CollisionObject.ADD
    assert 'wall' in scene.objects
    graph.receive['attached_collision_object'](attached)
    assert 'wall' in scene.attached
    box.id = 'table'
    graph.receive['planning_scene_world'](PlanningSceneWorld(collision_objects=[box]))
    assert 'table' in scene.objects
    attached.object.id = 'ghost'
    graph.receive['attached_collision_object'](attached)
    assert 'ghost' in graph.errors[0]


@pytest.fixture
def q(graph, scene):
    """Return a robot state (n,) away from the default, which its joint states report."""
    joints = scene.kinematic_model.robot.group('manipulator').active_joints
    positions = (1.0, 0.3, 1.5, 0.5, 1.0, 0.0)
    graph.joint_states.append(JointState(name=list(joints), position=positions))
    return scene.kinematic_model.vector(dict(zip(joints, positions, strict=True)))


def test_an_object_attached_by_id_is_on_its_link_where_the_arm_is_now(graph, follow, scene, q):
    """
    Its pose on the link is that between the present robot state and the object in the world.

    Upstream: planning_scene_monitor.cpp, updateSceneWithCurrentState; planning_scene.cpp,
    processAttachedCollisionObjectMsg.
    """
    follow()
    held = scene.kinematic_model.link_pose(q, 'link_6')
    scene.apply_object(WorldObject('part', pose=held, shapes=(ObjectShape(Sphere(0.01)),)))
    attached = AttachedCollisionObject(link_name='link_6')
    attached.object.id, attached.object.operation = 'part', CollisionObject.ADD
    diff = PlanningSceneMessage(is_diff=True)
    diff.robot_state.is_diff = True
    diff.robot_state.attached_collision_objects = [attached]
    graph.receive['/monitored_planning_scene'](diff)
    np.testing.assert_allclose(scene.attached['part'].object.pose, np.eye(4), atol=1e-12)


def test_an_object_in_the_frame_of_a_link_is_where_that_link_is_now(graph, follow, scene, q):
    """
    Its pose in the world is that of the present robot state.

    Upstream: planning_scene.cpp, processCollisionObjectAdd.
    """
    follow()
    graph.wall = 'wall'
    box = graph._ask(None).message
    box.header.frame_id = 'link_6'
    graph.receive['collision_object'](box)
    np.testing.assert_allclose(
        scene.objects['wall'].pose, scene.kinematic_model.link_pose(q, 'link_6'), atol=1e-12)


def test_the_scene_that_is_served_has_the_present_robot_state(graph, follow, scene, q):
    """As upstream's planning_scene_monitor.cpp, getPlanningSceneServiceCallback."""
    follow(serves=True)
    looks(graph, 5)
    (answer,) = graph.own
    response = answer(GetPlanningScene.Request(), GetPlanningScene.Response())
    state = response.scene.robot_state.joint_state
    positions = dict(zip(state.name, state.position, strict=True))
    assert positions == scene.kinematic_model.positions(q)
