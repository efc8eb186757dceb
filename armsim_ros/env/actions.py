# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actions as joint positions, and observations as named vectors."""

from __future__ import annotations

from typing import Any, Literal

from gymnasium.spaces import Box, Dict
import mujoco
import numpy as np
from numpy.typing import ArrayLike

from armsim_ros.arrays import Matrix, selector, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.sim.physics.mujoco_model import object_body_name
from armsim_ros.sim.simulation import Simulation

ActionKind = Literal['position', 'velocity', 'twist']
KINDS: tuple[ActionKind, ...] = ('position', 'velocity', 'twist')

#: Range of a joint that has no limits [rad or m].
_UNBOUNDED = 2.0 * np.pi
#: Fastest action of a joint without a velocity limit [rad/s or m/s].
_UNLIMITED_SPEED = 1.0
#: Keeps joint velocities small next to a singularity (damped least squares).
_DAMPING = 1e-4


class Actions:
    """
    Reads action vectors.

    :param kind: what the first numbers are: a position of each joint at the end of the step, a
        velocity of each joint, or the tip's linear and angular velocity in world axes, after
        which come positions of the joints that do not move the tip.
    :param kinematics: of the robot.
    :param joints: (n,) all joints with drives.
    :param group: planning group whose tip a twist moves.
    :param tip: its link.
    :param world: (3, 3) axes of the model frame in the world.
    :param twist: fastest linear [m/s] and angular [rad/s] velocity.
    :param cups: names of the suction cups; each has a number at the end, above 0.5 is on.
    :param period: time of a step [s].
    """

    def __init__(
        self, kind: ActionKind, kinematics: KinematicModel, joints: tuple[str, ...], group: str,
        tip: str, world: Matrix, *, twist: tuple[float, float], cups: tuple[str, ...],
        period: float
    ) -> None:
        self._kind, self._kinematics, self._period = kind, kinematics, period
        self._group, self.tip = group, tip
        #: Turns linear and angular velocity from world axes to the model's.
        self._turn = np.kron(np.eye(2), world.T)
        places = np.array([kinematics.index(name) for name in joints], dtype=np.int64)
        lower, upper = kinematics.lower[places], kinematics.upper[places]
        speed = kinematics.velocity_limits[places]
        self.lower = np.where(np.isfinite(lower), lower, -_UNBOUNDED)
        self.upper = np.where(np.isfinite(upper), upper, _UNBOUNDED)
        self.speed = np.where(np.isfinite(speed), speed, _UNLIMITED_SPEED)
        self._farthest = self.speed * period
        self._places, self._cups = places, len(cups)
        moved = kinematics.group_indices(group).tolist() if group else []
        self._moved = np.array([places.tolist().index(i) for i in moved], dtype=np.int64)
        self.others = np.flatnonzero(~np.isin(places, moved))
        """Which joints do not move the tip (m,), places among the joints."""
        self._default = kinematics.default()
        self._damping = _DAMPING * np.eye(6)
        self._square, self._solved = np.empty((6, 6)), np.empty(6)
        names = {
            'position': joints,
            'velocity': tuple(f'velocity of {name}' for name in joints),
            'twist': ('x', 'y', 'z', 'about x', 'about y', 'about z',
                      *(joints[i] for i in self.others)),
        }[kind]
        self.names = (*names, *cups)
        """What each number of an action is."""
        reach = np.repeat(twist, 3)
        low, high = {
            'position': (self.lower, self.upper),
            'velocity': (-self.speed, self.speed),
            'twist': (np.append(-reach, self.lower[self.others]),
                      np.append(reach, self.upper[self.others])),
        }[kind]
        self.low = np.append(low, np.zeros(len(cups)))
        self.high = np.append(high, np.ones(len(cups)))
        self.space = Box(self.low, self.high, dtype=np.float64)

    def checked(self, action: ArrayLike) -> Vector:
        """
        Return an action as float64 numbers.

        :raises ValueError: it has the wrong length, or a number that is not finite; it is named.
        """
        values = np.asarray(action, dtype=np.float64)
        if values.shape != self.low.shape:
            raise ValueError(f'an action is {len(self.names)} numbers '
                             f'({", ".join(self.names)}); got shape {values.shape}')
        if not float(values.dot(values)) < np.inf and not np.isfinite(values).all():
            wrong = int(np.flatnonzero(~np.isfinite(values))[0])
            raise ValueError(f"number {wrong} of the action, '{self.names[wrong]}', is "
                             f'{values[wrong]}; all numbers must be finite')
        return values

    def read(self, values: Vector, start: Vector) -> tuple[Vector, tuple[bool, ...]]:
        """
        Return where the joints shall be at the end of the step, and which cups shall be on.

        What is beyond the bounds is taken as its bound, and no joint goes farther than its speed
        allows.

        :param values: of ``checked``, in units.
        :param start: (n,) where they are commanded to be now [rad or m].
        :returns: (n,) [rad or m], and a value for each cup.
        """
        values = np.minimum(np.maximum(values, self.low), self.high)
        cups: tuple[bool, ...] = ()
        if self._cups:
            cups = tuple((values[-self._cups:] > 0.5).tolist())
            values = values[: -self._cups]
        if self._kind == 'position':
            target = values
        elif self._kind == 'velocity':
            target = start + self._period * values
        else:
            target = start + self._period * self.velocities(values[:6], start)
            target[self.others] = values[6:]
        way = np.minimum(np.maximum(target - start, -self._farthest), self._farthest)
        return np.minimum(np.maximum(start + way, self.lower), self.upper), cups

    def towards(self, twist: Vector, others: Vector, start: Vector) -> Vector:
        """
        Return the action, in units and without cups, that moves the tip by a twist.

        :param twist: (6,) linear and angular velocity in world axes [m/s, rad/s].
        :param others: (m,) positions of the joints that do not move the tip [rad or m].
        :param start: (n,) where the joints are commanded to be now [rad or m].
        """
        if self._kind == 'twist':
            return np.concatenate((twist, others))
        velocity = self.velocities(twist, start)
        velocity[self.others] = (others - start[self.others]) / self._period
        if self._kind == 'velocity':
            return velocity
        return start + self._period * velocity

    def velocities(self, twist: Vector, start: Vector) -> Vector:
        """Return velocities (n,) that move the tip so on average over the step."""
        requested = np.empty(6)
        mujoco.mju_mulMatVec(requested, self._turn, np.ascontiguousarray(twist, dtype=np.float64))
        first = self._solve(requested, start)
        velocity = self._solve(requested, start + 0.5 * self._period * first)
        return velocity / max(1.0, float(np.max(np.abs(velocity) / self.speed)))

    def _solve(self, requested: Vector, positions: Vector) -> Vector:
        q = self._default.copy()
        q[self._places] = positions
        jacobian = np.ascontiguousarray(self._kinematics.jacobian(
            self._kinematics.apply_mimic(q), self.tip, self._group))
        # By MuJoCo: the bytes of numpy's results differ between its versions.
        square, solved = self._square, self._solved
        mujoco.mju_mulMatMatT(square, jacobian, jacobian)
        square += self._damping
        mujoco.mju_cholFactor(square, 0.0)
        mujoco.mju_cholSolve(solved, square, requested)
        moved = np.empty(jacobian.shape[1])
        mujoco.mju_mulMatTVec(moved, jacobian, solved)
        velocity = np.zeros(len(positions))
        velocity[self._moved] = moved
        return velocity


class Observations:
    """
    Reads a simulation.

    ``joint_positions``, ``joint_velocities`` and ``joint_efforts`` are (n,), ``tip_pose`` is (7,),
    ``object_poses`` (7 * k,) of the objects that can move, ``held`` 1 for each cup that holds
    something. A pose is x, y, z [m] in the world and a quaternion x, y, z, w.

    :param joints: (n,) the joints with drives.
    :param tip: link of ``tip_pose``.
    :param objects: (k,) names of the objects that can move.
    :param cups: names of the suction cups.
    """

    def __init__(
        self, joints: tuple[str, ...], tip: str, objects: tuple[str, ...], cups: tuple[str, ...]
    ) -> None:
        self._joints, self._tip, self._objects, self._cups = joints, tip, objects, cups
        sizes = {
            'joint_positions': len(joints), 'joint_velocities': len(joints),
            'joint_efforts': len(joints), 'tip_pose': 7, 'object_poses': 7 * len(objects),
        }
        spaces: dict[str, Any] = {
            name: Box(np.full(size, -np.inf), np.full(size, np.inf), dtype=np.float64)
            for name, size in sizes.items() if size}
        if cups:
            spaces['held'] = Box(np.zeros(len(cups)), np.ones(len(cups)), dtype=np.float64)
        self.space = Dict(spaces)
        self._model: Any = None

    def read(self, simulation: Simulation) -> dict[str, Vector]:
        """Return the present observation, in arrays of its own."""
        model, data = simulation.mujoco_model, simulation.mujoco_data
        if model is not self._model:
            self._bind(simulation)
        mujoco.mj_kinematics(model, data)
        state, places = simulation.state, self._places
        poses = np.concatenate((data.xpos.take(self._xyz), data.xquat.take(self._xyzw)), axis=1)
        found = {
            'joint_positions': state.position[places].copy(),
            'joint_velocities': state.velocity[places].copy(),
            'joint_efforts': state.effort[places].copy(),
            'tip_pose': poses[0],
        }
        if self._objects:
            found['object_poses'] = poses[1:].ravel()
        if self._cups:
            held = [bool(cup.held) for cup in simulation.vacuum_grippers.values()]
            found['held'] = np.array(held, dtype=np.float64)
        return found

    def _bind(self, simulation: Simulation) -> None:
        """Find the bodies; their numbers hold until the world is edited."""
        self._model = model = simulation.mujoco_model
        self._places = selector([simulation.index[name] for name in self._joints])
        items = [int(model.body(object_body_name(name)).id) for name in self._objects]
        # Places in the flat arrays; MuJoCo has w first.
        bodies = np.array([[simulation.link_body(self._tip)], *([item] for item in items)])
        self._xyz, self._xyzw = 3 * bodies + np.arange(3), 4 * bodies + np.array([1, 2, 3, 0])
