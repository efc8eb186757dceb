# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The page's current activity, its elapsed time and its time limit."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, Literal

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.web.page import Page
from armsim_ros.nodes.web.session import Session

#: Period of progress reports [s].
_PERIOD = 0.2


class Activity:
    """
    A single activity at a time, from any session; all sessions see it.

    :param page: publishes it.
    """

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
                'what': self.what, 'who': session.number, 'elapsed': round(elapsed, 1),
                'total': round(total, 1)})
            await asyncio.sleep(_PERIOD)
