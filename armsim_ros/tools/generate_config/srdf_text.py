# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The SRDF as text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from armsim_ros.model.description.xml_tree import quoted
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.planning.scene.allowed_collision_matrix import Pair
from armsim_ros.tools.generate_config.found_groups import FoundGroup


def srdf_text(robot: RobotModel, groups: Iterable[FoundGroup],
              states: Mapping[str, Mapping[str, float]], disabled: Mapping[Pair, str]) -> str:
    """
    Return the SRDF.

    :param states: state -> joint -> position [rad or m]; each group takes its own joints.
    :param disabled: pair of links -> why it is not checked.
    """
    found = list(groups)
    lines = ['<?xml version="1.0"?>', f'<robot name={quoted(robot.name)}>']
    for group in found:
        lines.append(f'  <group name={quoted(group.name)}>')
        if group.chain:
            base, tip = map(quoted, group.chain)
            lines.append(f'    <chain base_link={base} tip_link={tip}/>')
        else:
            lines += [f'    <joint name={quoted(name)}/>' for name in group.joints]
        lines.append('  </group>')
    for group in found:
        for state, positions in states.items():
            lines += _state(state, group, positions)
    for group in found:
        if group.parent:
            lines.append(
                f'  <end_effector name={quoted(group.name)} group={quoted(group.name)} '
                f'parent_link={quoted(group.parent_link)} '
                f'parent_group={quoted(group.parent)}/>')
    lines += [f'  <passive_joint name={quoted(name)}/>' for name in robot.movable_joints
              if robot.joints[name].mimic is not None]
    lines += [f'  <disable_collisions link1={quoted(first)} link2={quoted(second)} '
              f'reason="{reason}"/>' for (first, second), reason in disabled.items()]
    return '\n'.join([*lines, '</robot>']) + '\n'


def _state(state: str, group: FoundGroup, positions: Mapping[str, float]) -> list[str]:
    return [f'  <group_state name="{state}" group={quoted(group.name)}>',
            *(f'    <joint name={quoted(name)} value="{positions[name]:g}"/>'
              for name in group.active_joints),
            '  </group_state>']
