# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Find the cube in the depth image, pick it with the suction cup, place it elsewhere, go back.

A plain client of camera topics, pymoveit2 and two services of the gripper. It calls the
simulation only to check the result and to place the cube before each further run.

    armsim bringup camera:=true            # in one terminal
    python examples/grasp.py --runs 10     # in a second terminal
"""

import argparse
from contextlib import suppress
import math
import random
import sys
import threading
import time

from geometry_msgs.msg import Pose
import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, Image
from simulation_interfaces.msg import EntityState, Result
from simulation_interfaces.srv import GetEntityState, ResetSimulation, SetEntityState
from std_msgs.msg import Bool
from std_srvs.srv import Empty

try:
    from pymoveit2 import MoveIt2, RobotDescription
except ModuleNotFoundError:
    sys.exit('this example needs pymoveit2; in the environment: python -m pip install pymoveit2')

LOOK, GRIPPER, OPTICAL = 'scan_food', '/sunday/vacuum_gripper', 'camera_color_optical_frame'
#: From the origin of the last link to the rim of the cup, and from there to the cube [m].
RIM, GAP = 0.005, 0.015
ABOVE, DROP = 0.08, 0.015
#: Where the cube goes [m].
PLACE = (0.28, -0.10)
#: The cube is laid out in here, free of the other objects [m].
FIELD = ((0.17, 0.22), (0.21, 0.26))
CELL = 0.004
TIMEOUT = 120.0


class MissError(Exception):
    """A run that cannot go on; the text names the cause."""


class Grasper:
    """The arm, its eye and its hand; the executor spins in another thread."""

    def __init__(self, node, executor):
        self.node, self.executor, self.clients = node, executor, {}
        self.description = RobotDescription.from_node(node)
        words = {**self.description.moveit2_kwargs(), 'base_link_name': 'world'}
        self.arm = MoveIt2(node=node, **words)
        self.arm.max_velocity = self.arm.max_acceleration = 0.5
        self.arm.allowed_planning_time = 5.0
        self.held = None
        self.changed = threading.Condition()
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(Bool, f'{GRIPPER}/grasping', self.on_grasping, latched)

    def on_grasping(self, message):
        """Take the state of the gripper."""
        with self.changed:
            self.held = message.data
            self.changed.notify_all()

    def call(self, kind, service, **request):
        """Call a service and return its response."""
        if service not in self.clients:
            self.clients[service] = self.node.create_client(kind, service)
        client, done = self.clients[service], threading.Event()
        if not client.wait_for_service(TIMEOUT):
            raise MissError(f'there is no service {service}')
        future = client.call_async(kind.Request(**request))
        future.add_done_callback(lambda _: done.set())
        if not done.wait(TIMEOUT):
            raise MissError(f'{service} does not answer')
        return future.result()

    def go(self, state):
        """Move to a named state."""
        self.finish(self.arm.move_to_configuration(self.description.joint_positions(state)), state)

    def move(self, what, x, y, z, turn, *, straight=False):
        """Move the last link to a place in the world [m]."""
        for _ in range(5):
            begun = self.arm.move_to_pose(
                position=(x, y, z), quat_xyzw=turn, tolerance_position=0.001,
                tolerance_orientation=0.01, cartesian=straight, cartesian_fraction_threshold=0.9)
            if begun:
                break
            time.sleep(0.3)  # the planning scene is a moment behind what was grasped or let go
        self.finish(begun, what)

    def finish(self, begun, what):
        """Wait for the end of a motion."""
        if not begun or not self.arm.wait_until_executed(TIMEOUT):
            raise MissError(f'{what}: {self.arm.last_failure() or "the motion did not end"}')

    def suck(self, word, held):
        """Switch the vacuum and wait until something is held, or nothing any more."""
        self.call(Empty, f'{GRIPPER}/{word}')
        with self.changed:
            if not self.changed.wait_for(lambda: self.held is held, TIMEOUT):
                state = 'nothing is held' if held else 'it still holds'
                raise MissError(f'vacuum {word}: {state}')

    def look(self):
        """Return the points (n, 3) in the world that the camera sees from here on."""
        info = self.first(CameraInfo, '/camera/depth/camera_info', lambda _: True)
        here = stamp(self.arm.joint_state)
        image = self.first(Image, '/camera/depth/image_raw', lambda message: stamp(message) > here)
        depth = np.frombuffer(image.data, np.float32).reshape(image.height, image.width)
        lines, columns = np.nonzero(np.isfinite(depth))
        z = depth[lines, columns].astype(float)
        seen = np.column_stack([(columns - info.k[2]) / info.k[0] * z,
                                (lines - info.k[5]) / info.k[4] * z, z])
        frame = self.arm.compute_fk(fk_link_names=[OPTICAL])
        if not frame:
            raise MissError('the pose of the camera is not known')
        return seen @ rotation(frame[0].pose).T + vector(frame[0].pose.position)

    def first(self, kind, topic, fits):
        """Return the first message that fits; the camera draws while a client listens."""
        found, arrived = [], threading.Event()

        def take(message):
            if not found and fits(message):
                found.append(message)
                arrived.set()

        subscription = self.node.create_subscription(kind, topic, take, 2)
        try:
            if not arrived.wait(TIMEOUT):
                raise MissError(f'no message on {topic}: start bringup with camera:=true')
            return found[0]
        finally:  # in the thread that waits for it
            self.executor.create_task(self.node.destroy_subscription, subscription)

    def grasp(self):
        """Do it all once; what did not come up with the cup is tried once more."""
        try:
            table, top, turn = self.pick()
        except MissError as miss:
            print(f'once more: {miss}')
            self.suck('off', False)
            table, top, turn = self.pick()
        self.move('above the place', *PLACE, top + ABOVE, turn)
        self.move('down to the place', *PLACE, top + RIM + DROP, turn, straight=True)
        self.suck('off', False)
        self.move('leaving', *PLACE, top + ABOVE, turn, straight=True)
        self.go(LOOK)
        return table

    def pick(self):
        """Look, and lift the cube; return heights of table and top, and how the cup is turned."""
        self.go(LOOK)
        table, (x, y), top = find_cube(self.look())
        print(f'the cube is at ({x:.3f}, {y:.3f}), its top at {top:.3f}')
        pose = self.arm.compute_fk().pose.orientation
        turn = (pose.x, pose.y, pose.z, pose.w)
        self.move('above the cube', x, y, top + ABOVE, turn)
        self.move('down to the cube', x, y, top + GAP + RIM, turn, straight=True)
        self.suck('on', True)
        self.move('lifting', x, y, top + ABOVE, turn, straight=True)
        return table, top, turn

    def check(self, table):
        """Ask the simulation where the cube is."""
        state = self.call(GetEntityState, '/get_entity_state', entity='cube').state
        x, y, z = vector(state.pose.position)
        distance = math.dist((x, y), PLACE)
        if distance > 0.02 or not 0.0 < z - table < 0.03:
            raise MissError(f'the cube ended at ({x:.3f}, {y:.3f}, {z:.3f}), {distance:.3f} m off')
        print(f'the cube lies {distance * 1e3:.0f} mm from its place')

    def lay_out(self, dice):
        """Reset the simulation and lay the cube elsewhere."""
        self.call(ResetSimulation, '/reset_simulation', scope=ResetSimulation.Request.SCOPE_STATE)
        (left, right), (near, far) = FIELD
        pose, angle = Pose(), dice.uniform(-math.pi, math.pi)
        pose.position.x, pose.position.y = dice.uniform(left, right), dice.uniform(near, far)
        pose.position.z = 1.03
        pose.orientation.z, pose.orientation.w = math.sin(angle / 2), math.cos(angle / 2)
        answer = self.call(SetEntityState, '/set_entity_state', entity='cube',
                           state=EntityState(pose=pose)).result
        if answer.result != Result.RESULT_OK:
            raise MissError(f'the cube was not laid out: {answer.error_message}')


def find_cube(points):
    """
    Return the height of the table, and centre (x, y) and top of what is most like a square.

    :param points: (n, 3) in the world [m].
    """
    heights = points[:, 2]
    levels, counts = np.unique((heights[heights > 0.5] / 0.005).round(), return_counts=True)
    if not len(levels):
        raise MissError('no table is visible')
    table = float(np.median(heights[np.abs(heights - levels[counts.argmax()] * 0.005) < 0.005]))
    objects = points[(heights > table + 0.01) & (heights < table + 0.1)]
    best = (0.0, None, None)
    for cloud in blobs(objects):
        top = float(np.median(cloud[cloud[:, 2] > cloud[:, 2].max() - 0.004, 2]))
        cells = np.unique((cloud[cloud[:, 2] > top - 0.004, :2] / CELL).round(), axis=0) * CELL
        if len(cells) < 100:
            continue
        share, centre = squareness(cells)
        if share > best[0]:
            best = share, centre, top
    if best[0] < 0.8:
        raise MissError('no cube is visible')
    return table, best[1], best[2]


def squareness(cells):
    """Return how much of its smallest rectangle a thing fills, and that one's centre."""
    best = (0.0, None)
    for angle in np.radians(np.arange(0, 90, 2)):
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        turned = cells @ turn
        low, high = turned.min(axis=0), turned.max(axis=0)
        sides = high - low + CELL
        share = len(cells) * CELL**2 / sides.prod() * sides.min() / sides.max()
        if share > best[0]:
            best = share, turn @ ((low + high) / 2)
    return best


