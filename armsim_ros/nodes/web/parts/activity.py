# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the page does for a visitor, how long it has done so, and how long it may take."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, Literal

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.web.page import Page
from armsim_ros.nodes.web.visitor import Visitor

#: Between two words about how far it is [s].
_PERIOD = 0.2


class Activity:
    """
    One thing at a time, whoever asked for it; all visitors are told.

    :param page: who tells them.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self.what: Literal['', 'planning', 'executing'] = ''
        self._telling: asyncio.Task[Any] | None = None
        page.publish('activity', None)

    def begin(self, what: Literal['planning', 'executing'], visitor: Visitor, total: float,
              clock: Callable[[], float]) -> None:
        """
        Tell that something goes on from now on, also in place of what did.

        :param total: how long it takes, or may take at most [s].
        :param clock: which time it takes [s].
        """
        self.end()
        self.what = what
        self._telling = self._page.start(self._tell(visitor, total, clock))

    def end(self) -> None:
        """Tell that it is over."""
        self.what = ''
        if self._telling is not None:
            self._telling.cancel()
            self._telling = None
        self._page.publish('activity', None)

    def need_rest(self) -> None:
        """
        Let only one thing go on.

        :raises ArmsimError: there is something.
        """
        if self.what:
            raise ArmsimError(f"the page is {self.what} already; press 'Stop' to end that")

    async def _tell(self, visitor: Visitor, total: float, clock: Callable[[], float]) -> None:
        begun = clock()
        while True:
            elapsed = min(max(clock() - begun, 0.0), total)
            self._page.publish('activity', {
                'what': self.what, 'who': visitor.number, 'elapsed': round(elapsed, 1),
                'total': round(total, 1)})
            await asyncio.sleep(_PERIOD)
