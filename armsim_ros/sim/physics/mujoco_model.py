# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robot and its world as a MuJoCo specification."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import mujoco

from armsim_ros.config.simulation import SimulationSettings, Triple, VacuumGripperSettings
from armsim_ros.errors import nearest, SimulationError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.transforms import quat_wxyz_from_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.physics.geoms import (
    add_geom,
    COLLISION_GROUP,
    PLANE_HALF_SIZE,
    SEEN_ONLY,
    TOUCHING,
    volume,
    WORLD_GROUP,
)
from armsim_ros.sim.physics.robot_spec import RobotSpec, set_inertial

_INTEGRATORS = {
    'implicitfast': mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    'implicit': mujoco.mjtIntegrator.mjINT_IMPLICIT,
    'euler': mujoco.mjtIntegrator.mjINT_EULER,
}


#: Friction in a cone, not a pyramid, and stiffer than the normal force: what is held creeps by
#: micrometres, where MuJoCo's defaults let it slip.
IMPRATIO = 100.0
#: Contacts of free objects: turning about the normal rubs, too, and the surfaces give little.
#: Their friction is the object's own, whatever it touches.
GRASPABLE = {
    'condim': 4, 'solref': [0.005, 1.0], 'solimp': [0.95, 0.99, 0.001, 0.5, 2.0], 'priority': 1}
#: Radius of the mark at the rim of a vacuum gripper [m].
CUP_SIZE = 1e-4
#: How stiffly it holds, see the mimic constraints.
WELD_SOLIMP = (0.99, 0.999, 0.001, 0.5, 2.0)
#: The MuJoCo geom of the floor.
FLOOR_NAME = 'floor'


def object_body_name(name: str) -> str:
    """Return the MuJoCo body of a world object."""
    return f'object/{name}'


def cup_name(gripper: str) -> str:
    """Return the MuJoCo geom that marks the rim of a vacuum gripper."""
    return f'vacuum/{gripper}'


def weld_name(gripper: str, item: str) -> str:
    """Return the MuJoCo constraint by which a vacuum gripper holds an object."""
    return f'vacuum/{gripper}/{item}'


class Ground(NamedTuple):
    """
    What a world has besides its objects.

    :param floor: height of the floor [m]; None where there is none.
    :param gravity: [m/s^2]; None is that of the settings.
    """

    floor: float | None = 0.0
    gravity: Triple | None = None


