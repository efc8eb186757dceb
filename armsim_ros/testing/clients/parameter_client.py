# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A client of a node's parameter services."""

from __future__ import annotations

from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    ListParameters,
    SetParameters,
)
from rclpy.parameter import Parameter, parameter_value_to_python

from armsim_ros.testing.clients.client_node import ClientNode


class ParameterClient:
    """
    Reads and writes parameters of another node.

    :param client: the node to use.
    :param node: the other node's full name.
    """

    def __init__(self, client: ClientNode, node: str) -> None:
        self._client = client
        self._node = node

    def names(self) -> list[str]:
        """Return the names of all parameters."""
        response = self._client.call(f'{self._node}/list_parameters', ListParameters)
        return list(response.result.names)

    def get(self, name: str) -> Any:
        """Return a value; None where it is not set."""
        request = GetParameters.Request(names=[name])
        response = self._client.call(f'{self._node}/get_parameters', GetParameters, request)
        return parameter_value_to_python(response.values[0])

    def describe(self, name: str) -> ParameterDescriptor:
        """Return the descriptor of a parameter."""
        request = DescribeParameters.Request(names=[name])
        response = self._client.call(
            f'{self._node}/describe_parameters', DescribeParameters, request
        )
        descriptor: ParameterDescriptor = response.descriptors[0]
        return descriptor

    def set(self, name: str, value: Any) -> str:
        """Set a value; return the reason of a refusal, or '' where it was taken."""
        message = Parameter(name, value=value).to_parameter_msg()
        request = SetParameters.Request(parameters=[message])
        response = self._client.call(f'{self._node}/set_parameters', SetParameters, request)
        result = response.results[0]
        return '' if result.successful else result.reason or 'refused without a reason'
