# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A script that ends in some way: plain, shutdown, error, or with Ctrl-C in plan or execute.

    script.py WAY --ros-args --params-file PARAMETERS.yaml
"""

import os
import signal
import sys
import threading
import time

from geometry_msgs.msg import Pose
from moveit_msgs.msg import CollisionObject
import rclpy
from shape_msgs.msg import SolidPrimitive

from moveit.planning import MoveItPy, PlanRequestParameters

way = sys.argv[1]
# As in a terminal; background jobs of a shell ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
# Its own rclpy is initialized before, after, or never.
if way not in ('plain', 'error'):
    rclpy.init()
moveit = MoveItPy()
if way == 'error':
    rclpy.init()
arm = moveit.get_planning_component('panda_arm')
state = arm.get_start_state()
state.joint_positions = {'panda_joint1': state.joint_positions['panda_joint1'] + 0.5}
arm.set_goal_state(robot_state=state)


def walls():
    """Return the message of two walls beside the robot and a roof above it."""
    made = CollisionObject(id='walls', operation=CollisionObject.ADD)
    made.header.frame_id = 'panda_link0'
    for size, place in (((2.0, 0.02, 2.0), (0.0, 0.25, 1.0)),
                        ((2.0, 0.02, 2.0), (0.0, -0.25, 1.0)),
                        ((2.0, 0.6, 0.02), (0.0, 0.0, 0.9))):
        made.primitives.append(SolidPrimitive(type=SolidPrimitive.BOX, dimensions=size))
        pose = Pose()
        pose.position.x, pose.position.y, pose.position.z = place
        made.primitive_poses.append(pose)
    return made


def interrupt():
    """Press Ctrl-C while a function of MoveItPy waits."""
    waiting.wait()
    time.sleep(0.2)
    moment.append(time.monotonic())
    os.kill(os.getpid(), signal.SIGINT)


waiting, moment = threading.Event(), []
parameters = PlanRequestParameters(moveit, '')
try:
    if way == 'plan':
        # A long search: there are walls on both sides and above.
        with moveit.get_planning_scene_monitor().read_write() as scene:
            scene.apply_collision_object(walls())
            state.set_to_default_values('panda_arm', 'ready')
            scene.current_state = state
        arm.set_start_state(robot_state=state)
        state.joint_positions = {'panda_joint1': 2.8}
        arm.set_goal_state(robot_state=state)
        parameters.planning_time = 30.0
        threading.Thread(target=interrupt, daemon=True).start()
        waiting.set()
    result = arm.plan(parameters)
    assert result, result.error_code.message
    if way == 'execute':
        threading.Thread(target=interrupt, daemon=True).start()
        waiting.set()
        moveit.execute(result.trajectory, [])
    if way in ('plan', 'execute'):
        sys.exit('no interrupt')
except KeyboardInterrupt:
    print(f'interrupted after {time.monotonic() - moment[0]:.3f} s')
    assert not rclpy.ok()
if way == 'shutdown':
    moveit.shutdown()
    assert rclpy.ok()
    rclpy.shutdown()
if way == 'error':
    raise ZeroDivisionError
print('the end')
