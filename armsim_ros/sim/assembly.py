# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a robot's settings to its running parts, and a hash of all their states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
import hashlib
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.controllers.command_controllers import (
    JointGroupPositionControllerParameters,
    JointPositionControllerParameters,
)
from armsim_ros.config.controllers.gripper_action_controller import GripperParameters
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.world import is_foreign_world
from armsim_ros.control.arm_state import ArmState
from armsim_ros.control.controllers import ManagerGroup
from armsim_ros.control.faults import FaultInjector, FaultyControllers
from armsim_ros.control.hardware_interface import HardwareInterface, POSITION, SharedHardware
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.control.manager.switching import Strictness
from armsim_ros.control.stop_monitor import StopMonitor
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.errors import ConfigError, ControllerError, Problem, SimulationError
from armsim_ros.model.cell import Cell, Robot
from armsim_ros.model.robot_model import JointType, RobotModel
from armsim_ros.model.world_objects import initial_positions, START_KEYS
from armsim_ros.sim.clock import SimClock
from armsim_ros.sim.external_loads import ExternalLoads
from armsim_ros.sim.physics.robot_spec import bound_or_infinite
from armsim_ros.sim.simulation import Simulation
from armsim_ros.sim.world.loaded_world import LoadedWorld
from armsim_ros.sim.world.resources import WorldResources
from armsim_ros.vendors import find_vendor, Vendor

#: So far before its position a finger presses with all its effort [m].
FINGER_GIVE = 1e-3
#: Share of the gain at which a joint that carries its armature alone becomes unstable.
STABLE_SHARE = 0.2
_FORWARD_POSITION = (JointGroupPositionControllerParameters, JointPositionControllerParameters)


def servo_gains(settings: RobotSettings) -> dict[str, PidGains]:
    """Return the gains that position controllers give for their joints; they go to the drives."""
    gains: dict[str, PidGains] = {}
    for controller in settings.controllers:
        parameters = controller.parameters
        if (isinstance(parameters, JointTrajectoryControllerParameters)
                and POSITION in parameters.command_interfaces and not parameters.chained):
            gains.update(parameters.gains)
    for controller in settings.controllers:
        if isinstance(controller.parameters, _FORWARD_POSITION):
            for joint, block in controller.parameters.gains.items():
                gains.setdefault(joint, block)
    return gains


def finger_gains(settings: RobotSettings, model: RobotModel) -> dict[str, PidGains]:
    """
    Return gains of sliding joints that a gripper controller moves to positions.

    A millimetre short of the position a finger presses with all its effort, as far as the
    timestep allows gains so high: the force of a grasp is the goal's, not the error's.
    """
    simulation = settings.simulation
    highest = STABLE_SHARE * simulation.armature_linear / simulation.timestep**2
    gains: dict[str, PidGains] = {}
    for controller in settings.controllers:
        if not isinstance(controller.parameters, GripperParameters):
            continue
        joint = model.joints.get(controller.parameters.joint)
        if joint is None or joint.type is not JointType.PRISMATIC:
            continue
        requested = bound_or_infinite(joint.limits.effort) / FINGER_GIVE
        least = simulation.servo.default_gains.p
        gains[joint.name] = PidGains(p=max(least, min(requested, highest)), i_clamp=0.0)
    return gains


def build_simulation(
    settings: RobotSettings, model: RobotModel, *, clock: SimClock | None = None
) -> Simulation:
    """
    Return the robot of a user's files in its world.

    :param clock: simulated time; by default starting at 0.
    :raises ConfigError: the robot has no movable joint, or the start does not fit it; names file
        and line where it can.
    :raises SimulationError: the physics refuses robot or world.
    """
    if not model.movable_joints:
        raise ConfigError(Problem(
            f"robot '{model.name}' has no movable joint: it is an object, and not simulated alone",
            remedy='put it into the world of a robot (docs/world.md)'))
    try:
        initial_positions(model, settings.simulation)
    except SimulationError as error:
        places = (settings.locate('simulation', key) for key in START_KEYS)
        raise ConfigError(Problem(str(error), next(filter(None, places), None))) from None
    return Simulation(
        model, settings.simulation, _foreign_world(settings) or settings.world,
        gains={**finger_gains(settings, model), **servo_gains(settings)}, clock=clock)


def _foreign_world(settings: RobotSettings) -> LoadedWorld | None:
    """
    Return the world of an SDF or MJCF file; None without a world.

    :raises SimulationError: the file cannot be used.
    """
    file = settings.world_file
    if file is None or not is_foreign_world(file):
        return None
    folders = (file.parent, *map(Path, settings.simulation.resource_paths))
    return WorldResources(folder.expanduser() for folder in folders).world(str(file), '')


def build_manager(
    settings: RobotSettings, model: RobotModel, hardware: HardwareInterface,
    vendor: Vendor | None = None,
) -> ControllerManager:
    """
    Return the controller manager with controllers configured and the spawned ones active.

    The controllers of a package that are not spawned stay unloaded, as upstream.

    :param hardware: the simulation, or what lies between it and the controllers.
    :param vendor: of the arm.
    :raises ConfigError: a controller that cannot run on this robot; names the file and line.
    """
    manager = ControllerManager(hardware, settings.controller_manager, model, partial(
        ArmState, settings.simulation.hardware, vendor))
    problems = []
    for controller in settings.controllers:
        if settings.spawn_only and controller.name not in settings.spawn:
            continue
        try:
            manager.load(controller)
            manager.configure(controller.name)
        except ControllerError as error:
            if settings.spawn_only:
                manager.refusals.append(f"controller '{controller.name}' is not loaded: {error}")
                continue
            where = settings.locate('controllers', controller.name)
            problems.append(Problem(f"controller '{controller.name}': {error}", where))
    if problems:
        raise ConfigError(problems)
    spawned = [name for name in settings.spawn if name in manager.controllers]
    if settings.spawn_only or manager.resources.holds:
        for name in spawned:
            result = manager.switch(activate=[name], strictness=Strictness.STRICT)
            if not result.ok:
                manager.refusals.append(f"controller '{name}' stays inactive: {result.message}")
        return manager
    result = manager.switch(activate=spawned, strictness=Strictness.STRICT)
    if not result.ok:
        raise ConfigError(Problem(f'the controllers cannot start: {result.message}'))
    return manager


