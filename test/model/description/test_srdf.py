"""SRDF: groups, states, end effectors and pairs, for the robot that is there."""

import pytest

from armsim_ros.errors import ModelError


def test_a_chain(make_model):
    """CFG-1: a chain holds the joints from base to tip, fixed ones too."""
    model, warnings = make_model(
        '<group name="arm"><chain base_link="base" tip_link="tool"/></group>')
    arm = model.group('arm')
    assert arm.joints == ('j1', 'j2', 'to_tool')
    assert arm.active_joints == ('j1', 'j2')
    assert arm.links == ('a', 'b', 'tool')
    assert arm.chain == ('base', 'tool')
    assert arm.tips == ('tool',)
    assert warnings == []


def test_the_order_is_that_of_the_tree(make_model):
    """CFG-3: the listing order does not matter; a link stands for the joint above it."""
    model, _ = make_model('<group name="g"><joint name="to_tool"/><link name="b"/>'
                          '<joint name="j1"/></group>')
    assert model.group('g').joints == ('j1', 'j2', 'to_tool')
    assert model.group('g').chain == ('base', 'tool')


def test_joints_links_and_chain_together(make_model):
    """CFG-1: any mix gives each joint once."""
    model, _ = make_model('<group name="g"><joint name="j1"/><link name="a"/>'
                          '<chain base_link="base" tip_link="b"/></group>')
    assert model.group('g').joints == ('j1', 'j2')


def test_a_gripper(make_model):
    """Two fingers: the mimic joint is no variable, both links are tips."""
    model, _ = make_model('<group name="hand"><joint name="finger_1"/><joint name="finger_2"/>'
                          '</group>')
    hand = model.group('hand')
    assert hand.active_joints == ('finger_1',)
    assert hand.chain is None
    assert hand.tips == ('left', 'right')


def test_a_chain_across_the_tree(make_model):
    """
    A chain may go up from its base and down to its tip.

    The joint above the common link is in it (robot_model.cpp: addJointModelGroup).
    """
    model, _ = make_model('<group name="g"><chain base_link="left" tip_link="right"/></group>')
    assert model.group('g').joints == ('to_tool', 'finger_1', 'finger_2')


ARM = '<group name="arm"><chain base_link="base" tip_link="tool"/></group>'
HAND = '<group name="hand"><joint name="finger_1"/><joint name="finger_2"/></group>'


def test_subgroups(make_model):
    """CFG-1: a group of groups, which may come later in the text."""
    model, _ = make_model('<group name="all"><group name="arm"/><group name="hand"/></group>',
                          ARM, HAND)
    assert model.group('all').active_joints == ('j1', 'j2', 'finger_1')


def test_subgroups_are_all_groups_inside_by_name(make_model):
    """Named in the group or not (robot_model.cpp: buildGroupsInfoSubgroups)."""
    model, _ = make_model('<group name="all"><group name="hand"/><group name="arm"/></group>',
                          ARM, HAND, '<group name="elbow"><joint name="j2"/></group>')
    assert model.group('all').subgroups == ('arm', 'elbow', 'hand')
    assert model.group('arm').subgroups == ('elbow',)


def test_cyclic_subgroups_are_dropped(make_model):
    """CFG-2: groups that contain each other are left out, the others stay."""
    model, warnings = make_model(ARM, '<group name="x"><group name="y"/></group>',
                                 '<group name="y"><group name="x"/></group>')
    assert list(model.semantic.groups) == ['arm']
    assert 'planning groups contain each other (x -> y -> x)' in warnings[0]


def test_a_passive_joint_is_a_variable_of_its_group(make_model):
    """joint_model_group.cpp (the constructor): only fixed and mimic joints are not active."""
    model, _ = make_model(ARM, '<passive_joint name="j2"/>')
    assert model.group('arm').active_joints == ('j1', 'j2')
    assert model.semantic.passive_joints == ('j2',)


def test_named_states(make_model):
    """CFG-2: a state may omit joints; what it cannot have is left out with a warning."""
    model, warnings = make_model(
        ARM, '<group_state name="up" group="arm"><joint name="j1" value="0.5"/></group_state>',
        '<group_state name="odd" group="arm"><joint name="j1" value="9"/>'
        '<joint name="jj" value="0"/><joint name="finger_1" value="0"/>'
        '<joint name="j2" value="much"/></group_state>',
        '<group_state name="lost" group="leg"/>')
    assert model.semantic.named_states == {'arm': {'up': {'j1': 0.5}, 'odd': {'j1': 9.0}}}
    assert all(one.startswith('r.srdf:4:') for one in warnings[:4])
    assert [one.split(': ', 1)[1] for one in warnings] == [
        "named state 'odd': 9 of joint 'j1' is outside its limits -1 .. 2; a goal at "
        'this state ends at the limit',
        "named state 'odd': joint 'jj' is not in the URDF; it is left out",
        "named state 'odd': joint 'finger_1' is not in group 'arm'; it is left out",
        "named state 'odd': value 'much' of joint 'j2' is not a finite number; it is "
        'left out',
        "named state 'lost' is left out: planning group 'leg' is not in the SRDF",
    ]


def test_the_parent_group_of_an_end_effector(make_model):
    """CFG-1: the smallest group that contains the parent link, where none is named."""
    model, _ = make_model(
        ARM, HAND, '<group name="wrist"><link name="tool"/></group>',
        '<end_effector name="e" parent_link="tool" group="hand"/>',
        '<end_effector name="f" parent_link="tool" group="hand" parent_group="arm"/>')
    assert model.semantic.end_effectors['e'].parent_group == 'wrist'
    assert model.semantic.end_effectors['f'].parent_group == 'arm'


