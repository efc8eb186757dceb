# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the page works with, and whether it answers."""

from __future__ import annotations

import asyncio
import time
from typing import Any

from controller_manager_msgs.srv import ListControllers
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import PlanningSceneComponents
from moveit_msgs.srv import (
    ApplyPlanningScene,
    GetCartesianPath,
    GetPlanningScene,
    GetPositionIK,
    GetStateValidity,
    QueryPlannerInterfaces,
)
from rosgraph_msgs.msg import Clock

from armsim_ros.clients.motion import seconds
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes import qos
from armsim_ros.nodes.web.page import Page, Part

#: Period of checking whether a program answers, and how long its answer may take [s].
_PERIOD, _PATIENCE = 0.7, 2.0
#: Period of reading the names in the graph [s].
_GRAPH_PERIOD = 2.0
_CLOCK_PERIOD = 0.5

SERVICES = {
    '/get_planning_scene': GetPlanningScene,
    '/apply_planning_scene': ApplyPlanningScene,
    '/compute_ik': GetPositionIK,
    '/compute_cartesian_path': GetCartesianPath,
    '/check_state_validity': GetStateValidity,
    '/query_planner_interface': QueryPlannerInterfaces,
}
ACTIONS = {'/move_action': MoveGroup, '/execute_trajectory': ExecuteTrajectory}

_CURES = {
    'move_group': "start it again: 'armsim move_group', or all: 'armsim bringup'",
    'simulation': "start it again: 'armsim simulation', or all: 'armsim bringup'",
}


class WatchPart(Part):
    """Checks, while a panel is open, which programs are available."""

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self.managers: dict[str, list[Any]] = {}
        """Name of a controller manager -> its controllers, as last listed."""
        self.services: dict[str, str] = {}
        """Every service of the graph -> its type."""
        self.topics: dict[str, str] = {}
        """Every topic of the graph -> its type."""
        self.seen: set[str] = set()
        """The programs that have been there at some time."""
        self.clock: float | None = None
        """Simulated time [s], None where there is none."""
        self._heard_at = 0.0
        """When a clock came last, in the event loop's time [s]."""
        self._there: dict[str, bool] = {}
        self._clock = page.link.poll(Clock, '/clock', qos.COMMAND)
        for name, kind in SERVICES.items():
            page.link.prepare(kind, name)
        for name, kind in ACTIONS.items():
            page.link.prepare(kind, name, action=True)

    async def run(self) -> None:
        """Check everything while a panel is open."""
        for work in (self._look_at_graph(), self._ask_move_group(), self._ask_managers(),
                     self._read_clock()):
            self.page.start(work)

    def now(self) -> float:
        """Return the robot's time [s]: that of the newest /clock, else the wall clock's."""
        news = self._clock.take()
        if news:
            self.clock = seconds(news[-1].clock)
            self._heard_at = asyncio.get_running_loop().time()
        return time.time() if self.clock is None else self.clock

    async def rest(self, period: float) -> None:
        """Wait so long, and then until a panel is open."""
        await asyncio.sleep(period)
        while not self.page.watched:
            await self.page.arrival.wait()
            await asyncio.sleep(0.05)

    async def _look_at_graph(self) -> None:
        node = self.page.link.node
        while True:
            self.services = {name: kinds[0] for name, kinds in node.get_service_names_and_types()}
            self.topics = {name: kinds[0] for name, kinds in node.get_topic_names_and_types()}
            found = [name.removesuffix('/list_controllers') for name, kind in
                     self.services.items()
                     if kind == 'controller_manager_msgs/srv/ListControllers']
            for name in sorted(set(found) - set(self.managers)):
                self.page.link.prepare(ListControllers, f'{name}/list_controllers')
            self.managers = {name: self.managers.get(name, []) for name in sorted(found)}
            self._publish()
            await self.rest(_GRAPH_PERIOD if self.managers else 0.3)

    async def _ask_move_group(self) -> None:
        while True:
            try:
                await self.page.planning_scene(PlanningSceneComponents.SCENE_SETTINGS, _PATIENCE)
                self._note('move_group', True)
            except ArmsimError:
                self._note('move_group', False)
            await self.rest(_PERIOD if self._there['move_group'] else 0.3)

    async def _ask_managers(self) -> None:
        while True:
            managers = list(self.managers)
            answers = await asyncio.gather(
                *(self.page.call(ListControllers, f'{name}/list_controllers', None, _PATIENCE)
                  for name in managers), return_exceptions=True)
            for name, answer in zip(managers, answers, strict=True):
                if not isinstance(answer, BaseException) and name in self.managers:
                    self.managers[name] = list(answer.controller)
            self._note('simulation', bool(managers) and not any(
                isinstance(answer, BaseException) for answer in answers))
            await self.rest(_PERIOD if self._there['simulation'] else 0.3)

    async def _read_clock(self) -> None:
        before: tuple[float, float] | None = None
        loop = asyncio.get_running_loop()
        while True:
            self.now()
            if self.clock is not None and (before is None or self._heard_at > before[0]):
                now = (self._heard_at, self.clock)
                factor = None
                if before is not None:
                    factor = round((now[1] - before[1]) / (now[0] - before[0]), 2)
                before = now
                self.page.publish('clock', {'time': round(now[1], 1), 'factor': factor})
            elif before is not None and loop.time() - before[0] > 1.5:
                self.page.publish('clock', {'time': round(before[1], 1), 'factor': 0.0})
            await self.rest(_CLOCK_PERIOD)

    def _note(self, name: str, there: bool) -> None:
        changed = self._there.get(name) is not there
        self._there[name] = there
        if there:
            self.seen.add(name)
        if changed:
            self._publish()
            self.page.take_program(name, there)

    def _publish(self) -> None:
        """Publish what is missing: in red if it was there before, as a text otherwise."""
        gone = [{'name': name, 'text': f'{name} does not answer', 'cure': _CURES[name]}
                for name in _CURES if name in self.seen and not self._there.get(name)]
        waiting = []
        if 'move_group' not in self.seen:
            waiting.append('/move_action')
        if 'simulation' not in self.seen:
            waiting.append('controller_manager')
        if not self.page.shared.get('robot'):
            waiting.append('/robot_description')
        self.page.publish('programs', {'gone': gone, 'waiting': waiting})
