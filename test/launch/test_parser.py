# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Elements of launch files in XML and YAML."""

from armsim_ros.launch.api.context import LaunchContext
from armsim_ros.launch.files import read_launch_file


def parameters_of(text, name, tmp_path):
    """Return the parameters of a node of a launch file in XML or YAML."""
    path = tmp_path / name
    path.write_text(text)
    (node,) = read_launch_file(path).entities
    return node.spec(LaunchContext()).node.merged()


def test_a_parameter_without_a_text_is_an_empty_text(tmp_path):
    """launch/frontend/parse_substitution.py, parse_substitution: an empty TextSubstitution."""
    found = parameters_of("""
        <launch><node pkg="mine" exec="one">
          <param name="tf_prefix" value=""/><param name="other" value="" type="str"/>
        </node></launch>
    """, 'it.launch.xml', tmp_path)
    assert found == {'tf_prefix': '', 'other': ''}


def test_values_in_xml_are_typed_by_yaml(tmp_path):
    """launch_xml/entity.py, get_attr: attributes are what YAML sees in them."""
    found = parameters_of("""
        <launch><node pkg="mine" exec="one">
          <param name="int" value="1"/><param name="text" value="'1'"/>
          <param name="list" value="0;0.5" value-sep=";"/>
        </node></launch>
    """, 'it.launch.xml', tmp_path)
    assert found == {'int': 1, 'text': '1', 'list': [0.0, 0.5]}


def test_values_in_yaml_keep_their_types(tmp_path):
    """launch_yaml/entity.py, get_attr: no coercion; only substitutions are typed by YAML."""
    found = parameters_of("""
launch:
- node:
    pkg: mine
    exec: one
    param:
    - {name: quoted, value: '1'}
    - {name: int, value: 1}
    - {name: empty, value: ''}
    - {name: substitution, value: $(eval 1 + 1)}
    - {name: texts, value: ['1', 'true']}
    - {name: numbers, value: [0, 0.5]}
""", 'it.launch.yaml', tmp_path)
    assert found == {'quoted': '1', 'int': 1, 'empty': '', 'substitution': 2,
                     'texts': ['1', 'true'], 'numbers': [0.0, 0.5]}
    assert isinstance(found['numbers'][0], float)


def test_resets(dry, monkeypatch):
    """launch/actions: <reset> with <keep>, and <reset_env>."""
    monkeypatch.delenv('ROOM', raising=False)
    said = dry("""
        <launch>
          <let name="a" value="kept"/>
          <let name="b" value="lost"/>
          <set_env name="ROOM" value="hall"/>
          <reset><keep name="c" value="$(var a)"/></reset>
          <reset_env/>
          <node pkg="mine" exec="one" name="$(var c)_$(var b none)_$(env ROOM unset)"/>
        </launch>
    """, name='it.launch.xml')
    assert list(said.processes()) == ['kept_none_unset']


def test_a_ros_timer(dry):
    """launch_ros/actions/ros_timer.py, parse: its children follow after the period."""
    said = dry("""
        <launch>
          <ros_timer period="1.0"><node pkg="mine" exec="one" name="late"/></ros_timer>
          <node pkg="mine" exec="one" name="soon"/>
        </launch>
    """, name='it.launch.xml')
    assert list(said.processes()) == ['soon', 'late']


def test_the_number_of_respawns(tmp_path):
    """launch/actions/execute_process.py, parse: respawn_max_retries."""
    path = tmp_path / 'it.launch.xml'
    path.write_text('<launch><node pkg="mine" exec="one" respawn="true" '
                    'respawn_max_retries="2"/></launch>')
    (node,) = read_launch_file(path).entities
    assert node.spec(LaunchContext()).respawn_max_retries == 2
