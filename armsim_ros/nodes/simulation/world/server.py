# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All services of the simulated world, and its parameters, on the node ``/simulation``."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from pathlib import Path
import platform
from typing import Any

import mujoco
from rclpy.node import Node
from simulation_interfaces.msg import Resource
from simulation_interfaces.msg import SimulatorFeatures as Features
from simulation_interfaces.srv import GetSimulatorFeatures

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.simulation import RealTimeFactor
from armsim_ros.model.cell import Cell
from armsim_ros.model.grippers import grippers_of
from armsim_ros.model.world_objects import world_in_root
from armsim_ros.nodes.parameters import SettingsParameters
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.world.answers import Work
from armsim_ros.nodes.simulation.world.entity_services import EntityServices
from armsim_ros.nodes.simulation.world.grippers import GripperContacts, VacuumGripperServer
from armsim_ros.nodes.simulation.world.scene_mirror import SceneMirror
from armsim_ros.nodes.simulation.world.simulation_state import (
    Resetting,
    RunState,
    SimulationStateServices,
    Stepping,
)
from armsim_ros.nodes.simulation.world.spawning import Spawning, Worlds
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.finger_contacts import FingerContacts
from armsim_ros.sim.world.entities import Entities, RobotEntity
from armsim_ros.sim.world.resources import FORMATS, WorldResources

try:
    from armsim_ros.nodes.simulation.world.wrenches import WrenchServer
except ImportError:  # without mujoco_ros2_control_msgs there are no wrenches over ROS
    WrenchServer = None  # type: ignore[assignment, misc]

#: The features that have a service here.
_FEATURES = (
    Features.SPAWNING, Features.DELETING, Features.ENTITY_TAGS, Features.ENTITY_BOUNDS,
    Features.ENTITY_BOUNDS_BOX, Features.ENTITY_CATEGORIES, Features.SPAWNING_RESOURCE_STRING,
    Features.ENTITY_STATE_GETTING, Features.ENTITY_STATE_SETTING, Features.ENTITY_INFO_GETTING,
    Features.ENTITY_INFO_SETTING, Features.SPAWNABLES, Features.SIMULATION_RESET,
    Features.SIMULATION_RESET_STATE, Features.SIMULATION_RESET_SPAWNED,
    Features.SIMULATION_STATE_GETTING, Features.SIMULATION_STATE_SETTING,
    Features.SIMULATION_STATE_PAUSE, Features.STEP_SIMULATION_SINGLE,
    Features.STEP_SIMULATION_MULTIPLE, Features.STEP_SIMULATION_ACTION, Features.WORLD_LOADING,
    Features.WORLD_RESOURCE_STRING, Features.WORLD_TAGS, Features.WORLD_UNLOADING,
    Features.WORLD_INFO_GETTING, Features.AVAILABLE_WORLDS, Features.SPAWNING_ENTITIES)


class SimulatorFeatures:
    """
    Lists what this simulator can do.

    :param timestep: of the physics [s].
    :param lockstep: whether time moves by steps alone; only then can it be reset.
    """

    def __init__(self, node: Node, timestep: float, *, lockstep: bool) -> None:
        self._info = (
            f'armsim_ros with MuJoCo {mujoco.__version__}, Python {platform.python_version()}; '
            f'mode: {"lockstep" if lockstep else "real time"}; physics step: {timestep:g} s')
        self._features = [
            int(feature)
            for feature in (*_FEATURES, *((Features.SIMULATION_RESET_TIME,) if lockstep else ()))]
        node.create_service(GetSimulatorFeatures, '/get_simulator_features', self._answer)

    def _answer(self, _: Any, response: Any) -> Any:
        response.features.features = self._features
        response.features.spawn_formats = list(FORMATS)
        response.features.custom_info = self._info
        return response


#: The world of a robot whose files name none.
DEFAULT_WORLD = 'empty'


class LiveSettings(Settings):
    """What can be changed while the simulation runs."""

    real_time_factor: RealTimeFactor = parameter(
        1.0, 'simulated time per wall time, 0.1 to 100; 0 is as fast as it goes')


class WorldServer:
    """
    The simulated world as clients see it.

    :param publish: hands over what belongs to the present time; called between two ticks.
    :param settle: steps are answered when it is done.
    """

    def __init__(
        self, node: Node, cell: Cell, loop: ControlLoop, dispatcher: Dispatcher,
        publish: Callable[[], object], settle: Callable[[], Awaitable[object]],
        quit_program: Callable[[], None]
    ) -> None:
        settings = cell.settings
        robots = [RobotEntity(robot.name, robot.model.root_link, tuple(robot.model.links))
                  for robot in cell.robots]
        self.entities = Entities(loop.simulation, robots)
        file = settings.world_file
        self.state = RunState(
            loop.clock, file.stem if file is not None else DEFAULT_WORLD,
            Resource(uri=f'file://{file}' if file is not None else DEFAULT_WORLD))
        self._clock = loop.clock
        SettingsParameters(
            node, LiveSettings(real_time_factor=loop.clock.real_time_factor), self._changed)
        resources = WorldResources(
            [Path(path).expanduser() for path in settings.simulation.resource_paths])
        work = Work(node, loop, dispatcher)
        deterministic = settings.simulation.deterministic
        self.resetting = Resetting(
            node, work, self.entities, self.state, resets_time=deterministic)
        # In lockstep, what planning knows must not depend on when a message comes.
        grippers = {robot.name: grippers_of(robot) for robot in cell.robots}
        everyone = [gripper for group in grippers.values() for gripper in group]
        fingers = FingerContacts(loop.simulation, everyone)
        live = settings.planning_parameters.scene_from_world == 'live'
        tell_scene: Callable[[Callable[[], object]], object] = _call
        if live and not deterministic:
            self._mirror = SceneMirror(
                node, loop, dispatcher, cell.model.model_frame, world_in_root(settings),
                fingers.held if everyone else None)
            self.resetting.followers.append(self._mirror.begin_anew)
            tell_scene = self._mirror.tell_now
        grippers_of_robots = [
            VacuumGripperServer(
                node, work, dispatcher, robot.settings.namespace, gripper, tell_scene)
            for robot in cell.robots
            for gripper in loop.simulation.vacuum_grippers.values()
            if gripper.settings.link in robot.model.links]
        #: Suction cup -> what switches it.
        self.cups = {server.control.gripper.name: server.control for server in grippers_of_robots}
        self._finger_topics = [
            GripperContacts(node, loop, dispatcher, robot.settings.namespace, gripper, fingers)
            for robot in cell.robots for gripper in grippers[robot.name]]
        if WrenchServer is not None:
            self._wrenches = WrenchServer(node, work, dispatcher, self.entities)
            self.resetting.followers.append(self._wrenches.clear)
        self._services = (
            EntityServices(node, work, self.entities),
            Spawning(node, work, self.entities, resources),
            Worlds(node, work, self.entities, resources, self.state, self.resetting),
            SimulationStateServices(node, self.state, self.resetting, dispatcher, quit_program),
            Stepping(node, work, self.state, publish, settle),
            SimulatorFeatures(node, settings.simulation.timestep, lockstep=deterministic))

    def _changed(self, settings: LiveSettings) -> None:
        self._clock.real_time_factor = settings.real_time_factor


def _call(then: Callable[[], object]) -> None:
    then()
