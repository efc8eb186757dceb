# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What sensors on links measure, and poses of links, computed on demand."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from itertools import chain
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.simulation import SensorSettings
from armsim_ros.errors import nearest, SimulationError
from armsim_ros.model.robot_model import HardwareSensor, JointType, RobotModel
from armsim_ros.model.transforms import (
    inverse_pose,
    pose_matrix,
    quat_wxyz_from_matrix,
    quat_xyzw_from_matrix,
)
from armsim_ros.sim.physics.geoms import BodyContact, contacts, touching
from armsim_ros.sim.physics.plant import Plant

_LOAD, _MOTION = ('force', 'torque'), ('angular_velocity', 'linear_acceleration')
#: Kind of a sensor in simulation.yaml -> what it measures.
_KINDS: Mapping[str, tuple[tuple[str, str], ...]] = {
    'force_torque': (('force', 'xyz'), ('torque', 'xyz')),
    'imu': (('orientation', 'xyzw'), ('angular_velocity', 'xyz'), ('linear_acceleration', 'xyz')),
    'pose': (('position', 'xyz'), ('orientation', 'xyzw')),
}


class _Mount(NamedTuple):
    """A place in the frame of a link: its pose (4, 4), and its orientation as (w, x, y, z)."""

    pose: Matrix
    quat_wxyz: Vector


class Sensors:
    """
    The sensors of a robot.

    A force and its torque are those that everything beyond the frame exerts on the arm, as a
    sensor in a wrist has them: the weight of what hangs there pulls. The linear acceleration is
    that of an accelerometer, which at rest points upwards with 9.81 m/s^2. The orientation is
    that of the frame in the world; beside a position both are those in the sensor's reference,
    which is the robot's root link where it has none.
    All vectors are in the axes of the frame; an IMU has a frame of its own, where it is mounted.

    :param model: declares them.
    :param plant: is measured.
    :param more: further ones.
    """

    def __init__(
        self, model: RobotModel, plant: Plant, more: Iterable[HardwareSensor] = ()
    ) -> None:
        self._plant = plant
        self._root = model.root_link
        self._sensors = [
            (sensor, _carrier(model, sensor.frame),
             {name.partition('.')[0] for name in sensor.states}, _mount(sensor))
            for sensor in chain(*(system.sensors for system in model.hardware), more)]
        #: ``sensor/interface`` -> what a sensor shows less than it measures.
        self._zeros: dict[str, float] = {}

    @property
    def load_links(self) -> dict[str, str]:
        """Sensor of forces and torques -> the link on which it sits."""
        return {sensor.name: sensor.frame for sensor, _, kinds, _ in self._sensors
                if kinds.issuperset(_LOAD)}

    def tare(self, foreign: Collection[str] = ()) -> None:
        """Have the present forces and torques read as 0, but for those of foreign sensors."""
        self._zeros = {name: value + self._zeros.get(name, 0.0)
                       for name, value in self.read().items()
                       if name.rpartition('/')[2].partition('.')[0] in _LOAD
                       and name.rpartition('/')[0] not in foreign} | {
            name: zero for name, zero in self._zeros.items()
            if name.rpartition('/')[0] in foreign}

    def forget_zeros(self) -> None:
        """Show what is measured."""
        self._zeros = {}

    def read(self) -> dict[str, float]:
        """Return ``sensor/interface`` -> value of the last physics step [N, N*m, rad/s, m/s^2]."""
        if not self._sensors:
            return {}
        mujoco.mj_rnePostConstraint(self._plant.model, self._plant.data)
        found: dict[str, float] = {}
        for sensor, carrier, kinds, mount in self._sensors:
            frame = self._plant.body(sensor.frame)
            values: dict[str, float] = {}
            if kinds.intersection(_LOAD):
                _add(values, _LOAD, self._load(frame, self._plant.body(carrier)))
            if kinds.intersection(_MOTION):
                _add(values, _MOTION, self._motion(frame, mount))
            if 'position' in kinds:
                reference = self._plant.body(sensor.reference or self._root)
                pose = inverse_pose(self._plant.pose(reference)) @ self._plant.pose(frame)
                values.update(zip((f'position.{axis}' for axis in 'xyz'),
                                  pose[:3, 3].tolist(), strict=True))
                values.update(zip((f'orientation.{axis}' for axis in 'xyzw'),
                                  quat_xyzw_from_matrix(pose).tolist(), strict=True))
            elif 'orientation' in kinds:
                quat_wxyz = self._plant.data.xquat[frame].copy()
                if mount is not None:
                    mujoco.mju_mulQuat(quat_wxyz, self._plant.data.xquat[frame], mount.quat_wxyz)
                values.update(zip((f'orientation.{axis}' for axis in 'wxyz'),
                                  quat_wxyz.tolist(), strict=True))
            found.update({f'{sensor.name}/{name}': values[name] for name in sensor.states})
        for name, zero in self._zeros.items():
            found[name] -= zero
        return found

    def _load(self, frame: int, carrier: int) -> Vector:
        """Return force and torque (6,) on the frame's origin, in its axes."""
        model, data = self._plant.model, self._plant.data
        # MuJoCo has (torque, force) of the parent on the body, at the centre of mass of the tree.
        torque, force = -data.cfrc_int[carrier, :3], -data.cfrc_int[carrier, 3:]
        arm = data.subtree_com[model.body_rootid[carrier]] - data.xpos[frame]
        axes = data.xmat[frame].reshape(3, 3)
        return np.concatenate([axes.T @ force, axes.T @ (torque + np.cross(arm, force))])

    def _motion(self, frame: int, mount: _Mount | None) -> Vector:
        """Return angular velocity and linear acceleration (6,) of a mount, in its axes."""
        model, data = self._plant.model, self._plant.data
        velocity, acceleration = np.zeros(6), np.zeros(6)
        body = mujoco.mjtObj.mjOBJ_XBODY
        mujoco.mj_objectVelocity(model, data, body, frame, velocity, 1)
        mujoco.mj_objectAcceleration(model, data, body, frame, acceleration, 1)
        if mount is None:
            return np.concatenate([velocity[:3], acceleration[3:]])
        turning, place, axes = velocity[:3], mount.pose[:3, 3], mount.pose[:3, :3].T
        there = (acceleration[3:] + np.cross(acceleration[:3], place)
                 + np.cross(turning, np.cross(turning, place)))
        return np.concatenate([axes @ turning, axes @ there])


