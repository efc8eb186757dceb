# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Boxes around shapes, which show in many states at once which pairs of them may be near."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Mask, Matrix, Vector

#: Half the size [m] of the box around a plane, which has no end.
_ENDLESS = 1e6


class ShapeBoxes:
    """
    Boxes around g shapes, along the axes of their joints and along their own.

    In all arrays the states or the pairs are last, so that the same of all is side by side.

    :param shapes: (joint, pose (4, 4) on it, coal shape) each.
    :param pairs: (pairs, 2) numbers of shapes.
    """

    def __init__(
        self, shapes: Sequence[tuple[int, Matrix, Any]], pairs: NDArray[np.intp]
    ) -> None:
        self._joints = np.array([joint for joint, _, _ in shapes], dtype=np.intp)
        self._pairs = pairs
        boxes = [shape.aabb_local for _, _, shape in shapes]
        low, high = np.clip([[box.min_ for box in boxes], [box.max_ for box in boxes]],
                            -_ENDLESS, _ENDLESS).reshape(2, -1, 3)
        poses = np.array([pose for _, pose, _ in shapes]).reshape(-1, 4, 4)
        rotations, sizes = poses[:, :3, :3], 0.5 * (high - low)
        middles = np.einsum('gab,gb->ga', rotations, 0.5 * (low + high)) + poses[:, :3, 3]
        halves = np.einsum('gab,gb->ga', np.abs(rotations), sizes)
        #: (3, g) centres of both boxes, and half sizes along the joints' and the shapes' axes [m].
        self._middles, self._halves, self._sizes = (
            each.T.copy() for each in (middles, halves, sizes))
        #: (o,) the shapes whose axes are not their joint's, and (3, 3, o) how they are turned.
        self._oblique = np.flatnonzero((rotations != np.eye(3)).any(axis=(1, 2)))
        self._turned = rotations[self._oblique].transpose(1, 2, 0).copy()

    def near(
        self, rotations: Matrix, origins: Matrix, margins: Matrix, asked: Mask
    ) -> Mask:
        """
        Return which pairs (k, pairs) the boxes do not show to be apart.

        :param rotations: (k, joints, 3, 3) of the joints in k states.
        :param origins: (k, joints, 3) of the joints [m].
        :param margins: (k, pairs) [m] distance that counts as near.
        :param asked: (pairs,) the pairs to check.
        """
        axes = rotations.transpose(2, 3, 1, 0).take(self._joints, axis=2)
        centres = np.einsum('abgk,bg->agk', axes, self._middles)
        centres += origins.transpose(2, 1, 0).take(self._joints, axis=1)
        reaches = np.einsum('abgk,bg->agk', np.abs(axes), self._halves)
        first, second = self._pairs.T
        gaps = centres.take(first, axis=1)
        gaps -= centres.take(second, axis=1)
        np.abs(gaps, out=gaps)
        gaps -= reaches.take(first, axis=1)
        gaps -= reaches.take(second, axis=1)
        near: Mask = (margins >= gaps.max(axis=0).T) & asked
        axes[:, :, self._oblique] = np.einsum(
            'abok,bco->acok', axes[:, :, self._oblique], self._turned)
        states, pairs = near.nonzero()
        apart = self._apart(axes, centres, states, pairs) > margins[states, pairs]
        near[states[apart], pairs[apart]] = False
        return near

    def _apart(
        self, axes: Matrix, centres: Matrix, states: NDArray[np.intp], pairs: NDArray[np.intp]
    ) -> Vector:
        """
        Return a distance (p,) [m] that boxes along the shapes' own axes have at least.

        It is the largest gap along the axes of either box (Gottschalk et al. 1996,
        DOI 10.1145/237170.237244, without the products of two axes).

        :param axes: (3, 3, g, k) of the shapes in k states.
        :param centres: (3, g, k) of the boxes [m].
        :param states: (p,) numbers of states.
        :param pairs: (p,) numbers of pairs in them.
        """
        first, second = self._pairs.take(pairs, axis=0).T
        count = axes.shape[3]
        axes, centres = axes.reshape(9, -1), centres.reshape(3, -1)
        here, there = first * count + states, second * count + states
        own, others = (axes.take(place, axis=1).reshape(3, 3, -1) for place in (here, there))
        ways = centres.take(there, axis=1) - centres.take(here, axis=1)
        size, other_size = self._sizes.take(first, axis=1), self._sizes.take(second, axis=1)
        cosines = np.abs(np.einsum('abp,acp->bcp', own, others))
        gaps = np.abs(np.einsum('ap,abp->bp', ways, own))
        gaps -= size
        gaps -= np.einsum('bcp,cp->bp', cosines, other_size)
        other_gaps = np.abs(np.einsum('ap,abp->bp', ways, others))
        other_gaps -= other_size
        other_gaps -= np.einsum('bcp,bp->cp', cosines, size)
        apart: Vector = np.maximum(gaps, other_gaps, out=gaps).max(axis=0)
        return apart
