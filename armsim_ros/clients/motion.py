# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Requests to move_group, what its answers mean in words, and the stop of every motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Future, wait
from typing import Any

from action_msgs.srv import CancelGoal
from geometry_msgs.msg import PoseStamped
from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import (
    Constraints,
    JointConstraint,
    MotionPlanRequest,
    MoveItErrorCodes,
    RobotState,
)
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from armsim_ros.arrays import Matrix
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.model.transforms import quat_xyzw_from_matrix

SUCCESS = MoveItErrorCodes.SUCCESS
#: How near to its goal a joint must come to count as there [rad or m].
GOAL_TOLERANCE = 1e-4
#: Code -> its name in MoveItErrorCodes.
CODE_NAMES = {
    getattr(MoveItErrorCodes, name): name
    for name in dir(MoveItErrorCodes)
    if name.isupper() and isinstance(getattr(MoveItErrorCodes, name), int)}
_SENTENCES = {
    'PLANNING_FAILED': 'no path was found in the planning time',
    'INVALID_MOTION_PLAN': 'the path that was found collides',
    'CONTROL_FAILED': 'a controller did not reach the goal or refused it',
    'TIMED_OUT': 'the time is over',
    'PREEMPTED': 'stopped',
    'START_STATE_IN_COLLISION': 'the start state is in collision',
    'GOAL_IN_COLLISION': 'the goal is in collision',
    'INVALID_GROUP_NAME': 'move_group does not know this planning group',
    'NO_IK_SOLUTION': 'no joint positions reach this pose',
    'MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE': 'something came into the way',
}


def robot_state(positions: Mapping[str, float] | None) -> RobotState:
    """Return a state that lays joint positions [rad or m] over the current state."""
    state = RobotState(is_diff=True)
    if positions:
        state.joint_state = JointState(name=list(positions),
                                       position=[float(q) for q in positions.values()])
    return state


def joint_goal(target: Mapping[str, float]) -> Constraints:
    """Return the goal of joint positions [rad or m]."""
    return Constraints(joint_constraints=[
        JointConstraint(joint_name=joint, position=float(value), weight=1.0,
                        tolerance_above=GOAL_TOLERANCE, tolerance_below=GOAL_TOLERANCE)
        for joint, value in target.items()])


def plan_goal(
    group: str, target: Mapping[str, float], *, start: Mapping[str, float] | None = None,
    speed: float = 1.0, acceleration: float = 1.0, pipeline: str = '', planner: str = '',
    planning_time: float = 5.0, plan_only: bool = True
) -> MoveGroup.Goal:
    """
    Return the goal of ``/move_action`` that leads a group to joint positions.

    :param target: joint -> [rad or m].
    :param start: where the motion begins; the current state where None.
    :param speed: share of the velocity limits, up to 1; 0 is the default of the robot's files.
    :param acceleration: share of the acceleration limits, likewise.
    :param planning_time: [s].
    """
    goal = MoveGroup.Goal()
    goal.request = MotionPlanRequest(
        group_name=group, pipeline_id=pipeline, planner_id=planner, num_planning_attempts=1,
        allowed_planning_time=float(planning_time), start_state=robot_state(start),
        max_velocity_scaling_factor=float(speed),
        max_acceleration_scaling_factor=float(acceleration),
        goal_constraints=[joint_goal(target)])
    goal.planning_options.plan_only = plan_only
    goal.planning_options.planning_scene_diff.is_diff = True
    goal.planning_options.planning_scene_diff.robot_state.is_diff = True
    return goal


def code_text(code: Any) -> str:
    """Return a ``MoveItErrorCodes`` as its name and a sentence."""
    name = CODE_NAMES.get(code.val, str(code.val))
    sentence = getattr(code, 'message', '') or _SENTENCES.get(name, '')
    return f'{name}: {sentence}' if sentence else name


def seconds(duration: Any) -> float:
    """Return a duration or time message in seconds."""
    return float(duration.sec) + 1e-9 * float(duration.nanosec)


def stamped_pose(frame: str, pose: Matrix) -> PoseStamped:
    """Return a pose (4, 4) in a frame as a message."""
    message = PoseStamped()
    message.header.frame_id = frame
    point, turn = message.pose.position, message.pose.orientation
    point.x, point.y, point.z = (float(part) for part in pose[:3, 3])
    turn.x, turn.y, turn.z, turn.w = (float(part) for part in quat_xyzw_from_matrix(pose))
    return message


_EVENT = '/trajectory_execution_event'
_CANCEL = '/_action/cancel_goal'
#: How long the event of a stop waits for the answers to its requests [s].
EVENT_LATEST = 0.2
_MOVING = ('control_msgs/action/', 'moveit_msgs/action/')


class Stopper:
    """
    Cancels every goal of every controller and of move_group.

    :param client: to the graph.
    """

    def __init__(self, client: RosClient) -> None:
        """Make the publisher, so that move_group has found it when it is needed."""
        self._client = client
        self._publisher = client.in_thread(
            lambda: client.node.create_publisher(String, _EVENT, 10)).result(5.0)

    def actions(self) -> list[str]:
        """Return the names of the actions whose goals move a robot and that have a server."""
        node = self._client.node
        return sorted(
            name.removesuffix('/_action/send_goal')
            for name, kinds in node.get_service_names_and_types()
            if name.endswith('/_action/send_goal') and kinds[0].startswith(_MOVING)
            and node.count_services(name))

    def prepare(self) -> list[str] | None:
        """Make the clients of all actions that can be stopped; return these, None without any."""
        actions = self.actions()
        for action in actions:
            self._client.prepare(CancelGoal, action + _CANCEL)
        return actions or None

    def hears(self, action: str) -> bool:
        """Return whether the server of a prepared action would receive a request."""
        return self._client.serves(CancelGoal, action + _CANCEL)

    def stop(self, actions: Sequence[str] | None = None) -> list[Future[Any]]:
        """
        Ask actions to stop, and move_group by its event, which waits a little for their answers.

        A goal id of zeros with the time zero is every goal.

        :param actions: None asks all.
        :returns: their responses to be, of CancelGoal.
        """
        responses: list[Future[Any]] = []
        try:
            for action in self.actions() if actions is None else actions:
                responses.append(self.cancel(action))
            # A goal that the event has ended is not counted as cancelled.
            wait(responses, EVENT_LATEST)
        finally:
            self.send_event()
        return responses

    def cancel(self, action: str) -> Future[Any]:
        """Ask an action to cancel all its goals; return its response to be, of CancelGoal."""
        return self._client.call(CancelGoal, action + _CANCEL)

    def send_event(self) -> None:
        """Have move_group end all that it executes."""
        self._client.in_thread(lambda: self._publisher.publish(String(data='stop')))
