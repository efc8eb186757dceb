"""What a URDF says for Gazebo, beside the controllers of the files."""

import shutil

import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.errors import Severity
from armsim_ros.model.loading import survey_robot_model
from armsim_ros.resources import find_robot, PACKAGE, share_folder


@pytest.fixture
def leg(tmp_path):
    """Return a function that changes the leg's URDF and tells what is said of it."""
    folder = tmp_path / 'leg'
    shutil.copytree(find_robot('leg'), folder)
    source = share_folder(PACKAGE) / 'urdf' / 'leg.urdf.xacro'

    def say(old='', new='', **arguments):
        text = source.read_text()
        assert old in text
        (folder / source.name).write_text(text.replace(old, new, 1) if old else text)
        _, found = survey_robot_model(load_robot_settings(str(folder), **arguments))
        return [str(one) for one in found if one.severity in (Severity.WARNING, Severity.CHANGED)]

    return say


PLUGIN = '<gazebo><plugin name="c"><robotNamespace>/walker</robotNamespace></plugin></gazebo>'


def test_nothing_is_said_where_both_fit(leg):
    """PositionJointInterface, a position controller, no namespace anywhere."""
    assert leg() == []


def test_the_namespace_of_the_plugin_is_compared(leg):
    """Where the files have another one, the user reads how to get the plugin's."""
    (text,) = leg('</robot>', f'{PLUGIN}</robot>')
    assert "robotNamespace is '/walker', the controllers run in '/'" in text
    assert 'namespace:=walker' in text
    chosen = leg('</robot>', f'{PLUGIN}</robot>', namespace='walker')
    assert not any('robotNamespace' in one for one in chosen)


def test_the_hardware_interface_is_compared(leg):
    """O8: what ros_control would refuse is told, and runs."""
    (text,) = leg('PositionJointInterface', 'EffortJointInterface')
    assert "controller 'group_controller' commands position of joint 'hip', whose transmission " \
        'offers effort; ros_control would not start it' in text


@pytest.mark.parametrize('kind', ['PosVelJointInterface', 'hardware_interface/'
                                  'PositionJointInterface'])
def test_interfaces_that_include_the_command(kind, leg):
    """Both spellings, and interfaces for several commands."""
    assert leg('PositionJointInterface', kind) == []
