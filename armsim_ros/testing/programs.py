# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Starts the package's own programs on a private domain."""

from __future__ import annotations

import os
from pathlib import Path

import armsim_ros
from armsim_ros.testing.domain import ros_environment
from armsim_ros.testing.program import Program


def start_program(name: str, domain: int, *arguments: str) -> Program:
    """
    Start a program of the package with this interpreter.

    :param name: ``bringup``, ``simulation`` ...
    :param domain: ROS domain id.
    :param arguments: the program's arguments.
    """
    root = str(Path(armsim_ros.__file__).resolve().parent.parent)
    environment = ros_environment(domain)
    known = [entry for entry in environment.get('PYTHONPATH', '').split(os.pathsep) if entry]
    environment['PYTHONPATH'] = os.pathsep.join([root, *known])
    return Program.module('armsim_ros', name, *arguments, environment=environment)
