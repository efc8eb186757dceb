# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A stack that is not ours, in the test's own process: interfaces with next to nothing behind."""

import contextlib
import threading

from control_msgs.msg import JointTrajectoryControllerState
from controller_manager_msgs.msg import ControllerState
from controller_manager_msgs.srv import ListControllers, SwitchController
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import CollisionObject, ContactInformation, MoveItErrorCodes, PlanningScene
from moveit_msgs.srv import (
    ApplyPlanningScene,
    GetCartesianPath,
    GetPlanningScene,
    GetPositionIK,
    GetStateValidity,
    QueryPlannerInterfaces,
)
from octomap_msgs.msg import OctomapWithPose
import pytest
import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import GetSimulationState
from std_msgs.msg import String
from std_srvs.srv import Empty, Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

from armsim_ros.clients.node import destroy_node
from armsim_ros.nodes import qos

URDF = """<robot name="two">
  <link name="base"><visual><geometry><box size="0.2 0.2 0.1"/></geometry></visual></link>
  <link name="upper"><visual><geometry><box size="0.1 0.1 0.5"/></geometry></visual></link>
  <link name="lower"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="bend" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""
SRDF = """<robot name="two"><group name="arm"><chain base_link="base" tip_link="lower"/></group>
<group_state name="up" group="arm"><joint name="turn" value="1"/><joint name="bend" value="0.5"/>
</group_state></robot>"""


class FakeStack:
    """The interfaces of move_group and a controller manager, with next to nothing behind."""

    def __init__(self):
        self.objects, self.attached, self.positions = {}, {}, {'turn': 0.0, 'bend': 0.0}
        self.state, self.contacts = 'active', []
        self.planned, self.release = threading.Event(), threading.Event()
        self.matrix, self.paused, self.octomap = None, False, None
        self._tick = Future()
        self._context = Context()
        rclpy.init(args=[], context=self._context,
                   signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node('fake', context=self._context)
        self._node.declare_parameter('gain', 1.5)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._make()
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def close(self):
        """Leave the graph."""
        self._context.try_shutdown()
        self._thread.join(5.0)
        destroy_node(self._node)

    def _spin(self):
        with contextlib.suppress(ExternalShutdownException):
            self._executor.spin()

    def _make(self):
        node, group = self._node, ReentrantCallbackGroup()
        for topic, text in (('/robot_description', URDF), ('/robot_description_semantic', SRDF)):
            node.create_publisher(String, topic, qos.LATCHED).publish(String(data=text))
        for kind, name, answer in (
                (GetPlanningScene, '/get_planning_scene', self._scene),
                (ApplyPlanningScene, '/apply_planning_scene', self._apply),
                (GetStateValidity, '/check_state_validity', self._valid),
                (GetCartesianPath, '/compute_cartesian_path', self._straight),
                (GetPositionIK, '/compute_ik', lambda _, response: response),
                (Empty, '/clear_octomap', self._clear_octomap),
                (QueryPlannerInterfaces, '/query_planner_interface', lambda _, answer: answer),
                (ListControllers, '/arm/controller_manager/list_controllers', self._list),
                (SwitchController, '/arm/controller_manager/switch_controller', self._switch)):
            node.create_service(kind, name, answer, callback_group=group)
        self._servers = [
            ActionServer(node, MoveGroup, '/move_action', self._plan, callback_group=group,
                         cancel_callback=lambda _: CancelResponse.ACCEPT),
            ActionServer(node, ExecuteTrajectory, '/execute_trajectory', self._execute,
                         callback_group=group,
                         cancel_callback=lambda _: CancelResponse.ACCEPT)]
        node.create_publisher(JointTrajectoryControllerState, '/arm/controller_state', 10)
        self._states = node.create_publisher(JointState, '/arm/joint_states', qos.STATE)
        self._scenes = node.create_publisher(PlanningScene, '/monitored_planning_scene', 10)
        node.create_timer(0.05, self._tell)

    def pause(self):
        """Behave as a simulation whose time does not pass: joint states come on request alone."""
        self.paused = True
        self._node.create_publisher(Clock, '/clock', 1)
        for kind, name, answer in (
                (GetSimulationState, '/get_simulation_state', self._simulation),
                (Trigger, '/simulation/sync', self._sync)):
            self._node.create_service(kind, name, answer)

    def refuse(self, reason):
        """Publish that a change of the scene was refused."""
        self._node.create_publisher(String, '/rejected_scene_changes', qos.EVENTS).publish(
            String(data=reason))

    def _simulation(self, _, response):
        response.state.state = SimulationState.STATE_PAUSED
        return response

    def _sync(self, _, response):
        self._publish()
        response.success = True
        return response

    def _scene(self, _, response):
        state = response.scene.robot_state
        state.joint_state.name = list(self.positions)
        state.joint_state.position = list(self.positions.values())
        state.attached_collision_objects = list(self.attached.values())
        response.scene.world.collision_objects = list(self.objects.values())
        response.scene.world.octomap = self.octomap or OctomapWithPose()
        return response

    def _clear_octomap(self, _, response):
        self.octomap = None
        return response

    def _apply(self, request, response):
        for item in request.scene.world.collision_objects:
            if item.operation == CollisionObject.REMOVE:
                self.objects.pop(item.id, None)
            elif item.operation == CollisionObject.MOVE:
                self.objects[item.id].pose = item.pose
            else:
                self.objects[item.id] = item
        for item in request.scene.robot_state.attached_collision_objects:
            if item.object.operation == CollisionObject.REMOVE:
                self.objects[item.object.id] = self.attached.pop(item.object.id).object
            else:
                item.object = self.objects.pop(item.object.id)
                item.object.header.frame_id = item.link_name
                self.attached[item.object.id] = item
        if request.scene.allowed_collision_matrix.entry_names:
            self.matrix = request.scene.allowed_collision_matrix
        response.success = True
        return response

    def _valid(self, _, response):
        response.valid = not self.contacts
        response.contacts = [ContactInformation(contact_body_1=one, contact_body_2=other)
                             for one, other in self.contacts]
        return response

    async def _straight(self, _, response):
        while not self.planned.is_set():
            await self._tick
        return response

    def _list(self, _, response):
        response.controller = [ControllerState(
            name='arm', type='joint_trajectory_controller/JointTrajectoryController',
            state=self.state, required_command_interfaces=['turn/position', 'bend/position'])]
        return response

    def _switch(self, request, response):
        self.state = 'active' if request.activate_controllers else 'inactive'
        response.ok = True
        return response

    async def _plan(self, handle):
        result = MoveGroup.Result()
        while not handle.is_cancel_requested and not self.planned.is_set():
            await self._tick
        if handle.is_cancel_requested:
            result.error_code.val = MoveItErrorCodes.PREEMPTED
            handle.canceled()
            return result
        names = [each.joint_name
                 for each in handle.request.request.goal_constraints[0].joint_constraints]
        target = [each.position
                  for each in handle.request.request.goal_constraints[0].joint_constraints]
        trajectory = result.planned_trajectory.joint_trajectory
        trajectory.joint_names = names
        for time, positions in ((0, [self.positions[name] for name in names]), (2, target)):
            point = JointTrajectoryPoint(positions=positions)
            point.time_from_start.sec = time
            trajectory.points.append(point)
        if not handle.request.planning_options.plan_only:
            self._arrive(trajectory)
        result.error_code.val = 1
        handle.succeed()
        return result

    def _arrive(self, trajectory):
        self.positions.update(zip(trajectory.joint_names, trajectory.points[-1].positions,
                                  strict=True))

    def _tell(self):
        tick, self._tick = self._tick, Future()
        tick.set_result(None)
        if not self.paused:
            self._publish()
        if self.octomap is not None:
            scene = PlanningScene(is_diff=True)
            scene.world.octomap = self.octomap
            self._scenes.publish(scene)

    def _publish(self):
        self._states.publish(JointState(name=list(self.positions),
                                        position=list(self.positions.values())))

    async def _execute(self, handle):
        result = ExecuteTrajectory.Result()
        while not handle.is_cancel_requested and not self.release.is_set():
            await self._tick
        if handle.is_cancel_requested:
            handle.canceled()
            return result
        trajectory = handle.request.trajectory.joint_trajectory
        self._arrive(trajectory)
        result.error_code.val = 1
        handle.succeed()
        return result


@pytest.fixture(scope='module')
def fake_stack():
    """Serve the interfaces in this process."""
    fake = FakeStack()
    fake.planned.set()
    fake.release.set()
    yield fake
    fake.close()
