"""What check_config prints, and the status with which it ends."""

import shutil

import pytest

from armsim_ros.resources import find_robot, PACKAGE, share_folder
from armsim_ros.tools.check_config.main import main


@pytest.fixture
def user(tmp_path):
    """Return a folder with the files of ROBOT, whose launch file lies beside them."""
    folder = tmp_path / 'ROBOT'
    shutil.copytree(find_robot('ROBOT'), folder)
    shutil.copy(share_folder(PACKAGE) / 'urdf' / 'ROBOT.urdf.xacro', folder)
    (folder / 'robot.launch').write_text("""<launch>
  <arg name="gui" default="true"/>
  <node name="spawner" pkg="controller_manager" type="spawner" args="ROBOT_join_controller"/>
</launch>
""")
    return folder


def test_all_is_well(capsys):
    """The default robot: files, keys, coverage, status 0."""
    assert main(['sunday']) == 0
    text = capsys.readouterr().out
    assert "robot 'sunday'" in text
    assert 'keys: ' in text
    assert 'manipulator (joint_1, joint_2, joint_3, joint_4, joint_5, joint_6): ' \
        'sunday/arm_joint_controller' in text
    assert text.endswith('result: all is well\n')


def test_a_group_over_several_controllers(user, capsys):
    """The coverage names the set of controllers that one plan is split over."""
    (user / 'robot.launch').unlink()
    assert main([str(user)]) == 0
    assert 'arm_and_gripper (j1, j2, j3, j4, j5, j6, finger_j1, finger_j2): ' \
        'ROBOT/ROBOT_gripper_controller, ROBOT/ROBOT_joint_controller' in capsys.readouterr().out


def test_launch_files_are_answered_and_their_slips_told(user, capsys):
    """Each line has what stands in for it; a name that nothing describes is a warning."""
    assert main([str(user)]) == 1
    text = capsys.readouterr().out
    assert f"{user}/robot.launch:2:3: argument 'gui': the simulation has no window" in text
    assert "did you mean 'ROBOT_joint_controller'?" in text
    assert text.endswith('result: 0 errors, 1 warning\n')


def test_the_flags_of_spawn_model_become_arguments(user, capsys):
    """Each flag takes as many values as upstream's (gazebo_ros/scripts/spawn_model)."""
    (user / 'robot.launch').write_text("""<launch>
  <node name="spawn" pkg="gazebo_ros" type="spawn_model" args="-urdf -param robot_description
    -gazebo_namespace /gazebo -reference_frame world -unpause -wait table -package_to_model -b
    -database none -model arm -namespace /left -x 1 -y 2 -z 3 -Y 1.5 -J j1 0.5 -J j2 -0.5
    -speed"/>
</launch>
""")
    main([str(user)])
    text = capsys.readouterr().out
    assert ('bringup robot:=arm namespace:=left x:=1 y:=2 z:=3 initial_positions:=j1=0.5,j2=-0.5, '
            'and placement: {rpy: [0.0, 0.0, 1.5]} in simulation.yaml') in text
    assert "'-speed' is not a flag of spawn_model" in text
    assert text.count('is not a flag of spawn_model') == 1


def test_each_key_with_what_it_does(user, capsys):
    """--keys lists used, changed and unused keys with file and line."""
    main([str(user), '--keys'])
    lines = capsys.readouterr().out.splitlines()
    file = user / 'trajectory_control.yaml'
    assert f'  used             {file}:4:5: ROBOT.ROBOT_joint_controller.joints: ' \
        '[j1, j2, j3, j4, j5, j6]' in lines
    changed = [line for line in lines if line.startswith('  changed meaning') and '.type' in line]
    assert changed
    assert any(line.startswith('  not used here') and 'controller_manager_ns' in line
               for line in lines)


def test_mistakes_of_all_files_at_once(user, capsys):
    """YAML, SRDF and URDF are read on; status 2."""
    for name, old, new in (('joint_limits.yaml', 'max_velocity: 0.2', 'max_velocity: fast'),
                           ('kinematics.yaml', 'timeout', 'tiemout'),
                           ('ROBOT.urdf.xacro', '<robot', '<robot <')):
        text = (user / name).read_text()
        (user / name).write_text(text.replace(old, new, 1))
    assert main([str(user)]) == 2
    text = capsys.readouterr().out
    for name in ('joint_limits.yaml', 'kinematics.yaml', 'ROBOT.urdf.xacro'):
        assert f'{user}/{name}:' in text
    assert "did you mean 'kinematics_solver_timeout'?" in text


@pytest.mark.parametrize(('name', 'status'), [
    ('trajectory_control.yaml', 0), ('ROBOT.urdf.xacro', 0), ('robot.launch', 0)])
def test_a_single_file(user, name, status, capsys):
    """A file is checked by itself."""
    assert main([str(user / name)]) == status
    assert 'result: ' in capsys.readouterr().out


def test_a_robot_that_is_not_there(capsys):
    """The robots that there are, and the nearest name."""
    assert main(['sundai']) == 2
    assert "did you mean 'sunday'?" in capsys.readouterr().out


def test_keys_in_lists_of_blocks_have_the_number_of_their_block(user, capsys):
    """--keys tells them apart."""
    (user / 'sensors_3d.yaml').write_text("""
upper:
  lists:
    - {name: first}
    - {name: second}
""")
    main([str(user), '--keys'])
    text = capsys.readouterr().out
    assert ': upper.lists[0].name: first\n' in text
    assert ': upper.lists[1].name: second\n' in text
