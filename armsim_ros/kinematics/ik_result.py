# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Questions and answers of inverse kinematics."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.levenberg_marquardt import LevenbergMarquardt


def _identity() -> Matrix:
    return np.eye(4)


@dataclass(frozen=True, slots=True, eq=False)
class IKTarget:
    """
    Where a link is wanted.

    :param link: any link that the group moves.
    :param pose: (4, 4) wanted for ``link * offset`` in the model frame.
    :param offset: (4, 4) a frame fixed to the link.
    :param position_only: the orientation is free.
    """

    link: str
    pose: Matrix
    offset: Matrix = field(default_factory=_identity)
    position_only: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class IKOptions:
    """
    How inverse kinematics searches.

    :param is_valid: what else a solution (n,) must fulfil, for example no collision.
    :param rng: for random starts after the table's.
    :param clock: returns the time [s] that ``deadline`` is compared with.
    :param deadline: [s]; with it, random starts follow until then.
    :param max_starts: most starts from table and chance together, besides the seed; with 0 the
        answer is in the seed's own basin, which is searched with patience.
    :param table_starts: most starts from the table; None for as many as there are.
    :param bounds: (2, n) lower and upper bounds of the search, within the joint limits.
    """

    is_valid: Callable[[Vector], bool] | None = None
    rng: np.random.Generator | None = None
    clock: Callable[[], float] | None = None
    deadline: float | None = None
    max_starts: int | None = None
    table_starts: int | None = None
    bounds: Matrix | None = None


class IKFailure(Enum):
    """Why there is no solution."""

    UNREACHABLE = 'unreachable'
    INVALID = 'invalid'
    TIMED_OUT = 'timed out'
    LINK_NOT_MOVED = 'link not moved'


@dataclass(frozen=True, slots=True, eq=False)
class IKResult:
    """
    Answer of the inverse kinematics.

    :param q: (n,) or None.
    :param failure: None on success.
    :param message: a sentence for the user on failure.
    :param position_error: [m] of the solution, or of the nearest miss.
    :param orientation_error: [rad] likewise.
    :param rejected: solutions that ``is_valid`` refused.
    """

    q: Vector | None
    failure: IKFailure | None = None
    message: str = ''
    position_error: float = 0.0
    orientation_error: float = 0.0
    rejected: int = 0

    @property
    def success(self) -> bool:
        """Whether there is a solution."""
        return self.q is not None


class SearchRecord:
    """
    What a search has seen so far, and when it has to end.

    :param options: its clock and deadline count.
    """

    def __init__(self, options: IKOptions) -> None:
        self._clock = options.clock
        self._deadline = options.deadline
        self.rejected = 0
        self._starts = 0
        self._nearest = (math.inf, math.inf)
        self._late = False

    @property
    def timed(self) -> bool:
        """Whether a deadline is given."""
        return self._clock is not None and self._deadline is not None

    def late(self) -> bool:
        """Return whether the deadline has passed."""
        if self._clock is not None and self._deadline is not None:
            self._late = self._clock() >= self._deadline
        return self._late

    def note(self, descent: LevenbergMarquardt, solved: bool) -> None:
        """Count a descent and keep the nearest miss."""
        self._starts += 1
        miss = (descent.position_error, descent.orientation_error)
        if not solved and sum(miss) < sum(self._nearest):
            self._nearest = miss

    def result(self, group: str, targets: Sequence[IKTarget]) -> IKResult:
        """Return the failure that all this amounts to."""
        links = ', '.join(f"'{target.link}'" for target in targets)
        if self.rejected:
            return IKResult(
                None, IKFailure.INVALID,
                f"{self.rejected} IK solutions for {links} of group '{group}' were found, "
                'none of them valid', rejected=self.rejected)
        position, orientation = self._nearest
        failure = IKFailure.TIMED_OUT if self._late else IKFailure.UNREACHABLE
        cause = 'the time was used up' if self._late else 'the pose is probably out of reach'
        return IKResult(
            None, failure,
            f"no IK solution for {links} of group '{group}': the nearest of {self._starts} "
            f'descents missed by {position:.3g} m and {orientation:.3g} rad, {cause}',
            position, orientation)
