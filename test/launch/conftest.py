# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Launch files written into a folder and run dry, inside this process."""

from dataclasses import dataclass
from textwrap import dedent

import pytest
import yaml

from armsim_ros.launch.api.context import LaunchContext
from armsim_ros.launch.main import main
from armsim_ros.launch.mapping import Mapping


@dataclass
class Dry:
    """What a dry run said."""

    status: int
    plan: list
    errors: str

    def processes(self):
        """Return name -> line of the processes, in starting order."""
        return {line.split(' name=')[1].split()[0]: line for line in self.plan
                if line.startswith('process: ')}


@pytest.fixture
def workspace(tmp_path, monkeypatch):
    """Return a workspace with a package ``mine``; it is the working folder."""
    package = tmp_path / 'src' / 'mine'
    (package / 'launch').mkdir(parents=True)
    (package / 'config').mkdir()
    (package / 'scripts').mkdir()
    (package / 'package.xml').write_text('<package><name>mine</name></package>')
    for name in ('one', 'two', 'three', 'four'):
        (package / 'scripts' / name).write_text('#!/usr/bin/env python3\n')
    monkeypatch.chdir(tmp_path)
    return package


@pytest.fixture
def write(workspace):
    """Return a function that writes a launch file of the package."""

    def write_file(text, name='it.launch.py'):
        path = workspace / 'launch' / name
        path.write_text(dedent(text).lstrip())
        return path

    return write_file


@pytest.fixture
def dry(write, capsys):
    """Return a function that runs a launch file dry."""

    def run(text, *words, name='it.launch.py'):
        path = write(text, name)
        capsys.readouterr()
        status = main(['-n', str(path), *words])
        out, err = capsys.readouterr()
        return Dry(status, out.splitlines(), err)

    return run


HEAD = """
from launch import LaunchDescription, LaunchContext, Substitution
from launch.actions import *
from launch.conditions import *
from launch.event_handlers import *
from launch.events import matches_action, Shutdown as ShutdownEvent
from launch.launch_description_sources import *
from launch.substitutions import *
from launch_ros.actions import *
from launch_ros.descriptions import *
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import *


def node(name, **more):
    return Node(package='mine', executable='one', name=name, **more)


def generate_launch_description():
    return LaunchDescription([
"""


@pytest.fixture
def entities(dry):
    """Return a function that runs a description with these entities dry."""

    def run(text, *words, before=''):
        lines = '\n'.join(f'        {line}' for line in dedent(text).strip().splitlines())
        return dry(f'{before}\n{HEAD.strip()}\n{lines}\n    ])\n', *words)

    return run


@pytest.fixture
def decided(tmp_path):
    """Return a function that gives what is done for some nodes, and the files it wrote."""
    def decide(*nodes):
        texts = []

        def keep(name, text):
            (block,) = yaml.safe_load(text).values()
            texts.append(block['ros__parameters'])
            return str(tmp_path / name)

        context = LaunchContext()
        return Mapping(keep).decide([(node, node.spec(context)) for node in nodes]), texts
    return decide
