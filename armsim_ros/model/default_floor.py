# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The height of the floor where no world was chosen: below everything that the robot reaches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
import math

from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import Location, Problem, Severity
from armsim_ros.model.initial_state import initial_positions
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.shape_points import lowest_height
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.tree import link_poses, standing_links

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
