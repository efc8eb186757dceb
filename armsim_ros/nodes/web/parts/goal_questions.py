# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a panel may ask of a goal."""

from __future__ import annotations

from armsim_ros.nodes.web.page import Ask


class ChooseGroup(Ask):
    """Another planning group."""

    name: str


class ChooseState(Ask):
    """A named state, or one of the words for others."""

    name: str


class SetJoints(Ask):
    """Joint positions [rad or m]."""

    values: dict[str, float]


class ChooseStart(Ask):
    """Where plans begin: the current state, a named state, or the state of the ghost."""

    name: str
