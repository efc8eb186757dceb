# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Puts what was drawn for an episode into the compiled physics, and pushes the arm at random."""

from __future__ import annotations

from collections.abc import Mapping
import math
from typing import Any, ClassVar

import mujoco

from armsim_ros.env.ranges import Episode, number, Quantity, stream, Value
from armsim_ros.model.transforms import pose_matrix, quat_wxyz_from_matrix
from armsim_ros.sim.physics.mujoco_model import object_body_name
from armsim_ros.sim.simulation import Simulation
from armsim_ros.stack import ArmSim

POSITIVE = Quantity(low=0.0, above=True)
STD = Quantity(low=0.0)
#: Most periods that an action can be late.
LONGEST_LATENCY = 100

#: Arrays of the ``MjModel`` that an episode may change, directly or by ``mj_setConst``.
_FIELDS = (
    'body_pos', 'body_quat', 'body_mass', 'body_inertia', 'body_ipos', 'body_subtreemass',
    'body_invweight0', 'bvh_aabb', 'geom_pos', 'geom_size', 'geom_rbound', 'geom_aabb',
    'geom_friction', 'geom_rgba', 'dof_damping', 'dof_frictionloss', 'dof_armature', 'dof_M0',
    'dof_invweight0', 'actuator_acc0', 'actuator_length0', 'tendon_length0', 'tendon_invweight0',
    'cam_pos', 'cam_quat', 'cam_fovy', 'cam_pos0', 'cam_mat0', 'cam_poscom0', 'light_pos',
    'light_diffuse', 'light_pos0', 'light_poscom0', 'light_dir0', 'qpos0', 'qpos_spring')
#: Shapes whose size is a few lengths.
_SCALABLE = {int(kind) for kind in (
    mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CYLINDER,
    mujoco.mjtGeom.mjGEOM_CAPSULE, mujoco.mjtGeom.mjGEOM_ELLIPSOID)}
#: Quantities after whose change the constants of the model are computed again.
_HEAVY = ('mass', 'size', 'armature')


