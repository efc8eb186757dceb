# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Plan, execute, stop, and the progress of each."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
import time
from typing import Any, Literal

from action_msgs.msg import GoalStatus
from control_msgs.msg import JointTrajectoryControllerState
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import MoveItErrorCodes
from moveit_msgs.srv import GetCartesianPath, QueryPlannerInterfaces
from pydantic import Field
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy

from armsim_ros.clients.description import link_pose, tip_of
from armsim_ros.clients.motion import (
    code_text,
    plan_goal,
    robot_state,
    seconds,
    stamped_pose,
    Stopper,
    SUCCESS,
)
from armsim_ros.clients.node import GoalRun
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.web.curves import curves_of, Trace
from armsim_ros.nodes.web.page import Page, PanelCommand, Part, Session
from armsim_ros.nodes.web.parts.goal import GoalPart
from armsim_ros.nodes.web.parts.path import PathPart, Plan
from armsim_ros.nodes.web.parts.watch import WatchPart

#: Period of progress reports [s].
_PERIOD = 0.2


class Activity:
    """A single activity at a time, from any session; all sessions see it."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self.what: Literal['', 'planning', 'executing'] = ''
        self._telling: asyncio.Task[Any] | None = None
        page.publish('activity', None)

    def begin(self, what: Literal['planning', 'executing'], session: Session, total: float,
              clock: Callable[[], float]) -> None:
        """
        Publish a new activity, which replaces the present.

        :param total: how long it takes, or may take at most [s].
        :param clock: which time it takes [s].
        """
        self.end()
        self.what = what
        self._telling = self._page.start(self._publish(session, total, clock))

    def end(self) -> None:
        """Publish its end."""
        self.what = ''
        if self._telling is not None:
            self._telling.cancel()
            self._telling = None
        self._page.publish('activity', None)

    def need_rest(self) -> None:
        """
        Allow only a single activity.

        :raises ArmsimError: there is something.
        """
        if self.what:
            raise ArmsimError(f"the page is {self.what} already; press 'Stop' to end that")

    async def _publish(self, session: Session, total: float, clock: Callable[[], float]) -> None:
        begun = clock()
        while True:
            elapsed = min(max(clock() - begun, 0.0), total)
            self._page.publish('activity', {
                'what': self.what, 'session': session.number, 'elapsed': round(elapsed, 1),
                'total': round(total, 1)})
            await asyncio.sleep(_PERIOD)


#: What a Cartesian path moves between two states [m].
_STEP = 0.005
#: A planner gets this beyond its planning time before it counts as lost [s].
_SPARE = 10.0
#: Period of reading the controllers' reports [s]; so many of them make a picture.
_LOOK, _LOOKS = 0.1, 4
_REPORTS = QoSProfile(depth=50, reliability=QoSReliabilityPolicy.BEST_EFFORT,
                      durability=QoSDurabilityPolicy.VOLATILE)
#: Results of a motion that was stopped, whether move_group noticed first or the
#: controllers did.
STOPPED = 'stopped'
_STATE_TYPE = 'control_msgs/msg/JointTrajectoryControllerState'


class PlanCommand(PanelCommand):
    """Plan to the ghost, and move there if requested."""

    speed: float = Field(1.0, gt=0.0, le=1.0)
    acceleration: float = Field(1.0, gt=0.0, le=1.0)
    pipeline: str = ''
    planner: str = ''
    planning_time: float = Field(5.0, gt=0.0, le=120.0)
    straight: bool = False
    execute: bool = False


class Execute(PanelCommand):
    """Do what was planned."""


class Stop(PanelCommand):
    """Stop all that moves."""


class MotionPart(Part):
    """Plans for each session; one motion is executed at a time, whichever session requested it."""

    def __init__(self, page: Page, watch: WatchPart, goals: GoalPart, paths: PathPart) -> None:
        super().__init__(page)
        self._watch, self._goals, self._paths = watch, goals, paths
        self._stopper = Stopper(page.link)
        self._runs: dict[GoalRun, Session] = {}
        self._activity = Activity(page)
        self._planning: asyncio.Task[str] | None = None
        self._stopped = False
        """Whether 'Stop' was pressed since planning began."""

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {'plan': (PlanCommand, self._plan), 'execute': (Execute, self._execute),
                'stop': (Stop, self._stop)}

    def on_program(self, name: str, there: bool) -> None:
        """Query a new move_group's planners; forget a motion that ended with the old."""
        if there and name == 'move_group':
            self.page.start(self._ask_planners())
        if there:
            self._stopper.prepare()
        elif name == 'move_group':
            for run in list(self._runs):
                if not run.result.done():
                    run.result.set_exception(ArmsimError('move_group does not answer'))

    async def _ask_planners(self) -> None:
        try:
            answer = await self.page.call(QueryPlannerInterfaces, '/query_planner_interface')
        except ArmsimError:
            return
        self.page.publish('pipelines', [
            {'id': pipeline.pipeline_id, 'name': pipeline.name,
             'planners': list(pipeline.planner_ids)}
            for pipeline in answer.planner_interfaces])

    async def _plan(self, session: Session, command: PlanCommand) -> None:
        self._begin(session)
        self._activity.begin('planning', session, command.planning_time, time.monotonic)
        self._stopped = False
        work = self._straight if command.straight else self._search
        self._planning = asyncio.create_task(work(session, command))
        try:
            text = await self._planning
        except asyncio.CancelledError:
            text = STOPPED
        except ArmsimError as error:
            self._end(session, str(error), False)
            return
        except BaseException:
            self._end(session, 'the page has a bug', False)
            raise
        finally:
            self._planning = None
        if self._stopped:
            self._end(session, STOPPED, False)
        elif command.execute:
            await self._go(session)
        else:
            self._end(session, text, True)

    async def _search(self, session: Session, command: PlanCommand) -> str:
        goal = self._goals.goal(session)
        if not goal.group:
            raise ArmsimError('waiting for /robot_description_semantic')
        wrapped = await self._run(session, MoveGroup, '/move_action', plan_goal(
            goal.group, goal.positions, start=goal.start, speed=command.speed,
            acceleration=command.acceleration, pipeline=command.pipeline, planner=command.planner,
            planning_time=command.planning_time), command.planning_time + _SPARE)
        result = wrapped.result
        if result.error_code.val != SUCCESS:
            raise ArmsimError(_reason(result.error_code))
        self._take(session, goal.group, result.planned_trajectory, result.trajectory_start)
        return f'planned in {result.planning_time:.2f} s'

    async def _straight(self, session: Session, command: PlanCommand) -> str:
        goal, robot = self._goals.goal(session), self.page.robot
        if robot is None or not goal.group:
            raise ArmsimError('waiting for /robot_description')
        tip = tip_of(robot.group(goal.group))
        if not tip:
            raise ArmsimError(f"group '{goal.group}' has no single tip to move along a line")
        positions = robot.complete({**await self._goals.current(), **goal.positions})
        pose = stamped_pose(robot.root_link, link_pose(robot, tip, positions))
        request = GetCartesianPath.Request(
            group_name=goal.group, link_name=tip, waypoints=[pose.pose], max_step=_STEP,
            avoid_collisions=True, start_state=robot_state(goal.start),
            max_velocity_scaling_factor=command.speed,
            max_acceleration_scaling_factor=command.acceleration)
        request.header.frame_id = pose.header.frame_id
        answer = await self.page.call(GetCartesianPath, '/compute_cartesian_path', request,
                                      command.planning_time + _SPARE)
        text = f'straight line: {100.0 * answer.fraction:.0f} % of the way'
        if answer.error_code.val != SUCCESS or len(answer.solution.joint_trajectory.points) < 2:
            raise ArmsimError(f'{code_text(answer.error_code)}; {text}')
        self._take(session, goal.group, answer.solution, answer.start_state, text)
        if answer.fraction < 0.999 and command.execute:
            raise ArmsimError(f"{text}; press 'Execute' to follow that part")
        return text

    def _take(self, session: Session, group: str, trajectory: Any, start: Any, note: str = ''
              ) -> None:
        message = trajectory.joint_trajectory
        if not message.points:
            raise ArmsimError('the plan has no points')
        state = start.joint_state
        try:
            curves = curves_of(
                message.joint_names, [seconds(point.time_from_start) for point in message.points],
                [point.positions for point in message.points],
                [point.velocities for point in message.points],
                [point.accelerations for point in message.points])
        except ValueError as error:
            raise ArmsimError(f'the plan cannot be read: {error}') from None
        self._paths.take(session, Plan(group, trajectory, curves, dict(
            zip(state.name, state.position, strict=False))), note)

    async def _execute(self, session: Session, _command: Execute) -> None:
        if self._paths.plan(session) is None:
            raise ArmsimError("there is no plan; press 'Plan'")
        self._begin(session)
        await self._go(session)

    async def _go(self, session: Session) -> None:
        plan = self._paths.plan(session)
        assert plan is not None
        self._activity.begin('executing', session, plan.curves.duration, self._watch.now)
        self._paths.halt(session)
        self._goals.restore(session)
        reporting = self.page.start(self._report(session, plan))
        try:
            wrapped = await self._run(session, ExecuteTrajectory, '/execute_trajectory',
                                      ExecuteTrajectory.Goal(trajectory=plan.trajectory), None)
            code = wrapped.result.error_code
            if wrapped.status == GoalStatus.STATUS_CANCELED:
                self._end(session, STOPPED, False)
            elif code.val != SUCCESS:
                self._end(session, _reason(code), False)
            else:
                self._goals.arrived(session)
                self._end(session, 'arrived', True)
        except ArmsimError as error:
            self._end(session, str(error), False)
        finally:
            reporting.cancel()

    async def _report(self, session: Session, plan: Plan) -> None:
        """Show a session what the controllers report."""
        topics = [self.page.link.poll(JointTrajectoryControllerState, name, _REPORTS)
                  for name, kind in self._watch.topics.items() if kind == _STATE_TYPE]
        trace = Trace()
        joints = set(plan.curves.joints)
        try:
            while True:
                for _ in range(_LOOKS):
                    self._read(topics, joints, trace)
                    await asyncio.sleep(_LOOK)
                session.show('trace', trace.form())
        finally:
            self._read(topics, joints, trace)
            session.show('trace', trace.form())
            for topic in topics:
                topic.close()

    def _read(self, topics: list[Any], joints: set[str], trace: Trace) -> None:
        for topic in topics:
            for message in topic.take():
                if joints & set(message.joint_names):
                    trace.add(seconds(message.header.stamp), message.joint_names,
                              message.reference.positions, message.feedback.positions,
                              message.error.positions)

    async def _stop(self, _session: Session, _command: Stop) -> None:
        for run in list(self._runs):
            run.cancel()
        if self._planning is not None:
            self._stopped = True
            self._planning.cancel()
        answers = await asyncio.to_thread(self._stopper.stop)
        await asyncio.gather(*(self.page.answer(answer, 2.0) for answer in answers),
                             return_exceptions=True)

    async def _run(self, session: Session, kind: type[Any], name: str, goal: Any,
                   patience: float | None) -> Any:
        """Send a goal and return its wrapped result."""
        run = self.page.link.goal(kind, name, goal)
        self._runs[run] = session
        try:
            wrapped = await asyncio.wait_for(asyncio.wrap_future(run.result), patience)
        except (asyncio.TimeoutError, TimeoutError):
            run.cancel()
            raise ArmsimError(f'{name} gave no result within {patience:.0f} s') from None
        finally:
            self._runs.pop(run, None)
        if wrapped is None:
            raise ArmsimError(f'{name} refused the goal; its log has the reason')
        return wrapped

    def _begin(self, session: Session) -> None:
        self._activity.need_rest()
        session.show('result', None)

    def _end(self, session: Session, text: str, good: bool) -> None:
        self._activity.end()
        session.sections.pop('result', None)
        session.show('result', {'text': text, 'good': good})


def _reason(code: Any) -> str:
    """Return why there is no plan or no motion, as a text."""
    return STOPPED if code.val == MoveItErrorCodes.PREEMPTED else code_text(code)
