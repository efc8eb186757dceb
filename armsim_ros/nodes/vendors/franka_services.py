# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``service_server``: stiffness, frames, collision behaviour and load of an arm at rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from franka_msgs.srv import (
    SetCartesianStiffness,
    SetForceTorqueCollisionBehavior,
    SetFullCollisionBehavior,
    SetJointStiffness,
    SetLoad,
    SetStiffnessFrame,
    SetTCPFrame,
)
from geometry_msgs.msg import Inertia
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.transforms import inverse_pose
from armsim_ros.nodes.simulation.world.answers import vector
from armsim_ros.nodes.vendors.endpoints import ArmNodes
from armsim_ros.sim.assembly import watch
from armsim_ros.vendors import FRANKA_FORCES, FRANKA_TORQUES


@dataclass(frozen=True, eq=False)
class Mass:
    """
    A rigid body in the axes of the flange.

    :param mass: [kg].
    :param centre: of mass (3,) [m].
    :param inertia: at the centre of mass (3, 3) [kg*m^2].
    """

    mass: float = 0.0
    centre: Vector = field(default_factory=lambda: np.zeros(3))
    inertia: Matrix = field(default_factory=lambda: np.zeros((3, 3)))

    def __add__(self, other: Mass) -> Mass:
        """Return both as a single body; a body without mass has no inertia."""
        parts = [part for part in (self, other) if part.mass > 0.0]
        mass = sum(part.mass for part in parts)
        if not parts:
            return Mass()
        centre = np.asarray(sum(part.mass * part.centre for part in parts)) / mass
        inertia = np.zeros((3, 3))
        for part in parts:
            way = part.centre - centre
            inertia += part.inertia + part.mass * (way @ way * np.eye(3) - np.outer(way, way))
        return Mass(mass, centre, inertia)

    def message(self) -> Inertia:
        """Return it as a message."""
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = self.inertia.tolist()
        return Inertia(m=self.mass, com=vector(self.centre),
                       ixx=xx, ixy=xy, ixz=xz, iyy=yy, iyz=yz, izz=zz)


def end_effector(model: RobotModel, arm: ArmDynamics, flange: str) -> Mass:
    """Return what is mounted at the flange, all of its joints at 0."""
    whole, to_flange = Mass(), inverse_pose(arm.frame(flange))
    for name, link in model.links.items():
        if link.inertial is None or not _carries(model, flange, name):
            continue
        pose = to_flange @ arm.frame(name) @ link.inertial.origin
        turn = pose[:3, :3]
        whole += Mass(link.inertial.mass, pose[:3, 3], turn @ link.inertial.inertia @ turn.T)
    return whole


def _carries(model: RobotModel, flange: str, link: str) -> bool:
    """Return whether a link is beyond the flange."""
    while (joint := model.parent_joint.get(link)) is not None:
        link = model.joints[joint].parent
        if link == flange:
            return True
    return False


#: The stiffest joint [N*m/rad].
STIFFEST = 14_250.0


@dataclass(eq=False)
class ArmParameters:
    """
    What clients have set of an arm.

    :param tool: (4, 4) the tool in the frame of the hand, else of the flange.
    :param stiffness: (4, 4) the frame of wrenches in that of the tool.
    :param torques: (2, n) external torques that are a contact, and that are a collision [N*m].
    :param forces: (2, 6) the same of the wrench [N, N*m].
    :param load: what the flange carries beside its end effector.
    """

    tool: Matrix = field(default_factory=lambda: np.eye(4))
    stiffness: Matrix = field(default_factory=lambda: np.eye(4))
    torques: Matrix = field(default_factory=lambda: np.array(FRANKA_TORQUES))
    forces: Matrix = field(default_factory=lambda: np.array(FRANKA_FORCES))
    load: Mass = field(default_factory=Mass)


