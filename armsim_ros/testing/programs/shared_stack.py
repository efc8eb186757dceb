# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Programs that serve several tests in sequence, each from the same start."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from armsim_ros.testing.programs.program import start_program

if TYPE_CHECKING:
    from armsim_ros.testing.clients.robot_user import RobotUser
    from armsim_ros.testing.programs.started_stack import StartedStack

#: The planner knows what a test gives it, as in the test's own process; a test may request more.
WITHOUT_WORLD = 'scene_from_world:=false'


class SharedStack:
    """
    A stack that is put back to its start, or started anew where that does not do.

    :param domain: ROS domain id that the caller has leased.
    """

    def __init__(self, domain: int) -> None:
        self._domain = domain
        self._stack = ExitStack()
        self._key: Hashable = None
        self._started: StartedStack | None = None

    def at_start(
        self, key: Hashable, arguments: Sequence[str], namespace: Callable[[], str]
    ) -> RobotUser:
        """
        Return a stack as it is after its start.

        A reset takes arm and objects back and ends goals; the planning scene becomes what it was.
        Where controllers or parameters differ from those of the start, or the programs answer no
        more, they are ended and started again.

        :param key: equal for requests that one stack can serve.
        :param arguments: of bringup.
        :param namespace: returns where the robot's controllers are; called while programs start.
        """
        if self._started is None or key != self._key or not self._started.put_back():
            self.close()
            with ExitStack() as starting:
                program = starting.enter_context(
                    start_program('bringup', self._domain, WITHOUT_WORLD, *arguments))
                # What takes long to import, and to read, comes while the programs start.
                from armsim_ros.testing.clients.robot_user import user_of
                from armsim_ros.testing.programs.started_stack import StartedStack

                robot = starting.enter_context(user_of(program, self._domain, namespace()))
                self._started, self._key = StartedStack(robot), key
                self._stack = starting.pop_all()
        return self._started.robot

    def close(self) -> None:
        """End the programs."""
        self._started = None
        self._stack.close()
