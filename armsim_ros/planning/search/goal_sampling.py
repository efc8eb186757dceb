# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint positions that satisfy the goal, nearest to the start first; or the reason for none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.kinematics.inverse import IKTarget, InverseKinematics
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.transforms import matrix_from_axis_angle, pose_from_parts
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraints import (
    ConstraintSet,
    JointTerm,
    OrientationTerm,
    Poses,
    PositionTerm,
)

MAX_GOALS = 10
"""Most goal states that a search gets."""

_SOURCE = 'goal sampling'
_FIRST_STARTS = 24
_MORE_STARTS = 120
_DRAWS = 40


@dataclass(slots=True)
class _Tally:
    """What happened to the states that were looked at."""

    candidates: int = 0
    unsolved: int = 0
    off_goal: int = 0
    colliding: int = 0
    off_path_constraints: int = 0
    nearest_collision: Vector | None = None
    off_goal_text: str = ''
    path_text: str = ''


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
        self._model = model
        self._inverse = inverse
        self._validity = validity
        self._start = start
        self._rng = rng
        self._indices = model.group_indices(validity.group)
        self._origin: Vector = start[self._indices]
        low, high = validity.lower, validity.upper
        self._bounds = (
            np.where(np.isfinite(low), low, self._origin - math.pi),
            np.where(np.isfinite(high), high, self._origin + math.pi),
        )
        self._poses = PoseSampler(model, validity.group, self._bounds, rng)

    def sample(self, goals: Sequence[ConstraintSet], budget: Budget) -> list[Vector]:
        """
        Return up to :data:`MAX_GOALS` states (m,) of the group, nearest to the start first.

        :param goals: alternatives; one is enough.
        :raises PlanningError: GOAL_IN_COLLISION, NO_IK_SOLUTION, GOAL_VIOLATES_PATH_CONSTRAINTS
            or INVALID_GOAL_CONSTRAINTS where no state is valid, with the reason.
        """
        tally = _Tally()
        found: list[Vector] = []
        for goal in goals:
            for candidate in self._candidates(goal, tally, budget):
                budget.check(_SOURCE)
                values = candidate[self._indices]
                if any(float(np.max(np.abs(values - other))) < 1e-4 for other in found):
                    continue
                if self._accept(candidate, values, goal, tally):
                    found.append(values)
                if found and (
                    len(found) >= MAX_GOALS or budget.spent() or self._is_one_state(goal)
                ):
                    break
        budget.check(_SOURCE)
        if not found:
            raise self._failure(goals, tally)
        return sorted(found, key=lambda values: float(np.linalg.norm(values - self._origin)))

    def _is_one_state(self, goal: ConstraintSet) -> bool:
        """Return whether a goal names every joint: then its middle is what is meant."""
        named = {term.index for term in goal.joints}
        return not (goal.positions or goal.orientations) and all(
            int(index) in named for index in self._indices
        )

    def _accept(
        self, candidate: Vector, values: Vector, goal: ConstraintSet, tally: _Tally
    ) -> bool:
        tally.candidates += 1
        if not self._validity.within_limits(values) or not goal.satisfied(candidate):
            tally.off_goal += 1
            tally.off_goal_text = goal.violation(candidate) or self._validity.why_not(values)
            return False
        if self._validity.collides(values):
            tally.colliding += 1
            if tally.nearest_collision is None:
                tally.nearest_collision = values
            return False
        if not self._validity.constrained(values):
            tally.off_path_constraints += 1
            tally.path_text = self._validity.why_not(values)
            return False
        return True

    # ---------------------------------------------------------------- candidates

    def _candidates(
        self, goal: ConstraintSet, tally: _Tally, budget: Budget
    ) -> Iterator[Vector]:
        if goal.positions or goal.orientations:
            yield from self._pose_candidates(goal, tally, budget)
        else:
            yield from self._joint_candidates(goal, budget)

    def _joint_candidates(self, goal: ConstraintSet, budget: Budget) -> Iterator[Vector]:
        """Yield the box's middle, then random states of it; free joints stay, then roam."""
        named = {term.index for term in goal.joints}
        low, high = self._bounds
        wide = any(index not in named for index in self._indices) or any(
            term.upper - term.lower > 1e-3 for term in goal.joints
        )
        for draw in range(_DRAWS if wide else 1):
            if draw and budget.spent():
                return
            q = self._start.copy()
            if draw > 1:
                q[self._indices] = self._rng.uniform(low, high)
            for term in goal.joints:
                value = term.target if not draw else self._rng.uniform(term.lower, term.upper)
                self._set(q, term, value)
            yield self._model.apply_mimic(q)

    def _set(self, q: Vector, term: JointTerm, value: float) -> None:
        """Put a joint of the group where a constraint wants it; others cannot be moved."""
        if term.index in self._indices:
            q[term.index] = (
                _nearest_turn(value, self._start[term.index]) if term.continuous else value
            )

    def _pose_candidates(
        self, goal: ConstraintSet, tally: _Tally, budget: Budget
    ) -> Iterator[Vector]:
        seed = self._start.copy()
        for term in goal.joints:
            self._set(seed, term, term.target)
        seed = self._model.apply_mimic(seed)
        draws = _DRAWS if has_room(goal) else 1
        for draw in range(draws):
            if draw and budget.spent():
                return
            targets = self._poses.targets(goal, seed, middle=draw == 0)
            before = tally.colliding + tally.off_goal + tally.off_path_constraints
            solutions = self._inverse.solutions(
                targets, seed, count=MAX_GOALS, rng=self._rng, clock=budget.now,
                deadline=budget.deadline, max_starts=_FIRST_STARTS if draw == 0 else 4,
            )
            yield from solutions
            refused = tally.colliding + tally.off_goal + tally.off_path_constraints - before
            if draw == 0 and refused == len(solutions):
                more = self._inverse.solutions(
                    targets, seed, count=2 * MAX_GOALS, rng=self._rng, clock=budget.now,
                    deadline=budget.deadline, max_starts=_MORE_STARTS,
                )
                yield from more
                solutions = solutions or more
            if not solutions:
                tally.unsolved += 1

    # ---------------------------------------------------------------- reasons

    def _failure(self, goals: Sequence[ConstraintSet], tally: _Tally) -> PlanningError:
        if tally.colliding:
            assert tally.nearest_collision is not None
            pairs = self._validity.touching(tally.nearest_collision)
            return PlanningError(
                MoveItErrorCode.GOAL_IN_COLLISION,
                f'all {tally.colliding} goal states that were found collide; the nearest one: '
                f'{pairs}; move the goal or the object, or allow the pair in the allowed '
                'collision matrix',
                _SOURCE, self._validity.contacts(tally.nearest_collision),
            )
        if tally.off_path_constraints:
            return PlanningError(
                MoveItErrorCode.GOAL_VIOLATES_PATH_CONSTRAINTS,
                f'no goal state keeps the path constraints: {tally.path_text}; widen them or '
                'change the goal',
                _SOURCE,
            )
        if tally.unsolved and not tally.candidates:
            return self._no_solution(goals)
        return PlanningError(
            MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
            f'no state satisfies the goal constraints: {tally.off_goal_text}; widen their '
            'tolerances',
            _SOURCE,
        )

    def _no_solution(self, goals: Sequence[ConstraintSet]) -> PlanningError:
        goal = next(each for each in goals if each.positions or each.orientations)
        targets = self._poses.targets(goal, self._start, middle=True)
        result = self._inverse.solve(targets, self._start, max_starts=8)
        where = '; '.join(
            f"'{target.link}' at {np.round(target.pose[:3, 3], 4).tolist()} m in the model frame"
            for target in targets
        )
        return PlanningError(
            MoveItErrorCode.NO_IK_SOLUTION,
            f'{result.message or "no inverse kinematics solution was found"} ({where}); move '
            'the goal nearer, widen its tolerances, or set position_only_ik in kinematics.yaml '
            f"if '{self._validity.group}' has fewer than 6 joints",
            _SOURCE,
        )


