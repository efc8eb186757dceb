# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Command lines of xacro, and runs of xacro inside this process."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
import os
from pathlib import Path
import threading
from typing import Any

PROGRAMS = ('xacro', 'xacro.py')
_OUTPUTS = ('-o', '>')
#: Module variables of xacro; ``$(find p)`` may run xacro for a file that the build of p makes.
_STATE = ('filestack', 'macrostack', 'verbosity', 'all_includes', 'root_dir')
_LOCK = threading.RLock()


@dataclass(frozen=True)
class XacroCommand:
    """A file and its arguments; the file that it writes, '' for standard output."""

    file: str
    mappings: Mapping[str, str] = field(default_factory=dict)
    output: str = ''


def as_xacro(words: Sequence[str]) -> XacroCommand | None:
    """Return the xacro command in these words, None for any other command."""
    rest = list(words)
    if rest[:3] == ['ros2', 'run', 'xacro']:
        rest = rest[3:]
    if not rest or os.path.basename(rest[0]) not in PROGRAMS:
        return None
    file = output = ''
    mappings: dict[str, str] = {}
    following = iter(rest[1:])
    for word in following:
        name, sign, value = word.partition(':=')
        if word in _OUTPUTS:
            output = next(following, '')
        elif word == '--verbosity':
            next(following, '')
        elif sign:
            # As in xacro, an argument without a value leaves the file's default.
            name, value = name.strip(), value.strip()
            if name and value:
                mappings[name] = value
        elif not word.startswith('-') and not file:
            file = word
    return XacroCommand(file, mappings, output)


@contextmanager
def xacro_finding(find: Callable[[str], Path]) -> Iterator[Any]:
    """
    Give the module ``xacro``, which finds packages as this package does, ROS installed or not.

    :param find: returns the folder of a package.
    """
    import xacro  # only robots in xacro pay for its import
    from xacro import substitution_args

    with _LOCK:
        before = substitution_args._eval_find
        state = {name: getattr(xacro, name) for name in _STATE}
        context = dict(xacro.substitution_args_context)
        substitution_args._eval_find = lambda package: str(find(package))
        try:
            yield xacro
        finally:
            substitution_args._eval_find = before
            for name, value in state.items():
                setattr(xacro, name, value)
            xacro.substitution_args_context.update(context)
