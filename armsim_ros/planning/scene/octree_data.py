# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The serial form of an octree, as OctoMap reads and writes it.

A tree has 16 levels of nodes below its root; a leaf of level 0 is a cell, one of level k a cube
of ``2**k`` cells to a side. Nodes are stored depth first. The full form has for each node its log
odds (float32) and a byte with a bit for each child that exists. The binary form has for each node
with children two bits per child: 0 unknown, 1 free, 2 occupied, 3 has children itself. Child
``x + 2 y + 4 z`` is the one above the middle in these axes.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Mask

Integers = NDArray[np.int64]
Floats = NDArray[np.float32]

#: Levels below the root.
DEPTH = 16
#: Log odds of the clamps, as OctoMap computes them from probabilities.
LOWEST = float(np.log(0.1192 / (1.0 - 0.1192)))
HIGHEST = float(np.log(0.971 / (1.0 - 0.971)))

_FULL_NODE = np.dtype([('value', '<f4'), ('children', 'u1')])
_BITS = np.array([bin(byte).count('1') for byte in range(256)], dtype=np.int64)
#: Two bits of a child in the binary form.
_FREE, _OCCUPIED, _INNER = 1, 2, 3
#: Shifts and masks that put two zeros between the bits of a number.
_SPREADING = ((16, 0x1F0000FF0000FF), (8, 0x100F00F00F00F00F), (4, 0x10C30C30C30C30C3),
              (2, 0x1249249249249249))


class Leaves:
    """
    The leaves of an octree.

    :param corners: (k, 3) the lowest cell of each, 0 .. 65535.
    :param levels: (k,) 0 .. 16.
    :param log_odds: (k,) of occupancy.
    """

    def __init__(self, corners: Integers, levels: Integers, log_odds: Floats) -> None:
        self.corners, self.levels, self.log_odds = corners, levels, log_odds

    @property
    def occupied(self) -> Mask:
        """Which leaves (k,) are occupied: those as likely occupied as free, and likelier."""
        found: Mask = self.log_odds >= 0.0
        return found


def read_leaves(data: bytes, *, binary: bool) -> Leaves:
    """
    Return the leaves of a tree.

    :param data: without a file's header; at least a byte.
    :raises ValueError: the data is damaged; names the byte.
    """
    return _read_binary(data) if binary else _read_full(data)


def _read_full(data: bytes) -> Leaves:
    if len(data) % _FULL_NODE.itemsize:
        raise ValueError(_cut_off(len(data), 'a node of 5 bytes'))
    nodes = np.frombuffer(data, _FULL_NODE)
    bad = np.flatnonzero(~np.isfinite(nodes['value']))
    if len(bad):
        raise ValueError(f'the log odds at byte {5 * bad[0]} are {nodes["value"][bad[0]]}')
    children = nodes['children']
    corners, levels = _places(
        _BITS[children], 5, lambda k: (children[k][:, None] >> np.arange(8)) & 1)
    leaf = np.flatnonzero(children == 0)
    return Leaves(corners[leaf], levels[leaf], nodes['value'][leaf].astype(np.float32))


def _read_binary(data: bytes) -> Leaves:
    if len(data) % 2:
        raise ValueError(_cut_off(len(data), 'a node of 2 bytes'))
    words = np.frombuffer(data, '<u2').astype(np.int64)
    kinds = (words[:, None] >> (2 * np.arange(8))) & 3
    corners, levels = _places(
        (kinds == _INNER).sum(axis=1), 2, lambda k: kinds[k] == _INNER)
    node, child = np.nonzero((kinds == _FREE) | (kinds == _OCCUPIED))
    level = levels[node] - 1
    if len(level) and level.min() < 0:
        raise ValueError(_too_deep(2 * int(node[level < 0][0])))
    log_odds = np.where(kinds[node, child] == _OCCUPIED, HIGHEST, LOWEST).astype(np.float32)
    return Leaves(corners[node] + _steps(child, level), level, log_odds)


def _places(
    counts: Integers, size: int, children: Callable[[Integers], NDArray[np.generic]]
) -> tuple[Integers, Integers]:
    """
    Return the lowest cell (n, 3) and the level (n,) of nodes that are stored depth first.

    A node's subtree ends where the number of nodes that are still awaited falls below what it was
    before the node.

    :param counts: (n,) stored children of each node.
    :param size: bytes of a node, for errors.
    :param children: function from numbers (k,) of nodes to flags (k, 8) of stored children.
    """
    total = len(counts)
    awaited = np.cumsum(counts - 1) + 1
    ends = np.flatnonzero(awaited == 0)
    if not len(ends):
        raise ValueError(
            f'it ends at byte {size * total}, where {awaited[-1]} more nodes should follow')
    if ends[0] != total - 1:
        raise ValueError(f'the tree is complete at byte {size * (ends[0] + 1)}, but the data has '
                         f'{size * total} bytes')
    number = np.arange(total)
    order = np.lexsort((number, awaited))
    sorted_keys = awaited[order] * total + order
    corners, levels = np.zeros((total, 3), dtype=np.int64), np.full(total, DEPTH)
    nodes = np.zeros(1, dtype=np.int64)
    while len(nodes):
        level = levels[nodes[0]] - 1
        first = nodes + 1
        exists = children(nodes).astype(bool)
        following = []
        if level < 0 and exists.any():
            raise ValueError(_too_deep(size * int(nodes[exists.any(axis=1)][0])))
        for child in range(8):
            has = exists[:, child]
            if not has.any():
                continue
            found = first[has]
            levels[found] = level
            corners[found] = corners[nodes[has]] + _steps(
                np.full(len(found), child), np.full(len(found), level))
            following.append(found)
            # The next sibling comes after the subtree of this child.
            before = awaited[found - 1] - 1
            at = np.searchsorted(sorted_keys, before * total + found)
            first[has] = order[np.minimum(at, total - 1)] + 1
        nodes = np.concatenate(following) if following else nodes[:0]
    return corners, levels


