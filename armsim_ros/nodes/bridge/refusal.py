# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a client's request may fail with, and how a client is informed."""

from __future__ import annotations

from enum import IntEnum

from armsim_ros.errors import ArmsimError


class Level(IntEnum):
    """Which status messages a client gets: those of its level and graver ones."""

    NONE = 0
    ERROR = 1
    WARNING = 2
    INFO = 3


class RefusalError(ArmsimError):
    """
    A request is not carried out; the text is for the client.

    :param level: a warning where nothing was lost.
    """

    def __init__(self, text: str, level: Level = Level.ERROR) -> None:
        super().__init__(text)
        self.level = level
