# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a trajectory controller finds out once, when it is configured."""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.control.events import EventQueue
from armsim_ros.control.hardware_interface import HardwareInterface, JointProperties
from armsim_ros.errors import ControllerError, nearest


def check_configuration(
    parameters: JointTrajectoryControllerParameters, hardware: HardwareInterface
) -> None:
    """
    Refuse parameters that do not fit together or to the hardware.

    :raises ControllerError: the first error.
    """
    for joint in parameters.joints:
        if joint not in hardware.index:
            hint = nearest(joint, hardware.joint_names)
            raise ControllerError(
                f"joint '{joint}' is not a joint of the hardware "
                f"({', '.join(hardware.joint_names)})"
                f'{"; " if hint else ""}{hint}'
            )
    _check_command_joints(parameters, hardware)
    commands = parameters.command_interfaces
    if (commands == ('velocity',) or 'effort' in commands) and (
        'velocity' not in parameters.state_interfaces
    ):
        raise ControllerError(
            f'command_interfaces {", ".join(commands)} need the state_interfaces position and '
            f'velocity, not only {", ".join(parameters.state_interfaces)}'
        )


def _check_command_joints(
    parameters: JointTrajectoryControllerParameters, hardware: HardwareInterface
) -> None:
    joints, commanded = parameters.joints, parameters.commanded
    allowed = (
        f"allowed: some of joints ({', '.join(joints)}), or in place of each of them another "
        "joint of the hardware or 'controller/joint' of a following controller"
    )
    following = sum('/' in name for name in commanded)
    for name in commanded:
        if len(commanded) < len(joints) and name not in joints:
            raise ControllerError(f"command_joints: '{name}' is not among joints; {allowed}")
        if '/' not in name and (following or name not in hardware.index):
            raise ControllerError(f"command_joints: '{name}' is not a joint to command; {allowed}")


def warn_of_configuration(
    parameters: JointTrajectoryControllerParameters, events: EventQueue, time_ns: int
) -> None:
    """Report what a user of these parameters may not expect."""
    if not any(block.goal > 0.0 for block in parameters.constraints.joints.values()):
        text = (
            'goals end with their trajectory; set constraints.<joint>.goal to check the final '
            'positions'
        )
        events.add(time_ns, 'info', 'warning', text)
    if parameters.initial_pace != parameters.speed_scaling.initial_scaling_factor:
        text = 'speed_scaling.initial_scaling_factor has no effect: it needs [position] alone'
        events.add(time_ns, 'warning', 'warning', text)
    if parameters.open_loop_control:
        text = 'open_loop_control is deprecated, use interpolate_from_desired_state'
        events.add(time_ns, 'warning', 'warning', text)


def stop_brakes(
    parameters: JointTrajectoryControllerParameters,
    properties: JointProperties,
    events: EventQueue,
    time_ns: int,
) -> Vector | None:
    """
    Return the (n,) decelerations of a stop, or None where it is not to be done that way.

    Where ``decelerate_on_cancel`` is set but something for it is missing, a warning names it.
    """
    if not parameters.constraints.decelerate_on_cancel:
        return None
    brakes = np.array(
        [parameters.constraints.joints[j].max_deceleration_on_cancel for j in parameters.joints]
    )
    lacking = ''
    if 'velocity' not in parameters.state_interfaces:
        lacking = 'there is no velocity state interface'
    for joint, brake, limit in zip(parameters.joints, brakes, properties.velocity, strict=True):
        if not brake > 0.0:
            lacking = f'constraints.{joint}.max_deceleration_on_cancel is not above 0'
        elif not 0.0 < limit < np.inf:
            lacking = f"the URDF gives joint '{joint}' no velocity limit"
    if lacking:
        events.add(
            time_ns, 'warning', 'warning',
            f'decelerate_on_cancel is not possible, a cancel stops at once: {lacking}',
        )
        return None
    return brakes


def command_timeout(
    parameters: JointTrajectoryControllerParameters, events: EventQueue, time_ns: int
) -> float:
    """Return cmd_timeout [s]; 0, with a warning, where goal_time is not below it."""
    timeout, goal_time = parameters.cmd_timeout, parameters.constraints.goal_time
    if 0.0 < timeout <= goal_time:
        events.add(
            time_ns, 'warning', 'warning',
            f'cmd_timeout {timeout:g} s is switched off: it has to be above '
            f'constraints.goal_time {goal_time:g} s',
        )
        return 0.0
    return timeout