def _steps(child: Integers, level: Integers) -> Integers:
    """Return the way (k, 3) in cells from a node's lowest cell to that of its child."""
    steps: Integers = ((child[:, None] >> np.arange(3)) & 1) << level[:, None]
    return steps


def _cut_off(length: int, what: str) -> str:
    return f'it has {length} bytes and ends in the middle of {what}'


def _too_deep(byte: int) -> str:
    return f'the node at byte {byte} has children below the {DEPTH} levels of an octree'


# -------------------------------------------------------------------- writing


class _Nodes:
    """The nodes of a tree level by level, pruned as OctoMap prunes."""

    def __init__(self, leaves: Leaves) -> None:
        codes = morton(leaves.corners)
        parts: list[tuple[Integers, Integers, Floats, Integers]] = []
        above: tuple[Integers, Floats, Mask] = (
            np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.float32), np.zeros(0, dtype=bool))
        for level in range(DEPTH + 1):
            own = leaves.levels == level
            code = np.concatenate([codes[own] >> 3 * level, above[0]])
            value = np.concatenate([leaves.log_odds[own].astype(np.float32), above[1]])
            inner = np.concatenate([np.zeros(int(own.sum()), dtype=bool), above[2]])
            order = np.argsort(code, kind='stable')
            code, value, inner = code[order], value[order], inner[order]
            if len(code) and (np.diff(code) == 0).any():
                raise ValueError('two leaves of the tree overlap')
            if level == DEPTH:
                parts.append((code, np.full(len(code), level), value, inner.astype(np.int64)))
                break
            parent, begin, number = np.unique(
                code >> 3, return_index=True, return_counts=True)
            highest = np.maximum.reduceat(value, begin) if len(code) else value
            lowest = np.minimum.reduceat(value, begin) if len(code) else value
            has_inner = np.logical_or.reduceat(inner, begin) if len(code) else inner
            pruned = (number == 8) & (highest == lowest) & ~has_inner
            kept = ~np.repeat(pruned, number)
            parts.append((code[kept], np.full(int(kept.sum()), level), value[kept],
                          inner[kept].astype(np.int64)))
            above = parent, highest, ~pruned
        self.code, self.level, self.value, inner_ = (
            np.concatenate([part[k] for part in parts]) for k in range(4))
        self.inner = inner_.astype(bool)
        order = np.lexsort((-self.level, self.code << 3 * self.level))
        self.code, self.level, self.value, self.inner = (
            self.code[order], self.level[order], self.value[order], self.inner[order])

    def children(self) -> tuple[Integers, Integers]:
        """Return the number of the parent and the place 0 .. 7 of each node but the root."""
        key = (self.code << 5) | self.level
        order = np.argsort(key)
        parent = ((self.code[1:] >> 3) << 5) | (self.level[1:] + 1)
        return order[np.searchsorted(key[order], parent)], self.code[1:] & 7


def write_full(leaves: Leaves) -> bytes:
    """Return the full form of a pruned tree; empty for no leaves."""
    nodes = _Nodes(leaves)
    data = np.zeros(len(nodes.code), _FULL_NODE)
    data['value'] = nodes.value
    if len(data) > 1:
        parent, place = nodes.children()
        np.bitwise_or.at(data['children'], parent, (1 << place).astype(np.uint8))
    return data.tobytes()


def write_binary(leaves: Leaves) -> tuple[bytes, int]:
    """
    Return the binary form of a pruned tree, and the number of its nodes.

    Free and occupied are all that it holds. A tree that is a single leaf is written as its eight
    children, as the form has no other way.
    """
    values = np.where(leaves.occupied, HIGHEST, LOWEST).astype(np.float32)
    nodes = _Nodes(Leaves(leaves.corners, leaves.levels, values))
    if len(nodes.code) == 1:
        kind = _OCCUPIED if nodes.value[0] >= 0.0 else _FREE
        word = sum(kind << 2 * child for child in range(8))
        return np.array([word], dtype='<u2').tobytes(), 9
    words = np.zeros(len(nodes.code), dtype=np.int64)
    if len(nodes.code):
        parent, place = nodes.children()
        kinds = np.where(nodes.inner, _INNER, np.where(nodes.value >= 0.0, _OCCUPIED, _FREE))[1:]
        np.bitwise_or.at(words, parent, kinds << 2 * place)
    return words[nodes.inner].astype('<u2').tobytes(), len(nodes.code)


def morton(corners: Integers) -> Integers:
    """Return the cells' numbers (k,) in the order of a tree, from keys (k, 3) below 65536."""
    code = np.zeros(len(corners), dtype=np.int64)
    for axis in range(3):
        spread = corners[:, axis].astype(np.int64)
        for shift, mask in _SPREADING:
            spread = (spread | spread << shift) & mask
        code |= spread << axis
    return code
