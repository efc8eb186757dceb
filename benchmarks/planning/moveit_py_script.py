# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The script that is measured: ``moveit_py_script.py PARAMETERS.json TIME_OF_ITS_START``."""

from __future__ import annotations

from collections.abc import Callable
import json
from pathlib import Path
from statistics import median
import sys
import time

from moveit_msgs.srv import GetMotionPlan

from armsim_ros.clients.ros_client import RosClient
from moveit.core.robot_state import RobotState
from moveit.planning import MoveItPy, PlanningComponent, PlanRequestParameters

PLANS, CALLS = 20, 2000


def main(file: str, began: float) -> None:
    """Print the measurements as JSON."""
    moveit = MoveItPy(config_dict=json.loads(Path(file).read_text(encoding='utf-8')))
    arm = moveit.get_planning_component('panda_arm')
    arm.set_goal_state(configuration_name='extended')
    first = arm.plan()
    found = {'first_plan': time.time() - began}
    moveit.execute(first.trajectory, [])
    arm.set_start_state_to_current_state()
    arm.set_goal_state(configuration_name='ready')
    moveit.execute(arm.plan().trajectory, [])
    found['memory'] = resident()
    found.update(plans(moveit, arm))
    found.update(states(moveit))
    moveit.shutdown()
    print(json.dumps(found))


def plans(moveit: MoveItPy, arm: PlanningComponent) -> dict[str, float]:
    """Return the times of plans [ms], here and of move_group, and how many are equal."""
    start = RobotState(moveit.get_robot_model())
    start.set_to_default_values('panda_arm', 'ready')
    arm.set_start_state(robot_state=start)
    # The simulated world is in the scene of move_group alone.
    moveit.get_planning_scene_monitor().request_planning_scene_state('/get_planning_scene')
    ours, theirs, same = [], [], 0
    with RosClient('measures') as client:
        client.prepare(GetMotionPlan, '/plan_kinematic_path')
        while not client.serves(GetMotionPlan, '/plan_kinematic_path'):
            time.sleep(0.05)
        for number in range(PLANS):
            goal = start.__copy__()
            goal.joint_positions = {
                'panda_joint1': 0.1 * (number - 10), 'panda_joint2': 0.02 * number}
            arm.set_goal_state(robot_state=goal)
            request = GetMotionPlan.Request(
                motion_plan_request=arm._request(PlanRequestParameters(moveit, ''), None))
            began = time.perf_counter()
            answer = client.call(GetMotionPlan, '/plan_kinematic_path', request).result()
            between = time.perf_counter()
            plan = arm.plan().trajectory
            ours.append(1000.0 * (time.perf_counter() - between))
            theirs.append(1000.0 * (between - began))
            if plan is not None:
                same += plan.get_robot_trajectory_msg() == answer.motion_plan_response.trajectory
    return {'plan': median(ours), 'move_group': median(theirs), 'same': same}


def states(moveit: MoveItPy) -> dict[str, float]:
    """Return the processor time of questions about a state [us]."""
    state = RobotState(moveit.get_robot_model())
    state.set_to_default_values('panda_arm', 'ready')
    pose = state.get_pose('panda_link8')

    def turn() -> None:
        state.joint_positions = {'panda_joint1': state.joint_positions['panda_joint1'] + 1e-4}

    def turn_and_check() -> None:
        turn()
        scene.is_state_colliding(state, 'panda_arm')

    def move() -> None:
        pose.position.z -= 1e-5
        assert state.set_from_ik('panda_arm', pose, 'panda_link8')

    with moveit.get_planning_scene_monitor().read_only() as scene:
        found = {
            'colliding': timed(lambda: scene.is_state_colliding(state, 'panda_arm')),
            'transform': timed(lambda: state.get_global_link_transform('panda_link8')),
        }
        both = timed(turn_and_check)
    found['colliding'] = max(found['colliding'], both - timed(turn))
    found['ik'] = timed(move)
    return found


def timed(work: Callable[[], object]) -> float:
    """Return the processor time of a call [us]."""
    work()
    began = time.thread_time()
    for _ in range(CALLS):
        work()
    return 1e6 * (time.thread_time() - began) / CALLS


def resident() -> float:
    """Return the resident memory of this process [MiB]."""
    text = Path('/proc/self/status').read_text(encoding='ascii')
    return int(text.partition('VmRSS:')[2].split()[0]) / 1024.0


if __name__ == '__main__':
    main(sys.argv[1], float(sys.argv[2]))
