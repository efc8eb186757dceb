# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint positions that satisfy the goal, nearest to the start first; or the reason for none."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
import itertools
import math
from typing import TypeVar

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.kinematics.inverse import IKOptions, IKResult, IKTarget, InverseKinematics
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.transforms import pose_from_parts
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraint_terms import JointTerm, OrientationTerm, Poses, PositionTerm
from armsim_ros.planning.constraints import ConstraintSet

MAX_GOALS = 10
"""Most goal states that a search gets."""

_SOURCE = 'goal sampling'
_FIRST_STARTS = 24
_MORE_STARTS = 120
_DRAWS = 40
_FURTHER_DRAWS = 1000
_FURTHER_STARTS = 5


@dataclass(slots=True)
class _Tally:
    """
    The states that were checked, and what is wrong with them.

    :param found: states (m,) that are valid.
    :param colliding: states (m,) that collide.
    :param off_goal: sentences about states outside the limits or the goal.
    :param off_path: sentences about states that violate the path constraints.
    :param unsolved: poses without a solution.
    """

    found: list[Vector] = field(default_factory=list)
    colliding: list[Vector] = field(default_factory=list)
    off_goal: list[str] = field(default_factory=list)
    off_path: list[str] = field(default_factory=list)
    unsolved: int = 0

    @property
    def refused(self) -> int:
        """Number of states that were refused."""
        return len(self.colliding) + len(self.off_goal) + len(self.off_path)


