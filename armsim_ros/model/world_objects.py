# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The state of a robot at the start, and its world's objects as the model has them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.config.world import (
    BoxSettings,
    CapsuleSettings,
    ConeSettings,
    convex_outline,
    CylinderSettings,
    PrismSettings,
    ShapeSettings,
    SphereSettings,
    WorldObjectSettings,
    WorldSettings,
)
from armsim_ros.errors import Location, nearest, Problem, Severity, SimulationError
from armsim_ros.model.geometry import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Geometry,
    lowest_height,
    Mesh,
    Sphere,
)
from armsim_ros.model.robot_model import Inertial, LinkGeometry, RobotModel
from armsim_ros.model.transforms import inverse_pose, pose_matrix
from armsim_ros.model.tree import link_poses, standing_links

#: Keys of simulation.yaml for the start positions of joints.
START_KEYS = ('initial_positions', 'initial_state')


def initial_positions(model: RobotModel, settings: SimulationSettings) -> dict[str, float]:
    """
    Return the positions at the start that the settings give, by joint [rad or m].

    The named state comes first, single joints win over it.

    :raises SimulationError: an unknown state or joint, or a position outside the limits.
    """
    requested = dict(_named_state(model, settings.initial_state))
    requested.update(settings.initial_positions)
    for name, position in requested.items():
        joint = model.joints.get(name)
        if joint is None or not joint.active:
            raise SimulationError(
                f"the initial position of '{name}' does not fit robot '{model.name}'; "
                f'allowed: {", ".join(model.active_joints)}; ' + nearest(name, model.active_joints)
            )
        if not joint.limits.lower <= position <= joint.limits.upper:
            raise SimulationError(
                f"the initial position {position:g} of joint '{name}' is outside its limits; "
                f'allowed: {joint.limits.lower:g} to {joint.limits.upper:g}')
    return requested


def with_hardware_start(settings: RobotSettings, model: RobotModel
                        ) -> tuple[RobotSettings, list[Problem]]:
    """
    Return settings in which the joints start as given by the URDF's hardware or the package.

    The user's own settings win: single joints, and the joints of a named state. A joint
    of the hardware without a value starts at 0, or at the limit nearest to it.

    :returns: the settings, and a warning for each value that does not fit.
    """
    simulation = settings.simulation
    places = dict(settings.start)
    for name, joint in model.hardware_joints.items():
        if model.joints[name].active:
            places[name] = places.get(name, 0.0) if joint.initial is None else joint.initial
    problems: list[Problem] = []
    where = Location(str(settings.urdf_file))
    if simulation.initial_state:
        for name in _named_state(model, simulation.initial_state):
            places.pop(name, None)
    start: dict[str, float] = {}
    for name, value in places.items():
        found = model.joints.get(name)
        if found is None or not found.active:
            if found is None:
                problems.append(Problem(
                    f"the start of joint '{name}' is left out: it is not in the URDF", where,
                    '', nearest(name, model.active_joints), Severity.WARNING))
            continue
        start[name] = min(max(value, found.limits.lower), found.limits.upper)
        if start[name] != value and name not in simulation.initial_positions:
            problems.append(Problem(
                f"joint '{name}' starts at {start[name]:g}: {value:g} is outside its limits",
                where, '', '', Severity.WARNING))
    if not start:
        return settings, problems
    moved = simulation.model_copy(
        update={'initial_positions': {**start, **simulation.initial_positions}})
    return settings.model_copy(update={'simulation': moved}), problems


def _named_state(model: RobotModel, requested: str) -> dict[str, float]:
    if not requested:
        return {}
    states = model.semantic.named_states
    group, _, name = requested.rpartition('/')
    for candidate, values in states.items():
        if name in values and group in ('', candidate):
            return values[name]
    known = [f'{key}/{state}' for key, values in states.items() for state in values]
    raise SimulationError(
        f"the initial state '{requested}' is not in the SRDF of robot '{model.name}'; "
        f'allowed: {", ".join(known) or "the SRDF has none"}')


WORLD_TYPE = 'armsim_ros/world'
"""
Key of the object type that marks objects of a simulated world in messages.

Its ``db`` is the world's epoch. In a planning scene they have no type, so that an object that a
client sends back is the user's.
"""

#: Name of the floor where it is an object, and its size [m].
FLOOR = 'floor'
FLOOR_EDGE, FLOOR_DEPTH = 10.0, 0.1


@dataclass(frozen=True, slots=True, eq=False)
class WorldObject:
    """
    A rigid object.

    :param name: unique in the world.
    :param pose: (4, 4) in the world.
    :param parts: shapes in the object's frame; at least one.
    :param mass: [kg]; None for an object that never moves.
    :param friction: coefficient of sliding friction.
    :param inertial: how the mass is spread; None is evenly over the parts.
    :param gravcomp: share of the weight that does not act: 0 falls, 1 floats.
    """

    name: str
    pose: Matrix
    parts: tuple[LinkGeometry, ...]
    mass: float | None = None
    friction: float = 0.8
    inertial: Inertial | None = None
    gravcomp: float = 0.0

    @classmethod
    def of_shape(
        cls, name: str, shape: Geometry, pose: Matrix, *, mass: float | None = None
    ) -> WorldObject:
        """
        Return an object of a single shape.

        :param pose: (4, 4) in the world.
        :param mass: [kg]; None for an object that never moves.
        """
        return cls(name, pose, (LinkGeometry(shape, np.eye(4)),), mass)


