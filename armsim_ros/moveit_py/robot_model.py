# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.core.robot_model``: joints, links and groups of a robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math
from pathlib import Path
import threading

import numpy as np
from numpy.typing import ArrayLike

from armsim_ros.arrays import Vector
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.robot_model import Joint, JointType
from armsim_ros.moveit_py.utils import logger
from armsim_ros.planning.context import PlanningContext, PlanningSettings
from armsim_ros.planning.scene.planning_scene import PlanningScene


@dataclass(frozen=True, slots=True)
class VariableBounds:
    """Bounds of a joint: position, velocity, acceleration, jerk; 0 where there are none."""

    min_position: float
    max_position: float
    position_bounded: bool
    min_velocity: float
    max_velocity: float
    velocity_bounded: bool
    min_acceleration: float
    max_acceleration: float
    acceleration_bounded: bool
    min_jerk: float
    max_jerk: float
    jerk_bounded: bool


def _bounds(joint: Joint, lower: float, upper: float) -> VariableBounds:
    limits = joint.limits
    bounded = joint.type is not JointType.CONTINUOUS and math.isfinite(upper - lower)
    low, high = (lower, upper) if bounded else (-math.pi, math.pi)
    rates = [(-value, value, True) if math.isfinite(value) else (0.0, 0.0, False)
             for value in (limits.velocity, limits.acceleration, limits.jerk)]
    return VariableBounds(float(low), float(high), bounded, *rates[0], *rates[1], *rates[2])


class JointModelGroup:
    """
    A planning group of the SRDF.

    :param name: of the group.
    """

    def __init__(self, robot_model: RobotModel, name: str) -> None:
        kinematics = robot_model._kinematics
        self._robot, self._name = kinematics.robot, name
        kinematics.group_indices(name)
        self._group = self._robot.semantic.groups[name]
        #: Movable joints, those that mimic others too: the values of the group.
        self._variables = tuple(
            joint for joint in self._group.joints if self._robot.joints[joint].movable)
        self._indices = np.array([kinematics.index(joint) for joint in self._variables], int)
        places = [kinematics.index(joint) for joint in self._group.active_joints]
        self._lower, self._upper = kinematics.lower[places], kinematics.upper[places]

    def _checked(self, names: Sequence[str], values: ArrayLike) -> Vector:
        """Return values for joints as numbers (len(names),); raise where they do not fit."""
        given = np.asarray(values, dtype=np.float64).ravel()
        if len(given) != len(names):
            raise ValueError(
                f"group '{self._name}' takes {len(names)} values, {len(given)} are given; its "
                f"joints: {', '.join(names)}")
        if not np.isfinite(given).all():
            raise PlanningError(MoveItErrorCode.INVALID_ROBOT_STATE,
                                f"values for group '{self._name}' are not finite")
        return given

    def _of(self, values: Vector) -> Vector:
        """Return the values of the group (v,) among those of all movable joints (n,)."""
        found: Vector = values[self._indices]
        return found

    @property
    def name(self) -> str:
        """Name of the group."""
        return self._name

    @property
    def link_model_names(self) -> list[str]:
        """Names of the links of the group."""
        return list(self._group.links)

    @property
    def joint_model_names(self) -> list[str]:
        """Names of all joints of the group, fixed joints too."""
        return list(self._group.joints)

    @property
    def active_joint_model_names(self) -> list[str]:
        """Names of the joints with a variable of their own."""
        return list(self._group.active_joints)

    @property
    def active_joint_model_bounds(self) -> list[list[VariableBounds]]:
        """The bounds of each active joint, a list with an item per variable."""
        return [[_bounds(self._robot.joints[joint], float(low), float(high))]
                for joint, low, high in zip(
                    self._group.active_joints, self._lower, self._upper, strict=True)]

    @property
    def eef_name(self) -> str:
        """
        Name of the link that carries the group's end effector.

        :raises RuntimeError: the group has no end effector, or several.
        """
        links = sorted({each.parent_link for each in self._robot.semantic.end_effectors.values()
                        if each.group != self._name and each.parent_link in self._group.links})
        if len(links) != 1:
            raise RuntimeError(
                f"group '{self._name}' has {len(links)} end effectors "
                f'({", ".join(links) or "none"}); exactly one link of the group has to be the '
                'parent_link of an end_effector of the SRDF')
        return links[0]

    def satisfies_position_bounds(self, values: ArrayLike, margin: float = 0.0) -> bool:
        """
        Return whether positions are within the bounds of the active joints.

        :param values: (m,) [rad or m].
        :param margin: by which a bound may be exceeded [rad or m].
        :raises ValueError: values for more or fewer joints.
        """
        given = self._checked(self._group.active_joints, values)
        return bool(np.all(given >= self._lower - margin)
                    and np.all(given <= self._upper + margin))


