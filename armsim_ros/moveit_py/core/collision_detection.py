# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.core.collision_detection``: what is asked of a collision check, and its answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import combinations_with_replacement
from typing import Any

from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.scene.allowed_collision_matrix import AllowedCollisionMatrix as Matrix


@dataclass(init=False)
class CollisionRequest:
    """
    What is to be found out about a state.

    Its fields: ``joint_model_group_name``, '' for the whole robot; ``distance``, whether the
    smallest distance is wanted; ``contacts``, whether contacts are wanted, of them at most
    ``max_contacts``; ``verbose``, whether contacts are logged. There is a single contact per
    pair, the deepest, and there are no costs.
    """

    joint_model_group_name: str = ''
    distance: bool = False
    cost: bool = False
    contacts: bool = False
    max_contacts: int = 1
    max_contacts_per_pair: int = 1
    max_cost_sources: int = 1
    verbose: bool = False


@dataclass(init=False)
class CollisionResult:
    """
    The answer: filled by the checks of a planning scene.

    Its fields: ``collision``; ``distance`` [m], where requested; ``contact_count`` and
    ``contacts``, (name, name) -> contacts with position, normal and depth; ``cost_sources``,
    always empty.
    """

    collision: bool = False
    distance: float = float('inf')
    contact_count: int = 0
    contacts: dict[tuple[str, str], list[Contact]] = field(default_factory=dict)
    cost_sources: set[Any] = field(default_factory=set)

    def __init__(self) -> None:
        """Begin without a collision."""
        self.contacts = {}
        self.cost_sources = set()


class AllowedCollisionMatrix:
    """
    Which pairs of links and objects may touch.

    :param names: of links and objects.
    :param default_entry: whether any two of them may touch.
    """

    def __init__(self, names: Sequence[str], default_entry: bool = False) -> None:
        self._own = Matrix().with_pairs(dict.fromkeys(
            combinations_with_replacement(names, 2), default_entry))
        self._read: Callable[[], Matrix] = lambda: self._own
        self._write: Callable[[Matrix], None] = self._keep

    @classmethod
    def _of(
        cls, read: Callable[[], Matrix], write: Callable[[Matrix], None]
    ) -> AllowedCollisionMatrix:
        """Return a matrix that reads and writes another one, such as that of a scene."""
        made = cls(())
        made._read, made._write = read, write
        return made

    def _keep(self, matrix: Matrix) -> None:
        self._own = matrix

    def get_entry(self, name1: str, name2: str) -> tuple[bool, str]:
        """Return whether a pair has an entry, and that: ALWAYS, NEVER, or UNKNOWN without."""
        pair = (name1, name2) if name1 <= name2 else (name2, name1)
        entry = self._read().pairs.get(pair)
        return entry is not None, {None: 'UNKNOWN', True: 'ALWAYS', False: 'NEVER'}[entry]

    def set_entry(self, name1: str, name2: str, allowed: bool) -> None:
        """Set whether two links or objects may touch."""
        self._write(self._read().with_pair(name1, name2, bool(allowed)))

    def remove_entry(self, name1: str, name2: str) -> None:
        """Remove the entry of a pair; nothing happens where it has none."""
        self._write(self._read().without_pair(name1, name2))

    def clear(self) -> None:
        """Remove all entries."""
        self._write(Matrix())
