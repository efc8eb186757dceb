# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 param`` and ``ros2 control``: form, status and words of ros2cli and ros2controlcli."""

import yaml

NODE = '/sunday/arm_joint_controller'
MANAGER = ('-c', '/sunday/controller_manager')


def test_parameters_are_listed(ros2):
    """Two blanks before each name; types, prefixes and a filter (ros2param/verb/list.py)."""
    names = ros2('param', 'list', '/move_group').lines
    assert names == sorted(names)
    assert '  use_sim_time' in names
    typed = ros2('param', 'list', '/move_group', '--param-type').lines
    assert [line.partition(' (type: ')[0] for line in typed] == names
    assert '  use_sim_time (type: boolean)' in typed
    assert ros2('param', 'list', '/move_group', '--filter', 'use_sim').lines == ['  use_sim_time']
    assert '/move_group:' in ros2('param', 'list').lines
    done = ros2('param', 'list', '/nope')
    assert (done.status, done.out, done.err) == (1, '', "Node not found: '/nope'\n")


def test_parameters_are_read_and_set(ros2):
    """A refused value and a missing parameter are status 0, as upstream."""
    get = ('param', 'get', '/move_group')
    assert ros2(*get, 'use_sim_time').out.startswith('Boolean value is: ')
    assert ros2(*get, 'use_sim_time', '--hide-type').out in ('True\n', 'False\n')
    done = ros2(*get, 'use_sim_tim')
    assert (done.status, done.out) in ((0, 'Parameter not set.\n'), (1, ''))
    assert "did you mean 'use_sim_time'?" in done.err
    done = ros2('param', 'set', '/move_group', 'use_sim_time', 'abc')
    assert (done.status, done.out) == (0, '')
    assert done.err.startswith('Setting parameter failed: ')
    speed = ('/simulation', 'real_time_factor', '1.0')
    assert ros2('param', 'set', *speed).out.startswith('Set parameter successful')
    done = ros2('param', 'delete', '/move_group', 'use_sim_time')
    assert (done.status, done.out) == (0, '')
    assert done.err.startswith('Deleting parameter failed')
    assert ros2('param', 'describe', '/move_group', 'use_sim_time').out.startswith(
        'Parameter name: use_sim_time\n  Type: boolean\n')


def test_a_dump_can_be_loaded(ros2, tmp_path):
    """The text of dump is a parameter file (ros2param/verb/dump.py, load.py)."""
    text = ros2('param', 'dump', NODE).out
    values = yaml.safe_load(text)[NODE]['ros__parameters']
    assert values['joints'][0] == 'joint_1'
    file = tmp_path / 'dump.yaml'
    file.write_text('/**:\n  ros__parameters:\n    real_time_factor: 1.0\n')
    assert ros2('param', 'load', '/simulation', str(file)).out == (
        'Set parameter real_time_factor successful\n')
    assert ros2('param', 'load', '/simulation', '/nope.yaml').status == 1


def test_controllers_and_hardware_are_listed(ros2):
    """The only manager of the graph is taken without -c; what is claimed is shown as claimed."""
    done = ros2('control', 'list_controllers')
    assert done.err == 'using the controller manager /sunday/controller_manager\n'
    row = next(line for line in done.lines if line.startswith('arm_joint_controller'))
    assert row.split() == ['arm_joint_controller',
                           'joint_trajectory_controller/JointTrajectoryController', 'active']
    text = ros2('control', 'list_controllers', '-v', *MANAGER).out
    assert '\tupdate_rate: ' in text
    assert '\tclaimed interfaces:\n\t\tjoint_1/position\n' in text
    types = ros2('control', 'list_controller_types', *MANAGER).lines
    assert f'{"joint_trajectory_controller/JointTrajectoryController":70s} ' \
        'controller_interface::ControllerInterface' in types
    text = ros2('control', 'list_hardware_components', '-v', *MANAGER).out
    assert text.startswith('Hardware Component 1\n\tname: ')
    assert '\t\tjoint_1/position [double] [available] [claimed]\n' in text
    lines = ros2('control', 'list_hardware_interfaces', *MANAGER).lines
    assert lines[0] == 'command interfaces'
    assert '\tjoint_1/position [available] [claimed]' in lines
    assert '\tjoint_1/velocity' in lines[lines.index('state interfaces'):]


def test_controllers_are_switched(ros2):
    """set_controller_state and switch_controllers, and what is refused."""
    name = 'arm_joint_controller'
    state = ('control', 'set_controller_state', name)
    assert ros2(*state, 'inactive', *MANAGER).out == f'Successfully deactivated {name}\n'
    assert ros2('control', 'switch_controllers', '--activate', name, '--strict',
                *MANAGER).status == 0
    done = ros2(*state, 'unconfigured', *MANAGER)
    assert (done.status, done.err) == (1, f'cannot cleanup {name} from its current state active\n')
    done = ros2('control', 'set_controller_state', 'arm_joint_controler', 'active', *MANAGER)
    assert (done.status, done.err) == (1, 'controller arm_joint_controler does not seem to be '
                                          f"loaded; did you mean '{name}'?\n")
    done = ros2('control', 'unload_controller', 'nope', *MANAGER)
    assert (done.status, done.out) == (
        1, 'Error unloading controller nope, check controller_manager logs\n')
    done = ros2('control', 'load_controller', name, *MANAGER)
    assert done.out == f'Controller : {name} already loaded, skipping load_controller!\n'