class Variation:
    """
    The quantities of a simulation that may differ from episode to episode.

    :param sim: whose ``MjModel`` is changed; its world must not be edited any more.
    :param joints: the joints with drives.
    """

    def __init__(self, sim: ArmSim, joints: tuple[str, ...]) -> None:
        self._sim, self._joints = sim, joints
        self.model: Any = sim.simulation.mujoco_model
        self._scratch = mujoco.MjData(self.model)
        self._base = {name: getattr(self.model, name).copy() for name in _FIELDS
                      if getattr(self.model, name).size}
        self._gravity = self.model.opt.gravity.copy()
        self._extent = self._statistics()
        self._dirty = self._scaled = False
        self._objects = sim.simulation.world.objects
        self._dofs = {name: self._joint_dofs(name) for name in joints}
        self._cameras = {self.model.camera(i).name: i for i in range(self.model.ncam)}
        self._lights = {self.model.light(i).name: i for i in range(self.model.nlight)}

    def known(self) -> dict[str, Quantity]:
        """Return dotted path -> its quantity, of all that can be varied."""
        vector, scalar = Quantity(3), Quantity()
        unit = Quantity(3, 0.0, 1.0)
        known: dict[str, Quantity] = {}
        for name, item in self._objects.items():
            known |= {f'objects.{name}.xyz': vector, f'objects.{name}.rpy': vector,
                      f'objects.{name}.friction': Quantity(1, 0.0, 10.0),
                      f'objects.{name}.color': unit}
            if item.mass is not None:
                known[f'objects.{name}.mass'] = POSITIVE
            if all(int(self.model.geom_type[geom]) in _SCALABLE for geom in self._geoms(name)):
                known[f'objects.{name}.size'] = POSITIVE
        for name in self._joints:
            known[f'joints.{name}'] = scalar
            known |= {f'joints.{name}.{what}': STD for what in ('damping', 'friction', 'armature')}
        known |= {'gains': POSITIVE, 'gravity': vector,
                  'latency': Quantity(1, 0.0, LONGEST_LATENCY, whole=True)}
        known |= {f'noise.{what}': STD
                  for what in ('joint_positions', 'joint_velocities', 'object_poses')}
        for name in self._cameras:
            known |= {f'camera.{name}.xyz': vector, f'camera.{name}.rpy': vector,
                      f'camera.{name}.focal': POSITIVE}
        if self._lights:
            known |= {'light.xyz': vector, 'light.color': unit}
        return known

    def apply(self, episode: Episode) -> None:
        """Make physics and start of an episode."""
        model, simulation = self.model, self._sim.simulation
        if self._dirty:
            for name, values in self._base.items():
                getattr(model, name)[:] = values
            model.opt.gravity[:] = self._gravity
            self._statistics(self._extent)
        poses = self._vary_objects(episode)
        starts = {path[len('joints.'):]: number(value)
                  for path, value in episode.values.items()
                  if path.startswith('joints.') and path[len('joints.'):] in self._dofs}
        self._vary_joints(episode)
        self._vary_sight(episode)
        if 'gravity' in episode.values:
            model.opt.gravity[:] = episode.values['gravity']
        if any(path.endswith(_HEAVY) for path in episode.values):
            mujoco.mj_setConst(model, self._scratch)
            # The solver's tolerance follows the mean inertia, as in a world with these masses.
            inertia = model.stat.meaninertia
            self._statistics(self._extent)
            model.stat.meaninertia = inertia
        gains = episode.get('gains', 1.0)
        if gains != 1.0 or self._scaled:
            simulation.scale_gains(gains)
            self._scaled = gains != 1.0
        self._dirty = bool(episode.values)
        self._sim.begin(starts, poses, seed=episode.seed % 2**31)

    def _vary_objects(self, episode: Episode) -> dict[str, Any]:
        model, simulation = self.model, self._sim.simulation
        given: dict[str, dict[str, Value]] = {}
        for name, quantity, value in episode.under('objects'):
            given.setdefault(name, {})[quantity] = value
        poses = {}
        for name, values in given.items():
            body, geoms = self._body(name), self._geoms(name)
            if 'size' in values:
                self._scale(body, geoms, number(values['size']))
            if 'mass' in values:
                ratio = number(values['mass']) / float(model.body_mass[body])
                model.body_inertia[body] *= ratio
                model.body_mass[body] = values['mass']
            if 'friction' in values:
                model.geom_friction[geoms, 0] = values['friction']
            if 'color' in values:
                model.geom_rgba[geoms, :3] = values['color']
            if 'xyz' in values or 'rpy' in values:
                pose = self._objects[name].pose.copy()
                if 'rpy' in values:
                    pose[:3, :3] = pose_matrix(rpy=values['rpy'])[:3, :3]
                if 'xyz' in values:
                    pose[:3, 3] = values['xyz']
                if self._objects[name].mass is None:
                    simulation.world.set_pose(name, pose)
                poses[name] = pose
        return poses

    def _scale(self, body: int, geoms: list[int], factor: float) -> None:
        model = self.model
        for name in ('geom_pos', 'geom_size', 'geom_rbound', 'geom_aabb'):
            getattr(model, name)[geoms] *= factor
        start = int(model.body_bvhadr[body])
        if start >= 0:
            model.bvh_aabb[start:start + int(model.body_bvhnum[body])] *= factor
        model.body_ipos[body] *= factor
        model.body_inertia[body] *= factor**2

    def _vary_joints(self, episode: Episode) -> None:
        arrays = {'damping': self.model.dof_damping, 'friction': self.model.dof_frictionloss,
                  'armature': self.model.dof_armature}
        for name, quantity, value in episode.under('joints'):
            if quantity in arrays and name in self._dofs:
                arrays[quantity][self._dofs[name]] = value

    def _vary_sight(self, episode: Episode) -> None:
        model = self.model
        for name, quantity, value in episode.under('camera'):
            camera = self._cameras[name]
            if quantity == 'xyz':
                model.cam_pos[camera] = value
            elif quantity == 'rpy':
                rotation = pose_matrix(rpy=value)
                model.cam_quat[camera] = quat_wxyz_from_matrix(rotation)
            else:
                model.cam_fovy[camera] = field_of_view(number(value))
        for quantity, array in (('xyz', model.light_pos), ('color', model.light_diffuse)):
            if f'light.{quantity}' in episode.values:
                array[:] = episode.values[f'light.{quantity}']

    def _statistics(self, values: tuple[Any, ...] | None = None) -> tuple[Any, ...]:
        """Return what the picture's near and far planes depend on, set first where given."""
        stat = self.model.stat
        if values is not None:
            stat.extent, stat.meansize, stat.meanmass, stat.meaninertia = values[:4]
            stat.center[:] = values[4]
        return (stat.extent, stat.meansize, stat.meanmass, stat.meaninertia, stat.center.copy())

    def _body(self, name: str) -> int:
        return int(self.model.body(object_body_name(name)).id)

    def _geoms(self, name: str) -> list[int]:
        start = int(self.model.body_geomadr[self._body(name)])
        return list(range(start, start + int(self.model.body_geomnum[self._body(name)])))

    def _joint_dofs(self, name: str) -> list[int]:
        element = self._sim.simulation.joint_element(name)
        return [int(self.model.joint(element).dofadr[0])]


def field_of_view(focal: float) -> float:
    """Return MuJoCo's vertical field of view [degrees] of a focal length in picture heights."""
    return math.degrees(2.0 * math.atan(0.5 / focal))


FORCE, INTERVAL = 'pushes.force', 'pushes.interval'
#: Time from push to push where none is given [s].
_INTERVAL = 1.0


class Pushes:
    """
    Pushes a link, for a step at a time, in random directions.

    :param link: that is pushed at its centre of mass.
    :param period: time of a step [s].
    """

    #: What can be drawn: the force of all pushes of an episode [N], and the time between two [s].
    KNOWN: ClassVar[Mapping[str, Quantity]] = {
        FORCE: Quantity(low=0.0), INTERVAL: Quantity(low=0.0, above=True)}

    def __init__(self, link: str, period: float) -> None:
        self._link, self._period = link, period
        self.begin(Episode({}, 0))

    def begin(self, episode: Episode) -> None:
        """Begin an episode; nothing acts yet."""
        self._force = episode.get(FORCE, 0.0)
        interval = episode.get(INTERVAL, _INTERVAL)
        self._steps = max(1, round(interval / self._period))
        self.random = stream(episode.seed, 'pushes')

    def act(self, simulation: Simulation, step: int) -> None:
        """
        Have act what belongs to a step.

        :param step: number of the step in its episode, from 0.
        """
        if not self._force:
            return
        due, ended = (step + 1) % self._steps == 0, step and step % self._steps == 0
        if due:
            x, y, z = self.random.normal(size=3).tolist()
            factor = self._force / math.sqrt(x * x + y * y + z * z)
            simulation.apply_wrench(self._link, (factor * x, factor * y, factor * z))
        elif ended:
            simulation.apply_wrench(self._link)
