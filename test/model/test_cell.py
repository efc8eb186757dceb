"""Several robots as one: their names, their places, what touches what."""

import shutil

import numpy as np
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.errors import ConfigError, Severity
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.cell import prefixed_urdf
from armsim_ros.model.cell_loading import load_cell, survey_cell
from armsim_ros.model.description.urdf import parse_urdf
from armsim_ros.model.description.xml_tree import parse_xml, xml_text
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import inverse_pose, pose_matrix
from armsim_ros.model.tree import link_poses
from armsim_ros.resources import cell_names, find_robot, PACKAGE, share_folder
from armsim_ros.sim.camera import cameras_of

TWO = 'robots:\n  left: {robot: bot, xyz: [0, 0.25, 0]}\n  right: {robot: bot, xyz: [0, -1, 0]}\n'


class CellFiles:
    """A cell's folder with a copy of bot inside."""

    def __init__(self, folder):
        self.folder = folder
        shutil.copytree(find_robot('bot'), folder / 'bot')
        shutil.copy(share_folder(PACKAGE) / 'urdf' / 'bot.urdf.xacro', folder / 'bot')
        self.write('robots.yaml', TWO)

    def write(self, name, text):
        """Write a file."""
        (self.folder / name).write_text(text)
        return self

    def load(self, **arguments):
        """Return the cell."""
        return load_cell(str(self.folder), **arguments)

    def told(self, *severities):
        """Return the messages of some severities, with the folder's path left out."""
        return [str(one).replace(f'{self.folder}/', '')
                for one in survey_cell(str(self.folder)).problems if one.severity in severities]


@pytest.fixture
def cell(tmp_path):
    """Return the files of a cell."""
    return CellFiles(tmp_path)


def test_one_robot_is_a_cell_of_one():
    """Nothing of it is copied or renamed."""
    single = load_cell('bot')
    (robot,) = single.robots
    assert robot.model is single.model
    assert robot.settings is single.settings
    assert robot.name == 'bot'


def test_each_robot_stands_where_the_file_says(cell):
    """On the link 'world', by a fixed joint; the arm itself is as it is alone."""
    whole = cell.load().model
    assert whole.model_frame == whole.root_link == 'world'
    alone = link_poses(load_robot_model(load_robot_settings('bot')), {'joint2': 0.4})
    poses = link_poses(whole, {'left_joint2': 0.4})
    for link, pose in alone.items():
        moved = pose.copy()
        moved[1, 3] += 0.25
        np.testing.assert_allclose(poses[f'left_{link}'], moved, atol=1e-12)
    assert poses['right_tool'][1, 3] == pytest.approx(-1.0)


def test_without_a_place_its_own_counts(cell):
    """The magician stands on its pedestal, in a cell too."""
    cell.write('robots.yaml', 'robots:\n  a: {robot: magician}\n  b: {robot: bot, xyz: [1, 0, 0]}')
    found = cell.load()
    base = link_poses(found.model, {})[found.robots[0].model.root_link]
    assert base[2, 3] == pytest.approx(0.14)


VIRTUAL = ('<virtual_joint name="v" type="fixed" parent_frame="world" '
           'child_link="base_link"/></robot>')


def test_a_camera_beside_a_robot_moves_with_it(cell):
    """It sees the robot as it does alone, wherever the cell places the robot."""
    srdf = cell.folder / 'bot' / 'bot.srdf'
    srdf.write_text(srdf.read_text().replace('</robot>', VIRTUAL))
    with (cell.folder / 'bot' / 'simulation.yaml').open('a') as file:
        file.write('placement: {xyz: [0, 0, 0.5], rpy: [0, 0, 1.5]}\ncameras:\n'
                   '  front: {link: world, xyz: [1.5, 0, 1.6], rpy: [0, 0.3, 3.1]}\n')
    cell.write('robots.yaml', 'robots: {left: {robot: bot, xyz: [0, 2, 0], rpy: [0, 0.5, 0]}}')
    alone = load_cell(str(cell.folder / 'bot'))
    (camera,) = cameras_of(alone.settings.simulation.cameras, alone.model)
    assert camera.body == 'world'
    placement = alone.settings.simulation.placement
    of_base = inverse_pose(pose_matrix(placement.xyz, placement.rpy)) @ camera.optical_pose
    whole = cell.load()
    (camera,) = cameras_of(whole.settings.simulation.cameras, whole.model)
    assert (camera.name, camera.parent) == ('left_front', 'left_base_link')
    np.testing.assert_allclose(camera.optical_pose, of_base, atol=1e-12)


@pytest.mark.parametrize('name', cell_names())
def test_the_texts_say_the_same_as_the_model(name):
    """The URDF of the whole and of each robot, read again: the same links, joints, places."""
    found = load_cell(name)
    for model in (found.model, *(robot.model for robot in found.robots)):
        again = parse_urdf(model.urdf, 'text', read_mesh=None)
        assert list(again.links) == list(model.links)
        assert list(again.joints) == list(model.joints)
        for joint, other in zip(again.joints.values(), model.joints.values(), strict=True):
            np.testing.assert_allclose(joint.origin, other.origin, atol=1e-9)
            assert (joint.type, joint.parent, joint.child, joint.mimic) == (
                other.type, other.parent, other.child, other.mimic)


