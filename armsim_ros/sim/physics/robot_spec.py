# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot's links, joints and motors as parts of a MuJoCo specification."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations
import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Mask, Matrix
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.errors import SimulationError
from armsim_ros.model.geometry import Mesh
from armsim_ros.model.inertia import rigid_inertia
from armsim_ros.model.meshes import convex_parts
from armsim_ros.model.robot_model import Inertial, Joint, JointType, Link, LinkGeometry, RobotModel
from armsim_ros.model.transforms import pose_matrix, quat_wxyz_from_matrix
from armsim_ros.sim.physics.geoms import (
    add_geom,
    COLLISION_GROUP,
    SEEN_ONLY,
    TOUCHING,
    VISUAL_GROUP,
)

#: Fields of the geoms that are seen and of those that touch.
VISUAL = {'group': VISUAL_GROUP, **SEEN_ONLY}
COLLISION = {'group': COLLISION_GROUP, **TOUCHING}
#: What a link gets that moves though it and all that is fixed to it weigh nothing.
LEAST_MASS, LEAST_INERTIA = 1e-3, 1e-6
#: Impedance of what hardly gives under a force: end stops, mimic joints, dry friction.
STIFF_SOLIMP = (0.999, 0.9999, 0.001, 0.5, 2.0)
#: Time constant of mimic joints and dry friction, in timesteps.
STIFF_TIMESTEPS = 2.0
#: Time constant of an end stop [s]: a joint that is put beyond its stop is not thrown back.
STOP_TIME = 0.01
#: Time constant [s] and impedance of dry friction that a drive overcomes.
SOFT_FRICTION = (0.02, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)
#: Play of a joint that cannot move, on each side [rad or m]; MuJoCo refuses a range of 0.
PLAY = 1e-9


def element_name(robot: str, element: str) -> str:
    """Return the MuJoCo name of a link or joint; the robot's name keeps robots apart."""
    return f'{robot}/{element}'


