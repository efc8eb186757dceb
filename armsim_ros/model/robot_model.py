# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robot as everything above sees it: links, joints, limits, planning groups."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
import math

from armsim_ros.arrays import Matrix
from armsim_ros.errors import ModelError, nearest, Problem
from armsim_ros.model.geometry import Geometry
from armsim_ros.model.semantic_model import PlanningGroup, SemanticModel


class JointType(Enum):
    """Joint types of URDF, by their URDF words."""

    FIXED = 'fixed'
    REVOLUTE = 'revolute'
    CONTINUOUS = 'continuous'
    PRISMATIC = 'prismatic'
    FLOATING = 'floating'
    PLANAR = 'planar'


@dataclass(frozen=True, slots=True)
class JointLimits:
    """
    Bounds of a joint; infinite where there is none.

    :param lower: [rad or m].
    :param upper: [rad or m].
    :param velocity: [rad/s or m/s].
    :param acceleration: [rad/s^2 or m/s^2].
    :param jerk: [rad/s^3 or m/s^3].
    :param effort: [N*m or N].
    """

    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf
    acceleration: float = math.inf
    jerk: float = math.inf
    effort: float = math.inf


@dataclass(frozen=True, slots=True)
class SoftLimits:
    """
    ``<safety_controller>`` of a joint: bounds inside those of ``<limit>``.

    :param lower: [rad or m].
    :param upper: [rad or m].
    :param k_position: velocity per distance to a bound [1/s].
    :param k_velocity: effort per velocity beyond its bound [N*m*s/rad or N*s/m].
    """

    lower: float
    upper: float
    k_position: float
    k_velocity: float


@dataclass(frozen=True, slots=True)
class Mimic:
    """Position = multiplier * position of ``joint`` + offset [rad or m]."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """
    A URDF joint.

    :param limits: the URDF's; plans have bounds of their own (``planning_robot``).
    :param origin: (4, 4) pose of the joint frame in the parent link's frame.
    :param axis: (3,) unit vector in the joint frame.
    :param damping: [N*m*s/rad or N*s/m].
    :param friction: [N*m or N].
    """

    name: str
    type: JointType
    parent: str
    child: str
    origin: Matrix
    axis: Matrix
    limits: JointLimits = field(default_factory=JointLimits)
    mimic: Mimic | None = None
    damping: float = 0.0
    friction: float = 0.0
    soft_limits: SoftLimits | None = None

    @property
    def movable(self) -> bool:
        """Whether the joint has one position variable."""
        return self.type in (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC)

    @property
    def active(self) -> bool:
        """Whether the joint moves by itself: movable and no mimic."""
        return self.movable and self.mimic is None


@dataclass(frozen=True, slots=True, eq=False)
class Inertial:
    """
    Mass properties of a link.

    :param mass: [kg].
    :param origin: (4, 4) pose of the inertia frame in the link frame.
    :param inertia: (3, 3) [kg*m^2] in the inertia frame.
    """

    mass: float
    origin: Matrix
    inertia: Matrix


@dataclass(frozen=True, slots=True, eq=False)
class LinkGeometry:
    """A shape fixed to a link; ``origin`` (4, 4) in the link frame, ``rgba`` in 0..1."""

    geometry: Geometry
    origin: Matrix
    name: str = ''
    rgba: tuple[float, float, float, float] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A URDF link with what is fixed to it."""

    name: str
    inertial: Inertial | None = None
    collisions: tuple[LinkGeometry, ...] = ()
    visuals: tuple[LinkGeometry, ...] = ()


@dataclass(frozen=True, slots=True)
class HardwareJoint:
    """
    A joint of a ``<ros2_control>`` tag.

    :param commands: the interfaces that may be claimed.
    :param states: the interfaces that can be read.
    :param initial: position at the start [rad or m]; None where the tag gives none.
    :param bounds: command interface -> (least, largest) value, narrower than the URDF's; both
        infinite where the interface's limits are switched off.
    :param others: further state interfaces, such as a temperature -> value at the start.
    :param limited: whether commands are kept within limits where the manager is configured to.
    :param free: whether a joint that mimics another in the URDF is driven by itself.
    :param follows: what the hardware makes a joint follow that mimics none in the URDF.
    """

    name: str
    commands: tuple[str, ...] = ()
    states: tuple[str, ...] = ()
    initial: float | None = None
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)
    others: dict[str, float] = field(default_factory=dict)
    limited: bool = True
    free: bool = False
    follows: Mimic | None = None


