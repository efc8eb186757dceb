# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services that rclpy gives every node, asked what others may ask them."""

from __future__ import annotations

import pytest
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import (
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from type_description_interfaces.srv import GetTypeDescription

NODES = ('/move_group', '/moveit_simple_controller_manager', '/sunday/controller_manager',
         '/sunday/arm_joint_controller')

each_node = pytest.mark.parametrize('node', NODES)


@each_node
def test_a_parameter_of_an_unknown_type_is_refused(stack, node):
    """The client gets an answer with a reason, by either service."""
    wrong = [Parameter(name='x', value=ParameterValue(type=200))]
    answer = stack.client.call(
        f'{node}/set_parameters', SetParameters, SetParameters.Request(parameters=wrong * 2))
    assert [(one.successful, bool(one.reason)) for one in answer.results] == [(False, True)] * 2
    answer = stack.client.call(
        f'{node}/set_parameters_atomically', SetParametersAtomically,
        SetParametersAtomically.Request(parameters=wrong))
    assert not answer.result.successful
    assert 'please report' not in stack.program.text


@each_node
def test_questions_about_what_is_not_there_are_answered(stack, node):
    """Whatever the answer is, it comes."""
    stack.client.call(
        f'{node}/get_parameter_types', GetParameterTypes,
        GetParameterTypes.Request(names=['no.such', 'use_sim_time']))
    stack.client.call(
        f'{node}/list_parameters', ListParameters,
        ListParameters.Request(prefixes=['', 'no', '.'], depth=3))
    stack.client.call(
        f'{node}/get_type_description', GetTypeDescription,
        GetTypeDescription.Request(type_name='no/such/Type', type_hash='RIHS01_0'))
    assert 'please report' not in stack.program.text


@each_node
def test_no_parameter_has_the_name_of_a_group(stack, node):
    """Else no YAML file could hold them all, and ``ros2 param dump`` fails."""
    names = set(stack.client.call(f'{node}/list_parameters', ListParameters).result.names)
    groups = {name[:end] for name in names for end, sign in enumerate(name) if sign == '.'}
    assert names & groups == set()
