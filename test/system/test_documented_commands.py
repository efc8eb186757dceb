# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Command lines of README and docs are run as printed, on one robot that has what they use."""

from pathlib import Path
import re
import shlex
import shutil
import signal
import subprocess
import sys

import pytest

from armsim_ros.cli.programs import PROGRAMS
from armsim_ros.testing.program import private_domain, ros_environment, start_program

ROOT = Path(__file__).parents[2]
#: Those that switch controllers and make joints fail come last.
LAST = ['streaming', 'controllers']
DOCUMENTS = sorted([ROOT / 'README.md', *(ROOT / 'docs').glob('*.md')],
                   key=lambda path: (path.stem in LAST and 1 + LAST.index(path.stem), path))
READY = 'You can start planning now!'
#: Commands that run until they are stopped: their first line is waited for.
ENDLESS = ('ros2 topic pub -r',)
#: Programs that start a robot, files that only the reader has, and a motion of half a minute:
#: checked by name.
BY_NAME = re.compile(r'ros2 (run|launch) |armsim (bringup|launch|overlay|web)\b|/folder|path/to|'
                     r'my_robot|two_arms|--speed 0.02')
POSITION = """
sunday:
  position_controller:
    type: position_controllers/JointGroupPositionController
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
"""


def documented_lines():
    """Return the lines in blocks of the documents, in order: a parameter per different command."""
    seen = []
    for document in DOCUMENTS:
        inside = False
        for line in document.read_text().replace('\\\n', ' ').splitlines():
            command = line.strip().replace('.venv/bin/', '')
            if command.startswith('```'):
                inside = not inside
            elif inside and command.startswith(('ros2 ', 'armsim ')):
                words = shlex.split(command, comments=True)
                if words in seen:
                    continue
                seen.append(words)
                yield pytest.param(words, id=f'{document.stem}: {" ".join(words)[:60]}')


LINES = list(documented_lines())


@pytest.fixture(scope='module')
def environment(tmp_path_factory):
    """Run the default robot with the controller, the faults and the servo of the documents."""
    folder = tmp_path_factory.mktemp('documents') / 'sunday'
    shutil.copytree(ROOT / 'config/sunday', folder)
    (folder / 'position_controller.yaml').write_text(POSITION)
    with open(folder / 'simulation.yaml', 'a') as stream:
        stream.write('fault_injection: true\n')
    with private_domain() as domain, start_program(
            'bringup', domain, f'robot:={folder}', 'servo:=true') as program:
        program.wait_for_line(READY, 60)
        paths = f'{ROOT}:{ROOT / "ros2"}'
        yield {**ros_environment(domain), 'PYTHONPATH': paths}


def start(words, environment):
    """Start a command with this interpreter."""
    module = {'ros2': 'armsim_ros2', 'armsim': 'armsim_ros'}[words[0]]
    return subprocess.Popen([sys.executable, '-m', module, *words[1:]], env=environment, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)


@pytest.mark.parametrize('words', [line for line in LINES
                                   if not BY_NAME.search(' '.join(line.values[0]))])
def test_a_documented_line_works(words, environment):
    """It ends with status 0, or prints until it is stopped."""
    process = start(words, environment)
    if ' '.join(words).startswith(ENDLESS):
        assert process.stdout.readline()
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=30)[1] == ''
        return
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, out + err


@pytest.mark.parametrize('words', [line for line in LINES
                                   if BY_NAME.search(' '.join(line.values[0]))])
def test_a_documented_program_exists(words):
    """What starts a robot, or uses files of the reader, names a program of this package."""
    if words[0] == 'armsim':
        assert words[1] in PROGRAMS
    elif words[:3] == ['ros2', 'run', 'armsim_ros']:
        assert words[3] in PROGRAMS
    else:
        assert words[:2] == ['ros2', 'launch']
