# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint positions that put links where they are wanted."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import replace
import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.ik_result import IKFailure, IKOptions, IKResult, IKTarget, SearchRecord
from armsim_ros.kinematics.kinematic_model import Indices, KinematicModel
from armsim_ros.kinematics.levenberg_marquardt import Convergence, LevenbergMarquardt, PoseTask
from armsim_ros.model.transforms import inverse_pose

#: Solutions that differ by less in every joint [rad or m] count as equal.
DISTINCT = 0.05
#: Takes any solution, in whatever time.
ANY = IKOptions()

Answer = TypeVar('Answer')


def end_of(tries: Generator[None, None, Answer]) -> Answer:
    """Run a search to its end and return its answer."""
    while True:
        try:
            next(tries)
        except StopIteration as end:
            answer: Answer = end.value
            return answer


class InverseKinematics:
    """
    Inverse kinematics of a planning group.

    From the seed first, then from sampled configurations whose poses are nearest to the
    target (the table is made once for a robot, group and set of links), then, while a clock
    allows, from random starts. Limits are kept; a joint that may turn more
    than once takes the turn nearest to the seed.

    :param kinematics: the robot.
    :param group: planning group whose active variables are found.
    :param position_only: leave all orientations free.
    :param max_starts: starts taken from the table.
    :param max_iterations: most Jacobians per start.
    :param position_tolerance: [m].
    :param orientation_tolerance: [rad].
    :param table_size: samples in the table.
    :raises PlanningError: INVALID_GROUP_NAME for an unknown group.
    """

    def __init__(
        self, kinematics: KinematicModel, group: str, *, position_only: bool = False,
        max_starts: int = 60, max_iterations: int = 100, position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6, table_size: int = 1000
    ) -> None:
        """Keep the settings; tables are made at the first need."""
        self.kinematics, self.group = kinematics, group
        self._indices = kinematics.group_indices(group)
        self._moved = kinematics.moved_links(group)
        self._variables_of: dict[tuple[str, ...], Indices] = {}
        self._position_only, self._max_starts = position_only, max_starts
        self._table_size = table_size
        self._convergence = Convergence(
            position_tolerance, orientation_tolerance, max_iterations)

    def prepare(self, targets: Sequence[IKTarget]) -> None:
        """Make the tables for these targets; otherwise a first search spends its time on them."""
        if self._refusal(targets) is None:
            self._table(tuple(target.link for target in targets))

    @property
    def turning(self) -> Indices:
        """The group's variables that are angles and may turn more than once."""
        found: Indices = self.kinematics.cached(
            ('turning variables', self.group), lambda: _turning(self.kinematics, self._indices))
        return found

    def solve(
        self, targets: Sequence[IKTarget], seed: Vector, options: IKOptions = ANY,
    ) -> IKResult:
        """
        Return the first solution found, the seed's own basin first.

        :param targets: one or more; the links may be several tips.
        :param seed: (n,) first start, and state of the joints outside the group.
        :param options: what is valid, where to start, when to end.
        :raises PlanningError: INVALID_LINK_NAME for an unknown link.
        """
        return end_of(self.tries(targets, seed, options))

    def tries(
        self, targets: Sequence[IKTarget], seed: Vector, options: IKOptions = ANY,
    ) -> Generator[None, None, IKResult]:
        """Do as :meth:`solve`, and yield after each start that led nowhere."""
        refused = self._refusal(targets)
        if refused is not None:
            return refused
        search = SearchRecord(options)
        bounds = self._bounds(options)
        descent = self._descent(targets, bounds)
        only_seed = options.max_starts == 0
        for start in self._starts(targets, seed, search, options):
            found = descent.descend(seed, start, patient=only_seed)
            search.note(descent, found is not None)
            if found is not None:
                solution = self._unwind(found, seed, bounds)
                if options.is_valid is None or options.is_valid(solution):
                    return IKResult(
                        solution, None, '', descent.position_error, descent.orientation_error,
                        search.rejected)
                search.rejected += 1
            yield
        return search.result(self.group, targets)

    def solve_batch(
        self, batch: Iterable[Sequence[IKTarget]], seed: Vector, options: IKOptions = ANY,
    ) -> list[IKResult]:
        """
        Return a result for each of many targets, as :meth:`solve` does.

        Each is searched from the solution before it, so that poses that lie close together get
        solutions that do.

        :param batch: what is wanted in each case, in the order to be solved.
        :param seed: (n,) first start, and state of the joints outside the group.
        """
        results = []
        for targets in batch:
            result = self.solve(targets, seed, options)
            seed = seed if result.q is None else result.q
            results.append(result)
        return results

    def solutions(
        self, targets: Sequence[IKTarget], seed: Vector, options: IKOptions = ANY, *,
        count: int = 8,
    ) -> list[Vector]:
        """
        Return up to ``count`` distinct solutions (n,), nearest to the seed first.

        Parameters are those of :meth:`solve`; starts come to an end without ``max_starts``, too.
        """
        if self._refusal(targets) is not None:
            return []
        if options.max_starts is None:
            options = replace(options, max_starts=self._max_starts)
        search = SearchRecord(options)
        bounds = self._bounds(options)
        descent = self._descent(targets, bounds)
        found: list[Vector] = []
        for start in self._starts(targets, seed, search, options):
            solution = descent.descend(seed, start)
            if solution is None:
                continue
            solution = self._unwind(solution, seed, bounds)
            if any(float(np.abs(solution - other).max()) < DISTINCT for other in found):
                continue
            if options.is_valid is None or options.is_valid(solution):
                found.append(solution)
                if len(found) >= count:
                    break
        return sorted(found, key=lambda q: float(np.linalg.norm(q - seed)))

    # ---------------------------------------------------------------- parts

    def _refusal(self, targets: Sequence[IKTarget]) -> IKResult | None:
        if not targets:
            raise ValueError('inverse kinematics needs at least one target')
        for target in targets:
            self.kinematics.frame_index(target.link)
            if target.link not in self._moved:
                return IKResult(
                    None,
                    IKFailure.LINK_NOT_MOVED,
                    f"group '{self.group}' does not move link '{target.link}'; it moves "
                    f'{", ".join(sorted(self._moved)) or "nothing"}',
                    math.inf,
                    math.inf)
        return None

    def _free_orientation(self, target: IKTarget) -> bool:
        return self._position_only or target.position_only

    def _bounds(self, options: IKOptions) -> Matrix:
        """Return the bounds (2, n) of a search."""
        if options.bounds is not None:
            return options.bounds
        return np.array([self.kinematics.lower, self.kinematics.upper])

    def _descent(self, targets: Sequence[IKTarget], bounds: Matrix) -> LevenbergMarquardt:
        tasks = []
        for target in targets:
            frame = self.kinematics.frame_index(target.link)
            if self._free_orientation(target):
                point = np.array(target.offset[:3, 3])
                tasks.append(PoseTask(frame, np.array(target.pose[:3, 3]), point))
            else:
                wanted = target.pose @ inverse_pose(target.offset)
                tasks.append(PoseTask(frame, pin.SE3(wanted)))
        return LevenbergMarquardt(
            self.kinematics, self.group, self._variables(targets), tuple(tasks),
            self._convergence, bounds)

    def _variables(self, targets: Sequence[IKTarget]) -> Indices:
        """Return which of the group's variables move any of the targets' links."""
        links = tuple(target.link for target in targets)
        found = self._variables_of.get(links)
        if found is None:
            found = self.kinematics.moving_variables(self.group, links)
            self._variables_of[links] = found
        return found

    def _starts(
        self, targets: Sequence[IKTarget], seed: Vector, search: SearchRecord, options: IKOptions
    ) -> Iterator[Vector]:
        """Yield the seed, the table's best, then random values while there is time."""
        variables = self._variables(targets)
        low, high = self._bounds(options)[:, self._indices[variables]]
        yield seed[self._indices[variables]]
        limit = self._max_starts if options.max_starts is None else options.max_starts
        if limit <= 0:
            return
        table = self._table(tuple(target.link for target in targets))
        wanted = np.array([target.pose @ inverse_pose(target.offset) for target in targets])
        free = any(self._free_orientation(target) for target in targets)
        used = 0
        count = self._max_starts if options.table_starts is None else options.table_starts
        for start in table.best_first(wanted, seed, min(limit, count), position_only=free):
            if search.late():
                return
            used += 1
            yield np.clip(start[variables], low, high)
        generator = options.rng if options.rng is not None else np.random.default_rng(1)
        endless = options.max_starts is None and search.timed
        low, high = sampling_range(low, high)
        while (endless or used < limit) and not search.late():
            used += 1
            yield generator.uniform(low, high)

    def _table(self, links: tuple[str, ...]) -> StartTable:
        key = ('start table', self.group, links, self._table_size)
        table: StartTable = self.kinematics.cached(
            key, lambda: StartTable(self.kinematics, self.group, links, self._table_size))
        return table

    def _unwind(self, q: Vector, seed: Vector, bounds: Matrix) -> Vector:
        """Return q with every full turn removed that leads away from the seed, within bounds."""
        kinematics, turns = self.kinematics, self.turning
        if not len(turns):
            return q
        values = q[turns]
        unwound = values - 2.0 * math.pi * np.round((values - seed[turns]) / (2.0 * math.pi))
        lower, upper = bounds[:, turns]
        allowed = (unwound >= lower) & (unwound <= upper)
        if not allowed.any():
            return q
        result = q.copy()
        result[turns] = np.where(allowed, unwound, values)
        return kinematics.apply_mimic(result)


