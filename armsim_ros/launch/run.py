# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
``armsim run PACKAGE PROGRAM``: what ``ros2 run`` starts that is not installed.

Those are programs in the sources of the workspace, and programs of upstream that this package
replaces, such as ``controller_manager spawner``.
"""

from __future__ import annotations

from collections.abc import Sequence
import os
import signal
import subprocess
import sys

from armsim_ros.cli.arguments import UsageError
from armsim_ros.install_rules.view import installed_programs
from armsim_ros.launch.api.process import ExecuteLocal
from armsim_ros.launch.lookup import (
    current_lookup,
    KeptFiles,
    looking_with,
    make_lookup,
    python_sources,
)
from armsim_ros.launch.mapping import Kind, Mapping, Start
from armsim_ros.launch.process_spec import ProcessSpec, RosNode

USAGE = 'usage: armsim run PACKAGE PROGRAM [argument ...]'
_ROS_ARGS = '--ros-args'


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run a program; it keeps this process's input and output.

    :param argv: the words after the program's name; those of this process where None.
    :returns: the program's exit status; 1 if it is unknown.
    :raises UsageError: no program is named.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    if {'-h', '--help'} & set(words[:2]):
        print(USAGE)
        return 0
    failure = 'No executable found'
    if words and words[0].startswith('--failure='):  # what ros2 run found out
        failure = words.pop(0).partition('=')[2]
    if len(words) < 2:
        raise UsageError(USAGE)
    package, program, *rest = words
    node = RosNode(package, program, arguments=rest)
    kept = KeptFiles()
    try:
        with looking_with(make_lookup([], [])):
            spec = ProcessSpec([program], dict(os.environ), program, node=node)
            (start,) = Mapping(kept.write).decide([(ExecuteLocal(), spec)])
            if start.kind is Kind.UNKNOWN:
                print(_unknown(package, program) or failure, file=sys.stderr)
                return 1
            if start.kind is not Kind.RUN:
                print(f'{package} {program}: {start.note}', file=sys.stderr)
                return 0 if start.kind is Kind.PART else 1
            return _wait(start, kept)
    finally:
        kept.remove()


def _unknown(package: str, program: str) -> str:
    """Return an error that lists the programs of a package in sources; '' for any other."""
    folder = current_lookup().find(package)
    if folder is None or folder.parent.name == 'share':
        return ''
    names = sorted({*python_sources(folder).scripts, *installed_programs(folder, package)})
    return (f"No executable found: package '{package}' ({folder}) has no program '{program}' "
            f'(it has: {", ".join(names) or "none"})')


def _wait(start: Start, kept: KeptFiles) -> int:
    """Start a program, pass SIGTERM on, and return the status of its end."""
    command, environment = list(start.command), dict(os.environ)
    if not start.is_ours:
        if command[-1] == _ROS_ARGS:
            command.pop()
        environment['PYTHONPATH'] = os.pathsep.join(filter(None, (
            environment.get('PYTHONPATH', ''), kept.source_modules())))
    # A terminal interrupts both; the program decides how it ends.
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    process = subprocess.Popen(
        command, env=environment, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    signal.signal(signal.SIGTERM, lambda number, _: process.send_signal(number))
    status = process.wait()
    signal.signal(signal.SIGINT, before)
    return status if status >= 0 else 128 - status