class PlantSpec:
    """
    Builds the ``MjSpec`` of a robot, and of the world around it if requested.

    :param settings: physics.
    :param contacts: whether robot and objects touch; False gives the robot alone, as its
        inverse dynamics needs it.
    :raises SimulationError: a joint type that the physics does not have.
    """

    def __init__(
        self, model: RobotModel, settings: SimulationSettings, *, contacts: bool = True
    ) -> None:
        self.spec = mujoco.MjSpec()
        self.spec.compiler.degree = False
        self._set_options(settings, contacts)
        self._gravity = settings.gravity
        self.spec.option.gravity = list(settings.gravity)
        self.robot = RobotSpec(self.spec, model, settings, contacts=contacts)
        self._grippers = settings.vacuum_grippers if contacts else {}
        for name, gripper in self._grippers.items():
            self._add_cup(name, gripper)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What had to be changed or guessed; a line each."""
        return tuple(self.robot.warnings)

    def name(self, element: str) -> str:
        """Return the MuJoCo name of a link or joint of the robot."""
        return self.robot.name(element)

    def _add_cup(self, name: str, gripper: VacuumGripperSettings) -> None:
        """Mark the rim of a vacuum gripper; the mark touches nothing."""
        link = self.spec.body(self.name(gripper.link))
        if link is None:
            links = tuple(self.robot.model.links)
            raise SimulationError(
                f"vacuum gripper '{name}': the robot has no link '{gripper.link}' "
                f'{nearest(gripper.link, links)}'.rstrip())
        link.add_geom(
            name=cup_name(name), type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[CUP_SIZE, 0.0, 0.0],
            pos=list(gripper.xyz), mass=0.0, group=COLLISION_GROUP, rgba=[0.0, 0.0, 0.0, 0.0],
            **SEEN_ONLY)

    def _add_welds(self, item: WorldObject) -> None:
        """Add what a vacuum gripper may hold an object by; none of it acts at first."""
        for name, gripper in self._grippers.items():
            weld = self.spec.add_equality(
                name=weld_name(name, item.name), type=mujoco.mjtEq.mjEQ_WELD,
                objtype=mujoco.mjtObj.mjOBJ_BODY, name1=self.name(gripper.link),
                name2=object_body_name(item.name))
            weld.active = 0
            weld.solref = [2.0 * self.spec.option.timestep, 1.0]
            weld.solimp = list(WELD_SOLIMP)

    def set_ground(self, ground: Ground) -> None:
        """Have a world's floor, or none, and its gravity."""
        floor = self.spec.geom(FLOOR_NAME)
        if ground.floor is not None:
            (floor or self._add_floor()).pos = [0.0, 0.0, ground.floor]
        elif floor is not None:
            self.spec.delete(floor)
        self.spec.option.gravity = list(ground.gravity or self._gravity)

    def _add_floor(self) -> Any:
        return self.spec.worldbody.add_geom(
            name=FLOOR_NAME, type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[PLANE_HALF_SIZE, PLANE_HALF_SIZE, 0.1], rgba=[0.5, 0.5, 0.5, 1.0],
            group=WORLD_GROUP, **TOUCHING)

    def add_object(self, item: WorldObject) -> None:
        """
        Add an object; an object with mass may move freely.

        Where an error is raised, the specification is as it was.

        :raises SimulationError: an object of that name is there, it has no parts, or one of them
            cannot have mass.
        """
        name = object_body_name(item.name)
        if self.spec.body(name) is not None:
            raise SimulationError(f"the world already has an object '{item.name}'")
        if not item.parts:
            raise SimulationError(f"object '{item.name}' has no shape")
        body = self.spec.worldbody.add_body(
            name=name, pos=item.pose[:3, 3], quat=quat_wxyz_from_matrix(item.pose))
        try:
            self._fill_object(body, item)
        except Exception:
            self.remove_object(item.name)
            raise

    def _fill_object(self, body: Any, item: WorldObject) -> None:
        masses = [0.0] * len(item.parts)
        if item.mass is not None:
            body.add_freejoint(name=body.name)
            body.gravcomp = item.gravcomp
            self._add_welds(item)
            volumes = [volume(part.geometry) for part in item.parts]
            if not sum(volumes) > 0.0:
                raise SimulationError(f"the shapes of object '{item.name}' enclose no volume")
            masses = [item.mass * size / sum(volumes) for size in volumes]
            if item.inertial is not None:
                body.explicitinertial = True
                set_inertial(body, item.inertial)
        for i, (part, mass) in enumerate(zip(item.parts, masses, strict=True)):
            add_geom(
                self.spec, body, part.geometry, part.origin, mesh_name=f'{body.name}/{i}',
                mass=mass, friction=[item.friction, 0.005, 0.0001],
                rgba=part.rgba or (0.6, 0.6, 0.6, 1.0), group=WORLD_GROUP, **TOUCHING,
                **({} if item.mass is None else GRASPABLE))

    def remove_object(self, name: str) -> None:
        """
        Take an object out.

        :raises SimulationError: there is none of that name.
        """
        body = self.spec.body(object_body_name(name))
        if body is None:
            raise SimulationError(f"the world has no object '{name}'")
        for gripper in self._grippers:
            weld = self.spec.equality(weld_name(gripper, name))
            if weld is not None:
                self.spec.delete(weld)
        self.spec.delete(body)
        for mesh in list(self.spec.meshes):
            if mesh.name.startswith(f'{object_body_name(name)}/'):
                self.spec.delete(mesh)

    def compile(self) -> Any:
        """
        Return the ``MjModel``.

        :raises SimulationError: MuJoCo refuses the robot or the world; its words are in the text.
        """
        try:
            return self.spec.compile()
        except (ValueError, RuntimeError, mujoco.FatalError) as error:
            raise SimulationError(
                f"the physics cannot take robot '{self.robot.model.name}' and its world: {error}"
            ) from error

    def _set_options(self, settings: SimulationSettings, contacts: bool) -> None:
        option = self.spec.option
        option.timestep = settings.timestep
        option.integrator = _INTEGRATORS[settings.integrator]
        option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        option.impratio = IMPRATIO
        option.noslip_iterations = settings.noslip_iterations
        # An instability shall be reported, not papered over by a silent reset.
        option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
        # What lies still costs nothing until something touches or moves it.
        option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        if not contacts:
            option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)


def build_plant(
    model: RobotModel, settings: SimulationSettings, objects: Iterable[WorldObject], ground: Ground
) -> PlantSpec:
    """
    Return the specification of a robot in its world.

    :param objects: what is around the robot.
    :param ground: its floor and gravity.
    """
    plant = PlantSpec(model, settings)
    plant.set_ground(ground)
    for item in objects:
        plant.add_object(item)
    return plant
