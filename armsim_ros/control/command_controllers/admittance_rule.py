# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How far an arm yields to a wrench: the law of the admittance controller."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.controllers.command_controllers import (
    AdmittanceControllerParameters,
    AdmittanceSettings,
)
from armsim_ros.errors import ControllerError, nearest
from armsim_ros.model.robot_model import Joint, JointType, RobotModel
from armsim_ros.model.transforms import inverse_pose, rotation_vector
from armsim_ros.model.tree import joint_pose


class LinkMotion:
    """
    Some links of a robot.

    :param joints: (n,) those that move; all others are at 0.
    :param base: link before the joints, in whose frame everything is given.
    :param links: those that are asked for.
    :raises ControllerError: a link or joint that the robot lacks, or a base that moves.
    """

    def __init__(
        self, model: RobotModel, joints: Sequence[str], base: str, links: Iterable[str]
    ) -> None:
        for kind, names, known in (('link', (base, *links), tuple(model.links)),
                                   ('joint', joints, tuple(model.joints))):
            for name in names:
                if name not in known:
                    hint = nearest(name, known) or f'known: {", ".join(known)}'
                    raise ControllerError(
                        f"'{name}' is not a {kind} of robot '{model.name}'; {hint}")
        self._base = base
        self._columns = {name: column for column, name in enumerate(joints)}
        self._paths = {link: _path(model, link) for link in (base, *links)}
        for joint in self._paths[base]:
            if joint.name in self._columns:
                raise ControllerError(f"'{base}' moves with '{joint.name}' and cannot be the "
                                      f"base; choose '{joint.parent}' or a link before it")

    def poses(self, positions: Vector) -> dict[str, Matrix]:
        """Return the pose (4, 4) of each link for positions (n,) [rad or m]."""
        reached: dict[str, Matrix] = {}
        for link, path in self._paths.items():
            pose: Matrix = np.eye(4)
            for joint in path:
                if joint.child not in reached:
                    reached[joint.child] = pose @ joint_pose(joint, self._at(joint, positions))
                pose = reached[joint.child]
            reached[link] = pose
        root = inverse_pose(reached[self._base])
        return {link: root @ reached[link] for link in self._paths}

    def jacobian(self, link: str, positions: Vector) -> Matrix:
        """
        Return how a link's origin moves with the joints (6, n): linear above angular.

        :param positions: (n,) [rad or m].
        """
        found = np.zeros((6, len(self._columns)))
        base: Matrix = np.eye(4)
        for joint in self._paths[self._base]:
            base = base @ joint_pose(joint, self._at(joint, positions))
        frames, pose = [], inverse_pose(base)
        for joint in self._paths[link]:
            pose = pose @ joint_pose(joint, self._at(joint, positions))
            frames.append((joint, pose))
        for joint, frame in frames:
            column = self._columns.get(joint.name)
            if column is None:
                continue
            # A joint turns about its axis, or slides along it, in both its frames alike.
            axis = frame[:3, :3] @ joint.axis
            if joint.type is JointType.PRISMATIC:
                found[:3, column] = axis
            else:
                found[:3, column] = np.cross(axis, pose[:3, 3] - frame[:3, 3])
                found[3:, column] = axis
        return found

    def _at(self, joint: Joint, positions: Vector) -> float:
        column = self._columns.get(joint.name)
        return 0.0 if column is None else float(positions[column])


def _path(model: RobotModel, link: str) -> list[Joint]:
    """Return the joints from the root link to a link."""
    parents: Mapping[str, str] = model.parent_joint
    path: list[Joint] = []
    while (name := parents.get(link)) is not None:
        path.append(model.joints[name])
        link = model.joints[name].parent
    return path[::-1]