@dataclass(frozen=True, slots=True)
class HardwareSensor:
    """
    A ``<sensor>`` of a ``<ros2_control>`` tag that something measures here.

    :param frame: the link in whose frame it measures.
    :param states: names of its interfaces, such as ``force.x``.
    :param reference: the link in whose frame a pose is; '' for the root link.
    :param mount: where an IMU sits in the frame: x, y, z [m], roll, pitch, yaw [rad].
    """

    name: str
    frame: str
    states: tuple[str, ...] = ()
    reference: str = ''
    mount: tuple[float, ...] = (0.0,) * 6


#: Words in the names of packages with the plugins of simulators.
_SIMULATORS = frozenset({'gazebo', 'gz', 'ign', 'mujoco', 'webots'})


@dataclass(frozen=True, slots=True)
class HardwareSystem:
    """
    A ``<ros2_control>`` tag: a hardware component.

    :param type: system, actuator or sensor.
    :param plugin: as written; all are simulated.
    :param other_states: ``sensor/interface``, ``gpio/interface``, or a further interface of a
        joint -> value.
    :param other_commands: likewise; a state of the same name follows it.
    :param sensors: those that measure; their values are among ``other_states``, too.
    :param parameters: of the hardware, as written.
    :param deaf: whether commands do not reach the joints.
    :param offset: added to each position command [rad or m].
    """

    name: str
    type: str
    plugin: str
    joints: tuple[HardwareJoint, ...] = ()
    other_states: dict[str, float] = field(default_factory=dict)
    other_commands: tuple[str, ...] = ()
    sensors: tuple[HardwareSensor, ...] = ()
    parameters: dict[str, str] = field(default_factory=dict)
    deaf: bool = False
    offset: float = 0.0

    @property
    def of_simulator(self) -> bool:
        """Whether the plugin belongs to a simulator, which reads effort limits and has gravity."""
        words = self.plugin.partition('/')[0].split('_')
        return not _SIMULATORS.isdisjoint(words)

    @property
    def reads_efforts(self) -> bool:
        """
        Whether effort limits bound position commands, too.

        Gazebo Classic sets the positions themselves (gazebo_system.cpp: write).
        """
        return self.of_simulator and not self.plugin.startswith('gazebo_ros2_control/')


