# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What differs between the arms of vendors: a table per vendor, read by name or by plugin."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
import math

from armsim_ros.errors import ConfigError, nearest, Problem


@dataclass(frozen=True, slots=True, kw_only=True)
class Vendor:
    """
    What an arm of a vendor does that others do not.

    :param name: short name.
    :param plugins: of ``<ros2_control>`` of such an arm.
    :param unlock_delay: a protective stop lasts at least so long [s].
    :param power_step: each step of powering up lasts so long [s].
    :param collision_torques: external torques of the arm's joints that stop it, from the base on;
        the last is that of all further joints [N*m or N].
    :param collision_effort: share of a joint's effort limit that stops it as an external torque.
    :param collision_force: contact force that stops it [N].
    :param emergency_power_off: whether a released emergency stop leaves the drives without power.
    :param program: whether the arm takes commands only while a program runs on it; while none
        does, the controllers of the arm are inactive.
    :param pace: state interface with the pace of trajectories, without the robot's prefix.
    :param tool: link at which payloads are given, without the robot's prefix.
    :param pose: sensor with the pose of the tool, which the hardware has whatever the URDF
        declares, and the link in whose frame it is; both without the robot's prefix.
    :param finger: end of the name of the joint that moves the fingers of the vendor's hand.
    :param endpoints: ``module:function`` that makes what the driver offers to ROS beside its
        controllers; see ``armsim_ros.nodes.vendors``.
    """

    name: str
    plugins: tuple[str, ...] = ()
    unlock_delay: float = 0.0
    power_step: float = 0.0
    collision_torques: tuple[float, ...] = (math.inf,)
    collision_effort: float = math.inf
    collision_force: float = math.inf
    emergency_power_off: bool = False
    program: bool = False
    pace: str = ''
    tool: str = ''
    pose: tuple[str, str] | None = None
    finger: str = ''
    endpoints: str = ''


#: As ``ur_robot_driver`` of Jazzy presents them.
_UNIVERSAL_ROBOTS = Vendor(
    name='ur',
    plugins=('ur_robot_driver/URPositionHardwareInterface',),
    unlock_delay=5.0,
    power_step=1.0,
    # Neither is of the driver, which leaves both to the controller of the arm: a share and a
    # force at which nothing stops in free motion, and everything in a blow.
    collision_effort=0.5,
    collision_force=150.0,
    emergency_power_off=True,
    program=True,
    pace='speed_scaling/speed_scaling_factor',
    tool='tool0',
    pose=('tcp_pose', 'base'),
    endpoints='armsim_ros.nodes.vendors.ur_endpoints:UniversalRobots')

#: External torques of Franka's arms that are a contact, and that are a collision [N*m]. As
#: ``getDefaultCollisionBehaviorRequest`` (default_robot_behavior_utils.hpp of
#: franka_example_controllers), which the example controllers set before they move.
FRANKA_TORQUES = ((25.0, 25.0, 22.0, 20.0, 19.0, 17.0, 14.0),
                  (35.0, 35.0, 32.0, 30.0, 29.0, 27.0, 24.0))
#: The same of the wrench [N, N*m].
FRANKA_FORCES = ((30.0, 30.0, 30.0, 25.0, 25.0, 25.0),
                 (40.0, 40.0, 40.0, 35.0, 35.0, 35.0))

#: As ``franka_ros2`` presents them.
_FRANKA = Vendor(
    name='franka', plugins=('franka_hardware/FrankaHardwareInterface',),
    collision_torques=FRANKA_TORQUES[1], collision_force=FRANKA_FORCES[1][0], tool='link8',
    finger='_finger_joint1', endpoints='armsim_ros.nodes.vendors.franka_endpoints:FrankaEndpoints')

#: As ``ros2_kortex`` presents the Gen3.
_KINOVA = Vendor(
    name='kinova', plugins=('kortex_driver/KortexMultiInterfaceHardware',),
    tool='end_effector_link', endpoints='armsim_ros.nodes.vendors.kinova:KinovaEndpoints')

#: Name -> table.
TABLES = {table.name: table for table in (_UNIVERSAL_ROBOTS, _FRANKA, _KINOVA)}


def find_vendor(name: str, plugins: Iterable[str] = ()) -> Vendor | None:
    """
    Return the table of a vendor, None where there is none.

    :param name: a key of ``TABLES``, the name of a module with a ``VENDOR``, ``none``; or '' for
        the vendor whose table names one of the plugins.
    :param plugins: of the robot's hardware.
    :raises ConfigError: there is no such vendor, or its module has no table.
    """
    if name == 'none':
        return None
    if name:
        return _table(name)
    used = set(plugins)
    return next((table for table in TABLES.values() if used.intersection(table.plugins)), None)


def _table(name: str) -> Vendor:
    if name in TABLES:
        return TABLES[name]
    try:
        vendor = getattr(import_module(name), 'VENDOR', None)
    except ImportError as error:
        raise ConfigError(Problem(
            f"hardware.vendor: '{name}' is not a vendor, and as a Python module it cannot be "
            f'imported: {error}', allowed=f'{", ".join(TABLES)}, none, or a module on PYTHONPATH',
            remedy=nearest(name, tuple(TABLES)))) from None
    if not isinstance(vendor, Vendor):
        raise ConfigError(Problem(
            f"hardware.vendor: the module '{name}' has no VENDOR",
            remedy='give it VENDOR = armsim_ros.vendors.Vendor(...)'))
    return vendor