def test_the_named_parent_group_may_contain_the_hand(make_model):
    """Any group with the parent link but the hand's own (buildGroupsInfoEndEffectors)."""
    model, warnings = make_model(
        ARM, HAND, '<group name="all"><group name="arm"/><group name="hand"/></group>',
        '<end_effector name="e" parent_link="tool" group="hand" parent_group="all"/>')
    assert model.semantic.end_effectors['e'].parent_group == 'all'
    assert warnings == []


def test_of_equal_parent_groups_the_first_by_name_carries_the_hand(make_model):
    """The groups are compared by name (buildGroupsInfoEndEffectors)."""
    model, _ = make_model(
        HAND, '<group name="wrist"><link name="tool"/></group>',
        '<group name="end"><link name="tool"/></group>',
        '<end_effector name="e" parent_link="tool" group="hand"/>')
    assert model.semantic.end_effectors['e'].parent_group == 'end'


@pytest.mark.parametrize(('kind', 'frame'), [
    ('fixed', 'base'), ('planar', 'world'), ('floating', 'world')])
def test_the_model_frame_with_a_virtual_joint(make_model, kind, frame):
    """CFG-1: the frame in which the robot moves, else the root link (constructJointModel)."""
    model, _ = make_model(f'<virtual_joint name="v" type="{kind}" parent_frame="world" '
                          'child_link="base"/>', ARM)
    assert (model.model_frame, model.parent_frame) == (frame, 'world')


@pytest.mark.parametrize(('written', 'kind', 'warnings'), [
    ('Floating', 'floating', 0), ('slider', 'fixed', 1)])
def test_the_type_of_a_virtual_joint(make_model, written, kind, warnings):
    """Capital letters do not matter; an unknown type is fixed (srdfdom: loadVirtualJoints)."""
    model, said = make_model(f'<virtual_joint name="v" type="{written}" parent_frame="world" '
                             'child_link="base"/>', ARM)
    assert model.semantic.virtual_joint.type == kind
    assert len(said) == warnings


def test_a_group_without_a_name_is_left_out(make_model):
    """The others count, with a warning (srdfdom: loadGroups)."""
    model, said = make_model(ARM, '<group><joint name="j1"/></group>')
    assert list(model.semantic.groups) == ['arm']
    assert said == ["r.srdf:3:1: <group> has no 'name'; it is left out"]


def test_a_virtual_joint_to_another_link_is_left_out(make_model):
    """Only the root link can be tied to the world."""
    model, warnings = make_model('<virtual_joint name="v" type="fixed" parent_frame="world" '
                                 'child_link="a"/>', ARM)
    assert model.model_frame == 'base'
    assert "its child link 'a' is not the root link 'base'" in warnings[0]


def test_collision_pairs(make_model):
    """CFG-1: pairs are sorted by name, with their reason."""
    model, warnings = make_model(
        ARM, '<disable_collisions link1="b" link2="a" reason="Adjacent"/>',
        '<enable_collisions link1="left" link2="a"/>', '<disable_default_collisions link="b"/>',
        '<disable_collisions link1="b" link2="c" reason="Never"/>')
    assert model.semantic.disabled_collisions == {('a', 'b'): 'Adjacent'}
    assert model.semantic.enabled_collisions == {('a', 'left')}
    assert model.semantic.default_disabled == {'b'}
    assert warnings == [
        "r.srdf:6:1: <disable_collisions> is left out: link 'c' is not in the URDF"]


def test_the_srdf_of_another_robot(make_model):
    """One error where nothing fits, a warning where only the name differs."""
    with pytest.raises(ModelError, match=r"r\.srdf:1:1: none of the planning groups arm fits "
                       r"robot 'r'.*is this the SRDF of another robot, 'ur5'\?"):
        make_model('<group name="arm"><chain base_link="base_link" tip_link="tool0"/></group>',
                   name='ur5')
    _, warnings = make_model(ARM, name='ur5')
    assert "the SRDF is for robot 'ur5', the URDF for 'r'" in warnings[0]


def test_names_that_are_not_there(make_model):
    """CFG-2: wrong names are left out, each with a warning and the nearest name."""
    model, warnings = make_model(
        ARM, '<group name="g"><joint name="to_tol"/><joint name="finger1"/><link name="x"/>'
        '<group name="ar"/></group>', '<grup name="z"/>')
    assert 'g' not in model.semantic.groups
    assert [one.split(': ', 1)[1] for one in warnings] == [
        "planning group 'g': joint 'to_tol' is not in the URDF; it is left out; did you mean "
        "'to_tool'?",
        "planning group 'g': joint 'finger1' is not in the URDF; it is left out; did you mean "
        "'finger_1'?",
        "planning group 'g': link 'x' is not in the URDF; it is left out",
        "planning group 'g' contains 'ar', which is not in the SRDF; did you mean 'arm'?",
        "planning group 'g' has no joints and is left out",
        "<grup> is not known and has no effect; did you mean 'group'?",
    ]


def test_of_two_states_with_one_name_the_last_counts(make_model):
    """
    A later state of the same group replaces the former one.

    moveit_core/robot_model/src/joint_model_group.cpp: addDefaultState.
    """
    state = '<group_state name="up" group="g"><joint name="{}" value="{}"/></group_state>'
    model, warnings = make_model('<group name="g"><joint name="j1"/><joint name="j2"/></group>'
                                 + state.format('j1', 0.1) + state.format('j2', 0.2))
    assert model.semantic.named_states['g']['up'] == {'j2': 0.2}
    assert any('the last is used' in text for text in warnings)
