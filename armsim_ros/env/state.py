# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The saved state of an environment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from armsim_ros.arrays import Vector
from armsim_ros.env.ranges import Episode
from armsim_ros.sim.physics.saved_state import SimulationState


@dataclass(frozen=True, eq=False)
class EnvState:
    """
    All that the future of an environment depends on; opaque, may be pickled.

    :param episode: what was drawn.
    :param simulation: physics and drives.
    :param target: (n,) the last command [rad or m].
    :param steps: done in the episode.
    :param waiting: actions that latency holds back.
    :param random: of the environment's random numbers, of the noise and of the pushes.
    :param task: what a task remembers of the episode.
    """

    episode: Episode
    simulation: SimulationState
    target: Vector
    steps: int
    waiting: tuple[Vector, ...]
    random: tuple[Mapping[str, Any], ...]
    task: Mapping[str, Any]
