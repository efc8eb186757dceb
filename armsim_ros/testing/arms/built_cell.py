# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The files of the robots that tests ask for, read once a process."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from armsim_ros.model.cell import Cell
from armsim_ros.model.cell_loading import load_cell

_cells: dict[tuple[str, str | None, str], Cell] = {}


def built_cell(robot: str, world: str | None, overrides: Mapping[str, Any]) -> Cell:
    """Return the checked files of a robot; each is read once a process."""
    key = (robot, world, repr(sorted(overrides.items())))
    if key not in _cells:
        _cells[key] = load_cell(robot, world=world, overrides=overrides)
    return _cells[key]
