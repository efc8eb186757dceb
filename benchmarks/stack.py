# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The running stack that benchmarks measure, and what they read from outside."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
import os
from pathlib import Path
import re
import statistics

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.config.loading import load_robot_settings
from armsim_ros.testing.program import private_domain, Program, ros_environment

READY = 'You can start planning now!'
DOMAINS = range(20, 30)


@dataclass
class Stack:
    """A bringup process and a client's node in its domain."""

    program: Program
    client: ClientNode
    domain: int

    def processes(self) -> dict[str, int]:
        """Return name -> process id of the stack's programs."""
        found = {'bringup': self.program.process.pid}
        for folder in Path('/proc').glob('[0-9]*'):
            try:
                words = (folder / 'cmdline').read_bytes().split(b'\0')
                parent = re.search(r'^PPid:\s+(\d+)', (folder / 'status').read_text(), re.M)
            except OSError:
                continue
            if parent and int(parent[1]) == self.program.process.pid:
                for name in ('simulation', 'move_group', 'servo_node', 'camera', 'web'):
                    if name.encode() in words:
                        found[name] = int(folder.name)
        return found


@contextmanager
def running_stack(*arguments: str, wait: bool = True) -> Iterator[Stack]:
    """Start bringup in a domain of its own and stop it afterwards."""
    with private_domain(DOMAINS) as domain, ClientNode(domain, 'benchmark') as client:
        program = Program.module(
            'armsim_ros', 'bringup', *arguments, environment=ros_environment(domain))
        with program:
            if wait:
                program.wait_for_line(re.escape(READY), 60.0)
            yield Stack(program, client, domain)


@contextmanager
def peer(module: str, *arguments: str, domain: int, settled: str = '') -> Iterator[Program]:
    """
    Run a module of these benchmarks in a process of its own and in a stack's domain.

    :param module: with its folder, as in ``bringup.page_session``.
    :param settled: what it prints when it is ready, if anything.
    """
    program = Program.module(
        f'benchmarks.{module}', *arguments, environment=ros_environment(domain))
    with program:
        if settled:
            program.wait_for_line(settled, 60.0)
        yield program


def arm_of(robot: str) -> tuple[str, tuple[str, ...]]:
    """Return full name and joints of a robot's first trajectory controller."""
    settings = load_robot_settings(robot)
    controller = next(
        each for each in settings.controllers
        if isinstance(each.parameters, JointTrajectoryControllerParameters))
    return f'{settings.namespace}/{controller.name}', tuple(controller.parameters.joints)


def joint_states_of(robot: str) -> str:
    """Return the topic of a robot's joint states."""
    controller, _ = arm_of(robot)
    return f'{controller.rpartition("/")[0]}/joint_states'


def processor_seconds(process: int) -> float:
    """Return the processor time that a process has used [s]."""
    fields = Path(f'/proc/{process}/stat').read_text(encoding='ascii').rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def resident_mib(process: int) -> float:
    """Return the resident memory of a process [MiB]."""
    text = Path(f'/proc/{process}/status').read_text(encoding='ascii')
    match = re.search(r'^VmRSS:\s+(\d+) kB', text, re.M)
    return int(match[1]) / 1024.0 if match else 0.0


def median(values: list[float]) -> float:
    """Return the median, NaN of nothing."""
    return statistics.median(values) if values else float('nan')


def percentile(values: list[float], share: float) -> float:
    """Return the value below which a share (0..1) of the values lies."""
    ordered = sorted(values)
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)]
