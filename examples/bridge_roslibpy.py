# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Move the arm from Python without ROS.

    pip install roslibpy
    armsim bringup bridge:=true
    python examples/bridge_roslibpy.py

Reads the joints, plans with move_group through the bridge, executes, and reads them again. The
first argument is another port.
"""

import sys
import threading

import roslibpy

TARGET = {'joint_1': 0.5, 'joint_2': -0.4}
PATIENCE = 30.0


def joints(ros):
    """Return the position of each joint [rad]."""
    got, found = threading.Event(), {}

    def receive(message):
        found.update(zip(message['name'], message['position'], strict=False))
        got.set()

    topic = roslibpy.Topic(ros, '/sunday/joint_states', 'sensor_msgs/JointState')
    topic.subscribe(receive)
    assert got.wait(PATIENCE), 'no joint states'
    topic.unsubscribe()
    return found


def move(ros, target):
    """Plan and execute; return the action's status and the error code."""
    action = roslibpy.ActionClient(ros, '/move_action', 'moveit_msgs/action/MoveGroup')
    constraints = [{'joint_name': name, 'position': position, 'tolerance_above': 1e-3,
                    'tolerance_below': 1e-3, 'weight': 1.0} for name, position in target.items()]
    goal = roslibpy.Goal({'request': {
        'group_name': 'manipulator', 'allowed_planning_time': 5.0,
        'goal_constraints': [{'joint_constraints': constraints}]}})
    done, answers = threading.Event(), []

    def answer(result):
        answers.append(result)
        done.set()

    action.send_goal(goal, answer, lambda feedback: print(feedback['state']), answer)
    assert done.wait(PATIENCE), 'no result'
    return answers[0]['status'], answers[0]['values']['error_code']['val']


def main():
    """Move, and return 0 where the arm has arrived."""
    port = int(sys.argv[1]) if len(sys.argv) > 1 else 9090
    ros = roslibpy.Ros('127.0.0.1', port)
    ros.run()
    before = joints(ros)
    target = {**before, **TARGET}
    status, code = move(ros, target)
    after = joints(ros)
    ros.terminate()
    error = max(abs(after[name] - position) for name, position in target.items())
    print(f'status {status.name}, error code {code}, {error * 1e3:.1f} mrad from the target')
    return 0 if code == 1 and error < 0.01 else 1


if __name__ == '__main__':
    sys.exit(main())
