# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names under which launch files import what they use."""

import pytest

from armsim_ros.launch.api.namespaces import make_namespace_absolute, prefix_namespace


@pytest.mark.parametrize('line', [
    'from launch import SomeSubstitutionsType_types_tuple',
    'from launch.actions.shutdown_action import Shutdown, ShutdownEvent',
    'from launch.event_handlers import OnIncludeLaunchDescription',
    'from launch.event_handlers.on_process_exit import OnProcessExit',
    'from launch.events.process import RunningProcessEvent',
    'from launch.frontend import InvalidFrontendLaunchFileError',
    'from launch.frontend.parse_substitution import parse_substitution',
    'from launch.some_substitutions_type import SomeSubstitutionsType_types_tuple',
    'from launch.substitutions.boolean_substitution import NotSubstitution',
    'from launch.utilities.type_utils import normalize_typed_substitution',
    'from launch_param_builder import get_package_share_directory',
    'from launch_ros.parameters_type import SomeParameters',
    'from launch_ros.substitutions.find_package import FindPackageShare',
    'from launch_ros.substitutions.find_package import get_package_share_directory',
    'from launch_ros.utilities import normalize_parameters, prefix_namespace',
    'from launch_ros.utilities.normalize_parameters import normalize_parameters',
    'from moveit_configs_utils.moveit_configs_builder import get_pattern_matches',
])
def test_a_name_of_upstream_can_be_imported(dry, line):
    """Published launch files import these, some from the modules where upstream uses them."""
    said = dry(f"""
        {line}
        from launch import LaunchDescription

        def generate_launch_description():
            return LaunchDescription()
    """)
    assert (said.status, said.plan) == (0, ['nothing to start']), said.errors


@pytest.mark.parametrize(('base', 'namespace', 'combined'), [
    ('a', 'b', 'a/b'), ('/a', 'b/', '/a/b'), ('/', 'b', '/b'), ('a', '/b', '/b'),
    (None, 'b', 'b'), ('a', None, 'a'), (None, None, None), ('a', '/', '/')])
def test_a_namespace_inside_another(base, namespace, combined):
    """launch_ros/utilities/namespace_utils.py, prefix_namespace."""
    assert prefix_namespace(base, namespace) == combined


@pytest.mark.parametrize(('namespace', 'absolute'), [
    ('a', '/a'), ('/a', '/a'), ('', '/'), (None, None)])
def test_an_absolute_namespace(namespace, absolute):
    """launch_ros/utilities/namespace_utils.py, make_namespace_absolute."""
    assert make_namespace_absolute(namespace) == absolute


def test_a_typed_substitution_of_the_users_own_action(entities):
    """launch/utilities/type_utils.py: a text stays, substitutions get the type."""
    said = entities("""
        SetLaunchConfiguration('n', '3'),
        OpaqueFunction(function=lambda context: [LogInfo(msg=str([
            perform_typed_substitution(context, normalize_typed_substitution(value, kind), kind)
            for value, kind in (('3', str), (LaunchConfiguration('n'), int), (2.5, float),
                                ([LaunchConfiguration('n'), '.5'], None))]))]),
    """, before='from launch.utilities.type_utils import *')
    assert "['3', 3, 2.5, 3.5]" in said.errors


def test_the_event_that_includes_a_description(entities):
    """launch/event_handlers/on_include_launch_description.py: the launch visits it."""
    said = entities("""
        EmitEvent(event=IncludeLaunchDescriptionEvent(LaunchDescription([node('included')]))),
    """, before='from launch.events import IncludeLaunchDescription as '
                'IncludeLaunchDescriptionEvent')
    assert list(said.processes()) == ['included']