def build_managers(cell: Cell, hardware: HardwareInterface) -> dict[str, ControllerManager]:
    """
    Return robot -> its controller manager, with its controllers configured and active.

    :param hardware: the joints of all robots.
    :raises ConfigError: every controller that cannot run on its robot; names file and line.
    """
    if len(cell.robots) == 1 and cell.robots[0].model is cell.model:
        robot = cell.robots[0]
        return {robot.name: build_manager(robot.settings, robot.model, hardware, vendor_of(robot))}
    shared = SharedHardware(hardware)
    managers: dict[str, ControllerManager] = {}
    problems: list[Problem] = []
    owned = {robot.name: _sensors_and_gpios(robot) for robot in cell.robots}
    for robot in cell.robots:
        foreign = {interface for name in owned if name != robot.name for interface in owned[name]}
        part = shared.part(robot.model.movable_joints, foreign)
        try:
            managers[robot.name] = build_manager(
                robot.settings, robot.model, part, vendor_of(robot))
        except ConfigError as error:
            problems.extend(error.problems)
    if problems:
        raise ConfigError(problems)
    return managers


def vendor_of(robot: Robot) -> Vendor | None:
    """
    Return whose arm a robot is, None for an arm without a vendor.

    :raises ConfigError: the settings name a vendor that there is not.
    """
    plugins = [system.plugin for system in robot.model.hardware]
    return find_vendor(robot.settings.simulation.hardware.vendor, plugins)


def watch(robot: Robot, manager: ControllerManager, simulation: Simulation, *,
          always: bool = False, loaded: bool = False) -> None:
    """
    Let speeds, positions and loads stop an arm.

    :param always: whether the settings ask for it or not.
    :param loaded: whether loads are measured also without a limit.
    """
    settings, vendor = robot.settings.simulation.hardware, manager.arm.vendor
    names = manager.hardware.joint_names
    torques = _collision_torques(robot.model, names, vendor)
    if settings.collision.torque:
        torques[:] = settings.collision.torque
    force = settings.collision.force or vendor.collision_force
    limited = force < inf or bool((torques < inf).any())
    asked = settings.watch == 'always' or (settings.watch == 'auto' and limited)
    if not (asked or always):
        return
    loads = None
    if loaded or limited:
        fingers = [name for name in names if vendor.finger and name.endswith(vendor.finger)]
        loads = ExternalLoads(simulation, names, robot, fingers)
    manager.stops.watch(StopMonitor(manager.hardware, robot.model, loads, torques, force))


def _collision_torques(model: RobotModel, names: Sequence[str], vendor: Vendor) -> Vector:
    """Return the external torques of joints that stop an arm of a vendor (n,) [N*m or N]."""
    given = vendor.collision_torques
    torques = np.array([given[min(i, len(given) - 1)] for i in range(len(names))])
    efforts = [bound_or_infinite(model.joints[name].limits.effort) for name in names]
    least: Vector = np.minimum(torques, vendor.collision_effort * np.array(efforts))
    return least


def _sensors_and_gpios(robot: Robot) -> set[str]:
    """Return the names of what has states and is not a joint."""
    declared = {name.rpartition('/')[0] for system in robot.model.hardware
                for name in (*system.other_states, *system.other_commands)}
    return declared | set(robot.settings.simulation.sensors)


class ControlParts(NamedTuple):
    """
    What commands a simulation.

    :param managers: robot -> its controller manager.
    :param controllers: all of them, as a control loop runs them.
    :param faults: makes joints fail; None where ``fault_injection`` does not ask for it.
    """

    managers: dict[str, ControllerManager]
    controllers: ControllerManager | ManagerGroup
    faults: FaultInjector | None


def build_control(cell: Cell, simulation: Simulation) -> ControlParts:
    """
    Return the controller managers of all robots on a simulation.

    :raises ConfigError: every controller that cannot run on its robot; names file and line.
    """
    faults = FaultInjector(simulation) if cell.settings.simulation.fault_injection else None
    managers = build_managers(cell, faults or simulation)
    for robot in cell.robots:
        watch(robot, managers[robot.name], simulation)
    group = tuple(managers.values())
    controllers: ControllerManager | ManagerGroup
    if faults:
        controllers = FaultyControllers(group, faults)
    else:
        controllers = group[0] if len(group) == 1 else ManagerGroup(group)
    return ControlParts(managers, controllers, faults)


def run_digest(simulation: Simulation, managers: Mapping[str, ControllerManager]) -> str:
    """
    Return a hash of plant, drives, time, and what controllers are loaded, active and follow.

    :param managers: robot -> its controller manager.
    """
    parts = hashlib.sha256(simulation.digest().encode())
    for robot, manager in managers.items():
        for info in manager.list_controllers():
            parts.update(f'{robot}/{info.name} {info.type} {info.state}'.encode())
            controller = manager.controllers[info.name]
            if isinstance(controller, JointTrajectoryController):
                goal = controller.active_goal
                if goal is not None:
                    parts.update(goal.trajectory.times.tobytes())
                    parts.update(goal.trajectory.positions.tobytes())
    return parts.hexdigest()
