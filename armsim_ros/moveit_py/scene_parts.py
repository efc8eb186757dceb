# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parts of a planning scene: collision checks and their answers, allowed pairs, frames, world."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.scene.allowed_collision_matrix import AllowedCollisionMatrix as Pairs
from armsim_ros.planning.scene.content import further_frames
from armsim_ros.planning.scene.planning_scene import PlanningScene


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
        self._own = Pairs().with_pairs(dict.fromkeys(
            combinations_with_replacement(names, 2), default_entry))
        self._read: Callable[[], Pairs] = lambda: self._own
        self._write: Callable[[Pairs], None] = self._keep

    @classmethod
    def _of(
        cls, read: Callable[[], Pairs], write: Callable[[Pairs], None]
    ) -> AllowedCollisionMatrix:
        """Return a matrix that reads and writes another one, such as that of a scene."""
        made = cls(())
        made._read, made._write = read, write
        return made

    def _keep(self, matrix: Pairs) -> None:
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
        self._write(Pairs())


class World:
    """The world of a planning scene; empty, and filled through the scene."""


class Transforms:
    """
    A snapshot of frames and their poses in a target frame.

    :param target_frame: the frame of all poses.
    """

    def __init__(self, target_frame: str) -> None:
        self._target, self._poses = target_frame, {target_frame: np.eye(4)}

    @classmethod
    def _of(cls, scene: PlanningScene) -> Transforms:
        made = cls(scene.model_frame)
        made._poses.update({name: scene.frame_pose(name) for name in further_frames(scene.content)
                            if scene.has_frame(name)})
        return made

    def get_target_frame(self) -> str:
        """Return the frame of all poses."""
        return self._target

    def get_transform(self, from_frame: str) -> Matrix:
        """
        Return the pose (4, 4) of a frame.

        :raises KeyError: it is not known; the text lists those that are.
        """
        if from_frame not in self._poses:
            raise KeyError(f"frame '{from_frame}' is not known; known: {', '.join(self._poses)}")
        return self._poses[from_frame]

    def get_all_transforms(self) -> Mapping[str, Matrix]:
        """Return frame -> pose (4, 4)."""
        return dict(self._poses)
