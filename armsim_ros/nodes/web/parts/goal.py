# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The goal of each session's planning group: the ghost, its handle, its sliders."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
import random
from typing import Any
from weakref import WeakKeyDictionary

from moveit_msgs.msg import PlanningSceneComponents

from armsim_ros.arrays import Matrix
from armsim_ros.clients.description import bounds, link_pose, moved_links, position_of, tip_of
from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.web.page import Page, Part, Session
from armsim_ros.nodes.web.parts.reach import (
    ChooseGroup,
    ChooseStart,
    ChooseState,
    Reach,
    SetJoints,
)
from armsim_ros.nodes.web.parts.robot import RobotPart
from armsim_ros.nodes.web.robot_drawing import RobotDrawing, ToolHandle
from armsim_ros.nodes.web.shapes import Color

CURRENT, RANDOM, DRAG = 'current', 'random valid', 'drag the tool'
_GREEN, _RED, _GREY = (72, 187, 120), (240, 138, 128), (150, 156, 166)
_TOUCHING: Color = (214, 34, 34)
_COLORS: Mapping[str, Color] = {
    'reachable': _GREEN, 'collision': _RED, 'unreachable': _GREY, 'unknown': _GREEN}
_OPACITY = 0.5
_MOST_TRIES = 100


class SessionGoal:
    """A session's goal."""

    def __init__(self) -> None:
        self.group = ''
        self.serial = 0
        """Rises with every new group: what was found out about the old group is obsolete."""
        self.state = CURRENT
        self.positions: dict[str, float] = {}
        self.start_name = CURRENT
        self.start: dict[str, float] | None = None
        self.verdict: dict[str, Any] = {'kind': 'unknown', 'text': '', 'touching': []}
        self.ghost: RobotDrawing | None = None
        self.handle: ToolHandle | None = None
        self.shown = False
        self.wanted_pose: Matrix | None = None
        self.dirty = asyncio.Event()
        self.drawing = asyncio.Lock()
        self.worker: asyncio.Task[Any] | None = None