def _mount(sensor: HardwareSensor) -> _Mount | None:
    """Return where a sensor is in its frame, None for the frame itself."""
    if not any(sensor.mount):
        return None
    pose = pose_matrix(sensor.mount[:3], sensor.mount[3:])
    return _Mount(pose, quat_wxyz_from_matrix(pose))


def sensors_of(
    settings: Mapping[str, SensorSettings], model: RobotModel
) -> tuple[HardwareSensor, ...]:
    """
    Return the sensors that simulation.yaml names.

    :raises SimulationError: a sensor is on an unknown link.
    """
    for name, entry in settings.items():
        if entry.link not in model.links:
            raise SimulationError(
                f"sensor '{name}' sits on '{entry.link}', which is not a link of robot "
                f"'{model.name}'; " + (nearest(entry.link, tuple(model.links)) or 'see its URDF'))
    return tuple(
        HardwareSensor(name, entry.link, tuple(
            f'{quantity}.{axis}' for quantity, axes in _KINDS[entry.type] for axis in axes))
        for name, entry in settings.items())


def _add(values: dict[str, float], kinds: tuple[str, str], pair: Vector) -> None:
    names = (f'{kind}.{axis}' for kind in kinds for axis in 'xyz')
    values.update(zip(names, pair.tolist(), strict=True))


def _carrier(model: RobotModel, frame: str) -> str:
    """Return the link at whose joint the load of a frame is felt: a bare frame carries none."""
    link = frame
    while not _weighs(model, link):
        joint = model.parent_joint.get(link)
        if joint is None or model.joints[joint].type is not JointType.FIXED:
            break
        link = model.joints[joint].parent
    return link