class RobotModel:
    """
    A robot: kinematic tree and planning groups.

    :param urdf_xml_path: file of the URDF; xacro is evaluated.
    :param srdf_xml_path: file of the SRDF.
    :raises ConfigError: with every error of both files.
    """

    def __init__(self, urdf_xml_path: str, srdf_xml_path: str) -> None:
        urdf, srdf = Path(urdf_xml_path).absolute(), Path(srdf_xml_path).absolute()
        settings = RobotSettings(
            name=urdf.stem, folder=urdf.parent, urdf_file=urdf, srdf_file=srdf)
        model = load_robot_model(settings, report=lambda problem: logger().warning(str(problem)))
        self._set_up(KinematicModel(model), PlanningSettings())

    @classmethod
    def _of(cls, kinematics: KinematicModel, settings: PlanningSettings) -> RobotModel:
        """Return the robot of a node, with its kinematics solvers."""
        made = object.__new__(cls)
        made._set_up(kinematics, settings)
        return made

    def _set_up(self, kinematics: KinematicModel, settings: PlanningSettings) -> None:
        self._kinematics = kinematics
        self._settings = settings
        self._groups: dict[str, JointModelGroup] = {}
        self._planning: PlanningContext | None = None
        #: Held while the context is used, which serves a thread at a time.
        self._lock = threading.RLock()

    @property
    def _context(self) -> PlanningContext:
        """Solvers, collision checker and limits of this model; made at the first need."""
        with self._lock:
            if self._planning is None:
                self._planning = PlanningContext(
                    PlanningScene(self._kinematics), self._settings, logger())
            return self._planning

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self._kinematics.robot.name

    @property
    def model_frame(self) -> str:
        """The frame of all poses without a frame."""
        return self._kinematics.robot.model_frame

    @property
    def root_joint_name(self) -> str:
        """Name of the joint between the model frame and the root link."""
        virtual = self._kinematics.robot.semantic.virtual_joint
        return 'ASSUMED_FIXED_ROOT_JOINT' if virtual is None else virtual.name

    @property
    def joint_model_group_names(self) -> list[str]:
        """Names of the planning groups, in the order of the alphabet."""
        return sorted(self._kinematics.robot.semantic.groups)

    @property
    def joint_model_groups(self) -> list[JointModelGroup]:
        """The planning groups, in the order of their names."""
        return [self.get_joint_model_group(name) for name in self.joint_model_group_names]

    @property
    def end_effectors(self) -> list[JointModelGroup]:
        """The planning groups that are end effectors, in the order of their names."""
        effectors = self._kinematics.robot.semantic.end_effectors.values()
        return [self.get_joint_model_group(name)
                for name in sorted(each.group for each in effectors)]

    def has_joint_model_group(self, joint_model_group_name: str) -> bool:
        """Return whether there is a planning group of this name."""
        return joint_model_group_name in self._kinematics.robot.semantic.groups

    def get_joint_model_group(self, joint_model_group_name: str) -> JointModelGroup:
        """
        Return a planning group.

        :raises PlanningError: there is none of this name; lists those that there are.
        """
        name = joint_model_group_name
        if name not in self._groups:
            self._groups[name] = JointModelGroup(self, name)
        return self._groups[name]

    def _unknown_state(self, group: str, name: str) -> str:
        """Return a sentence about a named state that is not there."""
        known = tuple(self._kinematics.robot.semantic.named_states.get(group, {}))
        return (f"group '{group}' has no named state '{name}' {nearest(name, known)}".rstrip()
                + f"; known: {', '.join(known) or 'none'}")

    def get_model_info(self) -> str:
        """Return a text with frames, joints, links and groups."""
        robot = self._kinematics.robot
        lines = [f'Model {self.name} in frame {self.model_frame}, root joint '
                 f'{self.root_joint_name}']
        for name, joint in robot.joints.items():
            limits = joint.limits
            lines.append(
                f'  joint {name}: {joint.type.value}, {joint.parent} -> {joint.child}'
                + (f', [{limits.lower:g}, {limits.upper:g}]' if joint.movable else '')
                + (f', mimics {joint.mimic.joint}' if joint.mimic else ''))
        lines += [f'  link {name}: {len(link.collisions)} collision shapes'
                  for name, link in robot.links.items()]
        lines += [f'  group {name}: {", ".join(group.joints)}'
                  for name, group in robot.semantic.groups.items()]
        return '\n'.join(lines) + '\n'
