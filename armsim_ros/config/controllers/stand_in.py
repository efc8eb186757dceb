# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of controllers that are replaced."""

from __future__ import annotations

from pydantic import ConfigDict

from armsim_ros.config.base import parameter
from armsim_ros.config.controllers.controller_parameters import ControllerParameters


class StandInParameters(ControllerParameters):
    """Parameters that a replacement reads; all others are the vendor's and ignored."""

    model_config = ConfigDict(extra='ignore')

    state_publish_rate: float = parameter(
        100.0, 'messages a second, where it publishes anything [Hz]', read_only=True, gt=0.0)
