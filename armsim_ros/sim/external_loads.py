# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What acts on an arm from outside, as the physics has it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.model.cell import Robot
from armsim_ros.model.grippers import grippers_of
from armsim_ros.sim.physics.robot_spec import element_name
from armsim_ros.sim.simulation import Simulation


class ExternalLoads:
    """
    External torques of an arm's joints and the forces of its contacts.

    Fingers count for neither: they press what they hold. The payloads that are set are a part of
    the arm, whether it carries them or not.

    :param simulation: the plant; an edit of the world replaces its model.
    :param joint_names: (n,) joints of the arm, fingers too.
    :param fingers: joints that move fingers, besides those that the robot's files name.
    """

    def __init__(self, simulation: Simulation, joint_names: Sequence[str], robot: Robot,
                 fingers: Sequence[str] = ()) -> None:
        self._simulation = simulation
        self._joint_names = tuple(joint_names)
        self._robot = simulation.model.name
        model = robot.model
        links: set[str] = set()
        for gripper in grippers_of(robot, fingers):
            palm = gripper.bodies.get(gripper.palm)
            links |= {link for link, root in gripper.bodies.items() if root != palm}
        self._links = frozenset(model.links) - links
        moved = {name: joint.child for name, joint in model.joints.items()}
        self._counts = np.array([moved.get(name) not in links for name in joint_names])
        self._force = np.zeros(6)
        self._bound: Any = None

    def torques(self) -> Vector:
        """Return the external torque of each joint (n,), 0 for fingers [N*m or N]."""
        model, data = self._follow_model()
        dofs = self._dofs
        # All that moves the joints, but for drives, gravity, inertia and springs.
        outside = (data.qfrc_constraint + data.qfrc_smooth + data.qfrc_bias
                   - data.qfrc_passive - data.qfrc_actuator)[dofs]
        for link, (mass, centre) in self._simulation.payloads.items():
            if mass and link in self._links:
                outside -= self._weight(model, data, link, mass, centre)[dofs]
        friction = model.dof_frictionloss[dofs]
        excess = np.maximum(np.abs(outside) - friction, 0.0)
        found: Vector = np.where(self._counts, np.copysign(excess, outside), 0.0)
        return found

    def _weight(self, model: Any, data: Any, link: str, mass: float, centre: Vector) -> Vector:
        """Return with what a point mass at a link loads all joints, as they move (nv,)."""
        body = model.body(element_name(self._robot, link)).id
        point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ centre
        speeds = np.zeros((3, model.nv))
        changes = np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, speeds, None, point, body)
        mujoco.mj_jacDot(model, data, changes, None, point, body)
        # Accelerations are those of the last step, velocities those after it.
        velocity = data.qvel - model.opt.timestep * data.qacc
        acceleration = speeds @ data.qacc + changes @ velocity
        load: Vector = mass * (model.opt.gravity - acceleration) @ speeds
        return load

    def hardest_contact(self) -> tuple[float, str]:
        """Return the greatest force of a contact of the arm [N], and the bodies; 0 without."""
        model, data = self._follow_model()
        if not data.ncon:
            return 0.0, ''
        bodies = model.geom_bodyid[data.contact.geom[: data.ncon]]
        touching = np.flatnonzero(self._of_arm[bodies].any(axis=1))
        hardest, pair = 0.0, None
        for i in touching.tolist():
            mujoco.mj_contactForce(model, data, i, self._force)
            force = float(np.linalg.norm(self._force[:3]))
            if force > hardest:
                hardest, pair = force, bodies[i]
        if pair is None:
            return 0.0, ''
        return hardest, ' and '.join(model.body(int(body)).name for body in pair)

    def _follow_model(self) -> tuple[Any, Any]:
        """Find the arm in the present model."""
        simulation = self._simulation
        model = simulation.mujoco_model
        if model is not self._bound:
            self._bound = model
            self._dofs = np.array([int(model.joint(element_name(self._robot, name)).dofadr[0])
                                   for name in self._joint_names], dtype=np.intp)
            names = {element_name(self._robot, link) for link in self._links}
            self._of_arm = np.array([model.body(i).name in names for i in range(model.nbody)])
        return model, simulation.mujoco_data
