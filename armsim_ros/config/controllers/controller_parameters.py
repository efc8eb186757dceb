# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that every controller has, and those of replaced controllers."""

from __future__ import annotations

from pydantic import ConfigDict

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


class StandInParameters(ControllerParameters):
    """Parameters that a replacement reads; all others are the vendor's and ignored."""

    model_config = ConfigDict(extra='ignore')

    state_publish_rate: float = parameter(
        100.0, 'messages a second, where it publishes anything [Hz]', read_only=True, gt=0.0)
