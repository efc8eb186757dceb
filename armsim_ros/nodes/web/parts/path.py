# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planned path in each session's scene: the line of the tip, the ghost that runs along."""

from __future__ import annotations

import asyncio
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from pydantic import Field

from armsim_ros.clients.description import link_pose, tip_of
from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.web.curves import Curves
from armsim_ros.nodes.web.page import Page, PanelCommand, Part, Session
from armsim_ros.nodes.web.parts.goal import GoalPart
from armsim_ros.nodes.web.parts.robot import RATE, RobotPart

#: Points of the tip's line, and its colour.
_LINE_POINTS = 120
_LINE_COLOR = (66, 133, 244)
#: The ghost's while it runs along a path.
_PREVIEW = (120, 160, 230)
#: Between two runs of a looped replay [s].
_PAUSE = 0.4


class Scrub(PanelCommand):
    """Show the ghost at a time of the plan [s]."""

    time: float = Field(ge=0.0)


class Replay(PanelCommand):
    """Run the ghost along the plan."""

    loop: bool = False


class Clear(PanelCommand):
    """Forget the plan."""


class Plan:
    """
    What was planned last for a session.

    :param trajectory: the message that is executed.
    """

    def __init__(self, group: str, trajectory: Any, curves: Curves,
                 start: dict[str, float]) -> None:
        self.group, self.trajectory, self.curves, self.start = group, trajectory, curves, start

    def at(self, time: float) -> dict[str, float]:
        """Return the joint positions of the whole robot at a time [rad or m]."""
        return {**self.start, **self.curves.at(time)}


class PathPart(Part):
    """Keeps each session's plan and shows it."""

    def __init__(self, page: Page, robot_part: RobotPart, goals: GoalPart) -> None:
        super().__init__(page)
        self._robot_part, self._goals = robot_part, goals
        self._plans: WeakKeyDictionary[Session, Plan] = WeakKeyDictionary()
        self._lines: WeakKeyDictionary[Session, Any] = WeakKeyDictionary()
        self._runs: WeakKeyDictionary[Session, asyncio.Task[Any]] = WeakKeyDictionary()

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {'scrub': (Scrub, self._scrub), 'replay': (Replay, self._replay),
                'clear': (Clear, self._clear)}

    def on_robot(self, robot: RobotModel) -> None:
        """Forget the plans of another robot."""
        for session, plan in list(self._plans.items()):
            if not set(plan.curves.joints) <= set(robot.joints):
                self.forget(session)

    def on_scene(self, session: Session) -> None:
        """Draw the line anew."""
        self._lines.pop(session, None)
        if session in self._plans:
            self._draw(session)

    def plan(self, session: Session) -> Plan | None:
        """Return what was planned last for a session."""
        return self._plans.get(session)

    def take(self, session: Session, plan: Plan, note: str = '') -> None:
        """Show a new plan in place of the last."""
        self.forget(session)
        self._plans[session] = plan
        self._draw(session)
        robot = self.page.robot
        limits = {name: robot.joints[name].limits for name in plan.curves.joints} if robot else {}
        session.show('plan', {
            **plan.curves.form(), 'group': plan.group, 'duration': plan.curves.duration,
            'note': note,
            'limits': {name: {
                'lower': limit.lower, 'upper': limit.upper, 'velocity': limit.velocity,
                'acceleration': limit.acceleration} for name, limit in limits.items()},
        })

    def forget(self, session: Session) -> None:
        """Take a session's plan away."""
        self.halt(session)
        self._plans.pop(session, None)
        line = self._lines.pop(session, None)
        if line is not None and session.scene is not None:
            line.remove()
        session.show('plan', None)

    def halt(self, session: Session) -> None:
        """End a replay."""
        run = self._runs.pop(session, None)
        if run is not None:
            run.cancel()

    def _draw(self, session: Session) -> None:
        plan, robot = self._plans[session], self.page.robot
        if session.scene is None or robot is None:
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
        self._lines[session] = session.scene.scene.add_line_segments(
            '/path', pieces, colors=_LINE_COLOR, thickness=3.0, thickness_units='screen')

    async def _scrub(self, session: Session, command: Scrub) -> None:
        plan = self._need(session)
        self.halt(session)
        await self._goals.ghost(session)
        self._goals.show(session, plan.at(command.time), _PREVIEW)

    async def _replay(self, session: Session, command: Replay) -> None:
        plan = self._need(session)
        self.halt(session)
        await self._goals.ghost(session)
        self._runs[session] = self.page.start(self._run(session, plan, command.loop))

    async def _run(self, session: Session, plan: Plan, loop: bool) -> None:
        clock = asyncio.get_running_loop()
        while True:
            begin = clock.time()
            while (time := clock.time() - begin) < plan.curves.duration:
                self._goals.show(session, plan.at(time), _PREVIEW)
                session.show('replay', round(time, 2))
                await asyncio.sleep(1.0 / RATE)
            self._goals.show(session, plan.at(plan.curves.duration), _PREVIEW)
            session.show('replay', round(plan.curves.duration, 2))
            await asyncio.sleep(_PAUSE)
            if not loop:
                break
        self._goals.restore(session)

    async def _clear(self, session: Session, _command: Clear) -> None:
        self.forget(session)
        self._goals.restore(session)

    def _need(self, session: Session) -> Plan:
        plan = self._plans.get(session)
        if plan is None:
            raise ArmsimError("there is no plan; press 'Plan'")
        return plan
