# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Robots of any number of joints: arms of six joints on one base, under one controller."""

from __future__ import annotations

from pathlib import Path

JOINTS_PER_ARM = 6
CONTROLLER = 'arms_controller'
_AXES = ('0 0 1', '0 1 0', '0 1 0', '0 0 1', '0 1 0', '0 0 1')
_LENGTHS = (0.1, 0.3, 0.3, 0.1, 0.1, 0.05)

_LINK = """
  <link name="{name}">
    <inertial>
      <origin xyz="0 0 {middle}"/><mass value="{mass}"/>
      <inertia ixx="{side}" iyy="{side}" izz="{along}" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision>
      <origin xyz="0 0 {middle}"/><geometry><cylinder radius="0.03" length="{length}"/></geometry>
    </collision>
  </link>"""

_JOINT = """
  <joint name="{name}" type="revolute">
    <parent link="{parent}"/><child link="{child}"/><origin xyz="{origin}"/><axis xyz="{axis}"/>
    <limit lower="-2.8" upper="2.8" velocity="3" effort="200"/>
  </joint>"""

_CONTROLLERS = """
controller_manager:
  ros__parameters:
    update_rate: 1000
    {controller}:
      type: joint_trajectory_controller/JointTrajectoryController
    joint_state_broadcaster:
      type: joint_state_broadcaster/JointStateBroadcaster
{controller}:
  ros__parameters:
    joints: [{joints}]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
    constraints:
{tolerances}
"""


def joint_names(joints: int) -> list[str]:
    """Return the names of so many joints."""
    return [f'arm_{i // JOINTS_PER_ARM}_joint_{i % JOINTS_PER_ARM}' for i in range(joints)]


def write_robot(folder: Path, joints: int) -> Path:
    """
    Write the files of a robot whose controller judges every tolerance, and return its folder.

    :param joints: a multiple of six.
    """
    names = joint_names(joints)
    parts = ['<robot name="arms">\n  <link name="base"/>']
    for i, name in enumerate(names):
        first = i % JOINTS_PER_ARM == 0
        length = _LENGTHS[i % JOINTS_PER_ARM]
        mass = 5.0 * length
        parts.append(_LINK.format(
            name=f'{name}_link', middle=length / 2, length=0.8 * length, mass=mass,
            side=mass * length**2 / 12 + 1e-3, along=1e-3,
        ))
        parts.append(_JOINT.format(
            name=name, child=f'{name}_link', axis=_AXES[i % JOINTS_PER_ARM],
            parent='base' if first else f'{names[i - 1]}_link',
            origin=f'{i // JOINTS_PER_ARM} 0 0.5' if first
            else f'0 0 {_LENGTHS[i % JOINTS_PER_ARM - 1]}',
        ))
    (folder / 'arms.urdf').write_text(''.join([*parts, '\n</robot>\n']), encoding='utf-8')
    tolerances = '\n'.join(f'      {name}: {{trajectory: 0.5, goal: 0.01}}' for name in names)
    (folder / 'controllers.yaml').write_text(
        _CONTROLLERS.format(controller=CONTROLLER, joints=', '.join(names), tolerances=tolerances),
        encoding='utf-8',
    )
    return folder
