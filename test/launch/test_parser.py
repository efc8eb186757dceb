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
