# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot and the scenes of problems as Pinocchio's models, for the planners that use it."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np
import pinocchio as pin


class PinocchioModels:
    """
    A robot's kinematics and collision meshes.

    :param robot: its files.
    """

    def __init__(self, robot: dict[str, Any]) -> None:
        self.model = pin.buildModelFromUrdf(robot['urdf'])
        self._geometry = pin.buildGeomFromUrdf(
            self.model, robot['urdf'], pin.GeometryType.COLLISION)
        self._srdf = robot['srdf']

    def scene(self, problem: dict[str, Any]) -> Any:
        """Return the robot's geometry with a problem's obstacles, and all pairs to check."""
        scene = pin.GeometryModel(self._geometry)
        for each in problem['obstacles']:
            shape = (
                coal.Box(*each['size']) if each['type'] == 'box'
                else coal.Cylinder(each['radius'], each['length']))
            placement = pin.XYZQUATToSE3(np.array([*each['position'], *each['quat_xyzw']]))
            scene.addGeometryObject(pin.GeometryObject(each['id'], 0, placement, shape))
        scene.addAllCollisionPairs()
        pin.removeCollisionPairs(self.model, scene, self._srdf)
        return scene
