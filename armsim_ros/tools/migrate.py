# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program migrate: a robot's files in the layout of ROS 2."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import shutil
import sys
from typing import Any

from armsim_ros.cli.arguments import argparse_words, split_ros_args
from armsim_ros.config.loading import load_robot_settings
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import ArmsimError, ConfigError, Problem, Severity
from armsim_ros.tools.check_config.launch_file import answer_launch_file
from armsim_ros.tools.check_config.robot_check import launch_files
from armsim_ros.tools.migrate_files import FileRecords, Ros2Files, SAME_IN_BOTH
from armsim_ros.tools.migrate_text import real_number_edits

REPORT = 'MIGRATION.txt'
_PLUGIN_LINES = ['planning_plugins:', '  - ompl_interface/OMPLPlanner']


def migrate(robot: str, target: Path) -> list[str]:
    """
    Write a robot's files in the layout of ROS 2, and check that they are equivalent.

    :param robot: a name under ``config/``, or a path to a folder.
    :param target: a folder that does not exist, or is empty.
    :returns: the report; it is in the folder too.
    :raises ConfigError: the robot's files have errors, or the folder is not empty.
    """
    before = load_robot_settings(robot)
    if target.is_file() or (target.is_dir() and any(target.iterdir())):
        raise ConfigError(Problem(f"'{target}' is not empty", allowed='a new folder'))
    others = _other_files(before)
    target.mkdir(parents=True, exist_ok=True)
    report = _write_settings(before, target)
    report += _copy_others(before, others, target)
    report += [str(remark) for remark in before.remarks if remark.severity is Severity.INFO]
    report += _launch_answers(before)
    after = load_robot_settings(str(target), urdf=before.urdf_file)
    differences = _differences(before, after)
    if differences:
        raise ArmsimError("the new files are not equivalent; please report this with the "
                          f"robot's files: {', '.join(differences)}")
    report.append('checked: both folders load to the same values')
    (target / REPORT).write_text('\n'.join(report) + '\n', encoding='utf-8')
    return report


def _write_settings(before: RobotSettings, target: Path) -> list[str]:
    new = Ros2Files(before.namespace)
    report: list[str] = []
    for file in before.files:
        records = FileRecords(file)
        kept = _kept_as_it_is(records)
        if kept is None:
            new.take(records)
        elif kept:
            (target / file.name).write_text('\n'.join(kept) + '\n', encoding='utf-8')
            same = kept == [line.rstrip() for line in records.text.lines]
            report.append(f"{file.name} -> {file.name}{'' if same else ', with changed values'}")
    for name, text in new.files().items():
        place = target / name
        if place.exists():
            text = place.read_text(encoding='utf-8') + text
        place.write_text(text, encoding='utf-8')
    return report + new.remarks


def _kept_as_it_is(records: FileRecords) -> list[str] | None:
    """Return the lines of a file that has the same form in ROS 2; None where it has another."""
    if records.is_ros2:
        return records.text.edited({})
    if not records.records:
        is_world = 'objects' in records.root.entries
        return records.text.edited({}) if is_world else []
    if not records.kinds <= set(SAME_IN_BOTH):
        return None
    edits: dict[tuple[int, int], str] = {}
    for record in records.records:
        kind: Any = SAME_IN_BOTH[record.section]
        node = record.node.with_value({record.key: record.node}) if record.key else record.node
        edits |= real_number_edits(kind, node) if kind is not None else {}
    lines = records.text.edited(edits)
    bare = 'planner_configs' in records.root.entries
    if bare and not {'planning_plugins', 'planning_plugin'} & set(records.root.entries):
        lines = [*_PLUGIN_LINES, *lines]
    return lines


def _copy_others(before: RobotSettings, files: list[Path], target: Path) -> list[str]:
    """Copy what is not a settings file: URDF, SRDF, meshes, worlds."""
    report = []
    for file in files:
        place = target / file.relative_to(before.folder)
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, place)
    if files:
        report.append(f'{len(files)} other files are copied as they are')
    for used in (before.urdf_file, before.srdf_file):
        if used is not None and used not in files:
            report.append(f'{used} stays in place; if it is not found by its name, start '
                          'with urdf:=FILE or srdf:=FILE')
    report.append('on a real robot ROS 2 needs a <ros2_control> block in the URDF in place of '
                  '<transmission>; here every joint has all interfaces')
    return report


def _other_files(before: RobotSettings) -> list[Path]:
    settings = {file.resolve() for file in before.files}
    return [file for file in sorted(before.folder.rglob('*'))
            if file.is_file() and file.resolve() not in settings
            and not file.name.endswith(('.launch', '.launch.xml'))]


def _launch_answers(before: RobotSettings) -> list[str]:
    lines: list[str] = []
    for file in launch_files(before.folder):
        try:
            lines += [str(line) for line in answer_launch_file(file)]
        except ConfigError as error:
            lines += [str(problem) for problem in error.problems]
    return lines


def _differences(before: RobotSettings, after: RobotSettings) -> list[str]:
    first, second = settings_values(before), settings_values(after)
    return [key for key in first if first[key] != second[key]]


def settings_values(settings: RobotSettings) -> dict[str, object]:
    """Return what must not depend on the layout of the files."""
    places = {'name', 'folder', 'files', 'remarks', 'urdf_file', 'srdf_file', 'world_file'}
    values = settings.model_dump(exclude={*places, 'controllers', 'moveit_controllers', 'spawn'})
    values['controllers'] = {controller.name: (controller.type, controller.parameters)
                             for controller in settings.controllers}
    values['moveit_controllers'] = {controller.name: controller
                                    for controller in settings.moveit_controllers}
    values['spawn'] = set(settings.spawn)
    return values


def main(argv: Sequence[str] | None = None) -> int:
    """
    Write a robot's files in the layout of ROS 2.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0.
    :raises ConfigError: the robot's files have errors.
    """
    words, _ = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(argparse_words(words))
    for line in migrate(options.robot, options.to):
        print(line)
    print(f'written to {options.to}, with this report as {REPORT}')
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='armsim migrate',
        description="Write a robot's files in the layout of ROS 2, with their comments, and a "
                    'report of the destination of each block; the original files are not changed.')
    parser.add_argument('robot', metavar='DIR|NAME', help="the robot's folder or name")
    parser.add_argument('--to', type=Path, required=True, metavar='OUT',
                        help='a new folder for the files')
    return parser
