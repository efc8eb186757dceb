# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Suction cups: they pull what is near, hold what they touch, and let go of what is too heavy."""

from __future__ import annotations

from collections import deque
import math

import mujoco
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.simulation import VacuumGripperSettings
from armsim_ros.sim.physics.mujoco_model import cup_name, object_body_name, weld_name
from armsim_ros.sim.physics.plant import Plant
from armsim_ros.sim.physics.saved_state import Restorable
from armsim_ros.sim.world.world_scene import WorldScene

#: Simulated time between checks of a cup that is on [ns].
LOOK_NS = 2_000_000
#: Nearer than this is a touch [m].
TOUCH = 5e-4
#: A surface that lies askew on the link is as near as this to the rim: the cup yields [m].
LIP = 5e-3
#: Lines that are kept for callers.
KEPT_LOSSES = 100
#: Acceleration with which a free object is pulled, over gravity [m/s^2].
PULL = 4.0
#: A load above the limit for so long tears the object off [ns].
TEAR_NS = 20_000_000


class VacuumGripper(Restorable):
    """
    A suction cup; only the thread that ticks may use it.

    While it is on, the nearest free object in reach is pulled. Where it touches the cup it is
    welded as it lies; the weld's own forces show when it is torn off.

    :param name: of the gripper.
    :param world: its objects.
    """

    unchanging = frozenset({'name', 'settings', '_plant', '_world', '_axis', '_offset'})

    def __init__(
        self, name: str, settings: VacuumGripperSettings, plant: Plant, world: WorldScene
    ) -> None:
        self.name, self.settings = name, settings
        self.on = False
        self.losses: deque[str] = deque(maxlen=KEPT_LOSSES)
        """A line for each object that was torn off, until it is taken."""
        self._plant, self._world = plant, world
        self.held = self._pulled = ''
        """Name of the object that is held, '' for none."""
        self._over_ns = 0
        self._offset = np.array(settings.xyz)
        self._axis = np.array(settings.axis) / np.linalg.norm(settings.axis)

    def switch_on(self) -> None:
        """Begin to pull."""
        self.on = True

    def switch_off(self) -> None:
        """Let go."""
        self.on = False
        self.release()

    def release(self) -> None:
        """Let go of what is held or pulled."""
        self._stop_pulling()
        if self.held in self._world.objects:
            self._plant.data.eq_active[self._weld(self.held)] = 0
            self._plant.wake()
        self.held, self._over_ns = '', 0

    def look(self, elapsed_ns: int = LOOK_NS) -> None:
        """
        Pull, weld, or see whether the weld still holds; between two steps.

        :param elapsed_ns: simulated time since the last call [ns].
        """
        if self.held and self.held not in self._world.objects:
            self.held = ''
        if self.held:
            self._check_load(elapsed_ns)
        elif self.on:
            self._search()

    def _search(self) -> None:
        self._stop_pulling()
        found = self._nearest()
        if found is None:
            return
        name, distance, surface = found
        if distance <= TOUCH or (distance <= LIP and self._touches(name)):
            self._hold(name)
            return
        model, data = self._plant.model, self._plant.data
        body = int(model.body(object_body_name(name)).id)
        mass = float(model.body_subtreemass[body])
        gravity = float(np.linalg.norm(model.opt.gravity))
        size = min(self.settings.force, mass * (gravity + PULL))
        force = size * (self._point_of(self._pose()) - surface) / distance
        arm = surface - data.xipos[body]
        data.xfrc_applied[body] = np.concatenate([force, _cross(arm, force)])
        self._pulled = name

    def _nearest(self) -> tuple[str, float, Vector] | None:
        """Return the nearest free object in reach, how far it is, and its nearest point."""
        model, data = self._plant.model, self._plant.data
        cup = int(model.geom(cup_name(self.name)).id)
        pose, ends = self._pose(), np.empty(6)
        rim, axis = self._point_of(pose), pose[:3, :3] @ self._axis
        best: tuple[str, float, Vector] | None = None
        for name, item in self._world.objects.items():
            if item.mass is None:
                continue
            body = int(model.body(object_body_name(name)).id)
            start = int(model.body_geomadr[body])
            for geom in range(start, start + int(model.body_geomnum[body])):
                limit = self.settings.reach if best is None else best[1]
                far = float(np.linalg.norm(data.geom_xpos[geom] - rim))
                if far - float(model.geom_rbound[geom]) > limit:
                    continue
                distance = mujoco.mj_geomDistance(model, data, cup, geom, limit, ends)
                if distance >= limit:
                    continue
                way = ends[3:] - rim
                length = float(np.linalg.norm(way))
                aside = math.acos(min(1.0, max(-1.0, float(way.dot(axis)) / length))) if (
                    length > TOUCH and distance > TOUCH) else 0.0
                if aside <= self.settings.angle:
                    best = name, max(0.0, distance), ends[3:].copy()
        return best

    def _touches(self, name: str) -> bool:
        """Return whether an object touches the link that carries the cup."""
        model, data = self._plant.model, self._plant.data
        pair = {int(model.body(object_body_name(name)).id), self._plant.body(self.settings.link)}
        return any({int(model.geom_bodyid[geom]) for geom in contact.geom} == pair
                   for contact in data.contact[:data.ncon])

    def _hold(self, name: str) -> None:
        """Weld an object where it is."""
        model, data = self._plant.model, self._plant.data
        weld, body = self._weld(name), int(model.body(object_body_name(name)).id)
        link = self._plant.body(self.settings.link)
        mujoco.mj_kinematics(model, data)
        relative_xyz, relative_quat, back = np.empty(3), np.empty(4), np.empty(4)
        mujoco.mju_negQuat(back, data.xquat[link])
        mujoco.mju_rotVecQuat(relative_xyz, data.xpos[body] - data.xpos[link], back)
        mujoco.mju_mulQuat(relative_quat, back, data.xquat[body])
        values = model.eq_data[weld]
        values[:3], values[3:6], values[6:10], values[10] = 0.0, relative_xyz, relative_quat, 1.0
        data.eq_active[weld] = 1
        self._plant.wake()
        self.held, self._over_ns = name, 0

    def _check_load(self, elapsed_ns: int) -> None:
        force, moment = self._load()
        if force <= self.settings.force and moment <= self.settings.moment:
            self._over_ns = 0
            return
        self._over_ns += elapsed_ns
        if self._over_ns < TEAR_NS:
            return
        held = self.held
        self.switch_off()
        self.losses.append(
            f"gripper '{self.name}' lost '{held}' at {self._plant.data.time:.3f} s: {force:.1f} N "
            f'and {moment:.2f} N*m; it holds {self.settings.force:g} N and '
            f'{self.settings.moment:g} N*m')

    def _load(self) -> tuple[float, float]:
        """
        Return what the cup carries: force [N], and moment about the rim [N*m].

        It is what the weld and the contact with the link do together. That the link presses on
        the object does not count as a load.
        """
        model, data = self._plant.model, self._plant.data
        body = int(model.body(object_body_name(self.held)).id)
        rows = np.flatnonzero(
            (data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY))
            & (data.efc_id == self._weld(self.held))).tolist()
        if not rows:
            return 0.0, 0.0
        elliptic = model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
        bodies = np.sort(model.geom_bodyid[data.contact.geom], axis=1)
        pair = sorted((body, self._plant.body(self.settings.link)))
        touching = (bodies == pair).all(axis=1) & (data.contact.efc_address >= 0)
        for at in np.flatnonzero(touching).tolist():
            address, dim = int(data.contact.efc_address[at]), int(data.contact.dim[at])
            width = dim if elliptic or dim == 1 else 2 * (dim - 1)
            rows += range(address, address + width)
        forces, generalized = np.zeros(data.nefc), np.zeros(model.nv)
        forces[rows] = data.efc_force[rows]
        mujoco.mj_mulJacTVec(model, data, generalized, forces)
        start = int(model.body_dofadr[body])
        force = generalized[start:start + 3]
        turn = data.xmat[body].reshape(3, 3) @ generalized[start + 3:start + 6]
        pose = self._pose()
        moment = turn + _cross(data.xpos[body] - self._point_of(pose), force)
        axis = pose[:3, :3] @ self._axis
        pull = force - max(0.0, float(force.dot(axis))) * axis
        return float(np.linalg.norm(pull)), float(np.linalg.norm(moment))

    def _stop_pulling(self) -> None:
        if self._pulled in self._world.objects:
            body = int(self._plant.model.body(object_body_name(self._pulled)).id)
            self._plant.data.xfrc_applied[body] = 0.0
        self._pulled = ''

    def _weld(self, item: str) -> int:
        kind = mujoco.mjtObj.mjOBJ_EQUALITY
        return int(mujoco.mj_name2id(self._plant.model, kind, weld_name(self.name, item)))

    def _pose(self) -> Matrix:
        return self._plant.pose(self._plant.body(self.settings.link))

    def _point_of(self, pose: Matrix) -> Vector:
        rim: Vector = pose[:3, :3] @ self._offset + pose[:3, 3]
        return rim


def _cross(first: Vector, second: Vector) -> Vector:
    """Return the product of two vectors (3,); ``numpy.cross`` takes ten times as long."""
    (a, b, c), (x, y, z) = first.tolist(), second.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])
