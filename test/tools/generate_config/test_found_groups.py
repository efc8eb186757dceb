"""Groups and grippers found from the tree of a URDF."""

import pytest

from armsim_ros.resources import PACKAGE, share_folder
from armsim_ros.tools.generate_config.found_groups import find_groups
from armsim_ros.tools.generate_config.main import read_urdf


def groups_of_text(text, folder):
    """Return the groups of a URDF."""
    file = folder / 'robot.urdf'
    file.write_text(text)
    return find_groups(read_urdf(file))


def urdf(*joints):
    """Return a URDF from (name, parent, child, type) of its joints."""
    links = dict.fromkeys(name for joint in joints for name in joint[1:3])
    shape = '<collision><geometry><sphere radius="0.01"/></geometry></collision>'
    inertial = ('<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" '
                'ixz="0" iyz="0"/></inertial>')
    parts = [f'<link name="{name}">{inertial}{shape}</link>' for name in links]
    for name, parent, child, kind in joints:
        parts.append(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            '<origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>')
    return f"<robot name='robot'>{''.join(parts)}</robot>"


ARM = [('a', 'base', 'l1', 'revolute'), ('b', 'l1', 'l2', 'revolute'),
       ('c', 'l2', 'l3', 'revolute')]


@pytest.mark.parametrize(('robot', 'expected'), [
    ('sunday', [('arm', 6, ('base_link', 'link_6'))]),
    ('bot', [('arm', 5, ('base_link', 'tool'))]),
    ('ROBOT', [('arm', 6, ('base_link', 'tool')), ('gripper', 2, None)]),
    ('leg', [('arm', 3, ('frame', 'sole'))]),
    ('magician', [('arm', 3, ('magician_base', 'magician_end_effector'))]),
    ('elfin', [('arm', 6, ('elfin_base_link', 'elfin_end_link'))]),
    ('ur5', [('arm', 6, ('base_link', 'tool0'))]),
])
def test_the_robots_of_this_package(robot, expected):
    """Arms end at their tool frames; joints that follow others are no variables."""
    groups = find_groups(read_urdf(share_folder(PACKAGE) / 'urdf' / f'{robot}.urdf.xacro'))
    assert [(one.name, len(one.active_joints), one.chain) for one in groups] == expected


def test_fingers_below_a_palm_are_a_gripper(tmp_path):
    """The arm ends at the link that carries the palm."""
    arm, gripper = groups_of_text(urdf(
        *ARM, ('mount', 'l3', 'flange', 'fixed'), ('hold', 'flange', 'palm', 'fixed'),
        ('f1', 'palm', 'finger1', 'prismatic'), ('f2', 'palm', 'finger2', 'prismatic')), tmp_path)
    assert arm.chain == ('base', 'flange')
    assert gripper.joints == ('f1', 'f2')
    assert (gripper.parent, gripper.parent_link) == ('arm', 'flange')


def test_a_jaw_at_the_end_of_the_chain_is_a_gripper(tmp_path):
    """Its name tells it from the arm's joints."""
    arm, gripper = groups_of_text(urdf(*ARM, ('gripper', 'l3', 'jaw', 'revolute')), tmp_path)
    assert arm.joints == ('a', 'b', 'c')
    assert gripper.joints == ('gripper',)
    assert gripper.parent_link == 'l3'


def test_two_arms_on_one_body(tmp_path):
    """Each bears the word with which its joints begin."""
    sides = [(f'{side}_{name}', 'base' if parent == 'base' else f'{side}_{parent}',
              f'{side}_{child}', kind)
             for side in ('left', 'right') for name, parent, child, kind in ARM]
    groups = groups_of_text(urdf(*sides), tmp_path)
    assert [one.name for one in groups] == ['left_arm', 'right_arm']
    assert groups[0].joints == ('left_a', 'left_b', 'left_c')


def test_two_arms_on_a_turning_body(tmp_path):
    """The body's joint belongs to neither."""
    sides = [(f'{side}_{name}', 'body' if parent == 'base' else f'{side}_{parent}',
              f'{side}_{child}', kind)
             for side in ('left', 'right') for name, parent, child, kind in ARM]
    groups = groups_of_text(urdf(('turn', 'base', 'body', 'revolute'), *sides), tmp_path)
    assert [one.name for one in groups] == ['left_arm', 'right_arm']
    assert not any('turn' in one.joints for one in groups)


def test_few_joints_are_a_group_too(tmp_path):
    """The longest chain is the group where none is an arm."""
    (group,) = groups_of_text(urdf(*ARM[:2]), tmp_path)
    assert group.joints == ('a', 'b')
