# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is called now and then within long checks, so that a request can be ended."""

from __future__ import annotations

from collections.abc import Callable

Poll = Callable[[], None]
"""Raises what ends the request."""

POLLED_STATES = {False: 50, True: 1}
"""States that are checked between two calls of a request's poll: on hulls, on exact shapes."""


def nothing() -> None:
    """Do nothing: nobody can end the request."""