class GoalSampler:
    """
    Finds states of a group that satisfy one of several goals.

    :param model: the robot's kinematics.
    :param inverse: inverse kinematics of the group.
    :param validity: what else a goal state has to be, path constraints among it.
    :param start: (n,) full robot state that the motion begins in.
    :param rng: source of chance.
    """

    def __init__(
        self, model: KinematicModel, inverse: InverseKinematics, validity: StateValidity,
        start: Vector, rng: np.random.Generator,
    ) -> None:
        self._model, self._inverse, self._validity, self._start = model, inverse, validity, start
        self._rng = rng
        self._indices = model.group_indices(validity.group)
        self._origin: Vector = start[self._indices]
        low, high = validity.lower, validity.upper
        self._bounds = (
            np.where(np.isfinite(low), low, self._origin - math.pi),
            np.where(np.isfinite(high), high, self._origin + math.pi),
        )

    def sample(self, goals: Sequence[ConstraintSet], budget: Budget) -> list[Vector]:
        """
        Return up to :data:`MAX_GOALS` states (m,) of the group, nearest to the start first.

        :param goals: alternatives; one is enough.
        :raises PlanningError: GOAL_IN_COLLISION, NO_IK_SOLUTION, GOAL_VIOLATES_PATH_CONSTRAINTS
            or INVALID_GOAL_CONSTRAINTS where no state is valid, with the reason.
        """
        tally = _Tally()
        for goal in goals:
            self._collect(goal, self._candidates(goal, tally, budget), tally, budget)
        narrow = [] if tally.found else [goal for goal in goals if self._is_narrow(goal, tally)]
        for _ in range(_FURTHER_DRAWS if narrow else 0):
            for goal in narrow:
                self._collect(goal, self._further(goal, budget), tally, budget)
            if tally.found or budget.spent():
                break
        budget.check(_SOURCE)
        if not tally.found:
            raise self._failure(goals, tally)
        return self._nearest_first(tally.found)

    def turned(
        self, goals: Sequence[ConstraintSet], states: Sequence[Vector]
    ) -> tuple[Vector, ...]:
        """
        Return the states (m,) that differ from goal states by a turn of a joint, nearest first.

        :param goals: alternatives, of which each state satisfies one.
        :param states: (m,) of :meth:`sample`.
        """
        validity, found = self._validity, []
        for place in np.flatnonzero(np.isin(self._indices, self._inverse.turning)):
            for turn, values in itertools.product((-2.0 * math.pi, 2.0 * math.pi), states):
                other = values.copy()
                other[place] += turn
                if (validity.search_lower[place] <= other[place] <= validity.search_upper[place]
                        and validity.constrained(other)
                        and any(goal.satisfied(validity.full(other)) for goal in goals)):
                    found.append(other)
        return tuple(self._nearest_first(found))

    def _nearest_first(self, states: Iterable[Vector]) -> list[Vector]:
        return sorted(states, key=lambda values: float(np.linalg.norm(values - self._origin)))

    def _collect(
        self, goal: ConstraintSet, candidates: Iterable[Vector], tally: _Tally, budget: Budget
    ) -> None:
        """Check candidates (n,) until there are enough valid states."""
        found, all_joints = tally.found, self._names_all_joints(goal)
        for candidate in candidates:
            budget.check(_SOURCE)
            values = candidate[self._indices]
            if any(float(np.max(np.abs(values - other))) < 1e-4 for other in found):
                continue
            if self._accept(candidate, values, goal, tally):
                found.append(values)
            if found and (len(found) >= MAX_GOALS or budget.spent() or all_joints):
                return

    def _names_all_joints(self, goal: ConstraintSet) -> bool:
        """Return whether a goal names every joint: its middle is what is meant."""
        return {int(index) for index in self._indices} <= {term.index for term in goal.joints}

    def _accept(
        self, candidate: Vector, values: Vector, goal: ConstraintSet, tally: _Tally
    ) -> bool:
        if not self._validity.within_limits(values) or not goal.satisfied(candidate):
            tally.off_goal.append(goal.violation(candidate) or self._validity.why_not(values))
        elif self._validity.collides(values):
            tally.colliding.append(values)
        elif not self._validity.constrained(values):
            tally.off_path.append(self._validity.why_not(values))
        else:
            return True
        return False

    # ---------------------------------------------------------------- candidates

    def _candidates(
        self, goal: ConstraintSet, tally: _Tally, budget: Budget
    ) -> Iterator[Vector]:
        """Yield what a goal means; solve for poses where its joints alone are not enough."""
        posed, all_joints = self._poses_of(goal), self._names_all_joints(goal)
        if all_joints or posed is not goal:
            yield from self._joint_candidates(goal, budget)
        if posed is not None and not all_joints and (posed is goal or not tally.found):
            yield from self._pose_candidates(goal, has_room(posed), tally, budget)

    def _poses_of(self, goal: ConstraintSet) -> ConstraintSet | None:
        """Return whose poses to solve for: the goal, else the path constraints; None for none."""
        return next((each for each in (goal, self._validity.path_constraints)
                     if each is not None and (each.positions or each.orientations)), None)

    def _joint_candidates(self, goal: ConstraintSet, budget: Budget) -> Iterator[Vector]:
        """Yield the box's middle, then random states of it; free joints stay, then roam."""
        named = {term.index for term in goal.intervals}
        wide = any(index not in named for index in self._indices) or any(
            term.upper - term.lower > 1e-3 for term in goal.intervals
        )
        yield self._middle(goal)
        for draw in range(1, _DRAWS if wide else 1):
            if budget.spent():
                return
            yield self._random(goal, roam=draw > 1)

    def _middle(self, goal: ConstraintSet) -> Vector:
        """Return the start with the goal's joints in the middle of their intervals."""
        q = self._start.copy()
        for term in goal.intervals:
            self._set(q, term, term.middle)
        return self._model.apply_mimic(q)

    def _random(self, goal: ConstraintSet, roam: bool = True) -> Vector:
        """Return a state with the goal's joints within their intervals, the others anywhere."""
        q = self._start.copy()
        if roam:
            q[self._indices] = self._rng.uniform(*self._bounds)
        for term in goal.intervals:
            self._set(q, term, self._rng.uniform(term.lower, term.upper))
        return self._model.apply_mimic(q)

    def _set(self, q: Vector, term: JointTerm, value: float) -> None:
        """Put a joint of the group where a constraint wants it; others cannot be moved."""
        if term.index in self._indices:
            q[term.index] = (
                _nearest_turn(value, self._start[term.index]) if term.continuous else value
            )

    def _pose_candidates(
        self, goal: ConstraintSet, roomy: bool, tally: _Tally, budget: Budget
    ) -> Iterator[Vector]:
        """Yield solutions for the desired pose, and where there is room for random ones."""
        seed, options = self._middle(goal), self._options(goal, budget)
        for draw in range(_DRAWS if roomy else 1):
            if draw and budget.spent():
                return
            targets = self._targets(goal, seed, middle=draw == 0)
            before = tally.refused
            solutions = self._inverse.solutions(
                targets, seed, replace(options, max_starts=_FIRST_STARTS if draw == 0 else 4),
                count=MAX_GOALS)
            yield from solutions
            if draw == 0 and tally.refused - before == len(solutions):
                more = self._inverse.solutions(
                    targets, seed, replace(options, max_starts=_MORE_STARTS),
                    count=2 * MAX_GOALS)
                yield from more
                solutions = solutions or more
            if not solutions:
                tally.unsolved += 1

    def _options(self, goal: ConstraintSet, budget: Budget) -> IKOptions:
        """Return options of inverse kinematics that keep joints within the goal's intervals."""
        bounds = np.array([self._model.lower, self._model.upper])
        for term in goal.intervals:
            if term.index in self._indices:
                bounds[:, term.index] = term.near(self._start[term.index])
        return IKOptions(
            rng=self._rng, clock=budget.now, deadline=budget.deadline, bounds=bounds)

    def _is_narrow(self, goal: ConstraintSet, tally: _Tally) -> bool:
        """
        Return whether more draws may find what the first have missed.

        This is where joint constraints leave a part of endlessly many states for a pose.
        """
        posed = self._poses_of(goal)
        named = {term.index for term in goal.intervals}.intersection(self._indices)
        if posed is None or not named or self._names_all_joints(goal):
            return False
        targets = self._targets(goal, self._start, middle=True)
        fixed = sum(3 if target.position_only else 6 for target in targets)
        if not has_room(posed) and len(self._indices) <= fixed:
            return False
        return bool(tally.refused) or self._reached(targets).success

    def _reached(self, targets: Sequence[IKTarget]) -> IKResult:
        """Solve for poses whatever joints the goal names."""
        return self._inverse.solve(targets, self._start, IKOptions(max_starts=8))

    def _further(self, goal: ConstraintSet, budget: Budget) -> list[Vector]:
        """Return solutions for a random pose of the goal, from random starts."""
        seed = self._middle(goal)
        options = replace(
            self._options(goal, budget), max_starts=_FURTHER_STARTS, table_starts=1)
        return self._inverse.solutions(
            self._targets(goal, seed, middle=False), seed, options, count=MAX_GOALS)

    # ---------------------------------------------------------------- reasons

    def _failure(self, goals: Sequence[ConstraintSet], tally: _Tally) -> PlanningError:
        if tally.colliding:
            nearest = tally.colliding[0]
            return PlanningError(
                MoveItErrorCode.GOAL_IN_COLLISION,
                f'all {len(tally.colliding)} goal states that were found collide; the nearest '
                f'one: {self._validity.touching(nearest)}; move the goal or the object, or allow '
                'the pair in the allowed collision matrix',
                _SOURCE, self._validity.contacts(nearest),
            )
        if tally.off_path:
            return PlanningError(
                MoveItErrorCode.GOAL_VIOLATES_PATH_CONSTRAINTS,
                f'no goal state satisfies the path constraints: {tally.off_path[-1]}; widen them '
                'or change the goal',
                _SOURCE,
            )
        if tally.unsolved and not tally.off_goal:
            return self._no_solution(goals)
        return self._off_goal(tally.off_goal[-1] if tally.off_goal else 'none was found')

    def _no_solution(self, goals: Sequence[ConstraintSet]) -> PlanningError:
        goal = next(each for each in goals if self._poses_of(each) is not None)
        targets = self._targets(goal, self._start, middle=True)
        result = self._reached(targets)
        if result.q is not None:
            return self._off_goal(goal.violation(result.q))
        where = '; '.join(
            f"'{target.link}' at {np.round(target.pose[:3, 3], 4).tolist()} m in the model frame"
            for target in targets
        )
        return PlanningError(
            MoveItErrorCode.NO_IK_SOLUTION,
            f'{result.message} ({where}); move the goal nearer, widen its tolerances, or set '
            f"position_only_ik in kinematics.yaml if '{self._validity.group}' has fewer than 6 "
            'joints',
            _SOURCE,
        )

    def _off_goal(self, reason: str) -> PlanningError:
        return PlanningError(
            MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
            f'no state satisfies the goal constraints: {reason}; widen their tolerances',
            _SOURCE,
        )

    # ---------------------------------------------------------------- poses

    def _targets(self, goal: ConstraintSet, seed: Vector, middle: bool) -> list[IKTarget]:
        """
        Return a pose for every constrained link: the desired pose, or a random allowed pose.

        Of several constraints of a kind for a link the narrowest is taken; the others are
        checked afterwards. An orientation that the path constraints fix is kept.
        """
        free = seed if middle else self._random(goal)
        on_path = self._validity.path_constraints
        posed = self._poses_of(goal)
        assert posed is not None
        poses = posed.poses(seed)
        targets: list[IKTarget] = []
        terms: list[PositionTerm | OrientationTerm] = [*posed.positions, *posed.orientations]
        for link in dict.fromkeys(term.target.link for term in terms):
            position = _narrowest(posed.positions, link)
            orientation, there = _narrowest(posed.orientations, link), poses
            if orientation is None and on_path is not None:
                orientation, there = _narrowest(on_path.orientations, link), on_path.poses(seed)
            turned = np.eye(3)
            if orientation is not None:
                turned = self._rotation(orientation, there, middle)
            if position is None:
                assert orientation is not None
                frame = orientation.target
                point = (self._model.link_pose(free, link) @ frame.offset)[:3, 3]
            else:
                frame = position.target
                place = np.append(self._point(position, middle), 1.0)
                point = (position.frame.pose(poses) @ place)[:3]
                if orientation is not None:
                    # The desired rotation is that of the orientation's frame on the link.
                    turned = turned @ orientation.target.offset[:3, :3].T @ frame.offset[:3, :3]
            targets.append(IKTarget(
                link, pose_from_parts(point, turned), frame.offset,
                position_only=orientation is None))
        return targets

    def _point(self, term: PositionTerm, middle: bool) -> Vector:
        if middle:
            return term.regions[0].center
        return term.regions[int(self._rng.integers(len(term.regions)))].random_point(self._rng)

    def _rotation(self, term: OrientationTerm, poses: Poses, middle: bool) -> Matrix:
        desired = term.desired if middle else term.random(self._rng)
        result: Matrix = term.frame.pose(poses)[:3, :3] @ desired
        return result


Constrained = TypeVar('Constrained', PositionTerm, OrientationTerm)


def _narrowest(terms: Sequence[Constrained], link: str) -> Constrained | None:
    """Return the constraint of a link with the smallest volume; None where it has none."""
    return min((term for term in terms if term.target.link == link),
               key=lambda term: term.volume, default=None)


def _nearest_turn(value: float, reference: float) -> float:
    return reference + math.remainder(value - reference, 2.0 * math.pi)


def has_room(goal: ConstraintSet) -> bool:
    """Return whether the goal leaves more than a point to choose from."""
    linked = {term.target.link for term in goal.orientations}
    return (
        any(len(term.regions) > 1 or term.regions[0].size > 2e-3 for term in goal.positions)
        or any(float(np.max(term.tolerances)) > 0.02 for term in goal.orientations)
        or any(term.target.link not in linked for term in goal.positions)
        or (bool(goal.orientations) and not goal.positions)
    )