def blobs(points):
    """Return the points of each thing: those whose cells touch each other from above."""
    cells = {}
    for number, cell in enumerate(map(tuple, (points[:, :2] / CELL).round().astype(int))):
        cells.setdefault(cell, []).append(number)
    while cells:
        edge, numbers = [next(iter(cells))], []
        while edge:
            x, y = edge.pop()
            numbers += cells.pop((x, y), [])
            edge += [(x + dx, y + dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)
                     if (x + dx, y + dy) in cells]
        yield points[numbers]


def stamp(message):
    """Return the time of a message [ns]."""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def vector(point):
    """Return a point as an array."""
    return np.array([point.x, point.y, point.z])


def rotation(pose):
    """Return the rotation matrix of a pose."""
    x, y, z, w = (getattr(pose.orientation, name) for name in 'xyzw')
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def spin(executor):
    """Spin until the end."""
    with suppress(ExternalShutdownException):
        executor.spin()


def main():
    """Grasp as often as requested; the status is 0 if nine of ten runs were hits."""
    parser = argparse.ArgumentParser(description='Grasp the cube that the camera sees.')
    parser.add_argument('--runs', type=int, default=1, help='each from another pose of the cube')
    parser.add_argument('--seed', type=int, default=0, help='of the poses')
    parser.add_argument('--joint-states', default='/sunday/joint_states', help='topic')
    arguments = parser.parse_args()
    rclpy.init(args=['--ros-args', '-r', f'joint_states:={arguments.joint_states}'])
    node = Node('grasp')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    thread = threading.Thread(target=spin, args=(executor,), daemon=True)
    thread.start()
    hits, dice = 0, random.Random(arguments.seed)
    try:
        grasper = Grasper(node, executor)
        for run in range(1, arguments.runs + 1):
            try:
                if arguments.runs > 1:
                    grasper.lay_out(dice)
                grasper.check(grasper.grasp())
                hits += 1
            except MissError as miss:
                print(f'run {run} missed: {miss}')
        print(f'{hits} of {arguments.runs} runs put the cube at its target')
    finally:
        executor.shutdown(1.0)
        thread.join(5.0)
        rclpy.try_shutdown()
    sys.exit(0 if hits >= 0.9 * arguments.runs else 1)


if __name__ == '__main__':
    main()