def test_groups_states_and_pairs_of_all_robots(cell):
    """Each group with its prefix, named states by group, disabled pairs within each robot."""
    semantic = cell.load().model.semantic
    assert list(semantic.groups) == ['left_arm', 'right_arm']
    assert semantic.groups['left_arm'].chain == ('left_base_link', 'left_tool')
    assert semantic.named_states['right_arm']['ready']['right_joint3'] == 1.4
    assert ('left_link1', 'left_link2') in semantic.disabled_collisions
    assert not [pair for pair in semantic.disabled_collisions
                if pair[0].partition('_')[0] != pair[1].partition('_')[0]]


def test_each_robot_has_its_part_of_the_whole(cell):
    """Its own root, its own names, in the order that they have in the whole."""
    whole = cell.load()
    names = [name for robot in whole.robots for name in robot.model.movable_joints]
    assert tuple(names) == whole.model.movable_joints
    assert [robot.model.root_link for robot in whole.robots] == [
        'left_base_link', 'right_base_link']
    assert list(whole.robots[0].model.semantic.groups) == ['left_arm']


def test_an_srdf_of_the_cell_adds_groups_and_pairs(cell):
    """A group over both arms, and two links that need no check."""
    cell.write('cell.srdf', '<robot name="cell"><group name="both"><group name="left_arm"/>'
               '<group name="right_arm"/></group><disable_collisions link1="left_link1" '
               'link2="right_link1" reason="Never"/></robot>')
    semantic = cell.load().model.semantic
    assert len(semantic.groups['both'].active_joints) == 10
    assert ('left_link1', 'right_link1') in semantic.disabled_collisions


def test_mistakes_in_the_srdf_of_the_cell_have_their_line(cell):
    """Those of the robots' own are told where they are read, and once."""
    cell.write('cell.srdf', '<robot name="cell">\n  <group name="both">\n'
               '    <group name="left_am"/>\n    <group name="right_arm"/>\n  </group>\n</robot>')
    (found,) = [text for text in cell.told(Severity.WARNING) if 'cell.srdf' in text]
    assert "cell.srdf:3:5: planning group 'both' contains 'left_am'" in found
    assert "did you mean 'left_arm'?" in found


def test_a_robot_without_disabled_pairs_gets_its_neighbours(cell):
    """As when it runs alone, though other robots have pairs."""
    (cell.folder / 'plain').mkdir()
    shutil.copy(cell.folder / 'bot' / 'bot.urdf.xacro', cell.folder / 'plain' / 'plain.urdf.xacro')
    cell.write('robots.yaml', 'robots: {a: {robot: bot}, b: {robot: plain, xyz: [1, 0, 0]}}')
    pairs = cell.load().model.semantic.disabled_collisions
    assert ('b_link1', 'b_link2') in pairs


def test_links_that_are_not_checked_are_checked_against_other_robots(cell):
    """disable_default_collisions holds within its robot."""
    srdf = cell.folder / 'bot' / 'bot.srdf'
    srdf.write_text(srdf.read_text().replace(
        '</robot>', '<disable_default_collisions link="link5"/></robot>'))
    semantic = cell.load().model.semantic
    assert 'left_link5' in semantic.default_disabled
    assert ('left_link5', 'right_link3') in semantic.enabled_collisions
    assert ('left_link3', 'left_link5') not in semantic.enabled_collisions


@pytest.mark.parametrize(('robots', 'said'), [
    ("a: {robot: bot, prefix: ''}\n  b: {robot: bot, prefix: ''}",
     "robots.yaml:3:3: link 'base_link' is in robot 'a' and in robot 'b'; give 'b' a prefix"),
    ('a: {robot: bott}', "robots.yaml:2:7: robot 'bott' is neither a folder from"),
    ('a: {robot: ../../../etc}', "robots.yaml:2:7: robot '../../../etc' is neither"),
    ('a: {robot: /etc}', "robots.yaml:2:7: file '/etc' lies outside of the robot's folders"),
])
def test_robots_that_do_not_fit(cell, robots, said):
    """One line with the place in robots.yaml and what to do."""
    cell.write('robots.yaml', f'robots:\n  {robots}\n')
    (found,) = cell.told(Severity.ERROR)
    assert said in found


def test_a_link_named_world_needs_a_prefix(cell):
    """All robots stand on a link of that name."""
    urdf = cell.folder / 'bot' / 'bot.urdf.xacro'
    urdf.write_text(urdf.read_text().replace('"base_link"', '"world"'))
    srdf = cell.folder / 'bot' / 'bot.srdf'
    srdf.write_text(srdf.read_text().replace('"base_link"', '"world"'))
    assert 'left_world' in cell.load().model.links
    cell.write('robots.yaml', "robots: {a: {robot: bot, prefix: ''}}")
    (found,) = cell.told(Severity.ERROR)
    assert ("link 'world' of robot 'a' has the name of the link that all robots are mounted on"
            in found)