class ParameterServices:
    """
    The services.

    :param joints: (n,) of the arm.
    """

    def __init__(self, nodes: ArmNodes, joints: Sequence[str], parameters: ArmParameters) -> None:
        self._nodes, self._joints, self._parameters = nodes, tuple(joints), parameters
        node = nodes.new_node('service_server')
        self._logger = node.get_logger()
        services: tuple[tuple[Any, str, Callable[[Any], str]], ...] = (
            (SetJointStiffness, 'set_joint_stiffness', self._set_joint_stiffness),
            (SetCartesianStiffness, 'set_cartesian_stiffness', _check_cartesian_stiffness),
            (SetTCPFrame, 'set_tcp_frame', partial(self._set_frame, 'tool')),
            (SetStiffnessFrame, 'set_stiffness_frame', partial(self._set_frame, 'stiffness')),
            (SetForceTorqueCollisionBehavior, 'set_force_torque_collision_behavior',
             self._set_collision_behavior),
            (SetFullCollisionBehavior, 'set_full_collision_behavior',
             self._set_collision_behavior),
            (SetLoad, 'set_load', self._set_load))
        for kind, name, function in services:
            nodes.service(node, kind, f'~/{name}', partial(self._answer, function))

    def _answer(self, function: Callable[[Any], str], request: Any, response: Any) -> None:
        moving = next((controller.name for controller in self._nodes.manager.controllers.values()
                       if controller.active and controller.moves_arm), '')
        response.error = function(request) if not moving else (
            f"the command is not possible while controller '{moving}' moves the arm; "
            'deactivate it')
        response.success = not response.error
        if response.error:
            self._logger.error(response.error)

    def _set_joint_stiffness(self, request: Any) -> str:
        values = [float(value) for value in request.joint_stiffness]
        if not all(0.0 < value <= STIFFEST for value in values):
            return f'joint stiffness {values}; allowed: above 0, at most {STIFFEST:g} N*m/rad'
        self._nodes.manager.hardware.set_gains({
            name: PidGains(p=value) for name, value in zip(self._joints, values, strict=False)})
        return ''

    def _set_frame(self, name: str, request: Any) -> str:
        frame = np.array(request.transformation).reshape(4, 4).T  # column by column
        turn = frame[:3, :3]
        if not (np.isfinite(frame).all() and np.allclose(frame[3], (0.0, 0.0, 0.0, 1.0))
                and np.allclose(turn @ turn.T, np.eye(3), atol=1e-5)
                and np.linalg.det(turn) > 0.0):
            return 'the transformation is not a pose, column by column'
        setattr(self._parameters, name, frame)
        return ''

    def _set_collision_behavior(self, request: Any) -> str:
        bounds = [np.array(getattr(request, f'{side}_{kind}_thresholds_nominal'))
                  for kind in ('torque', 'force') for side in ('lower', 'upper')]
        if not all((values > 0.0).all() for values in bounds):
            return 'a threshold is not above 0'
        nodes, parameters = self._nodes, self._parameters
        parameters.torques, parameters.forces = np.stack(bounds[:2]), np.stack(bounds[2:])
        stops = nodes.manager.stops
        if stops.monitor is None or not stops.monitor.has_loads:
            watch(nodes.robot, nodes.manager, nodes.loop.simulation, always=True, loaded=True)
        assert stops.monitor is not None
        places = [nodes.manager.hardware.index[name] for name in self._joints]
        stops.monitor.torques[places] = bounds[1][: len(places)]
        stops.monitor.force = float(bounds[3][:3].min())
        return ''

    def _set_load(self, request: Any) -> str:
        centre = [float(value) for value in request.center_of_mass]
        inertia = np.reshape(request.load_inertia, (3, 3))
        if not np.isfinite(inertia).all():
            return f'inertia {inertia.tolist()} has a number that is not finite'
        refusal = self._nodes.set_payload(request.mass, centre)
        if not refusal:
            self._parameters.load = Mass(float(request.mass), np.array(centre), inertia)
        return refusal


def _check_cartesian_stiffness(request: Any) -> str:
    """Return what is wrong with a stiffness; no controller here has a Cartesian one."""
    values = np.array(request.cartesian_stiffness)
    return '' if (values >= 0.0).all() else 'a stiffness is below 0'
