# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Commands of a panel about the goal."""

from __future__ import annotations

from armsim_ros.nodes.web.page import PanelCommand


class ChooseGroup(PanelCommand):
    """Another planning group."""

    name: str


class ChooseState(PanelCommand):
    """A named state, or a keyword for others."""

    name: str


class SetJoints(PanelCommand):
    """Joint positions [rad or m]."""

    values: dict[str, float]


class ChooseStart(PanelCommand):
    """Where plans begin: the current state, a named state, or the state of the ghost."""

    name: str
