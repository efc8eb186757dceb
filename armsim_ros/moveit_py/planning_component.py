# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""PlanningComponent: start, goal, parameters and plans of a planning group."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import sys
from typing import Any, TYPE_CHECKING

from geometry_msgs.msg import PoseStamped
from moveit_msgs.msg import Constraints, MotionPlanRequest, WorkspaceParameters
from moveit_msgs.msg import RobotState as RobotStateMessage
import numpy as np

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.moveit_py.answers import MotionPlanResponse
from armsim_ros.moveit_py.kinematic_constraints import construct_joint_constraint, pose_constraint
from armsim_ros.moveit_py.planning_scene import PlanningScene
from armsim_ros.moveit_py.robot_state import RobotState, robotStateToRobotStateMsg
from armsim_ros.moveit_py.robot_trajectory import RobotTrajectory
from armsim_ros.moveit_py.utils import logger, warn_once, warn_unused
from armsim_ros.nodes.conversions.motion_plan_request import error_code_message
from armsim_ros.nodes.move_group.planning.planning_job import PlanningAnswer
from armsim_ros.planning.request import ORIENTATION_TOLERANCE, POSITION_TOLERANCE
from armsim_ros.planning.scene.planning_scene import PlanningScene as Scene

if TYPE_CHECKING:
    from armsim_ros.moveit_py.moveit_py import MoveItPy


#: Name -> default of each parameter.
_DEFAULTS: dict[str, Any] = {
    'planner_id': '', 'planning_pipeline': '', 'planning_time': 1.0, 'planning_attempts': 5,
    'max_velocity_scaling_factor': 1.0, 'max_acceleration_scaling_factor': 1.0,
}


class PlanRequestParameters:
    """
    How to plan; each parameter can be set.

    A name that is not used, or a namespace without any, is logged once.

    :param moveit_py: its node has the parameters.
    :param ns: they are those of ``<ns>.plan_request_params``; '' for ``plan_request_params``.
    :raises ValueError: a parameter has a value of another type.
    """

    planner_id: str
    planning_pipeline: str
    planning_time: float
    planning_attempts: int
    max_velocity_scaling_factor: float
    max_acceleration_scaling_factor: float

    def __init__(self, moveit_py: MoveItPy, ns: str = '') -> None:
        given = moveit_py._cpp.parameters
        prefix = f'{ns}.plan_request_params.' if ns else 'plan_request_params.'
        warn_unused(given, prefix, _DEFAULTS)
        if not any(key.startswith(prefix) for key in given):
            warn_once(f'no parameter {prefix}*; plans with the defaults')
        for name, default in _DEFAULTS.items():
            key = prefix + name
            value = given.get(key, default)
            kind = type(default)
            if not isinstance(value, (int, float) if kind is float else kind):
                raise ValueError(f"parameter '{key}' is {value!r}; allowed: {kind.__name__}")
            setattr(self, name, kind(value))


class MultiPipelinePlanRequestParameters:
    """
    How to plan with several pipelines.

    :param moveit_py: its node has the parameters.
    :param planning_pipeline_names: a namespace of ``PlanRequestParameters`` each.
    """

    def __init__(self, moveit_py: MoveItPy, planning_pipeline_names: Sequence[str]) -> None:
        self._all = [PlanRequestParameters(moveit_py, name) for name in planning_pipeline_names]

    @property
    def multi_plan_request_parameters(self) -> list[PlanRequestParameters]:
        """The parameters for each pipeline."""
        return self._all


Selection = Callable[[list[MotionPlanResponse]], MotionPlanResponse]
Stopping = Callable[[list[MotionPlanResponse], list[MotionPlanRequest]], bool]


