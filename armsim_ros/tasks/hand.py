# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a robot grasps with: a suction cup, or the fingers of a gripper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.controllers.gripper_action_controller import GripperParameters
from armsim_ros.errors import ConfigError, Problem
from armsim_ros.model.cell import Cell
from armsim_ros.model.grippers import Gripper, grippers_in
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.sim.assembly import build_simulation
from armsim_ros.sim.physics.mujoco_model import object_body_name
from armsim_ros.sim.simulation import Simulation
from armsim_ros.stack import ArmSim

#: So far from the tips of the fingers an object is grasped [m].
_GRASP_DEPTH = 0.01


@dataclass(frozen=True, eq=False)
class HandModel:
    """
    Where a robot grasps.

    :param cup: the suction cup, '' for fingers.
    :param joint: the joint that moves the fingers, '' for a cup.
    :param closed: position of that joint with the fingers together [rad or m].
    :param open: its position with the fingers apart [rad or m].
    :param link: carries cup or fingers.
    :param offset: (3,) the point of the grasp in that link [m].
    :param gripper: the fingers; None for a cup.
    """

    cup: str
    joint: str
    closed: float
    open: float
    link: str
    offset: Vector
    gripper: Gripper | None

    @classmethod
    def of(cls, cell: Cell) -> HandModel:
        """
        Return the hand of a robot.

        :raises ConfigError: it has neither cup nor gripper.
        """
        for name, cup in cell.settings.simulation.vacuum_grippers.items():
            return cls(name, '', 0.0, 1.0, cup.link, np.array(cup.xyz), None)
        grippers = grippers_in(cell)
        for robot in cell.robots:
            for controller in robot.settings.controllers:
                if isinstance(controller.parameters, GripperParameters) and grippers:
                    return cls._with_fingers(cell, controller.parameters.joint, grippers[0])
        raise ConfigError(Problem(
            f"robot '{cell.model.name}' has nothing to grasp with",
            allowed='a vacuum_gripper in simulation.yaml, or a GripperActionController'))

    @classmethod
    def _with_fingers(cls, cell: Cell, joint: str, gripper: Gripper) -> HandModel:
        limits = cell.model.joints[joint].limits
        simulation = build_simulation(cell.settings, cell.model)
        fingers = [link for link, root in gripper.bodies.items()
                   if root != gripper.bodies.get(gripper.palm, gripper.palm)]
        low, high = simulation.link_bounds(fingers, gripper.palm)
        middle = 0.5 * (low + high)
        axis = int(np.argmax(np.abs(middle)))
        if middle[axis] > 0.0:
            middle[axis] = high[axis] - _GRASP_DEPTH
        else:
            middle[axis] = low[axis] + _GRASP_DEPTH
        middle[np.arange(3) != axis] = 0.0
        return cls('', joint, float(limits.lower), float(limits.upper), gripper.palm, middle,
                   gripper)

    def arm_joints(self, model: RobotModel) -> tuple[str, ...]:
        """Return the joints with drives but that of the fingers."""
        return tuple(name for name in model.active_joints if name != self.joint)

    def level_of(self, position: float) -> float:
        """Return how far fingers are open, 0 to 1, with their joint at a position [rad or m]."""
        return min(1.0, max(0.0, (position - self.closed) / (self.open - self.closed)))

    def point(self, simulation: Simulation) -> Vector:
        """Return the point of the grasp in the world (3,) [m]."""
        pose = simulation.link_pose(self.link)
        point: Vector = pose[:3, :3] @ self.offset + pose[:3, 3]
        return point


class Hand:
    """
    The hand of a running simulation.

    :param sim: its world must not be edited any more.
    :param model: where it grasps.
    """

    def __init__(self, sim: ArmSim, model: HandModel) -> None:
        self.model = model
        self.sim, self._simulation = sim, sim.simulation
        self._mujoco: Any = sim.simulation.mujoco_model
        self._body = sim.simulation.link_body(model.link)
        bodies = [sim.simulation.link_body(link)
                  for link in (model.gripper.links if model.gripper else ())]
        self._touching = np.isin(self._mujoco.geom_bodyid, bodies)
        self._joint = sim.simulation.index.get(model.joint)
        self._velocity = np.empty(6)

    @property
    def point(self) -> Vector:
        """The point of the grasp in the world (3,) [m], as of the last kinematics."""
        data = self._simulation.mujoco_data
        point: Vector = data.xmat[self._body].reshape(3, 3) @ self.model.offset
        point += data.xpos[self._body]
        return point

    @property
    def rotation(self) -> Matrix:
        """The axes of the link in the world (3, 3)."""
        rotation: Matrix = self._simulation.mujoco_data.xmat[self._body].reshape(3, 3)
        return rotation

    @property
    def speed(self) -> float:
        """How fast the link moves [m/s]."""
        mujoco.mj_objectVelocity(
            self._mujoco, self._simulation.mujoco_data, mujoco.mjtObj.mjOBJ_BODY, self._body,
            self._velocity, 0)
        return float(np.linalg.norm(self._velocity[3:]))

    @property
    def level(self) -> float:
        """1 for fingers apart or a cup that is on, 0 for fingers together or a cup that is off."""
        if self.model.cup:
            return float(self._simulation.vacuum_grippers[self.model.cup].on)
        return self.model.level_of(float(self._simulation.state.position[self._joint]))

    def holds(self, item: str) -> bool:
        """Return whether an object is at the cup, or pressed between the fingers."""
        if self.model.cup:
            return self._simulation.vacuum_grippers[self.model.cup].held == item
        return self.touches(item) and item in self.sim.fingers.squeezed()

    def touches(self, item: str) -> bool:
        """Return whether the hand touches an object; a cup does where it holds it."""
        if self.model.cup:
            return self.holds(item)
        model, data = self._mujoco, self._simulation.mujoco_data
        if not data.ncon:
            return False
        geoms = data.contact.geom
        mine = self._touching[geoms]
        others = model.geom_bodyid[geoms] == model.body(object_body_name(item)).id
        return bool((mine & others[:, ::-1]).any())