def prism(corners: Sequence[Sequence[float]], length: float) -> Mesh:
    """
    Return a convex polygon extruded along z, centred at half its height.

    :param corners: (n, 2) corners in order, either sense [m].
    :param length: height [m].
    :raises SimulationError: the polygon is not convex.
    """
    try:
        outline = np.array(convex_outline(corners))
    except ValueError as error:
        raise SimulationError(str(error)) from None
    count = len(outline)
    low = np.column_stack([outline, np.full(count, -0.5 * length)])
    high = np.column_stack([outline, np.full(count, 0.5 * length)])
    triangles = []
    for i in range(1, count - 1):
        triangles += [(0, i + 1, i), (count, count + i, count + i + 1)]
    for i in range(count):
        j = (i + 1) % count
        triangles += [(i, j, count + j), (i, count + j, count + i)]
    return Mesh(np.vstack([low, high]), np.array(triangles, dtype=np.int64))


def shape_geometry(shape: ShapeSettings) -> Geometry:
    """Return the geometry of a shape that was read from a world file."""
    if isinstance(shape, BoxSettings):
        return Box(shape.size)
    if isinstance(shape, SphereSettings):
        return Sphere(shape.radius)
    if isinstance(shape, CylinderSettings):
        return Cylinder(shape.radius, shape.length)
    if isinstance(shape, CapsuleSettings):
        return Capsule(shape.radius, shape.length)
    if isinstance(shape, ConeSettings):
        return Cone(shape.radius, shape.length)
    assert isinstance(shape, PrismSettings)
    return prism(shape.corners, shape.length)


def object_from_settings(name: str, settings: WorldObjectSettings) -> WorldObject:
    """Return an object of a world file."""
    try:
        parts = tuple(
            LinkGeometry(
                shape_geometry(part.shape), pose_matrix(part.xyz, part.rpy), rgba=settings.color)
            for part in settings.parts)
    except SimulationError as error:
        raise SimulationError(f"object '{name}': {error}") from None
    return WorldObject(
        name, pose_matrix(settings.xyz, settings.rpy), parts, settings.mass, settings.friction)


def floor_object(height: float) -> WorldObject:
    """
    Return the floor as an object that reaches farther than any arm.

    :param height: of its surface in the world [m].
    """
    shape = Box((FLOOR_EDGE, FLOOR_EDGE, FLOOR_DEPTH))
    return WorldObject.of_shape(FLOOR, shape, pose_matrix((0.0, 0.0, height - 0.5 * FLOOR_DEPTH)))


def world_in_root(settings: RobotSettings) -> Matrix:
    """Return the pose (4, 4) of the world in the root link's frame."""
    placement = settings.simulation.placement
    return inverse_pose(pose_matrix(placement.xyz, placement.rpy))


def world_objects(settings: WorldSettings) -> tuple[WorldObject, ...]:
    """Return all objects of a world file in its order."""
    return tuple(object_from_settings(name, entry) for name, entry in settings.objects.items())


#: What a link may reach below the usual floor before the floor is lowered [m].
TOLERANCE = 1e-3
#: Distance that a lowered floor keeps from the lowest point [m].
CLEARANCE = 0.05


def with_default_floor(settings: RobotSettings, model: RobotModel
                       ) -> tuple[RobotSettings, list[Problem]]:
    """
    Return settings whose floor touches the robot neither at the start nor in a named state.

    A floor that was chosen, by a world file, stays where it is. Links that no joint moves may
    reach below the floor: the robot is mounted there.

    :returns: the settings, and a warning if the floor was lowered.
    :raises SimulationError: the start does not fit the robot.
    """
    if settings.world_file is not None:
        return settings, []
    start = initial_positions(model, settings.simulation)
    poses = [('at the start', start)]
    poses += [(f"in the named state '{name}' of group '{group}'", {**start, **values})
              for group, states in model.semantic.named_states.items()
              for name, values in states.items()]
    height, link, where = min(
        ((height, link, where) for where, positions in poses
         for height, link in _lowest_points(settings, model, positions)),
        default=(0.0, '', ''))
    is_low = height < -TOLERANCE
    floor = math.floor((height - CLEARANCE) * 100.0) / 100.0 if is_low else True
    settings = settings.model_copy(
        update={'world': settings.world.model_copy(update={'floor': floor})})
    return settings, [] if not is_low else [Problem(
        f"the floor is at z = {floor:g} m: link '{link}' reaches down to z = {height:.3f} m "
        f'{where}',
        Location(str(settings.urdf_file)), severity=Severity.WARNING,
        remedy='choose a world with world:=FILE to have a floor at another height')]


def _lowest_points(settings: RobotSettings, model: RobotModel, positions: Mapping[str, float]
                   ) -> Iterator[tuple[float, str]]:
    """Yield the lowest height [m] of each link that a joint moves, and the link."""
    placement = settings.simulation.placement
    root = pose_matrix(placement.xyz, placement.rpy)
    standing = standing_links(model)
    for name, pose in link_poses(model, positions).items():
        if name in standing:
            continue
        for shape in model.links[name].collisions:
            yield lowest_height(shape.geometry, root @ pose @ shape.origin), name
