# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a file or text of a world gave, or why it gave nothing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

from armsim_ros.errors import SimulationError
from armsim_ros.model.world_objects import WorldObject


class Fault(Enum):
    """Why a resource cannot be used; the names of simulation_interfaces' result codes."""

    UNSUPPORTED_FORMAT = 'unsupported format'
    NO_RESOURCE = 'no resource'
    RESOURCE_PARSE_ERROR = 'parse error'
    MISSING_ASSETS = 'missing assets'
    UNSUPPORTED_ASSETS = 'unsupported assets'


#: Faults of files that a world refers to.
ASSET_FAULTS = (Fault.MISSING_ASSETS, Fault.UNSUPPORTED_ASSETS)


class ResourceFaultError(SimulationError):
    """
    A file or text of a world cannot be used.

    :param fault: the kind of error.
    :param text: what is wrong, where, and what is allowed.
    """

    def __init__(self, fault: Fault, text: str) -> None:
        super().__init__(text)
        self.fault = fault


class Unused:
    """
    Collects what of a file has no effect here, each once.

    :ivar remarks: what the file leaves to a default, with its place.
    """

    def __init__(self) -> None:
        self._lines: dict[str, None] = {}
        self.remarks: list[str] = []

    def add(self, line: str) -> None:
        """Note an element."""
        self._lines[line] = None

    @property
    def lines(self) -> tuple[str, ...]:
        """All of them, in the order in which they were found."""
        return tuple(self._lines)


@dataclass(frozen=True, slots=True, eq=False)
class LoadedObject:
    """
    An object that was read.

    :param item: the object; its pose is that of the file.
    :param unused: what of the file has no effect here, a line each.
    :param remarks: what the file leaves to a default, a line each.
    """

    item: WorldObject
    unused: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class LoadedWorld:
    """
    A world that was read.

    :param floor: height of the floor [m]; None where there is none.
    :param unused: what of the file has no effect here, a line each.
    :param gravity: [m/s^2]; None where ``simulation.yaml`` decides.
    :param remarks: what the file leaves to a default, a line each.
    """

    name: str
    items: tuple[WorldObject, ...]
    floor: float | None = None
    unused: tuple[str, ...] = ()
    gravity: tuple[float, float, float] | None = None
    remarks: tuple[str, ...] = ()


def told_of(loaded: LoadedObject | LoadedWorld) -> str:
    """Return what a user should know of what was read, '' for nothing."""
    unused = (f'not used: {"; ".join(loaded.unused)}',) if loaded.unused else ()
    return '; '.join((*unused, *loaded.remarks))


def check_names(items: Iterable[WorldObject]) -> None:
    """
    Refuse a world with two objects of the same name.

    :raises ResourceFaultError: names it.
    """
    seen: set[str] = set()
    for item in items:
        if item.name in seen:
            raise ResourceFaultError(
                Fault.RESOURCE_PARSE_ERROR, f"two objects have the name '{item.name}'")
        seen.add(item.name)
