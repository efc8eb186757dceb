# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Command lines of README and docs are run as printed, on one robot that has what they use.

Those that need no running robot, or start one, are in ``test/test_documents.py``; the tutorial
is in ``test_tutorial.py``.
"""

from pathlib import Path
import shlex
import shutil
import signal
import subprocess
import sys

from documents import blocks, PAGES
import pytest

from armsim_ros.cli.programs import FILE_PROGRAMS, LEARNING_PROGRAMS
from armsim_ros.testing.program import private_domain, ros_environment, start_program

ROOT = Path(__file__).parents[2]
#: Those that switch controllers and make joints fail come last.
LAST = ['streaming', 'controllers']
DOCUMENTS = sorted((path for path in PAGES if path.stem != 'tutorial'),
                   key=lambda path: (path.stem in LAST and 1 + LAST.index(path.stem), path))
READY = 'You can start planning now!'
#: Commands that run until they are stopped: their first line is waited for.
ENDLESS = ('ros2 topic pub -r',)
MODULES = {'ros2': 'armsim_ros2', 'armsim': 'armsim_ros'}
#: Programs that start a robot, that need a terminal, and that read and write files.
WITHOUT_ROBOT = {'bringup', 'web', 'bridge', 'teleop', *FILE_PROGRAMS, *LEARNING_PROGRAMS}
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
        for block in blocks(document):
            for command in [] if block.reason else block.commands:
                words = shlex.split(command)
                if words[0] not in MODULES or words in seen:
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
    command = [sys.executable, '-m', MODULES[words[0]], *words[1:]]
    return subprocess.Popen(command, env=environment, text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE)


@pytest.mark.parametrize('block', [
    pytest.param(block, id=block.place) for page in DOCUMENTS for block in blocks(page)
    if block.comment == 'beside a robot'])
def test_a_documented_program_works(block, environment):
    """It ends without an error."""
    done = subprocess.run([sys.executable, '-c', block.text], env=environment, text=True,
                          capture_output=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize('words', [line for line in LINES
                                   if line.values[0][1] not in WITHOUT_ROBOT])
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
