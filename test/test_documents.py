# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Blocks of the pages that need no running robot: commands, programs, settings.

``test/system/test_documented_commands.py`` runs the commands beside a robot, and
``test/system/test_tutorial.py`` the tutorial.
"""

from importlib import import_module
import json
import os
from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys

from documents import all_blocks, PAGES, ROOT, summary
import pytest
import yaml

from armsim_ros.cli.arguments import parse_arguments
from armsim_ros.cli.programs import FILE_PROGRAMS, LEARNING_PROGRAMS, main_of
from armsim_ros.cli.settings import cell_of
from armsim_ros.config.loading import load_robot_settings
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.nodes.bridge.settings import parse_bridge_arguments
from armsim_ros.nodes.web.main import parse_web_arguments

TUTORIAL, LIBRARY = ROOT / 'docs/tutorial.md', ROOT / 'docs/library.md'
BLOCKS = all_blocks()
HERE = [block for block in BLOCKS if not block.reason and block.page not in (TUTORIAL, LIBRARY)]
#: A command -> where else it runs.
ELSEWHERE = re.compile(
    r'ros2 |armsim (go|stop|state|teleop) |python examples/pick_with_fingers\.py'
    r'|python -m pytest test_my_arm.py|\. \.venv/bin/activate|eval ')


def of(*languages):
    """Return the blocks in these languages as parameters."""
    return [pytest.param(block, id=block.place) for block in HERE
            if block.language in languages and block.comment != 'beside a robot']


@pytest.fixture
def reader(tmp_path):
    """Return a folder with the files that the pages suppose the reader to have."""
    for name in ('path/to/folder', 'old/folder', 'my_robot_moveit_config'):
        shutil.copytree(ROOT / 'config/sunday', tmp_path / name)
        shutil.copy(ROOT / 'urdf/sunday.urdf.xacro', tmp_path / name)
    shutil.rmtree(tmp_path / 'path/to/folder')
    shutil.copytree(ROOT / 'config/leg', tmp_path / 'path/to/folder')
    shutil.copy(ROOT / 'urdf/leg.urdf.xacro', tmp_path / 'path/to/folder')
    text = (ROOT / 'urdf/leg.urdf.xacro').read_text()
    (tmp_path / 'robot.urdf').write_text(text)
    robots, = (block for block in BLOCKS if '# two_arms/robots.yaml' in block.text)
    (tmp_path / 'two_arms').mkdir()
    (tmp_path / 'two_arms/robots.yaml').write_text(robots.text)
    return tmp_path


def run_here(command):
    """Do what a command does without starting a robot."""
    program, *words = shlex.split(command)
    if program == 'make':
        words = ['-n', f'PYTHON={sys.executable}', *words]
        subprocess.run(['make', *words], cwd=ROOT, check=True, capture_output=True)
        return
    assert program == 'armsim', f'{command}: neither run nor given a reason'
    name, *words = words
    if name == 'bringup':
        cell_of(parse_arguments(words, xacro=True))
    elif name == 'web':
        parse_web_arguments(words)
    elif name == 'bridge':
        parse_bridge_arguments(words)
    elif name in LEARNING_PROGRAMS:
        # In a process of their own: how pictures are drawn is chosen before MuJoCo is imported.
        subprocess.run([sys.executable, '-m', 'armsim_ros', name, *words], check=True,
                       env={**os.environ, 'PYTHONPATH': str(ROOT)})
    else:
        assert name in FILE_PROGRAMS, f'{command}: neither run nor given a reason'
        if '--to' in words:
            shutil.rmtree(words[-1], ignore_errors=True)
        module, function = main_of(name).split(':')
        assert getattr(import_module(module), function)(words) <= 1


@pytest.mark.parametrize('block', of('sh', 'console'))
def test_commands_run(block, reader, monkeypatch):
    """
    What reads or writes files runs; what starts a robot reads its files.

    What runs beside a robot, or is an example with a test of its own, is left to that test.
    """
    monkeypatch.chdir(reader)
    for command in block.commands:
        for part in command.split(' && '):
            if not ELSEWHERE.match(part):
                run_here(part)


@pytest.mark.parametrize('block', of('python'))
def test_programs_run(block, tmp_path):
    """Each ends without an error; a test passes."""
    file = tmp_path / ('test_it.py' if 'def test_' in block.text else 'program.py')
    file.write_text(block.text)
    start = ['-m', 'pytest', '-p', 'no:cacheprovider', '-q'] if 'def test_' in block.text else []
    done = subprocess.run([sys.executable, *start, file], cwd=tmp_path, check=False, text=True,
                          env={'PATH': '/usr/bin:/bin', 'PYTHONPATH': ':'.join(sys.path)},
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize('block', of('json'))
def test_json_can_be_read(block):
    """It is valid."""
    json.loads(block.text)


@pytest.mark.parametrize('block', of('yaml'))
def test_settings_can_be_loaded(block, tmp_path):
    """A robot with these lines is without errors; other files are valid."""
    content = yaml.safe_load(block.text)
    target = tmp_path / 'robot'
    if 'robots' in content:
        target.mkdir()
        (target / 'robots.yaml').write_text(block.text)
        assert len(load_cell(str(target)).robots) == len(content['robots'])
    elif 'jobs' not in content:
        shutil.copytree(ROOT / 'config/sunday', target)
        shutil.copy(ROOT / 'urdf/sunday.urdf.xacro', target)
        add(block, content, target)
        load_robot_settings(str(target))


def add(block, content, folder):
    """Write lines where the page puts them: a file of their own, or simulation.yaml."""
    if 'servo.yaml' in block.text:
        (folder / 'servo.yaml').write_text(block.text)
    elif 'sunday' in content:
        (folder / 'more.yaml').write_text(block.text)
        if 'sensor_name' in block.text:
            sensors, = (each for each in BLOCKS if each.text.startswith('sensors:'))
            add(sensors, yaml.safe_load(sensors.text), folder)
    else:
        file = folder / 'simulation.yaml'
        whole = {**yaml.safe_load(file.read_text()), **content}
        file.write_text(yaml.safe_dump(whole))


def test_every_block_runs_or_has_a_reason(record_property):
    """No block is left without a test; the report has their numbers and the reasons."""
    known = {'sh', 'console', 'python', 'json', 'yaml'}
    for block in BLOCKS:
        if not block.reason and block.page != TUTORIAL:
            assert block.language in known, f'{block.place}: neither run nor given a reason'
    record_property('documentation blocks', '\n'.join(summary()))


def indented_commands():
    """Return the commands that pages have in indented blocks, without their remarks."""
    for page in PAGES:
        for number, line in enumerate(page.read_text(encoding='utf-8').splitlines(), 1):
            if found := re.match(r' {4}((?:make|pytest|python -m benchmarks) [^#]*)', line):
                place = f'{page.relative_to(ROOT)}:{number}'
                yield pytest.param(found[1].strip(), id=place)


@pytest.mark.parametrize('command', list(indented_commands()))
def test_benchmarks_and_long_tests_exist(command):
    """What takes minutes to hours is not run: its program, its file and its options are there."""
    program, *words = shlex.split(command)
    if program == 'make':
        run_here(command)
    elif program == 'pytest':
        assert (ROOT / words[0]).is_file()
        options = (ROOT / words[0]).read_text() + ''.join(
            file.read_text() for parent in Path(ROOT, words[0]).parents
            if parent.is_relative_to(ROOT / 'test')
            for file in [parent / 'conftest.py'] if file.is_file())
        assert words[1] in options
    else:
        assert list((ROOT / 'benchmarks').rglob(f'{words[2]}.py'))