def test_mistakes_of_a_robot_keep_their_file_and_line(cell):
    """With the names that its own files have; once, though two robots share the folder."""
    limits = cell.folder / 'bot' / 'joint_limits.yaml'
    limits.write_text('joint_limits:\n  joint1: {max_velocity: -1}\n')
    (found,) = cell.told(Severity.ERROR)
    assert found.startswith('bot/joint_limits.yaml:2:')


def test_mistakes_of_all_robots_at_once(cell):
    """A broken SRDF of one, an unknown limit in the cell's own file, a robot that is not there."""
    (cell.folder / 'bot' / 'bot.srdf').write_text('<robot name="bot"><group name="arm"><chain '
                                                  'base_link="a" tip_link="b"/></group></robot>')
    cell.write('robots.yaml', 'robots: {a: {robot: bot}, b: {robot: nobody}}')
    cell.write('limits.yaml', 'joint_limits: {a_joint1: {max_velocity: -1}}')
    told = '\n'.join(cell.told(Severity.ERROR))
    for said in ("bot/bot.srdf:1:1: none of the planning groups arm fits robot 'bot'",
                 "robot 'nobody' is neither a folder from", 'limits.yaml:1:'):
        assert said in told


def test_the_cells_own_files_are_checked_against_the_whole(cell):
    """A joint or group that no robot has is a warning with its line."""
    cell.write('more.yaml', 'joint_limits:\n  left_joint9: {max_velocity: 1}\n'
               'left_am:\n  kinematics_solver_timeout: 0.1\n')
    told = '\n'.join(cell.told(Severity.WARNING))
    assert "more.yaml:2:3: joint limits: joint 'left_joint9' is not in the URDF" in told
    assert "more.yaml:3:1: kinematics: planning group 'left_am' is not in the SRDF" in told


def test_limits_of_the_cell_bound_its_plans(cell):
    """The cell's values replace those of the robots' files, each for itself."""
    limits = cell.folder / 'bot' / 'joint_limits.yaml'
    limits.write_text('joint_limits:\n  joint1: {has_velocity_limits: true, max_velocity: 1.5, '
                      'has_acceleration_limits: true, max_acceleration: 4}\n')
    cell.write('limits.yaml', 'joint_limits: {left_joint1: {max_velocity: 0.5}}')
    whole = cell.load()
    planned = planning_robot(whole.model, whole.settings.joint_limits).joints
    assert planned['left_joint1'].limits.velocity == 0.5
    assert planned['left_joint1'].limits.acceleration == 4.0
    assert planned['right_joint1'].limits.velocity == 1.5
    assert whole.model.joints['left_joint1'].limits.velocity == 2.5
    assert whole.robots[0].model.joints['left_joint1'].limits.velocity == 2.5


def test_where_the_joints_start(cell):
    """Each robot as its own files say; the cell's simulation.yaml wins."""
    simulation = cell.folder / 'bot' / 'simulation.yaml'
    simulation.write_text('initial_state: arm/ready\n')
    cell.write('simulation.yaml', 'initial_positions: {right_joint3: 0.7}')
    start = cell.load().settings.simulation.initial_positions
    assert (start['left_joint3'], start['right_joint3'], start['right_joint2']) == (1.4, 0.7, -0.5)
    simulation.write_text('initial_state: arm/redy\n')
    found = cell.told(Severity.ERROR)
    assert "bot/simulation.yaml:1:1: the initial state 'left_arm/redy'" in found[0]


def test_a_namespace_for_the_whole_is_refused(cell):
    """The message says where each robot gets its own."""
    with pytest.raises(ConfigError, match=r"robots\.yaml: namespace 'x' is given for a cell"):
        survey_cell(str(cell.folder), namespace='x')


def test_what_others_read_keeps_its_names():
    """Gazebo's own elements are left alone, but for the link that they speak of."""
    text = ('<robot name="r"><gazebo reference="a"><joint name="x"/></gazebo>'
            '<transmission name="t"><joint name="j"/></transmission></robot>')
    gazebo, transmission = prefixed_urdf(text, 'f', 'p_').children
    assert (gazebo.get('reference'), gazebo.children[0].get('name')) == ('p_a', 'x')
    assert (transmission.get('name'), transmission.children[0].get('name')) == ('p_t', 'p_j')


def test_an_element_and_its_text():
    """What is written is read again: attributes, signs that XML escapes, text."""
    root = parse_xml('<a x="1 &lt; &quot;2&quot;"><b>text &amp; more</b><c/></a>', 'f')
    again = parse_xml(xml_text(root), 'f')
    assert again.attributes == root.attributes
    assert [(one.tag, one.content) for one in again.children] == [('b', 'text & more'), ('c', '')]