def _weighs(model: RobotModel, link: str) -> bool:
    """Return whether a link, or what is attached to it, has mass or can be touched."""
    carrier = model.links[link]
    if carrier.collisions or (carrier.inertial is not None and carrier.inertial.mass > 0.0):
        return True
    return any(_weighs(model, joint.child) for joint in model.joints.values()
               if joint.parent == link)


class SimulatedLinks:
    """What a simulation answers about its bodies and the links of its robot."""

    model: RobotModel
    _plant: Plant

    @property
    def mujoco_model(self) -> Any:
        """The ``MjModel``, for reading; an edit of the world replaces it."""
        return self._plant.model

    @property
    def mujoco_data(self) -> Any:
        """The ``MjData``, for reading; an edit of the world replaces it."""
        return self._plant.data

    @property
    def contacts(self) -> tuple[BodyContact, ...]:
        """What touched what in the last step, the deepest first."""
        return contacts(self._plant.model, self._plant.data)

    def touching(self) -> tuple[NDArray[np.int32], Vector]:
        """
        Return the contacts of the last step without conversion, for frequent callers.

        :returns: (n, 2) bodies, whose names are in ``body_names``, and (n,) overlaps [m],
            negative where there is still a gap.
        """
        return touching(self._plant.model, self._plant.data)

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of all bodies by number: ``world``, ``robot/link``, ``object/name``."""
        model = self._plant.model
        return tuple(model.body(i).name for i in range(model.nbody))

    def body_poses(self) -> tuple[Matrix, Matrix]:
        """Return where all bodies are in the world: (n, 3) [m] and (n, 4) quaternions wxyz."""
        return self._plant.data.xpos.copy(), self._plant.data.xquat.copy()

    def decorate(self, edit: Callable[[Any], object]) -> None:
        """
        Add to the specification what touches nothing: cameras, lights, marks.

        :param edit: gets the ``MjSpec``; the physics is compiled again after it.
        :raises SimulationError: MuJoCo refuses it.
        """
        edit(self._plant.spec.spec)
        self._plant.recompile()

    def joint_element(self, name: str) -> str:
        """Return the name of a joint in the physics."""
        return self._plant.spec.name(name)

    def apply_wrench(
        self, link: str, force: ArrayLike = (0, 0, 0), torque: ArrayLike = (0, 0, 0)
    ) -> None:
        """
        Push a link until another wrench is set.

        :param force: (3,) at its centre of mass, world axes [N].
        :param torque: (3,) world axes [N*m].
        :raises SimulationError: a link that is not there.
        """
        self._plant.push(self.link_body(link), force, torque)

    def link_pose(self, link: str) -> Matrix:
        """
        Return where a link is in the world (4, 4).

        :raises SimulationError: a link that is not there.
        """
        return self._plant.pose(self.link_body(link))

    def link_motion(self, link: str) -> tuple[Vector, Vector]:
        """
        Return how a link moves: (3,) [m/s] of its origin and (3,) [rad/s], world axes.

        :raises SimulationError: a link that is not there.
        """
        return self._plant.motion(self.link_body(link))

    def link_acceleration(self, link: str) -> tuple[Vector, Vector]:
        """
        Return the acceleration of a link's origin, see :meth:`Plant.acceleration`.

        :raises SimulationError: a link that is not there.
        """
        return self._plant.acceleration(self.link_body(link))

    def link_bounds(self, links: Sequence[str], frame: str) -> tuple[Vector, Vector]:
        """
        Return the smallest and the largest corner of some links now, (3,) each [m].

        :param frame: the link in whose axes.
        :raises SimulationError: a link that is not there.
        """
        bodies = [self.link_body(link) for link in links]
        return self._plant.bounds(bodies, self.link_body(frame))

    def link_body(self, link: str) -> int:
        """
        Return the number of a link's body in the physics.

        :raises SimulationError: a link that is not there.
        """
        if link not in self.model.links:
            raise SimulationError(
                f"robot '{self.model.name}' has no link '{link}'; "
                + (nearest(link, tuple(self.model.links)) or 'see its URDF'))
        return self._plant.body(link)
