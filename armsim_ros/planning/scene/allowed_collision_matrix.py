# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which pairs of links and objects may touch."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TypeVar

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.tree import adjacent_pairs

Pair = tuple[str, str]
Key = TypeVar('Key')


def sorted_pair(first: str, second: str) -> Pair:
    """Return the two names in alphabetical order."""
    return (first, second) if first <= second else (second, first)


@dataclass(frozen=True, slots=True)
class AcmUpdate:
    """
    Content of ``moveit_msgs/msg/AllowedCollisionMatrix``.

    :param entry_names: n names of links and objects.
    :param entry_values: n rows of n booleans, True where the two may touch.
    """

    entry_names: tuple[str, ...] = ()
    entry_values: tuple[tuple[bool, ...], ...] = ()
    default_entry_names: tuple[str, ...] = ()
    default_entry_values: tuple[bool, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class AllowedCollisionMatrix:
    """
    Allowed and forced pairs; it never changes, an edit makes a new matrix.

    A pair with an entry of its own follows it. Any other pair follows the defaults of its
    names: where both have a default, both must allow. What is named nowhere is checked.

    :param pairs: sorted pair of names -> True where they may touch.
    :param defaults: name -> True where it may touch whatever no pair speaks of.
    :param names: all names it knows, in the order of entry.
    """

    pairs: Mapping[Pair, bool] = field(default_factory=lambda: MappingProxyType({}))
    defaults: Mapping[str, bool] = field(default_factory=lambda: MappingProxyType({}))
    names: tuple[str, ...] = ()

    def allowed(self, first: str, second: str) -> bool:
        """Return whether two links or objects may touch."""
        entry = self.pairs.get((first, second) if first <= second else (second, first))
        return self._default(first, second) if entry is None else entry

    def _default(self, first: str, second: str) -> bool:
        a, b = self.defaults.get(first), self.defaults.get(second)
        if a is None or b is None:
            return bool(a) or bool(b)
        return a and b

    def differences(self, other: AllowedCollisionMatrix) -> tuple[set[Pair], set[str]]:
        """Return the pairs that another matrix has otherwise, and the names of such defaults."""
        if self is other:
            return set(), set()
        return (
            {pair for pair, _ in self.pairs.items() ^ other.pairs.items()},
            {name for name, _ in self.defaults.items() ^ other.defaults.items()})

    def forgotten_by(self, other: AllowedCollisionMatrix, names: Container[str]) -> list[Pair]:
        """
        Return the pairs that may touch here, and not where another matrix lacks a name of theirs.

        :param names: those whose pairs are meant.
        """
        if self is other:
            return []
        known = set(other.names)
        return [pair for pair, allowed in self.pairs.items()
                if allowed and not known.issuperset(pair) and not other.allowed(*pair)
                and all(name in names for name in pair)]

    def with_pair(self, first: str, second: str, allowed: bool) -> AllowedCollisionMatrix:
        """Return a matrix in which a pair is set."""
        return self.with_pairs({sorted_pair(first, second): allowed})

    def with_pairs(self, pairs: Mapping[Pair, bool]) -> AllowedCollisionMatrix:
        """Return a matrix in which several pairs are set; the names may be in any order."""
        added = {sorted_pair(*pair): allowed for pair, allowed in pairs.items()}
        names = _united(self.names, (name for pair in added for name in pair))
        return AllowedCollisionMatrix({**self.pairs, **added}, self.defaults, names)

    def without_pair(self, first: str, second: str) -> AllowedCollisionMatrix:
        """Return a matrix in which a pair has no entry of its own; itself if it had none."""
        pair = sorted_pair(first, second)
        if pair not in self.pairs:
            return self
        return AllowedCollisionMatrix(
            {key: value for key, value in self.pairs.items() if key != pair},
            self.defaults, self.names)

    def with_entry(
        self, name: str, allowed: bool, others: Iterable[str] | None = None
    ) -> AllowedCollisionMatrix:
        """Return a matrix in which a name's pairs with others, or with all known, are set."""
        partners = self.names if others is None else tuple(others)
        pairs = {sorted_pair(name, other): allowed for other in partners if other != name}
        matrix = self.with_pairs(pairs)
        return AllowedCollisionMatrix(
            matrix.pairs, matrix.defaults, _united(matrix.names, (name,)))

    def with_default(self, name: str, allowed: bool) -> AllowedCollisionMatrix:
        """Return a matrix with a default for a name."""
        return AllowedCollisionMatrix(
            self.pairs, {**self.defaults, name: allowed}, _united(self.names, (name,)))

    def without(self, names: Iterable[str]) -> AllowedCollisionMatrix:
        """Return a matrix without the pairs of the names; defaults stay. Itself without such."""
        gone = set(names).intersection(self.names)
        if not gone:
            return self
        pairs = {pair: value for pair, value in self.pairs.items() if not gone.intersection(pair)}
        left = tuple(name for name in self.names if name not in gone or name in self.defaults)
        if len(pairs) == len(self.pairs) and left == self.names:
            return self
        return AllowedCollisionMatrix(pairs, self.defaults, left)

    def to_update(self) -> AcmUpdate:
        """Return the content of a message, sorted; every pair has its effective value."""
        names, defaults = tuple(sorted(self.names)), dict(sorted(self.defaults.items()))
        rows = tuple(tuple(self.allowed(a, b) for b in names) for a in names)
        return AcmUpdate(names, rows, tuple(defaults), tuple(defaults.values()))

    @classmethod
    def from_update(cls, update: AcmUpdate) -> AllowedCollisionMatrix:
        """
        Return the matrix of a message; only its upper triangle is read.

        :raises PlanningError: FAILURE where rows and names do not fit together, or a name that
            is defined twice is allowed and forbidden to touch the same.
        """
        names, rows = update.entry_names, update.entry_values
        _check_sizes(update)
        defaults = _without_contradiction(
            (name, (name, bool(value))) for name, value in
            zip(update.default_entry_names, update.default_entry_values, strict=True))
        plain = cls({}, defaults)
        values = _without_contradiction(
            (names[i], (sorted_pair(names[i], names[j]), bool(rows[i][j])))
            for i in range(len(names))
            for j in range(i + 1, len(names))
            if names[i] != names[j])
        pairs = {pair: value for pair, value in values.items() if value != plain._default(*pair)}
        return cls(pairs, defaults, _united(names, defaults))

    @classmethod
    def from_robot(
        cls, robot: RobotModel, *, auto_disable_adjacent: bool = True
    ) -> AllowedCollisionMatrix:
        """
        Return the matrix that the SRDF asks for.

        :param auto_disable_adjacent: where the SRDF disables no pair at all, allow the pairs
            of links that at most one joint separates.
        """
        semantic = robot.semantic
        disabled = {sorted_pair(*pair) for pair in semantic.disabled_collisions}
        if auto_disable_adjacent and not disabled:
            disabled = set(adjacent_pairs(robot)) - semantic.enabled_collisions
        pairs = {sorted_pair(*pair): False for pair in semantic.enabled_collisions}
        pairs.update(dict.fromkeys(disabled, True))
        defaults = {name: True for name in robot.links if name in semantic.default_disabled}
        names = [name for name, link in robot.links.items() if link.collisions]
        return cls(pairs, defaults, _united(names, (n for p in sorted(pairs) for n in p)))


def _united(first: Iterable[str], second: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys([*first, *second]))


def _without_contradiction(
    entries: Iterable[tuple[str, tuple[Key, bool]]]
) -> dict[Key, bool]:
    """Return key -> value; PlanningError where a key has two values."""
    values: dict[Key, bool] = {}
    for name, (key, value) in entries:
        if values.setdefault(key, value) != value:
            raise PlanningError(
                MoveItErrorCode.FAILURE,
                f"the allowed collision matrix names '{name}' twice and contradicts itself about "
                f'{key}; the matrix stays as it was')
    return values


def _check_sizes(update: AcmUpdate) -> None:
    n, m = len(update.entry_names), len(update.default_entry_names)
    sizes = [len(row) for row in update.entry_values]
    wrong = ''
    if sizes != [n] * n:
        wrong = (f'{n} entry_names but {len(sizes)} rows of {sorted(set(sizes))} values; it needs '
                 f'{n} rows of {n} values')
    elif m != len(update.default_entry_values):
        wrong = (f'{m} default_entry_names but {len(update.default_entry_values)} '
                 'default_entry_values')
    if wrong:
        raise PlanningError(
            MoveItErrorCode.FAILURE,
            f'the allowed collision matrix has {wrong}; the matrix stays as it was')
