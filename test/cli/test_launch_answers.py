"""The arguments of Gazebo's and MoveIt's launch files on our command line."""

import pytest

from armsim_ros.cli.arguments import parse_arguments, ProgramArguments, UsageError
from armsim_ros.cli.settings import cell_of


@pytest.mark.parametrize('words', [
    ['gui:=false'], ['headless:=true'], ['debug:=false'], ['use_gui:=false'], ['unpause:=true'],
    ['--headless'], ['--unpause'], ['rviz:=false'], ['recording:=false'],
])
def test_what_happens_anyhow_may_be_asked_for(words):
    """CFG-11: an argument whose value asks for what is done is taken."""
    assert parse_arguments(words) == ProgramArguments()


@pytest.mark.parametrize(('words', 'said'), [
    (['gui:=true'], 'watch it with RViz'),
    (['debug:=true'], 'start it alone'),
    (['world_name:=worlds/empty.world'], 'world:=NAME|FILE'),
    (['rviz:=true'], 'rviz2'),
    (['model:=x'], 'robot:=NAME|DIR'),
    (['-J', 'a', '1'], 'initial_positions:=JOINT=VALUE'),
    (['-z', '0.14'], 'z:=METRES'),
    (['-unpause'], 'paused:=true holds it'),
])
def test_the_others_are_answered_with_what_to_use(words, said):
    """CFG-11: one message that names the replacement."""
    with pytest.raises(UsageError) as caught:
        parse_arguments(words)
    assert said in str(caught.value)


def test_place_and_joints_of_the_spawner():
    """-x -y -z and -J of the spawner; axes that are not given stay."""
    cell, _ = cell_of(parse_arguments(
        ['robot:=magician', 'x:=0.5', 'initial_positions:=magician_joint2=0.9']))
    assert cell.settings.simulation.placement.xyz == (0.5, 0.0, 0.14)
    assert cell.settings.simulation.initial_positions == {
        'magician_joint1': 0.0, 'magician_joint2': 0.9, 'magician_joint3': 0.785}


@pytest.mark.parametrize(('word', 'said'), [
    ('x:=left', "x is 'left'; allowed: a finite number"),
    ('y:=nan', "y is 'nan'; allowed: a finite number"),
    ('initial_positions:=joint_1', 'JOINT=VALUE,JOINT=VALUE'),
    ('initial_positions:=joint_1=far', "initial_positions of joint_1 is 'far'"),
])
def test_values_that_are_no_numbers(word, said):
    """One message with what is allowed."""
    with pytest.raises(UsageError) as caught:
        cell_of(parse_arguments([word]))
    assert said in str(caught.value)
