# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the page sends to edit objects of the planning scene; lengths in [m]."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from armsim_ros.nodes.web.page import PanelCommand

Three = tuple[float, float, float]
Four = tuple[float, float, float, float]


class Add(PanelCommand):
    """A new object before the robot."""

    shape: Literal['box', 'sphere', 'cylinder']


class AddMesh(PanelCommand):
    """A new object from a mesh file, its bytes in base64."""

    name: str = Field(max_length=200)
    data: str


class Change(PanelCommand):
    """Another place, turn (quaternion xyzw) or size of an object."""

    id: str
    xyz: Three | None = None
    turn: Four | None = None
    size: list[float] | None = Field(default=None, max_length=3)


class Named(PanelCommand):
    """An object."""

    id: str


class Select(PanelCommand):
    """The object to move by handles; '' for none."""

    id: str = ''


class Allow(PanelCommand):
    """Pairs that may touch from now on."""

    pairs: list[tuple[str, str]] = Field(min_length=1, max_length=50)


class Load(PanelCommand):
    """Objects that were saved."""

    text: str


class Save(PanelCommand):
    """The objects as text."""
