# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Forces from outside: those that act on an arm, and wrenches that act on bodies for a while."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.model.cell import Robot
from armsim_ros.model.grippers import grippers_of
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.physics.robot_spec import element_name
from armsim_ros.sim.simulation import Simulation
from armsim_ros.sim.world.entities import Entities


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


@dataclass(frozen=True, eq=False)
class Wrench:
    """
    A wrench in the axes of a body.

    :param frame: link or entity.
    :param force: (3,) [N].
    :param torque: (3,) [N*m].
    :param point: (3,) where the force acts, from the body's origin [m].
    :param duration_ns: 0 is a single physics step.
    :param ramp_ns: part at the end of the duration in which it fades to 0.
    """

    frame: str
    force: Vector
    torque: Vector
    point: Vector
    duration_ns: int = 0
    ramp_ns: int = 0

    def share(self, left_ns: int) -> float:
        """Return how much of it acts when so much of the duration is left [ns]."""
        return min(1.0, max(0.0, left_ns / self.ramp_ns)) if self.ramp_ns else 1.0


@dataclass(eq=False)
class _Acting:
    wrench: Wrench
    end_ns: int
    key: str
    ended: Callable[[], object]


class ExternalWrenches:
    """
    Adds wrenches to what acts on bodies already; only in the thread that ticks.

    :param loop: steps the physics.
    :param entities: the links and objects that there are.
    """

    def __init__(self, loop: ControlLoop, entities: Entities) -> None:
        self._loop, self._entities = loop, entities
        self._acting: list[_Acting] = []
        #: Body -> what acted on it after the last change here, and our part of that.
        self._written: dict[int, tuple[Vector, Vector]] = {}

    @property
    def acting(self) -> list[tuple[Wrench, float]]:
        """The wrenches that act now, and the share of each."""
        now_ns = self._loop.clock.now_ns
        return [(each.wrench, each.wrench.share(each.end_ns - now_ns)) for each in self._acting]

    def apply(
        self, wrenches: Sequence[Wrench], *, key: str = '',
        ended: Callable[[], object] = lambda: None,
    ) -> None:
        """
        Have wrenches act from now on: all of them, or none.

        :param key: where not empty, they replace those with the same key on the same frame.
        :param ended: called when the last of them has ended.
        :raises SimulationError: a frame that is not known, or an object that is fixed.
        """
        for wrench in wrenches:
            self._entities.body(wrench.frame)
        if not wrenches:
            ended()
            return
        now_ns, left = self._loop.clock.now_ns, [len(wrenches)]

        def count() -> None:
            left[0] -= 1
            if not left[0]:
                ended()

        if key:
            frames = {wrench.frame for wrench in wrenches}
            self._acting = [each for each in self._acting
                            if each.key != key or each.wrench.frame not in frames]
        if not self._acting:
            self._loop.every(self._loop.clock.step_ns, self._act)
        self._acting += [_Acting(each, now_ns + each.duration_ns, key, count) for each in wrenches]
        self._write(now_ns)

    def clear(self) -> None:
        """End all wrenches."""
        gone, self._acting = self._acting, []
        if gone:
            self._loop.forget(self._act)
        self._write(0)
        for each in gone:
            each.ended()

    def _act(self, now_ns: int) -> None:
        gone = [each for each in self._acting
                if now_ns >= each.end_ns or not self._is_there(each.wrench.frame)]
        self._acting = [each for each in self._acting if each not in gone]
        if not self._acting:
            self._loop.forget(self._act)
        self._write(now_ns)
        for each in gone:
            each.ended()

    def _is_there(self, frame: str) -> bool:
        return frame in self._loop.simulation.model.links or self._entities.has(frame)

    def _write(self, now_ns: int) -> None:
        """Add up what acts on each body at its centre of mass, in world axes."""
        data = self._loop.simulation.mujoco_data
        sums: dict[int, Vector] = {}
        for each in self._acting:
            wrench, body = each.wrench, self._entities.body(each.wrench.frame)
            turn = data.xmat[body].reshape(3, 3)
            force, torque = turn @ wrench.force, turn @ wrench.torque
            lever = data.xpos[body] + turn @ wrench.point - data.xipos[body]
            share = wrench.share(each.end_ns - now_ns)
            sums[body] = sums.get(body, np.zeros(6)) + share * np.concatenate(
                (force, torque + np.cross(lever, force)))
        applied = data.xfrc_applied
        for body in {*sums, *self._written}:
            if body >= len(applied):
                continue
            total, own = self._written.get(body, (None, None))
            # Others, such as suction cups, set what acts anew.
            others = applied[body] - own if total is not None and (
                np.array_equal(applied[body], total)) else applied[body]
            applied[body] = others + sums.get(body, np.zeros(6))
        self._written = {body: (applied[body].copy(), own) for body, own in sums.items()}
