# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The script of the page does what the page promises."""

from pathlib import Path
import re
import subprocess
import sys

import pytest
from std_msgs.msg import String

from armsim_ros.clients.ros_client import RosClient
from armsim_ros.nodes import qos

pytestmark = pytest.mark.statement('A1', 'A3')

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope='module')
def program():
    """Return the examples of the page as one program."""
    page = (ROOT / 'docs' / 'moveit_py.md').read_text(encoding='utf-8')
    return '\n\n'.join(re.findall(r'```python\n(.*?)```', page, re.DOTALL))


def test_the_script_moves_the_robot(program, panda, parameters, capsys):
    """Beside a robot whose descriptions are on topics."""
    panda.hangs = False
    with RosClient('describes') as client:
        for name in ('robot_description', 'robot_description_semantic'):
            publisher = client.node.create_publisher(String, f'/{name}', qos.LATCHED)
            publisher.publish(String(data=parameters[name]))
        names = {}
        exec(compile(program, 'moveit_py.md', 'exec'), names)
    names['moveit'].shutdown()
    assert panda.positions['panda_joint4'] == pytest.approx(-0.1, abs=1e-3)
    assert capsys.readouterr().out == 'planned\nTrue\n'


def test_the_script_passes_a_type_checker(program, tmp_path):
    """A script that is checked strictly finds annotations for all that it uses."""
    pytest.importorskip('mypy')
    path = tmp_path / 'program.py'
    path.write_text(program, encoding='utf-8')
    checked = subprocess.run(
        [sys.executable, '-m', 'mypy', str(path)],  # strict, see pyproject.toml
        cwd=ROOT, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout
