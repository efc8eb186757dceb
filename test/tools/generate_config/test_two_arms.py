"""The same arm twice in one world: one URDF with prefixes, two groups, two controllers."""

import re

import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.model.description.xacro_text import read_description
from armsim_ros.resources import PACKAGE, share_folder
from armsim_ros.stack import ArmSim
from armsim_ros.tools.generate_config.main import generate_config

#: Arm -> where it stands on the table [m].
PLACES = {'left': '0 0.25 0', 'right': '0 -0.25 0'}


def arm_with_prefix(text, side):
    """Return links and joints of a URDF with another name each, and a joint to the table."""
    inside = re.sub(r'^.*?<robot[^>]*>|</robot>\s*$', '', text, flags=re.DOTALL)
    inside = re.sub(r'<material[^>]*/>|<material.*?</material>', '', inside, flags=re.DOTALL)
    inside = re.sub(r'(name|link|joint)="([^"]+)"', rf'\1="{side}_\2"', inside)
    root = f'{side}_base_link'
    return (f'{inside}<joint name="{side}_mount" type="fixed"><parent link="table"/>'
            f'<child link="{root}"/><origin xyz="{PLACES[side]}"/></joint>')


@pytest.fixture(scope='module')
def pair(tmp_path_factory):
    """Return two arms that stand half a metre apart, with generated files."""
    folder = tmp_path_factory.mktemp('pair')
    text = read_description(share_folder(PACKAGE) / 'urdf' / 'bot.urdf.xacro')
    arms = ''.join(arm_with_prefix(text, side) for side in PLACES)
    (folder / 'pair.urdf').write_text(f'<robot name="pair"><link name="table"/>{arms}</robot>')
    generate_config(folder / 'pair.urdf', folder / 'pair', states=2000)
    return folder / 'pair'


def test_each_arm_has_its_group_and_controller(pair):
    """Two arms are found, and both hold still."""
    both = ArmSim(pair)
    both.step(100)
    assert list(both.model.semantic.groups) == ['left_arm', 'right_arm']
    assert {'left_arm_controller', 'right_arm_controller'} <= set(both.manager.controllers)


def test_both_move_at_once(pair):
    """Two trajectories for two controllers."""
    both = ArmSim(pair)
    both.step(100)
    goals = {side: {f'{side}_joint2': 0.3, f'{side}_joint3': 0.4} for side in PLACES}
    sent = []
    for side, goal in goals.items():
        sent += both.send_trajectory(both.plan(
            {**named(both, side), **goal}, f'{side}_arm', velocity=0.5))
    both.run_until(lambda: all(one.done for one in sent), timeout=20.0)
    for goal in goals.values():
        assert all(abs(both.joint_positions[name] - value) < 0.01 for name, value in goal.items())


def test_each_plan_knows_where_the_other_arm_is(pair):
    """What is free for one arm alone is refused while the other stands in it."""
    both = ArmSim(pair)
    both.step(100)
    # Both lean towards -y: the left one into the place where the right one stands.
    leaning = {side: {**named(both, side), f'{side}_joint1': -1.5708, f'{side}_joint2': 1.0,
                      f'{side}_joint3': 0.6} for side in PLACES}
    with pytest.raises(PlanningError, match=r"'left_link\d' with 'right_link\d'"):
        both.plan(leaning['left'], 'left_arm')
    both.execute(both.plan(leaning['right'], 'right_arm', velocity=0.5))
    both.execute(both.plan(leaning['left'], 'left_arm', velocity=0.5))
    assert both.joint_positions['left_joint2'] == pytest.approx(1.0, abs=0.01)


def named(both, side):
    """Return the present positions of one arm's joints [rad]."""
    return {name: both.joint_positions[name]
            for name in both.model.group(f'{side}_arm').active_joints}
