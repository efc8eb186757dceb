# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where each visitor wants his planning group to go: the ghost, its handle, its sliders."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
import random
from typing import Any
from weakref import WeakKeyDictionary

from moveit_msgs.msg import PlanningSceneComponents
from moveit_msgs.srv import GetPlanningScene

from armsim_ros.arrays import Matrix
from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.client.description import (
    bounds,
    link_pose,
    moved_links,
    position_of,
    tip_of,
)
from armsim_ros.nodes.web.page import Page, Part
from armsim_ros.nodes.web.parts.goal_questions import (
    ChooseGroup,
    ChooseStart,
    ChooseState,
    SetJoints,
)
from armsim_ros.nodes.web.parts.reach import Reach
from armsim_ros.nodes.web.parts.robot import RobotPart
from armsim_ros.nodes.web.scene.robot_drawing import RobotDrawing
from armsim_ros.nodes.web.scene.tool_handle import ToolHandle
from armsim_ros.nodes.web.view.shapes import Color
from armsim_ros.nodes.web.visitor import Visitor

CURRENT, RANDOM, DRAG = 'current', 'random valid', 'drag the tool'
_GREEN, _RED, _GREY = (72, 187, 120), (240, 138, 128), (150, 156, 166)
_TOUCHING: Color = (214, 34, 34)
_COLORS: Mapping[str, Color] = {
    'reachable': _GREEN, 'collision': _RED, 'unreachable': _GREY, 'unknown': _GREEN}
_OPACITY = 0.5
_MOST_TRIES = 100


