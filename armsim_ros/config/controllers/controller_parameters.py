# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that every controller has, as controller_interface declares them."""

from __future__ import annotations

from armsim_ros.config.base import parameter, Settings


class ControllerParameters(Settings):
    """The base of the parameters of all kinds of controllers."""

    update_rate: int = parameter(
        0, "updates per second, by default the manager's rate [Hz]", read_only=True, ge=0
    )
    is_async: bool = parameter(
        False, 'has no effect: all controllers run in the same control loop', read_only=True
    )
    thread_priority: int = parameter(
        -100, 'has no effect: all controllers run in the same control loop', read_only=True
    )
