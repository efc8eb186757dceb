# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A process of a launch file, with all substitutions performed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import os
from typing import Any, TypeAlias

#: Parameters as a block of names, or a file of them.
ParameterSource: TypeAlias = 'Mapping[str, Any] | str'


@dataclass
class RosNode:
    """
    What makes a process a node.

    :param name: '' where the program names itself.
    :param namespace: absolute.
    :param parameters: in order, later ones win.
    :param remappings: (from, to).
    """

    package: str
    executable: str
    name: str = ''
    namespace: str = '/'
    parameters: Sequence[ParameterSource] = ()
    remappings: Sequence[tuple[str, str]] = ()
    arguments: Sequence[str] = ()
    ros_arguments: Sequence[str] = ()

    def merged(self) -> dict[str, Any]:
        """Return the parameters that are not in files."""
        return {name: value for source in self.parameters if not isinstance(source, str)
                for name, value in source.items()}

    def files(self) -> list[str]:
        """Return the parameter files."""
        return [source for source in self.parameters if isinstance(source, str)]


@dataclass
class ProcessSpec:
    """
    A process to start.

    :param command: without what makes it a node.
    :param node: of a node, else None.
    """

    command: list[str]
    environment: dict[str, str]
    name: str
    cwd: str | None = None
    shell: bool = False
    output: str = 'screen'
    emulate_tty: bool = False
    respawn: bool = False
    respawn_delay: float = 0.0
    respawn_max_retries: int = -1
    sigterm_timeout: float = 5.0
    sigkill_timeout: float = 5.0
    prefix: list[str] = field(default_factory=list)
    node: RosNode | None = None

    @property
    def label(self) -> str:
        """``PKG/EXE``, or ``-/PROGRAM`` of a process that is not a node."""
        if self.node is not None:
            return f'{self.node.package}/{self.node.executable}'
        return f'-/{program_of(self.command, self.shell)}'

    def dry_line(self) -> str:
        """Return the line of ``--dry-run``."""
        node = self.node
        program = self.label.partition('/')[2]
        name = (node.name if node is not None and node.name else self.name) or program
        names = [_parameter_word(parameter) for parameter in parameter_names(node)] if node else []
        return (f'process: {_word(self.label)} name={_word(name)} '
                f'ns={node.namespace if node else "/"} parameters={",".join(names)}')


def parameter_names(node: RosNode) -> list[str]:
    """Return the names of a node's parameters, each once."""
    found: dict[str, None] = {}
    for source in node.parameters:
        if isinstance(source, str):
            found[os.path.basename(source)] = None
        else:
            found.update(dict.fromkeys(name.partition('.')[0] for name in source))
    return list(found)


def program_of(command: Sequence[str], shell: bool) -> str:
    """Return the name of a command's program."""
    words = ' '.join(command).split() if shell else list(command)
    return os.path.basename(words[0]) if words else ''


def _word(text: str) -> str:
    return '_'.join(text.split())


def _parameter_word(text: str) -> str:
    return _word(str(text)).replace(',', '_')