class RobotSpec:
    """
    Adds a robot to an ``MjSpec``.

    :param settings: placement, rotor inertia, timestep.
    :param contacts: whether it gets shapes, motors and mimic constraints; its inverse dynamics
        needs none of them.
    :raises SimulationError: a joint type that the physics does not have.
    """

    def __init__(
        self, spec: Any, model: RobotModel, settings: SimulationSettings, *, contacts: bool = True
    ) -> None:
        self.spec, self.model, self.settings = spec, model, settings
        self.warnings: list[str] = []
        self._contacts = contacts
        self._add_robot()
        if contacts:
            self._add_motors()
            self._add_mimics()
            for first, second in untouching_pairs(self.model):
                self.exclude(first, second)

    def name(self, element: str) -> str:
        """Return the MuJoCo name of a link or joint of this robot."""
        return element_name(self.model.name, element)

    def _add_robot(self) -> None:
        placement = self.settings.placement
        root_pose = pose_matrix(placement.xyz, placement.rpy)
        bodies = {
            self.model.root_link: self._add_link(
                self.spec.worldbody, self.model.links[self.model.root_link], root_pose)
        }
        for joint in self.model.joints.values():
            body = self._add_link(
                bodies[joint.parent], self.model.links[joint.child], joint.origin)
            self._add_joint(body, joint)
            bodies[joint.child] = body

    def _add_link(self, parent: Any, link: Link, pose: Matrix) -> Any:
        body = parent.add_body(
            name=self.name(link.name), pos=pose[:3, 3], quat=quat_wxyz_from_matrix(pose))
        # All mass is the URDF's: shapes weigh nothing.
        body.explicitinertial = True
        if link.inertial is not None:
            set_inertial(body, link.inertial)
        elif self._moves_without_mass(link):
            body.mass, body.ipos = LEAST_MASS, [0.0, 0.0, 0.0]
            body.inertia = [LEAST_INERTIA] * 3
            self.warnings.append(
                f"link '{link.name}' moves but has no mass; it gets {LEAST_MASS} kg")
        if self._contacts:
            self._add_shapes(body, link)
        return body

    def _add_shapes(self, body: Any, link: Link) -> None:
        groups = (('visual', link.visuals, VISUAL), ('collision', link.collisions, COLLISION))
        for kind, shapes, fields in groups:
            for i, shape in enumerate(shapes):
                self._add_shape(body, shape, f'{self.name(link.name)}/{kind}/{i}', fields)

    def _add_shape(self, body: Any, shape: LinkGeometry, mesh_name: str,
                   fields: Mapping[str, int]) -> None:
        add_geom(
            self.spec, body, shape.geometry, shape.origin, mesh_name=mesh_name, mass=0.0,
            rgba=shape.rgba or (0.6, 0.6, 0.6, 1.0), **fields)

    def decompose(self, link: str) -> int:
        """
        Let a link collide with the convex parts of its meshes in place of their hulls.

        :returns: how many parts there are; 0 where nothing was changed.
        """
        body, count = self.spec.body(self.name(link)), 0
        for i, shape in enumerate(self.model.links[link].collisions):
            name = f'{self.name(link)}/collision/{i}'
            parts = convex_parts(shape.geometry) if isinstance(shape.geometry, Mesh) else ()
            if not parts:
                continue
            count += len(parts)
            self.spec.delete(next(geom for geom in body.geoms if geom.meshname == name))
            self.spec.delete(self.spec.mesh(name))
            for number, part in enumerate(parts):
                self._add_shape(body, replace(shape, geometry=part), f'{name}/{number}', COLLISION)
        return count

    def exclude(self, first: str, second: str) -> None:
        """Let two links pass through each other."""
        self.spec.add_exclude(bodyname1=self.name(first), bodyname2=self.name(second))

    def _moves_without_mass(self, link: Link) -> bool:
        """Whether the link hangs on a movable joint and nothing fixed to it has mass."""
        above = self.model.parent_joint.get(link.name)
        if above is None or self.model.joints[above].type is JointType.FIXED:
            return False
        rigid = [link.name]
        for joint in self.model.joints.values():
            if joint.type is JointType.FIXED and joint.parent in rigid:
                rigid.append(joint.child)
        inertials = (self.model.links[name].inertial for name in rigid)
        return sum(inertial.mass for inertial in inertials if inertial is not None) <= 0.0

    def _add_joint(self, body: Any, joint: Joint) -> None:
        if joint.type is JointType.FIXED:
            return
        if not joint.movable:
            raise SimulationError(
                f"joint '{joint.name}' is of type '{joint.type.value}', which the physics does "
                'not have; allowed: fixed, revolute, continuous, prismatic')
        sliding = joint.type is JointType.PRISMATIC
        limits = joint.limits
        # A mimic joint is bounded by its driver, as published limits of the two often disagree.
        limited = joint.type is not JointType.CONTINUOUS and joint.mimic is None and all(
            math.isfinite(bound) for bound in (limits.lower, limits.upper))
        if not self._moved_by_another(joint):
            # Robots do not fall asleep, not even those that only mimic others.
            body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_NEVER
        play = PLAY if limits.lower == limits.upper else 0.0
        body.add_joint(
            name=self.name(joint.name),
            type=mujoco.mjtJoint.mjJNT_SLIDE if sliding else mujoco.mjtJoint.mjJNT_HINGE,
            axis=joint.axis, limited=int(limited),
            range=[limits.lower - play, limits.upper + play] if limited else [0.0, 0.0],
            solref_limit=[STOP_TIME, 1.0], solimp_limit=STIFF_SOLIMP,
            damping=joint.damping, frictionloss=joint.friction,
            solref_friction=SOFT_FRICTION[0], solimp_friction=SOFT_FRICTION[1],
            armature=self.settings.armature_linear if sliding else self.settings.armature)

    def _moved_by_another(self, joint: Joint) -> bool:
        """Whether a joint lies beyond another movable joint."""
        above = self.model.parent_joint.get(joint.parent)
        while above is not None:
            if self.model.joints[above].movable:
                return True
            above = self.model.parent_joint.get(self.model.joints[above].parent)
        return False

    def _add_motors(self) -> None:
        for name in self.model.active_joints:
            effort = bound_or_infinite(self.model.joints[name].limits.effort)
            motor = self.spec.add_actuator(
                name=self.name(name), target=self.name(name), trntype=mujoco.mjtTrn.mjTRN_JOINT)
            motor.set_to_motor()
            # Stiffness and damping of the drive come with its gains.
            motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
            if math.isfinite(effort):
                motor.forcelimited, motor.forcerange = 1, [-effort, effort]

    def _add_mimics(self) -> None:
        for name in self.model.movable_joints:
            mimic = self.model.joints[name].mimic
            if mimic is None:
                continue
            equality = self.spec.add_equality(
                name=self.name(name), type=mujoco.mjtEq.mjEQ_JOINT,
                objtype=mujoco.mjtObj.mjOBJ_JOINT, name1=self.name(name),
                name2=self.name(mimic.joint))
            equality.data[:5] = [mimic.offset, mimic.multiplier, 0.0, 0.0, 0.0]
            equality.solref = [STIFF_TIMESTEPS * self.settings.timestep, 1.0]
            equality.solimp = STIFF_SOLIMP