def _turning(kinematics: KinematicModel, indices: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the variables that are angles and may turn more than once."""
    robot = kinematics.robot
    wide = [
        int(index)
        for index in indices
        if robot.joints[kinematics.names[index]].type.value in ('revolute', 'continuous')
        and kinematics.upper[index] - kinematics.lower[index] >= 2.0 * math.pi
    ]
    return np.array(wide, dtype=np.int64)


__all__ = ['IKFailure', 'IKOptions', 'IKResult', 'IKTarget', 'InverseKinematics', 'end_of']


class StartTable:
    """
    Configurations of a group, sampled once, and where they put a set of links.

    Poses are kept relative to the link that carries the group's first joint, so that joints
    outside the group may be anywhere. Two poses count as near when positions, measured in
    the spread of all samples, and orientations, measured as the chord between rotation
    matrices, are near.

    :param kinematics: the robot.
    :param group: planning group whose variables are sampled.
    :param links: links whose poses are kept.
    :param size: number of samples.
    """

    def __init__(
        self, kinematics: KinematicModel, group: str, links: tuple[str, ...], size: int
    ) -> None:
        self._kinematics, self._links = kinematics, links
        self._base = base_link(kinematics, group)
        indices = kinematics.group_indices(group)
        low, high = sampling_range(kinematics.lower[indices], kinematics.upper[indices])
        rng = np.random.default_rng(0)
        self.samples: Matrix = rng.uniform(low, high, (size, len(indices)))
        self._poses: Matrix = np.empty((size, len(links), 4, 4))
        q = kinematics.default()
        for row, values in enumerate(self.samples):
            self._poses[row] = self._relative(kinematics.insert(q, group, values))
        spread = self._poses[:, :, :3, 3].std(axis=0).max(initial=0.0)
        self._length = max(float(spread), 1e-3)

    def _relative(self, q: Vector) -> Matrix:
        base, *poses = self._kinematics.link_poses(q, (self._base, *self._links))
        relative: Matrix = inverse_pose(base) @ np.array(poses)
        return relative

    def best_first(
        self, targets: Matrix, q: Vector, count: int, *, position_only: bool = False
    ) -> Matrix:
        """
        Return the samples (count, m) whose poses are nearest to the targets.

        :param targets: (links, 4, 4) wanted poses in the model frame.
        :param q: (n,) state of the joints outside the group.
        :param position_only: leave orientations out.
        """
        base = self._kinematics.link_pose(q, self._base)
        wanted = inverse_pose(base) @ targets
        difference = self._poses - wanted
        cost = (difference[:, :, :3, 3] ** 2).sum(axis=(1, 2)) / self._length**2
        if not position_only:
            # |R1 - R2|^2 = 8 sin^2(angle / 2) in the Frobenius norm.
            cost += (difference[:, :, :3, :3] ** 2).sum(axis=(1, 2, 3)) / 2.0
        if count >= len(cost):
            order = np.argsort(cost, kind='stable')
        else:
            order = np.argpartition(cost, count)[:count]
            order = order[np.argsort(cost[order], kind='stable')]
        best: Matrix = self.samples[order]
        return best


def base_link(kinematics: KinematicModel, group: str) -> str:
    """Return the link that carries the first of a group's active joints."""
    robot = kinematics.robot
    active = robot.semantic.groups[group].active_joints
    return robot.joints[active[0]].parent if active else robot.root_link


def sampling_range(lower: Vector, upper: Vector) -> tuple[Vector, Vector]:
    """
    Return finite bounds to sample between; where a turn or more is free, a turn about 0.

    :param lower: (m,) [rad or m], may be infinite.
    :param upper: (m,) [rad or m], may be infinite.
    """
    low, high = lower.copy(), upper.copy()
    wide = upper - lower >= 2.0 * math.pi
    with_zero = wide & (lower <= -math.pi) & (upper >= math.pi)
    low[with_zero], high[with_zero] = -math.pi, math.pi
    for bound, other, sign in ((low, high, -1.0), (high, low, 1.0)):
        endless = ~np.isfinite(bound)
        bound[endless] = other[endless] + sign * 2.0 * math.pi
    return low, high
