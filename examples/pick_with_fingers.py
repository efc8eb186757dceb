# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Pick a cube from the floor with two fingers, carry it, put it down, and go back.

An ordinary client: it uses only rclpy and the standard interfaces. The planning scene has
the pose of the cube, and whether it is held; the simulation updates both.

    armsim bringup robot:=panda
    python examples/pick_with_fingers.py --robot panda --from 0.42 0.1 0.3 --to 0.35 -0.25 0.0

The panda's hand is driven by the action GripperCommand, which presses with an effort and reports
when it has stalled. ROBOT's fingers have a trajectory controller: ``--fingers`` names its joints.
The other options adapt it to another arm.
"""

import argparse
import math
import sys
import time

from action_msgs.msg import GoalStatus
from control_msgs.action import FollowJointTrajectory, GripperCommand
from geometry_msgs.msg import Pose, PoseStamped, Quaternion
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import (
    Constraints,
    JointConstraint,
    MoveItErrorCodes,
    OrientationConstraint,
    PlanningSceneComponents,
    PositionConstraint,
)
from moveit_msgs.srv import GetCartesianPath, GetPlanningScene
import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node
from shape_msgs.msg import SolidPrimitive
from simulation_interfaces.srv import DeleteEntity, SpawnEntity
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

SIZE, MASS = 0.05, 0.2
#: SDF takes 1 kg*m^2 where none is given, and what is so hard to turn twists out of the fingers.
INERTIA = MASS * SIZE**2 / 6.0
CUBE = f"""<sdf version="1.9"><model name="cube"><link name="link">
  <inertial><mass>{MASS}</mass>
    <inertia><ixx>{INERTIA}</ixx><iyy>{INERTIA}</iyy><izz>{INERTIA}</izz></inertia></inertial>
  <collision name="c"><geometry><box><size>{SIZE} {SIZE} {SIZE}</size></box></geometry></collision>
  <visual name="v"><geometry><box><size>{SIZE} {SIZE} {SIZE}</size></box></geometry>
    <material><diffuse>0.9 0.3 0.1 1</diffuse></material></visual>
