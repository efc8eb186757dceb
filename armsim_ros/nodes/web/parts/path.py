# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planned path in each visitor's scene: the line of the tip, the ghost that runs along."""

from __future__ import annotations

import asyncio
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from pydantic import Field

from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.client.description import link_pose, tip_of
from armsim_ros.nodes.web.page import Ask, Page, Part
from armsim_ros.nodes.web.parts.goal import GoalPart
from armsim_ros.nodes.web.parts.robot import RATE, RobotPart
from armsim_ros.nodes.web.view.curves import Curves
from armsim_ros.nodes.web.visitor import Visitor

#: Points of the tip's line, and its colour.
_LINE_POINTS = 120
_LINE_COLOR = (66, 133, 244)
#: The ghost's while it runs along a path.
_PREVIEW = (120, 160, 230)
#: Between two runs of a looped replay [s].
_PAUSE = 0.4


class Scrub(Ask):
    """Show the ghost at a time of the plan [s]."""

    time: float = Field(ge=0.0)


class Replay(Ask):
    """Run the ghost along the plan."""

    loop: bool = False


class Clear(Ask):
    """Forget the plan."""


class Plan:
    """
    What was planned last for a visitor.

    :param trajectory: the message that is executed.
    """

    def __init__(self, group: str, trajectory: Any, curves: Curves,
                 start: dict[str, float]) -> None:
        self.group, self.trajectory, self.curves, self.start = group, trajectory, curves, start

    def at(self, time: float) -> dict[str, float]:
        """Return the joint positions of the whole robot at a time [rad or m]."""
        return {**self.start, **self.curves.at(time)}


class PathPart(Part):
    """
    Keeps each visitor's plan and shows it.

    :param robot_part: who knows where the root link stands.
    :param goals: whose ghosts run.
    """

    def __init__(self, page: Page, robot_part: RobotPart, goals: GoalPart) -> None:
        super().__init__(page)
        self._robot_part, self._goals = robot_part, goals
        self._plans: WeakKeyDictionary[Visitor, Plan] = WeakKeyDictionary()
        self._lines: WeakKeyDictionary[Visitor, Any] = WeakKeyDictionary()
        self._runs: WeakKeyDictionary[Visitor, asyncio.Task[Any]] = WeakKeyDictionary()

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {'scrub': (Scrub, self._scrub), 'replay': (Replay, self._replay),
                'clear': (Clear, self._clear)}

    def on_robot(self, robot: RobotModel) -> None:
        """Forget the plans of another robot."""
        for visitor, plan in list(self._plans.items()):
            if not set(plan.curves.joints) <= set(robot.joints):
                self.forget(visitor)

    def on_scene(self, visitor: Visitor) -> None:
        """Draw the line anew."""
        self._lines.pop(visitor, None)
        if visitor in self._plans:
            self._draw(visitor)

    def plan(self, visitor: Visitor) -> Plan | None:
        """Return what was planned last for a visitor."""
        return self._plans.get(visitor)

    def take(self, visitor: Visitor, plan: Plan, note: str = '') -> None:
        """Show a new plan in place of the last."""
        self.forget(visitor)
        self._plans[visitor] = plan
        self._draw(visitor)
        robot = self.page.robot
        limits = {name: robot.joints[name].limits for name in plan.curves.joints} if robot else {}
        visitor.tell('plan', {
            **plan.curves.form(), 'group': plan.group, 'duration': plan.curves.duration,
            'note': note,
            'limits': {name: {
                'lower': limit.lower, 'upper': limit.upper, 'velocity': limit.velocity,
                'acceleration': limit.acceleration} for name, limit in limits.items()},
        })

    def forget(self, visitor: Visitor) -> None:
        """Take a visitor's plan away."""
        self.halt(visitor)
        self._plans.pop(visitor, None)
        line = self._lines.pop(visitor, None)
        if line is not None and visitor.scene is not None:
            line.remove()
        visitor.tell('plan', None)

    def halt(self, visitor: Visitor) -> None:
        """End a replay."""
        run = self._runs.pop(visitor, None)
        if run is not None:
            run.cancel()

    def _draw(self, visitor: Visitor) -> None:
        plan, robot = self._plans[visitor], self.page.robot
        if visitor.scene is None or robot is None:
            return
        tip = tip_of(robot.group(plan.group)) if plan.group in robot.semantic.groups else ''
        if not tip:
            return
        times = np.linspace(0.0, plan.curves.duration, _LINE_POINTS)
        root = self._robot_part.pose_of(robot.root_link)
        places = np.array([
            (root @ link_pose(robot, tip, robot.complete(plan.at(float(time)))))[:3, 3]
            for time in times])
        pieces = np.stack([places[:-1], places[1:]], axis=1).astype(np.float32)
        self._lines[visitor] = visitor.scene.scene.add_line_segments(
            '/path', pieces, colors=_LINE_COLOR, thickness=3.0, thickness_units='screen')

    async def _scrub(self, visitor: Visitor, ask: Scrub) -> None:
        plan = self._need(visitor)
        self.halt(visitor)
        await self._goals.ghost(visitor)
        self._goals.show(visitor, plan.at(ask.time), _PREVIEW)

    async def _replay(self, visitor: Visitor, ask: Replay) -> None:
        plan = self._need(visitor)
        self.halt(visitor)
        await self._goals.ghost(visitor)
        self._runs[visitor] = self.page.start(self._run(visitor, plan, ask.loop))

    async def _run(self, visitor: Visitor, plan: Plan, loop: bool) -> None:
        clock = asyncio.get_running_loop()
        while True:
            begin = clock.time()
            while (time := clock.time() - begin) < plan.curves.duration:
                self._goals.show(visitor, plan.at(time), _PREVIEW)
                visitor.tell('replay', round(time, 2))
                await asyncio.sleep(1.0 / RATE)
            self._goals.show(visitor, plan.at(plan.curves.duration), _PREVIEW)
            visitor.tell('replay', round(plan.curves.duration, 2))
            await asyncio.sleep(_PAUSE)
            if not loop:
                break
        self._goals.restore(visitor)

    async def _clear(self, visitor: Visitor, _ask: Clear) -> None:
        self.forget(visitor)
        self._goals.restore(visitor)

    def _need(self, visitor: Visitor) -> Plan:
        plan = self._plans.get(visitor)
        if plan is None:
            raise ArmsimError("there is no plan; press 'Plan'")
        return plan
