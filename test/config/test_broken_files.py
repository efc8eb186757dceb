"""
Real configurations with one mistake each, and the words that check_config has for it.

A folder ``broken/<robot>-<mistake>/`` holds the files that differ from those of the robot,
``removed.txt`` names files that are left out, ``expected.txt`` is what is said.
"""

from pathlib import Path
import re
import shutil

import pytest

from armsim_ros.config.yaml_source import LARGEST_FILE
from armsim_ros.errors import Severity
from armsim_ros.resources import find_robot, PACKAGE, share_folder
from armsim_ros.tools.check_config.main import exit_status
from armsim_ros.tools.check_config.robot_check import check_robot

BROKEN = Path(__file__).parent / 'broken'
CASES = sorted(path.name for path in BROKEN.iterdir())
#: What is too large to be kept: case -> file -> content.
GENERATED = {'sunday-huge_file': {'joint_limits.yaml': b'# ' + b'x' * LARGEST_FILE}}
WARNED_ONLY = {
    'ROBOT-group_without_a_controller', 'leg-no_controller_files',
    'leg-transmission_of_a_joint_that_is_not_there', 'sunday-inertia_that_cannot_be',
    'sunday-kinematics_of_an_unknown_group', 'sunday-planner_that_is_not_configured',
    'sunday-spawned_controller_is_not_described', 'sunday-typo_in_a_namespace',
}


def broken_robot(case, folder):
    """Return a robot's folder with the mistake of a case."""
    robot = case.split('-')[0]
    target = folder / robot
    shutil.copytree(find_robot(robot), target)
    shutil.copy(share_folder(PACKAGE) / 'urdf' / f'{robot}.urdf.xacro', target)
    for file in (BROKEN / case).iterdir():
        if file.name == 'removed.txt':
            for name in file.read_text().split():
                (target / name).unlink()
        elif file.name != 'expected.txt':
            shutil.copy(file, target)
    for name, data in GENERATED.get(case, {}).items():
        (target / name).write_bytes(data)
    return target


def said(case, folder):
    """Return check and messages, one line a mistake or warning, without places of this machine."""
    check = check_robot(str(broken_robot(case, folder)), strict=True)
    lines = [f'{one.severity.value}: {one}' for one in check.problems
             if one.severity in (Severity.ERROR, Severity.WARNING)]
    lines = [re.sub('searched: .*?; clone', 'searched: ...; clone', line) for line in lines]
    places = {f'{folder}/': '', str(folder): '.', f'{share_folder(PACKAGE)}/': '',
              str(share_folder(PACKAGE)): '.'}
    for place, shown in places.items():
        lines = [line.replace(place, shown) for line in lines]
    return check, lines


@pytest.mark.parametrize('case', CASES)
def test_a_mistake_is_told_in_the_expected_words(case, tmp_path):
    """One message a mistake, with place and remedy; nothing is raised, nothing hangs."""
    check, lines = said(case, tmp_path)
    assert lines == (BROKEN / case / 'expected.txt').read_text(encoding='utf-8').splitlines()
    assert exit_status(check) == (1 if case in WARNED_ONLY else 2)
    assert 'Traceback' not in ''.join(lines)