class AdmittanceRule:
    """
    What a wrench makes of references.

    ``mass * a + damping * v + stiffness * x = force``, where x is how far the sensor's frame has
    left its place at the reference. The mass is that of the base frame's axes; damping, stiffness
    and the selected axes are those of the control frame. The step is implicit in v and x, so no
    stiffness or damping makes it unstable; the joints follow by the damped inverse of the
    Jacobian. Without a wrench nothing yields, and references pass as they are.

    :param links: gives the frames that the parameters name; replaced with them.
    :param lower: (n,) bounds of the joints [rad or m]; ``upper`` likewise.
    """

    def __init__(self, links: LinkMotion, lower: Vector, upper: Vector) -> None:
        self.links, self._lower, self._upper = links, lower, upper
        count = len(lower)
        #: How far the joints have yielded (n,) [rad or m], and its derivatives.
        self.offset, self.velocity, self.acceleration = (np.zeros(count) for _ in range(3))
        #: Force and torque in the base frame, without gravity, filtered (6,) [N, N*m].
        self.wrench: Vector = np.zeros(6)
        #: How far the sensor's frame has yielded (6,) [m, rad], base frame; ``twist`` and
        #: ``twist_rate`` are its derivatives.
        self.yielded, self.twist, self.twist_rate = (np.zeros(6) for _ in range(3))
        self.control_rotation: Matrix = np.eye(3)
        self.sensor_at_reference: Matrix = np.eye(4)

    def step(
        self, parameters: AdmittanceControllerParameters, admittance: AdmittanceSettings,
        reference: Vector, wrench: Vector, period: float
    ) -> None:
        """
        Yield for a period.

        :param reference: (n,) positions [rad or m].
        :param wrench: (6,) measured, in the sensor's frame [N, N*m].
        :param period: [s].
        """
        sensor = parameters.ft_sensor.frame.id
        posture = reference + self.offset
        poses = self.links.poses(posture)
        self.sensor_at_reference = self.links.poses(reference)[sensor]
        self._filter(parameters, poses, wrench)
        turn = poses[parameters.control.frame.id][:3, :3]
        self.control_rotation = turn
        here, there = poses[sensor], self.sensor_at_reference
        self.yielded[:3] = here[:3, 3] - there[:3, 3]
        self.yielded[3:] = rotation_vector(here[:3, :3] @ there[:3, :3].T)
        jacobian = self.links.jacobian(sensor, posture)
        speed = jacobian @ self.velocity
        axes = np.kron(np.eye(2), turn)
        selected, stiffness, damping = (
            axes * diagonal @ axes.T for diagonal in (
                np.array(admittance.selected_axes), np.array(admittance.stiffness),
                damping_of(admittance)))
        force = (selected @ self.wrench - damping @ speed
                 - stiffness @ (self.yielded + period * speed))
        rate = np.linalg.solve(
            np.diag(admittance.mass) + period * damping + period * period * stiffness, force)
        gram = jacobian.T @ jacobian + parameters.kinematics.alpha * np.eye(len(reference))
        requested = np.linalg.solve(gram, jacobian.T @ rate)
        before = self.velocity
        velocity = (before + period * requested) / (1.0 + period * admittance.joint_damping)
        posture = reference + self.offset + period * velocity
        bounded = np.clip(posture, self._lower, self._upper)
        self.velocity = np.where(bounded == posture, velocity, 0.0)
        self.offset = bounded - reference
        self.acceleration = (self.velocity - before) / period if period > 0.0 else np.zeros_like(
            before)
        self.twist = jacobian @ self.velocity
        self.twist_rate = jacobian @ self.acceleration

    def _filter(
        self, parameters: AdmittanceControllerParameters, poses: dict[str, Matrix], wrench: Vector
    ) -> None:
        """Bring what is measured into the base frame, without gravity, and smooth it."""
        gravity = parameters.gravity_compensation
        down = -poses[parameters.fixed_world_frame.frame.id][:3, 2]
        weight = gravity.CoG.force * down
        lever = poses[gravity.frame.id][:3, :3] @ np.array(gravity.CoG.pos)
        measured = _turned(poses[parameters.ft_sensor.frame.id][:3, :3], wrench)
        measured[:3] -= weight
        measured[3:] -= np.cross(lever, weight)
        share = parameters.ft_sensor.filter_coefficient
        self.wrench = share * measured + (1.0 - share) * self.wrench


def damping_of(admittance: AdmittanceSettings) -> Vector:
    """Return the damping of each axis (6,) [N*s/m, N*m*s/rad]."""
    mass, stiffness = np.array(admittance.mass), np.array(admittance.stiffness)
    return np.asarray(2.0 * np.array(admittance.damping_ratio) * np.sqrt(mass * stiffness))


def _turned(rotation: Matrix, pair: Vector) -> Vector:
    """Return two vectors (6,) in other axes."""
    return np.concatenate([rotation @ pair[:3], rotation @ pair[3:]])