@dataclass(frozen=True, eq=False)
class RobotModel:
    """
    A robot: kinematic tree, limits of the URDF, SRDF.

    :param name: the URDF's robot name.
    :param links: by name, in tree order (depth first from the root).
    :param joints: by name, in tree order.
    :param root_link: the link without a parent.
    :param hardware: what ``<ros2_control>`` declares; without any all joints have all
        interfaces.
    :param urdf: the URDF text after xacro, mesh addresses as the user wrote them.
    :param srdf: the SRDF text.
    """

    name: str
    links: dict[str, Link]
    joints: dict[str, Joint]
    root_link: str
    semantic: SemanticModel = field(default_factory=SemanticModel)
    hardware: tuple[HardwareSystem, ...] = ()
    urdf: str = ''
    srdf: str = ''

    @cached_property
    def movable_joints(self) -> tuple[str, ...]:
        """All joints with a position, mimic joints too, in tree order."""
        return tuple(name for name, joint in self.joints.items() if joint.movable)

    @cached_property
    def active_joints(self) -> tuple[str, ...]:
        """All joints with a variable of their own, in tree order."""
        return tuple(name for name, joint in self.joints.items() if joint.active)

    @cached_property
    def externally_driven_joints(self) -> frozenset[str]:
        """Joints of mock components or of a vendor's driver, which compensates gravity."""
        return frozenset(joint.name for system in self.hardware if not system.of_simulator
                         for joint in system.joints)

    @cached_property
    def ideally_positioned_joints(self) -> frozenset[str]:
        """Joints whose hardware follows positions whatever their effort limits are."""
        return frozenset(joint.name for system in self.hardware if not system.reads_efforts
                         for joint in system.joints)

    @cached_property
    def hardware_joints(self) -> dict[str, HardwareJoint]:
        """Joint -> its declaration in ``<ros2_control>``; interfaces of several tags together."""
        found: dict[str, HardwareJoint] = {}
        for joint in (joint for system in self.hardware for joint in system.joints):
            known = found.get(joint.name)
            if known is not None:
                joint = replace(
                    joint, commands=tuple(dict.fromkeys((*known.commands, *joint.commands))),
                    states=tuple(dict.fromkeys((*known.states, *joint.states))),
                    initial=known.initial if joint.initial is None else joint.initial,
                    bounds={**known.bounds, **joint.bounds})
            found[joint.name] = joint
        return found

    @cached_property
    def unactuated_joints(self) -> frozenset[str]:
        """
        Joints that a simulator moves by physics alone: declared there, without a command.

        As ``is_actuated`` in gz_system.cpp of gz_ros2_control (initSim, write).
        """
        simulated = {name for name in self.hardware_joints if self.joints[name].active}
        return frozenset(name for name in simulated - self.externally_driven_joints
                         if not self.hardware_joints[name].commands)

    @property
    def model_frame(self) -> str:
        """The frame of all poses without a frame: the root link, or the frame that it moves in."""
        virtual = self.semantic.virtual_joint
        moves = virtual is not None and virtual.type != 'fixed'
        return self.parent_frame if moves and self.parent_frame else self.root_link

    @property
    def parent_frame(self) -> str:
        """The frame outside of the robot that a virtual joint ties it to, '' for none."""
        virtual = self.semantic.virtual_joint
        if virtual is None or virtual.child_link != self.root_link:
            return ''
        return '' if virtual.parent_frame in self.links else virtual.parent_frame

    @cached_property
    def parent_joint(self) -> dict[str, str]:
        """Link -> joint above it; the root is not there."""
        return {joint.child: name for name, joint in self.joints.items()}

    def group(self, name: str) -> PlanningGroup:
        """Return a planning group; ModelError names the known ones."""
        try:
            return self.semantic.groups[name]
        except KeyError:
            known = tuple(self.semantic.groups)
            raise ModelError(
                Problem(
                    f"planning group '{name}' is not in the SRDF of robot '{self.name}'",
                    allowed=', '.join(known) or 'the SRDF has no groups',
                    remedy=nearest(name, known))) from None

    def controlled_joints(self, group: str) -> tuple[str, ...]:
        """
        Return the joints of a planning group that a controller has to move: not passive.

        :raises ModelError: as :meth:`group`.
        """
        return tuple(name for name in self.group(group).active_joints
                     if name not in self.semantic.passive_joints)

    def complete(self, positions: dict[str, float]) -> dict[str, float]:
        """
        Return a position for every movable joint.

        :param positions: joint -> [rad or m]; the others take their default (0 where the
            limits allow it, else the middle), mimic joints follow.
        """
        full: dict[str, float] = {}
        for name in self.active_joints:
            full[name] = positions.get(name, self.default_position(name))
        for name in self.movable_joints:
            if self.joints[name].mimic is not None:
                driver, multiplier, offset = self.driver_of(name)
                full[name] = multiplier * full[driver.name] + offset
        return {name: full[name] for name in self.movable_joints}

    def default_position(self, name: str) -> float:
        """Return 0 where the limits allow it, else the middle of the limits [rad or m]."""
        limits = self.joints[name].limits
        if limits.lower <= 0.0 <= limits.upper:
            return 0.0
        return 0.5 * (limits.lower + limits.upper)

    def driver_of(self, name: str) -> tuple[Joint, float, float]:
        """
        Return the joint that a joint follows, of a chain the last, with multiplier and offset.

        :returns: the joint itself, 1 and 0 where it mimics none.
        """
        joint, multiplier, offset = self.joints[name], 1.0, 0.0
        while joint.mimic is not None:
            offset += multiplier * joint.mimic.offset
            multiplier *= joint.mimic.multiplier
            joint = self.joints[joint.mimic.joint]
        return joint, multiplier, offset