class VisitorGoal:
    """One visitor's goal."""

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
    """
    Keeps a goal for each visitor, moves his ghost, and tells whether it can be reached.

    :param robot_part: who knows where the robot stands.
    """

    def __init__(self, page: Page, robot_part: RobotPart) -> None:
        super().__init__(page)
        self._robot_part = robot_part
        self._reach = Reach(page)
        self._goals: WeakKeyDictionary[Visitor, VisitorGoal] = WeakKeyDictionary()
        self.on_touching: Any = None
        """Gets a visitor and the names of the objects that his ghost touches."""

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {
            'group': (ChooseGroup, self._choose_group),
            'goal_state': (ChooseState, self._choose_state),
            'joints': (SetJoints, self._set_joints),
            'start_state': (ChooseStart, self._choose_start),
        }

    def goal(self, visitor: Visitor) -> VisitorGoal:
        """Return a visitor's goal."""
        if visitor not in self._goals:
            self._goals[visitor] = VisitorGoal()
        return self._goals[visitor]

    def on_robot(self, robot: RobotModel) -> None:
        """Begin anew with another robot."""
        for visitor, goal in self._goals.items():
            if goal.ghost is None or goal.ghost.robot.urdf != robot.urdf:
                goal.group = ''
                self._undraw(goal)
            self.page.start(self._begin(visitor))

    def on_visitor(self, visitor: Visitor) -> None:
        """Give a new visitor a goal; he can plan before he sees anything."""
        if not self.goal(visitor).group and self.page.robot is not None:
            self.page.start(self._begin(visitor))

    def on_scene(self, visitor: Visitor) -> None:
        """Draw the goal anew in a scene that knows nothing of it."""
        goal = self.goal(visitor)
        goal.ghost = goal.handle = None
        if self.page.robot is not None:
            self.page.start(self._begin(visitor))

    def on_program(self, name: str, there: bool) -> None:
        """Look at the goals again where it is known again what they would hit."""
        if name == 'move_group' and there and self.page.robot is not None:
            for visitor in list(self._goals):
                self.page.start(self._begin(visitor))

    async def current(self) -> dict[str, float]:
        """Return the robot's joint positions as move_group knows them [rad or m]."""
        request = GetPlanningScene.Request()
        request.components.components = PlanningSceneComponents.ROBOT_STATE
        scene = (await self.page.call(GetPlanningScene, '/get_planning_scene', request)).scene
        state = scene.robot_state.joint_state
        return dict(zip(state.name, state.position, strict=True))

    def show(self, visitor: Visitor, positions: Mapping[str, float], color: Color | None = None
             ) -> None:
        """Put a visitor's ghost somewhere for the moment, such as along a path."""
        goal = self.goal(visitor)
        if goal.ghost is not None:
            goal.ghost.visible = True
            goal.ghost.show_links(moved_links(self._need_robot(), goal.group))
            goal.ghost.set_joints(positions)
            if color is not None:
                goal.ghost.paint(color, {})

    async def ghost(self, visitor: Visitor) -> RobotDrawing | None:
        """Return a visitor's ghost, drawn where it was not yet; None without a scene."""
        goal = self.goal(visitor)
        async with goal.drawing:
            while goal.ghost is None and visitor.scene is not None and self.page.robot is not None:
                client, robot = visitor.scene, self.page.robot
                drawn = await asyncio.to_thread(
                    RobotDrawing, client.scene, '/ghost', robot, self._robot_part.reader,
                    _GREEN, _OPACITY)
                # Either may have been replaced while it was drawn.
                if visitor.scene is client and self.page.robot.urdf == robot.urdf:
                    goal.ghost = drawn
                    self._place_roots(goal, robot)
        return goal.ghost

    def restore(self, visitor: Visitor) -> None:
        """Put the ghost back to the goal."""
        self._show_goal(visitor)

    def arrived(self, visitor: Visitor) -> None:
        """Hide the ghost: the robot stands where it stood."""
        self.goal(visitor).shown = False
        self._show_goal(visitor)
        self._tell(visitor)

    def look_again(self) -> None:
        """Find out anew what every ghost touches."""
        for visitor, goal in self._goals.items():
            if goal.shown:
                self._wake(visitor)

    async def _begin(self, visitor: Visitor) -> None:
        """Show a goal as it is; a new goal is at the robot's state."""
        goal, robot = self.goal(visitor), self.page.robot
        if robot is None:
            return
        if not goal.group:
            await self._set_group(visitor, self.page.shared['robot']['group'])
            return
        self._draw_handle(visitor)
        self._tell(visitor)
        if goal.state != CURRENT:
            await self.ghost(visitor)
            self._show_goal(visitor)
            self._wake(visitor)

    async def _choose_group(self, visitor: Visitor, ask: ChooseGroup) -> None:
        if self.page.robot is None or ask.name not in self.page.robot.semantic.groups:
            raise ArmsimError(f"there is no planning group '{ask.name}'")
        await self._set_group(visitor, ask.name)

    async def _set_group(self, visitor: Visitor, name: str) -> None:
        goal = self.goal(visitor)
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
        self._draw_handle(visitor)
        self._tell(visitor)

    async def _choose_state(self, visitor: Visitor, ask: ChooseState) -> None:
        goal, robot = self.goal(visitor), self._need_robot()
        if ask.name == DRAG:
            goal.state = DRAG
            await self._appear(visitor)
            return
        if ask.name == CURRENT:
            goal.positions = self._of_group(goal, await self.current())
        elif ask.name == RANDOM:
            goal.positions = await self._random(goal)
        else:
            states = robot.semantic.named_states.get(goal.group, {})
            if ask.name not in states:
                raise ArmsimError(f"group '{goal.group}' has no state '{ask.name}'")
            goal.positions = {**goal.positions, **states[ask.name]}
        goal.state = ask.name
        goal.wanted_pose = None
        await self._appear(visitor)

    async def _set_joints(self, visitor: Visitor, ask: SetJoints) -> None:
        goal, robot = self.goal(visitor), self._need_robot()
        for name, value in ask.values.items():
            if name not in goal.positions:
                raise ArmsimError(f"'{name}' is no joint of group '{goal.group}'")
            lower, upper = bounds(robot.joints[name])
            goal.positions[name] = min(max(value, lower), upper)
        goal.state, goal.wanted_pose = '', None
        await self._appear(visitor)

    async def _choose_start(self, visitor: Visitor, ask: ChooseStart) -> None:
        goal, robot = self.goal(visitor), self._need_robot()
        states = robot.semantic.named_states.get(goal.group, {})
        if ask.name == CURRENT:
            goal.start = None
        elif ask.name == 'where the ghost is':
            goal.start = dict(goal.positions)
        elif ask.name in states:
            goal.start = dict(states[ask.name])
        else:
            raise ArmsimError(f"group '{goal.group}' has no state '{ask.name}'")
        goal.start_name = ask.name
        self._tell(visitor)

    async def _random(self, goal: VisitorGoal) -> dict[str, float]:
        """Return joint positions within the limits that touch nothing."""
        robot = self._need_robot()
        for _ in range(_MOST_TRIES):
            positions = {name: random.uniform(*bounds(robot.joints[name]))
                         for name in goal.positions}
            if (await self._reach.validity(goal.group, positions)).valid:
                return positions
        raise ArmsimError(f'none of {_MOST_TRIES} random states of {goal.group} is free of '
                          'collisions')

    async def _appear(self, visitor: Visitor) -> None:
        """Show the ghost at the goal and find out whether that can be."""
        goal = self.goal(visitor)
        visitor.tell('result', None)  # it was about another goal
        await self.ghost(visitor)
        goal.shown = True
        self._show_goal(visitor)
        self._put_handle(goal)
        self._tell(visitor)
        self._wake(visitor)

    def _show_goal(self, visitor: Visitor) -> None:
        goal = self.goal(visitor)
        if goal.ghost is None:
            return
        goal.ghost.visible = goal.shown
        if goal.shown:
            goal.ghost.show_links(moved_links(self._need_robot(), goal.group))
            goal.ghost.set_joints({**self._others(), **goal.positions})
            touching = {link: _TOUCHING for pair in goal.verdict['touching'] for link in pair}
            goal.ghost.paint(_COLORS[goal.verdict['kind']], touching)
        if self.on_touching is not None:
            self.on_touching(visitor, {name for pair in goal.verdict['touching']
                                       for name in pair} if goal.shown else set())

    def _others(self) -> dict[str, float]:
        """Return where all joints stand, read off tf [rad or m]."""
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

    def _wake(self, visitor: Visitor) -> None:
        goal = self.goal(visitor)
        goal.dirty.set()
        if goal.worker is None or goal.worker.done():
            goal.worker = self.page.start(self._judge(visitor))

    async def _judge(self, visitor: Visitor) -> None:
        """Follow the goal with inverse kinematics and collision checks; the newest counts."""
        goal, robot = self.goal(visitor), self._need_robot()
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
            self._show_goal(visitor)
            self._tell(visitor)

    def _draw_handle(self, visitor: Visitor) -> None:
        """Give the visitor a handle at the group's tip."""
        goal, robot = self.goal(visitor), self.page.robot
        if visitor.scene is None or robot is None:
            return
        if goal.handle is not None:
            goal.handle.remove()
            goal.handle = None
        if not tip_of(robot.group(goal.group)):
            return

        async def pulled(pose: Matrix) -> None:
            goal.wanted_pose = pose
            visitor.tell('result', None)
            if goal.state != DRAG or not goal.shown:
                goal.state, goal.shown = DRAG, True
                await self.ghost(visitor)
            self._wake(visitor)

        goal.handle = ToolHandle(visitor.scene.scene, pulled)
        self._place_roots(goal, robot)
        self._put_handle(goal)

    def _put_handle(self, goal: VisitorGoal) -> None:
        robot = self.page.robot
        if goal.handle is not None and robot is not None:
            positions = robot.complete({**self._others(), **goal.positions})
            goal.handle.put(link_pose(robot, tip_of(robot.group(goal.group)), positions))

    def _place_roots(self, goal: VisitorGoal, robot: RobotModel) -> None:
        """Put ghost and handle where the robot's root link stands."""
        edge = self._robot_part.edges.get(robot.root_link)
        if edge is None:
            return
        _, xyz, xyzw = edge
        for drawn in (goal.ghost, goal.handle):
            if drawn is not None:
                drawn.place(xyz, xyzw[[3, 0, 1, 2]])

    def _undraw(self, goal: VisitorGoal) -> None:
        for drawn in (goal.ghost, goal.handle):
            if drawn is not None:
                drawn.remove()
        goal.ghost = goal.handle = None

    def _of_group(self, goal: VisitorGoal, positions: Mapping[str, float]) -> dict[str, float]:
        robot = self._need_robot()
        return {name: float(positions.get(name, robot.default_position(name)))
                for name in robot.group(goal.group).active_joints}

    def _need_robot(self) -> RobotModel:
        if self.page.robot is None:
            raise ArmsimError('waiting for /robot_description')
        return self.page.robot

    def _tell(self, visitor: Visitor) -> None:
        goal = self.goal(visitor)
        visitor.tell('goal', {
            'group': goal.group, 'state': goal.state, 'positions': dict(goal.positions),
            'start': goal.start_name, 'kind': goal.verdict['kind'],
            'text': goal.verdict['text'] if goal.shown else '',
            'touching': goal.verdict['touching'],
        })