</link></model></sdf>"""
#: Robot -> its options.
ROBOTS = {
    'ROBOT': {
        'group': 'arm', 'link': 'tool', 'frame': 'base_link',
        'joints': [f'j{number}' for number in range(1, 7)],
        'home': [0.0, -0.4, 1.5, 0.0, 0.5, 0.0],
        'gripper': '/ROBOT/ROBOT_gripper_controller', 'fingers': ['finger_j1', 'finger_j2'],
    },
    'panda': {
        'group': 'panda_arm', 'link': 'panda_hand_tcp', 'frame': 'panda_link0',
        'joints': [f'panda_joint{number}' for number in range(1, 8)],
        'home': [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
        'gripper': '/panda_hand_controller', 'fingers': [],
    },
}
#: How far above the cube the hand begins to go straight down, and how far it lifts [m].
ABOVE = 0.12


class MissError(Exception):
    """Why the cube is not where it should be."""


class Hand:
    """An arm with a hand, known by its interfaces."""

    def __init__(self, node, options):
        self.node, self.options = node, options
        self.move = self._action(MoveGroup, '/move_action')
        self.execute = self._action(ExecuteTrajectory, '/execute_trajectory')
        kind, name = (FollowJointTrajectory, 'follow_joint_trajectory') if options.fingers else (
            GripperCommand, 'gripper_cmd')
        self.gripper = self._action(kind, f'{options.gripper}/{name}')
        self.services = {}

    def _action(self, kind, name):
        client = ActionClient(self.node, kind, name)
        if not client.wait_for_server(timeout_sec=self.options.timeout):
            sys.exit(f'no action server {name}: is the bringup running, with this robot?')
        return client

    def wait(self, future, what):
        """Return a future's result."""
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=self.options.timeout)
        if not future.done():
            raise MissError(f'no {what} within {self.options.timeout:g} s')
        return future.result()

    def call(self, kind, name, request):
        """Call a service."""
        if name not in self.services:
            self.services[name] = self.node.create_client(kind, name)
            if not self.services[name].wait_for_service(timeout_sec=self.options.timeout):
                sys.exit(f'no service {name}: is the bringup running?')
        return self.wait(self.services[name].call_async(request), f'answer of {name}')

    def run(self, action, goal, what):
        """Send a goal and return its status and result."""
        handle = self.wait(action.send_goal_async(goal), f'answer to the goal: {what}')
        if not handle.accepted:
            raise MissError(f'{what}: the goal was refused')
        answer = self.wait(handle.get_result_async(), f'result: {what}')
        return answer.status, answer.result

    def go(self, constraints, what):
        """Plan a motion around everything, and execute it."""
        goal = MoveGroup.Goal()
        request = goal.request
        request.group_name = self.options.group
        request.num_planning_attempts = 1
        request.allowed_planning_time = 5.0
        request.max_velocity_scaling_factor = request.max_acceleration_scaling_factor = 0.5
        request.start_state.is_diff = True
        request.goal_constraints = [constraints]
        goal.planning_options.planning_scene_diff.is_diff = True
        goal.planning_options.planning_scene_diff.robot_state.is_diff = True
        _, result = self.run(self.move, goal, what)
        check(result.error_code, what)
        print(what)

    def go_to_pose(self, pose, what):
        """Move the hand to a pose."""
        link, frame = self.options.link, self.options.frame
        position = PositionConstraint(link_name=link, weight=1.0)
        position.header.frame_id = frame
        position.constraint_region.primitives = [
            SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[1e-3])]
        position.constraint_region.primitive_poses = [
            Pose(position=pose.position, orientation=Quaternion(w=1.0))]
        turn = OrientationConstraint(
            link_name=link, orientation=pose.orientation, weight=1.0,
            absolute_x_axis_tolerance=0.01, absolute_y_axis_tolerance=0.01,
            absolute_z_axis_tolerance=0.01)
        turn.header.frame_id = frame
        self.go(Constraints(position_constraints=[position], orientation_constraints=[turn]), what)

    def go_straight(self, pose, what, *, avoid=False):
        """
        Move the hand along a line.

        :param avoid: whether nothing may be touched; what is lifted lies on something at first.
        """
        request = GetCartesianPath.Request(
            group_name=self.options.group, link_name=self.options.link, waypoints=[pose],
            max_step=0.005, avoid_collisions=avoid, max_velocity_scaling_factor=0.3,
            max_acceleration_scaling_factor=0.3)
        request.header.frame_id = self.options.frame
        request.start_state.is_diff = True
        path = self.call(GetCartesianPath, '/compute_cartesian_path', request)
        if path.fraction < 0.999:
            raise MissError(f'{what}: only {path.fraction:.0%} of the line can be followed')
        _, result = self.run(
            self.execute, ExecuteTrajectory.Goal(trajectory=path.solution), what)
        check(result.error_code, what)
        print(what)

    def move_fingers(self, position, what):
        """Open the fingers, or close them until something is between them."""
        if self.options.fingers:
            point = JointTrajectoryPoint(positions=[position] * len(self.options.fingers))
            point.time_from_start.sec = 1
            goal = FollowJointTrajectory.Goal(trajectory=JointTrajectory(
                joint_names=self.options.fingers, points=[point]))
        else:
            goal = GripperCommand.Goal()
            goal.command.position, goal.command.max_effort = position, self.options.effort
        status, result = self.run(self.gripper, goal, what)
        held = getattr(result, 'stalled', False)
        if status != GoalStatus.STATUS_SUCCEEDED and not held:
            raise MissError(f'{what}: {getattr(result, "error_string", "")} (status {status})')
        print(what)

    def scene(self):
        """Return the poses of the objects in the world, and the names of those that are held."""
        wanted = (PlanningSceneComponents.WORLD_OBJECT_GEOMETRY
                  | PlanningSceneComponents.ROBOT_STATE_ATTACHED_OBJECTS)
        request = GetPlanningScene.Request(components=PlanningSceneComponents(components=wanted))
        scene = self.call(GetPlanningScene, '/get_planning_scene', request).scene
        held = {each.object.id for each in scene.robot_state.attached_collision_objects}
        return {each.id: each.pose for each in scene.world.collision_objects}, held

    def until(self, holds, complaint):
        """Read the scene until a condition holds; return its value."""
        end = time.monotonic() + self.options.patience
        while not (found := holds(*self.scene())):
            if time.monotonic() > end:
                raise MissError(complaint)
            rclpy.spin_once(self.node, timeout_sec=0.1)
        return found


def check(code, what):
    """Complain where a motion failed."""
    if code.val != MoveItErrorCodes.SUCCESS:
        raise MissError(f'{what}: error {code.val}: {code.message}')


def downwards(position, yaw, height):
    """Return a pose above a point that looks down, the fingers turned by an angle."""
    pose = Pose(orientation=Quaternion(x=-math.sin(0.5 * yaw), y=math.cos(0.5 * yaw), w=0.0))
    pose.position.x, pose.position.y = float(position[0]), float(position[1])
    pose.position.z = float(position[2]) + height
    return pose