class PlanningComponent:
    """
    Plans for a planning group.

    :param joint_model_group_name: the group.
    :param moveit_py_instance: plans and has the scene.
    :raises RuntimeError: there is no such group; lists those that there are.
    """

    def __init__(self, joint_model_group_name: str, moveit_py_instance: MoveItPy) -> None:
        self._moveit, self._model = moveit_py_instance, moveit_py_instance.get_robot_model()
        try:
            self._group = self._model.get_joint_model_group(joint_model_group_name)
        except PlanningError as error:
            raise RuntimeError(str(error)) from None
        self._start: RobotState | None = None
        self._goals: list[Constraints] = []
        self._path = Constraints()
        self._workspace = WorkspaceParameters()

    @property
    def planning_group_name(self) -> str:
        """Name of the group."""
        return self._group.name

    @property
    def named_target_states(self) -> list[str]:
        """Names of the group's states in the SRDF."""
        return list(self._states)

    @property
    def _states(self) -> dict[str, dict[str, float]]:
        semantic = self._model._kinematics.robot.semantic
        return semantic.named_states.get(self._group.name, {})

    def get_named_target_state_values(self, name: str) -> dict[str, float]:
        """
        Return joint -> position [rad or m] of a named state.

        :raises ValueError: there is no such state; lists those that there are.
        """
        if name not in self._states:
            raise ValueError(self._model._unknown_state(self._group.name, name))
        return dict(self._states[name])

    # ---------------------------------------------------------------- start

    def set_start_state(
        self, configuration_name: str | None = None, robot_state: RobotState | None = None
    ) -> bool:
        """
        Begin plans in a named state, or in a given state.

        :returns: False where there is no named state of this name.
        :raises ValueError: neither or both are given.
        """
        _check_one(configuration_name=configuration_name, robot_state=robot_state)
        state = robot_state if configuration_name is None else self._named(configuration_name)
        if state is None:
            return False
        self._start = state.__copy__()
        return True

    def set_start_state_to_current_state(self) -> None:
        """Begin plans where the robot is then."""
        self._start = None

    def get_start_state(self) -> RobotState:
        """Return the start of the next plan; without a given one, the present state."""
        if self._start is not None:
            return self._start
        return self._current()

    def _current(self) -> RobotState:
        cpp, state = self._moveit._cpp, RobotState(self._model)

        async def update() -> Scene:
            await cpp.context.states.current()
            return cpp.context.scene.snapshot()

        scene = cpp.call(update)
        state._attached = scene.attached
        state._set_q(scene.q)
        return state

    def _named(self, name: str) -> RobotState | None:
        """Return a state with a named state of the group; None, and a log line, without."""
        state = RobotState(self._model)
        return state if state.set_to_default_values(self._group, name) else None

    # ---------------------------------------------------------------- goal and limits

    def set_goal_state(
        self, configuration_name: str | None = None, robot_state: RobotState | None = None,
        pose_stamped_msg: PoseStamped | None = None, pose_link: str | None = None,
        motion_plan_constraints: Sequence[Constraints] | None = None
    ) -> bool:
        """
        Set the goal: a named state, a state, the pose of a link, or constraints.

        :param pose_stamped_msg: together with ``pose_link``.
        :param motion_plan_constraints: alternatives; one of them is enough.
        :returns: False where there is no named state of this name.
        :raises ValueError: none or several are given, or a pose without its link.
        """
        _check_one(
            configuration_name=configuration_name, robot_state=robot_state,
            pose_stamped_msg=pose_stamped_msg, motion_plan_constraints=motion_plan_constraints)
        if (pose_stamped_msg is None) != (pose_link is None):
            raise ValueError('a pose goal needs both pose_stamped_msg and pose_link')
        if pose_stamped_msg is not None:
            self._goals = [pose_constraint(
                str(pose_link), pose_stamped_msg.header.frame_id, pose_stamped_msg.pose,
                POSITION_TOLERANCE, ORIENTATION_TOLERANCE)]
        elif motion_plan_constraints is not None:
            self._goals = list(motion_plan_constraints)
        else:
            state = robot_state if configuration_name is None else self._named(configuration_name)
            if state is None:
                return False
            self._goals = [construct_joint_constraint(state, self._group, sys.float_info.epsilon)]
        return True

    def set_path_constraints(self, path_constraints: Constraints) -> bool:
        """Set what holds along the whole path; an empty message for nothing."""
        self._path = path_constraints
        return True

    def set_workspace(
        self, min_x: float, min_y: float, min_z: float, max_x: float, max_y: float, max_z: float
    ) -> None:
        """Set the box [m] in the model frame in which a mobile base may move."""
        box = WorkspaceParameters()
        box.header.frame_id = self._model.model_frame
        low, high = box.min_corner, box.max_corner
        low.x, low.y, low.z = float(min_x), float(min_y), float(min_z)
        high.x, high.y, high.z = float(max_x), float(max_y), float(max_z)
        self._workspace = box

    def unset_workspace(self) -> None:
        """Have no box."""
        self._workspace = WorkspaceParameters()

    # ---------------------------------------------------------------- plans

    def plan(
        self, single_plan_parameters: PlanRequestParameters | None = None,
        multi_plan_parameters: MultiPipelinePlanRequestParameters | None = None,
        planning_scene: PlanningScene | None = None,
        solution_selection_function: Selection | None = None,
        stopping_criterion_callback: Stopping | None = None
    ) -> MotionPlanResponse:
        """
        Plan, and return the plan or why there is none; Ctrl-C ends the search.

        :param single_plan_parameters: None, without several: the node's own.
        :param multi_plan_parameters: plan with several pipelines, in turns.
        :param planning_scene: to plan in; None for that of the monitor. Where no start is set,
            the robot is in it where it is now, with what it carries.
        :param solution_selection_function: gets the answers and returns one of them; None takes
            the shortest plan.
        :param stopping_criterion_callback: gets the answers so far and all requests after each;
            true ends the planning.
        :raises ValueError: both kinds of parameters are given, or a scene without any.
        """
        if single_plan_parameters is not None and multi_plan_parameters is not None:
            raise ValueError('give single_plan_parameters or multi_plan_parameters, not both')
        if multi_plan_parameters is not None:
            return self._plan_several(
                multi_plan_parameters.multi_plan_request_parameters, planning_scene,
                solution_selection_function or _shortest, stopping_criterion_callback)
        if single_plan_parameters is None:
            if planning_scene is not None:
                raise ValueError('planning_scene needs single_plan_parameters or '
                                 'multi_plan_parameters')
            single_plan_parameters = PlanRequestParameters(self._moveit)
        request = self._request(single_plan_parameters, planning_scene)
        return self._answer(request, planning_scene)

    def _plan_several(
        self, parameters: Sequence[PlanRequestParameters], scene: PlanningScene | None,
        selection: Selection, stopping: Stopping | None
    ) -> MotionPlanResponse:
        requests = [self._request(each, scene) for each in parameters]
        answers: list[MotionPlanResponse] = []
        for request in requests:
            answers.append(self._answer(request, scene))
            if stopping is not None and stopping(answers, requests):
                break
        return selection(answers) if answers else self._failure(
            MoveItErrorCode.FAILURE, 'no pipeline is given')

    def _request(
        self, parameters: PlanRequestParameters, scene: PlanningScene | None
    ) -> MotionPlanRequest:
        own = scene is None or scene is self._moveit.get_planning_scene_monitor()._open
        if self._start is None and own:
            message = RobotStateMessage(is_diff=True)
        else:
            message = robotStateToRobotStateMsg(self.get_start_state())
        return MotionPlanRequest(
            group_name=self._group.name,
            pipeline_id=parameters.planning_pipeline,
            planner_id=parameters.planner_id,
            num_planning_attempts=max(1, int(parameters.planning_attempts)),
            allowed_planning_time=float(parameters.planning_time),
            max_velocity_scaling_factor=float(parameters.max_velocity_scaling_factor),
            max_acceleration_scaling_factor=float(parameters.max_acceleration_scaling_factor),
            workspace_parameters=self._workspace, goal_constraints=self._goals,
            path_constraints=self._path, start_state=message)

    def _answer(
        self, request: MotionPlanRequest, scene: PlanningScene | None
    ) -> MotionPlanResponse:
        if not self._goals:
            return self._failure(MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
                                 'no goal is set; call set_goal_state', request.planner_id)
        scene = scene or self._moveit.get_planning_scene_monitor()._open
        cpp, cancelled = self._moveit._cpp, [False]

        async def run() -> PlanningAnswer:
            return await cpp.job.run(
                request, scene=None if scene is None else scene._scene.snapshot(),
                cancelled=lambda: cancelled[0])

        def cancel() -> None:
            cancelled[0] = True

        try:
            answer = cpp.call(run, cancel)
        except PlanningError as error:
            return self._failure(MoveItErrorCode(error.code), str(error), request.planner_id)
        response = answer.response
        trajectory = None
        if response.success:
            base = RobotState(self._model)
            base.joint_positions = response.trajectory_start
            base._attached = answer.scene.attached
            trajectory = RobotTrajectory._of(base, response.trajectory, self._group.name)
        return MotionPlanResponse(
            trajectory, answer.error_code_message, response.planning_time, answer.start_message,
            request.planner_id)

    @staticmethod
    def _failure(code: MoveItErrorCode, text: str, planner_id: str = '') -> MotionPlanResponse:
        logger().error(f'plan: {text}')
        return MotionPlanResponse(None, error_code_message(code, text), planner_id=planner_id)


def _shortest(answers: list[MotionPlanResponse]) -> MotionPlanResponse:
    """Return the plan with the shortest way in joint space; without plans, the first answer."""
    def length(answer: MotionPlanResponse) -> float:
        plan = answer.trajectory
        if plan is None:
            return float('inf')
        return float(np.abs(np.diff(plan._points.positions, axis=0)).sum())

    return min(answers, key=length)


def _check_one(**values: object) -> None:
    """Raise ValueError unless exactly one of several arguments is given."""
    given = [name for name, value in values.items() if value is not None]
    if len(given) != 1:
        raise ValueError(f"give exactly one of {', '.join(values)}; "
                         f"given: {', '.join(given) or 'none'}")