class GoalPart(Part):
    """Keeps a goal for each session, moves its ghost, and shows whether it can be reached."""

    def __init__(self, page: Page, robot_part: RobotPart) -> None:
        super().__init__(page)
        self._robot_part = robot_part
        self._reach = Reach(page)
        self._goals: WeakKeyDictionary[Session, SessionGoal] = WeakKeyDictionary()
        self.on_touching: Any = None
        """Gets a session and the names of the objects that its ghost touches."""

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {
            'group': (ChooseGroup, self._choose_group),
            'goal_state': (ChooseState, self._choose_state),
            'joints': (SetJoints, self._set_joints),
            'start_state': (ChooseStart, self._choose_start),
        }

    def goal(self, session: Session) -> SessionGoal:
        """Return a session's goal."""
        if session not in self._goals:
            self._goals[session] = SessionGoal()
        return self._goals[session]

    def on_robot(self, robot: RobotModel) -> None:
        """Begin anew with another robot."""
        for session, goal in self._goals.items():
            if goal.ghost is None or goal.ghost.robot.urdf != robot.urdf:
                goal.group = ''
                self._undraw(goal)
            self.page.start(self._begin(session))

    def on_session(self, session: Session) -> None:
        """Give a new session a goal; it can plan before its scene is drawn."""
        if not self.goal(session).group and self.page.robot is not None:
            self.page.start(self._begin(session))

    def on_scene(self, session: Session) -> None:
        """Draw the goal anew in a scene that knows nothing of it."""
        goal = self.goal(session)
        goal.ghost = goal.handle = None
        if self.page.robot is not None:
            self.page.start(self._begin(session))

    def on_program(self, name: str, there: bool) -> None:
        """Check the goals again when collisions can be checked again."""
        if name == 'move_group' and there and self.page.robot is not None:
            for session in list(self._goals):
                self.page.start(self._begin(session))

    async def current(self) -> dict[str, float]:
        """Return the robot's joint positions as move_group knows them [rad or m]."""
        scene = await self.page.planning_scene(PlanningSceneComponents.ROBOT_STATE)
        state = scene.robot_state.joint_state
        return dict(zip(state.name, state.position, strict=True))

    def show(self, session: Session, positions: Mapping[str, float], color: Color | None = None
             ) -> None:
        """Put a session's ghost somewhere for the moment, such as along a path."""
        goal = self.goal(session)
        if goal.ghost is not None:
            goal.ghost.visible = True
            goal.ghost.show_links(moved_links(self._need_robot(), goal.group))
            goal.ghost.set_joints(positions)
            if color is not None:
                goal.ghost.paint(color, {})

    async def ghost(self, session: Session) -> RobotDrawing | None:
        """Return a session's ghost, drawn where it was not yet; None without a scene."""
        goal = self.goal(session)
        async with goal.drawing:
            while goal.ghost is None and session.scene is not None and self.page.robot is not None:
                client, robot = session.scene, self.page.robot
                drawn = await asyncio.to_thread(
                    RobotDrawing, client.scene, '/ghost', robot, self._robot_part.reader,
                    _GREEN, _OPACITY)
                # Either may have been replaced while it was drawn.
                if session.scene is client and self.page.robot.urdf == robot.urdf:
                    goal.ghost = drawn
                    self._place_roots(goal, robot)
        return goal.ghost

    def restore(self, session: Session) -> None:
        """Put the ghost back to the goal."""
        self._show_goal(session)

    def arrived(self, session: Session) -> None:
        """Hide the ghost: the robot is at its pose."""
        self.goal(session).shown = False
        self._show_goal(session)
        self._publish(session)

    def look_again(self) -> None:
        """Find out anew what every ghost touches."""
        for session, goal in self._goals.items():
            if goal.shown:
                self._wake(session)

    async def _begin(self, session: Session) -> None:
        """Show a goal as it is; a new goal is at the robot's state."""
        goal, robot = self.goal(session), self.page.robot
        if robot is None:
            return
        if not goal.group:
            await self._set_group(session, self.page.shared['robot']['group'])
            return
        self._draw_handle(session)
        self._publish(session)
        if goal.state != CURRENT:
            await self.ghost(session)
            self._show_goal(session)
            self._wake(session)

    async def _choose_group(self, session: Session, command: ChooseGroup) -> None:
        if self.page.robot is None or command.name not in self.page.robot.semantic.groups:
            raise ArmsimError(f"there is no planning group '{command.name}'")
        await self._set_group(session, command.name)

    async def _set_group(self, session: Session, name: str) -> None:
        goal = self.goal(session)
        goal.group, goal.state, goal.wanted_pose = name, CURRENT, None
        goal.positions = {}
        goal.serial += 1
        goal.shown = False
        goal.verdict = {'kind': 'unknown', 'text': '', 'touching': []}
        if goal.ghost is not None:
            goal.ghost.visible = False
        try:
            current = self._of_group(goal, await self.current())
        except ArmsimError:
            current = self._of_group(goal, {})
        # Something may have been chosen in the meantime.
        goal.positions = current if goal.state == CURRENT else {**current, **goal.positions}
        self._draw_handle(session)
        self._publish(session)

    async def _choose_state(self, session: Session, command: ChooseState) -> None:
        goal, robot = self.goal(session), self._need_robot()
        if command.name == DRAG:
            goal.state = DRAG
            await self._appear(session)
            return
        if command.name == CURRENT:
            goal.positions = self._of_group(goal, await self.current())
        elif command.name == RANDOM:
            goal.positions = await self._random(goal)
        else:
            states = robot.semantic.named_states.get(goal.group, {})
            if command.name not in states:
                raise ArmsimError(f"group '{goal.group}' has no state '{command.name}'")
            goal.positions = {**goal.positions, **states[command.name]}
        goal.state = command.name
        goal.wanted_pose = None
        await self._appear(session)

    async def _set_joints(self, session: Session, command: SetJoints) -> None:
        goal, robot = self.goal(session), self._need_robot()
        for name, value in command.values.items():
            if name not in goal.positions:
                raise ArmsimError(f"'{name}' is not a joint of group '{goal.group}'")
            lower, upper = bounds(robot.joints[name])
            goal.positions[name] = min(max(value, lower), upper)
        goal.state, goal.wanted_pose = '', None
        await self._appear(session)

    async def _choose_start(self, session: Session, command: ChooseStart) -> None:
        goal, robot = self.goal(session), self._need_robot()
        states = robot.semantic.named_states.get(goal.group, {})
        if command.name == CURRENT:
            goal.start = None
        elif command.name == 'where the ghost is':
            goal.start = dict(goal.positions)
        elif command.name in states:
            goal.start = dict(states[command.name])
        else:
            raise ArmsimError(f"group '{goal.group}' has no state '{command.name}'")
        goal.start_name = command.name
        self._publish(session)

    async def _random(self, goal: SessionGoal) -> dict[str, float]:
        """Return joint positions within the limits that touch nothing."""
        robot = self._need_robot()
        for _ in range(_MOST_TRIES):
            positions = {name: random.uniform(*bounds(robot.joints[name]))
                         for name in goal.positions}
            if (await self._reach.validity(goal.group, positions)).valid:
                return positions
        raise ArmsimError(f'none of {_MOST_TRIES} random states of {goal.group} is free of '
                          'collisions')

    async def _appear(self, session: Session) -> None:
        """Show the ghost at the goal and find out whether that can be."""
        goal = self.goal(session)
        session.show('result', None)  # it was about another goal
        await self.ghost(session)
        goal.shown = True
        self._show_goal(session)
        self._put_handle(goal)
        self._publish(session)
        self._wake(session)

    def _show_goal(self, session: Session) -> None:
        goal = self.goal(session)
        if goal.ghost is None:
            return
        goal.ghost.visible = goal.shown
        if goal.shown:
            goal.ghost.show_links(moved_links(self._need_robot(), goal.group))
            goal.ghost.set_joints({**self._others(), **goal.positions})
            touching = {link: _TOUCHING for pair in goal.verdict['touching'] for link in pair}
            goal.ghost.paint(_COLORS[goal.verdict['kind']], touching)
        if self.on_touching is not None:
            self.on_touching(session, {name for pair in goal.verdict['touching']
                                       for name in pair} if goal.shown else set())

    def _others(self) -> dict[str, float]:
        """Return the positions of all joints, read from tf [rad or m]."""
        robot, edges = self.page.robot, self._robot_part.edges
        found: dict[str, float] = {}
        if robot is None:
            return found
        for name in robot.active_joints:
            joint = robot.joints[name]
            if joint.child in edges:
                _, xyz, xyzw = edges[joint.child]
                found[name] = position_of(joint, xyz, xyzw)
        return found

    def _wake(self, session: Session) -> None:
        goal = self.goal(session)
        goal.dirty.set()
        if goal.worker is None or goal.worker.done():
            goal.worker = self.page.start(self._check(session))

    async def _check(self, session: Session) -> None:
        """Follow the goal with inverse kinematics and collision checks; the newest counts."""
        goal, robot = self.goal(session), self._need_robot()
        while goal.dirty.is_set():
            goal.dirty.clear()
            pose, group, positions = goal.wanted_pose, goal.group, dict(goal.positions)
            serial = goal.serial
            try:
                if pose is None:
                    verdict = await self._reach.collisions(group, positions)
                else:
                    positions, verdict = await self._reach.pose(robot, group, pose, positions)
            except ArmsimError as error:
                verdict = {'kind': 'unknown', 'text': str(error), 'touching': []}
            if goal.serial != serial:
                continue
            goal.verdict = verdict
            if pose is not None and goal.wanted_pose is not None:
                goal.positions = positions
            self._show_goal(session)
            self._publish(session)

    def _draw_handle(self, session: Session) -> None:
        """Give the session a handle at the group's tip."""
        goal, robot = self.goal(session), self.page.robot
        if session.scene is None or robot is None:
            return
        if goal.handle is not None:
            goal.handle.remove()
            goal.handle = None
        if not tip_of(robot.group(goal.group)):
            return

        async def pulled(pose: Matrix) -> None:
            goal.wanted_pose = pose
            session.show('result', None)
            if goal.state != DRAG or not goal.shown:
                goal.state, goal.shown = DRAG, True
                await self.ghost(session)
            self._wake(session)

        goal.handle = ToolHandle(session.scene.scene, pulled)
        self._place_roots(goal, robot)
        self._put_handle(goal)

    def _put_handle(self, goal: SessionGoal) -> None:
        robot = self.page.robot
        if goal.handle is not None and robot is not None:
            positions = robot.complete({**self._others(), **goal.positions})
            goal.handle.put(link_pose(robot, tip_of(robot.group(goal.group)), positions))

    def _place_roots(self, goal: SessionGoal, robot: RobotModel) -> None:
        """Put ghost and handle at the robot's root link."""
        edge = self._robot_part.edges.get(robot.root_link)
        if edge is None:
            return
        _, xyz, xyzw = edge
        for drawn in (goal.ghost, goal.handle):
            if drawn is not None:
                drawn.place(xyz, xyzw[[3, 0, 1, 2]])

    def _undraw(self, goal: SessionGoal) -> None:
        for drawn in (goal.ghost, goal.handle):
            if drawn is not None:
                drawn.remove()
        goal.ghost = goal.handle = None

    def _of_group(self, goal: SessionGoal, positions: Mapping[str, float]) -> dict[str, float]:
        robot = self._need_robot()
        return {name: float(positions.get(name, robot.default_position(name)))
                for name in robot.group(goal.group).active_joints}

    def _need_robot(self) -> RobotModel:
        if self.page.robot is None:
            raise ArmsimError('waiting for /robot_description')
        return self.page.robot

    def _publish(self, session: Session) -> None:
        goal = self.goal(session)
        session.show('goal', {
            'group': goal.group, 'state': goal.state, 'positions': dict(goal.positions),
            'start': goal.start_name, 'kind': goal.verdict['kind'],
            'text': goal.verdict['text'] if goal.shown else '',
            'touching': goal.verdict['touching'],
        })