def put_cube(hand, place):
    """Put the cube on the floor."""
    x, y, yaw = place
    hand.call(DeleteEntity, '/delete_entity', DeleteEntity.Request(entity='cube'))
    hand.until(lambda objects, held: 'cube' not in {*objects, *held},
               'the cube of before does not leave the scene')
    request = SpawnEntity.Request(name='cube', resource_string=CUBE, initial_pose=PoseStamped())
    pose = request.initial_pose.pose
    pose.position.x, pose.position.y, pose.position.z = x, y, 0.5 * SIZE
    pose.orientation = Quaternion(z=math.sin(0.5 * yaw), w=math.cos(0.5 * yaw))
    result = hand.call(SpawnEntity, '/spawn_entity', request).result
    if result.result != result.RESULT_OK:
        raise MissError(f'the cube cannot be spawned: {result.error_message}')


def pick_and_place(hand, options):
    """Do it, and complain where it does not succeed."""
    put_cube(hand, options.start)
    pose = hand.until(lambda objects, _: objects.get('cube'), 'the cube is not in the scene')
    at = pose.position.x, pose.position.y, pose.position.z
    yaw = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
    # A cube looks alike after a quarter of a turn: the hand turns as little as it can.
    yaw = math.remainder(yaw, 0.5 * math.pi)
    print(f'the cube is at {at[0]:.3f} {at[1]:.3f} {at[2]:.3f}, turned by {yaw:.2f} rad')
    hand.move_fingers(options.open, 'fingers open')
    hand.go_to_pose(downwards(at, yaw, ABOVE), 'above the cube')
    hand.go_straight(downwards(at, yaw, 0.0), 'down', avoid=True)
    hand.move_fingers(options.closed, 'fingers closed')
    hand.until(lambda _, held: 'cube' in held, 'the fingers have closed and hold nothing')
    hand.go_straight(downwards(at, yaw, ABOVE), 'lifted')
    target = *options.end[:2], at[2]
    yaw = math.remainder(options.end[2], 0.5 * math.pi)
    hand.go_to_pose(downwards(target, yaw, ABOVE), 'carried')
    if 'cube' not in hand.scene()[1]:
        raise MissError('the cube was lost on the way')
    # A millimetre above the floor: what is let go falls, what is pressed down is thrown.
    hand.go_straight(downwards(target, yaw, 1e-3), 'down')
    hand.move_fingers(options.open, 'released')
    pose = hand.until(lambda objects, held: 'cube' not in held and objects.get('cube'),
                      'the fingers are open and the cube is still held')
    hand.go_straight(downwards(target, yaw, ABOVE), 'away')
    hand.go(Constraints(joint_constraints=[
        JointConstraint(joint_name=name, position=float(value), tolerance_above=1e-3,
                        tolerance_below=1e-3, weight=1.0)
        for name, value in zip(options.joints, options.home, strict=True)]), 'back')
    pose = hand.scene()[0]['cube']
    aside = math.dist((pose.position.x, pose.position.y, pose.position.z), target)
    if aside > options.tolerance:
        raise MissError(f'the cube lies {aside * 1e3:.0f} mm from its target')
    print(f'the cube lies {aside * 1e3:.1f} mm from its target')


def main():
    """Read the options, pick, and end with 1 and a reason on a miss."""
    parser = argparse.ArgumentParser(
        description='Pick a cube with two fingers.',
        formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    place = {'nargs': 3, 'type': float, 'metavar': ('X', 'Y', 'YAW')}
    parser.add_argument('--from', dest='start', default=[0.42, 0.1, 0.3], **place, help='[m, rad]')
    parser.add_argument('--to', dest='end', default=[0.35, -0.25, 0.0], **place, help='[m, rad]')
    parser.add_argument('--robot', choices=ROBOTS, default='ROBOT', help='whose options hold')
    parser.add_argument('--group', help='planning group')
    parser.add_argument('--link', help='link between the fingers, z outwards')
    parser.add_argument('--frame', help='planning frame')
    parser.add_argument('--joints', nargs='+', help='of the arm')
    parser.add_argument('--home', nargs='+', type=float, help='where the arm ends [rad]')
    parser.add_argument('--gripper', help='its controller')
    parser.add_argument('--fingers', nargs='*',
                        help='joints of FollowJointTrajectory; none: GripperCommand')
    parser.add_argument('--open', type=float, default=0.04, help='of each finger [m]')
    parser.add_argument('--closed', type=float, default=0.0, help='of each finger [m]')
    parser.add_argument('--effort', type=float, default=15.0, help='of GripperCommand [N]')
    parser.add_argument('--tolerance', type=float, default=0.02, help='of the end [m]')
    parser.add_argument('--patience', type=float, default=10.0, help='for the scene [s]')
    parser.add_argument('--timeout', type=float, default=60.0, help='[s] for each answer')
    parser.set_defaults(**ROBOTS[parser.parse_known_args()[0].robot])
    options = parser.parse_args()
    rclpy.init()
    try:
        pick_and_place(Hand(Node('pick_with_fingers'), options), options)
    except MissError as reason:
        sys.exit(f'missed: {reason}')
    rclpy.shutdown()


if __name__ == '__main__':
    main()
