# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Helpers of MoveIt's launch files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from armsim_ros.install_rules.xacro_run import XacroCommand
from armsim_ros.launch.api.actions.configuration import DeclareLaunchArgument
from armsim_ros.launch.api.conditions import IfCondition, UnlessCondition
from armsim_ros.launch.api.context import LaunchContext
from armsim_ros.launch.api.description import LaunchDescription
from armsim_ros.launch.api.entity import SomeText, Substitution
from armsim_ros.launch.api.ros_node import Node
from armsim_ros.launch.api.substitutions.programs import run_xacro
from armsim_ros.launch.api.substitutions.texts import LaunchConfiguration
from armsim_ros.launch.api.utilities import perform_text


class Xacro(Substitution):
    """
    The output of xacro for a file.

    :param file_path: of the file.
    :param mappings: its arguments.
    """

    def __init__(self, file_path: SomeText, *, mappings: Mapping[Any, Any] | None = None) -> None:
        self._file = file_path
        self._mappings = dict(mappings or {})

    def perform(self, context: LaunchContext) -> str:
        """Return the robot description."""
        words = {perform_text(context, name): perform_text(context, value)
                 for name, value in self._mappings.items()}
        return run_xacro(XacroCommand(perform_text(context, self._file), words), self.where)


class DeclareBooleanLaunchArg(DeclareLaunchArgument):
    """
    An argument that is true or false.

    :param name: of the argument.
    """

    def __init__(self, name: str, *, default_value: Any = False,
                 description: str | None = None, **kwargs: Any) -> None:
        super().__init__(name, default_value=str(default_value), description=description,
                         choices=['true', 'false', 'True', 'False'], **kwargs)


def add_debuggable_node(
    ld: LaunchDescription, package: SomeText, executable: SomeText,
    condition_name: str = 'debug', commands_file: str | None = None,
    extra_debug_args: Iterable[str] | None = None, **kwargs: Any,
) -> None:
    """Add a node, and the same node in a debugger for when an argument asks for it."""
    requested = LaunchConfiguration(condition_name)
    ld.add_action(Node(package=package, executable=executable,
                       condition=UnlessCondition(requested), **kwargs))
    arguments = [*(kwargs.pop('arguments', None) or ()), *(extra_debug_args or ())]
    commands = f'-x {commands_file} ' if commands_file else ''
    ld.add_action(Node(package=package, executable=executable, condition=IfCondition(requested),
                       prefix=[f'gdb {commands}--ex run --args'], arguments=arguments, **kwargs))