def set_friction(model: Any, dofs: NDArray[np.intp], held: Mask) -> None:
    """
    Have the dry friction of joints suit what moves them.

    It holds a joint that only an effort moves. A drive that moves a joint to positions overcomes
    it: there it is soft, so that the joint does not stick short of its position.

    :param dofs: (n,) degrees of freedom of the joints.
    :param held: (n,) whether a drive holds the joint.
    """
    stiff = (STIFF_TIMESTEPS * model.opt.timestep, 1.0), STIFF_SOLIMP
    for values, soft, hard in zip(
            (model.dof_solref, model.dof_solimp), SOFT_FRICTION, stiff, strict=True):
        values[dofs] = np.where(held[:, None], soft, hard)


def bound_or_infinite(bound: float) -> float:
    """Return a velocity or effort limit; 0 or less is "unlimited" in many URDFs."""
    return bound if bound > 0.0 else math.inf


def untouching_pairs(model: RobotModel) -> list[tuple[str, str]]:
    """
    Return the pairs of links that never touch: neighbours, and what the SRDF disables.

    Without an SRDF hulls that overlap cannot be distinguished from links that touch, and no two
    links of the robot touch each other, as in Gazebo without ``self_collide``.

    :returns: pairs sorted by name; both links have collision shapes.
    """
    solid = {name for name, link in model.links.items() if link.collisions}
    if not model.srdf:
        return list(combinations(sorted(solid), 2))
    semantic = model.semantic
    pairs = {_sorted_pair(joint.parent, joint.child) for joint in model.joints.values()}
    pairs |= {
        _sorted_pair(quiet, other) for quiet in semantic.default_disabled for other in model.links}
    pairs -= semantic.enabled_collisions
    pairs |= set(semantic.disabled_collisions)
    return sorted(pair for pair in pairs if pair[0] != pair[1] and solid.issuperset(pair))


def _sorted_pair(first: str, second: str) -> tuple[str, str]:
    return (first, second) if first < second else (second, first)


def set_inertial(body: Any, inertial: Inertial) -> None:
    """Write mass and inertia about the centre of mass, turned into the link's axes."""
    rotation = inertial.origin[:3, :3]
    turned = rigid_inertia(rotation @ inertial.inertia @ rotation.T)
    body.mass, body.ipos = inertial.mass, inertial.origin[:3, 3]
    body.fullinertia = [
        turned[0, 0], turned[1, 1], turned[2, 2], turned[0, 1], turned[0, 2], turned[1, 2],
    ]