def _nearest_turn(value: float, reference: float) -> float:
    return reference + math.remainder(value - reference, 2.0 * math.pi)


class PoseSampler:
    """
    Turns position and orientation constraints into targets of inverse kinematics.

    :param model: the robot's kinematics.
    :param group: the group that is planned for.
    :param bounds: lower and upper values (m,) that random states are drawn from.
    :param rng: source of chance.
    """

    def __init__(
        self, model: KinematicModel, group: str, bounds: tuple[Vector, Vector],
        rng: np.random.Generator,
    ) -> None:
        self._model = model
        self._group = group
        self._bounds = bounds
        self._rng = rng

    def targets(self, goal: ConstraintSet, seed: Vector, middle: bool) -> list[IKTarget]:
        """Return a pose for every constrained frame: the wanted one, or a random allowed one."""
        poses = goal.poses(seed)
        free = seed
        if not middle:
            low, high = self._bounds
            free = self._model.insert(seed, self._group, self._rng.uniform(low, high))
        targets: list[IKTarget] = []
        used: set[int] = set()
        for position in goal.positions:
            frame = position.frame.pose(poses)
            partner = next(
                (k for k, term in enumerate(goal.orientations)
                 if term.target.link == position.target.link and k not in used), None,
            )
            point = (frame @ np.append(self._point(position, middle), 1.0))[:3]
            if partner is None:
                targets.append(IKTarget(
                    position.target.link, pose_from_parts(point, np.eye(3)),
                    position.target.offset, position_only=True,
                ))
                continue
            used.add(partner)
            orientation = goal.orientations[partner]
            rotation = self._rotation(orientation, poses, middle)
            # The wanted rotation is that of the orientation's frame on the link.
            link_rotation = rotation @ orientation.target.offset[:3, :3].T
            pose = pose_from_parts(point, link_rotation @ position.target.offset[:3, :3])
            targets.append(IKTarget(position.target.link, pose, position.target.offset))
        for k, orientation in enumerate(goal.orientations):
            if k in used:
                continue
            link = orientation.target.link
            rotation = self._rotation(orientation, poses, middle)
            here = self._model.link_pose(free, link) @ orientation.target.offset
            targets.append(IKTarget(
                link, pose_from_parts(here[:3, 3], rotation), orientation.target.offset
            ))
        return targets

    def _point(self, term: PositionTerm, middle: bool) -> Vector:
        if middle:
            return term.regions[0].center
        return term.regions[int(self._rng.integers(len(term.regions)))].random_point(self._rng)

    def _rotation(
        self, term: OrientationTerm, poses: Poses, middle: bool
    ) -> Vector:
        frame = term.frame.pose(poses)[:3, :3]
        wanted = term.wanted
        if not middle:
            reach = np.minimum(term.tolerances, math.pi)
            angles = self._rng.uniform(-reach, reach)
            wanted = _small_rotation(angles, term.rotation_vector) @ wanted
        result: Vector = frame @ wanted
        return result


def has_room(goal: ConstraintSet) -> bool:
    """Return whether the goal leaves more than a point to choose from."""
    linked = {term.target.link for term in goal.orientations}
    return (
        any(len(term.regions) > 1 or term.regions[0].size > 2e-3
            for term in goal.positions)
        or any(float(np.max(term.tolerances)) > 0.02 for term in goal.orientations)
        or any(term.target.link not in linked for term in goal.positions)
        or (bool(goal.orientations) and not goal.positions)
    )


def _small_rotation(angles: Vector, rotation_vector: bool) -> Vector:
    if rotation_vector:
        angle = float(np.linalg.norm(angles))
        return np.eye(3) if angle < 1e-12 else matrix_from_axis_angle(angles / angle, angle)
    x, y, z = np.eye(3)
    return (
        matrix_from_axis_angle(x, float(angles[0]))
        @ matrix_from_axis_angle(y, float(angles[1]))
        @ matrix_from_axis_angle(z, float(angles[2]))
    )
