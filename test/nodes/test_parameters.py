# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Settings declared as ROS parameters on a real node."""

from collections.abc import Iterator
import math
from typing import Literal

from pydantic import ConfigDict, Field, model_validator
import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from armsim_ros.config.base import parameter, Settings
from armsim_ros.nodes.parameters import entries, SettingsParameters
from armsim_ros.testing.program import private_domain


class Gains(Settings):
    p: float = parameter(1.0, 'gain [N*m/rad]', ge=0.0)
    clamp: float = parameter(math.inf, 'clamp [N*m]')


class Blocks(Settings):
    model_config = ConfigDict(extra='allow')
    __pydantic_extra__: dict[str, Gains] = Field(init=False)

    time: float = parameter(0.0, 'time [s]')


class Example(Settings):
    joints: tuple[str, ...] = parameter(('a', 'b'), 'joints', read_only=True)
    extra: tuple[str, ...] = parameter((), 'more joints', read_only=True)
    method: Literal['splines', 'none'] = parameter('splines', 'method')
    rate: float | None = parameter(None, 'rate [Hz]', gt=0.0)
    count: int = parameter(3, 'count', ge=1, le=9)
    lowest: float = parameter(0.0, 'lowest')
    highest: float = parameter(1.0, 'highest')
    gains: dict[str, Gains] = parameter({'a': Gains(), 'b': Gains(p=2.0)}, 'gains')
    blocks: Blocks = parameter(Blocks(a=Gains()), 'blocks')

    @model_validator(mode='after')
    def _ordered(self) -> 'Example':
        if self.lowest > self.highest:
            raise ValueError('lowest must not exceed highest')
        return self


@pytest.fixture
def context() -> Iterator[Context]:
    """Yield a context on a domain of its own."""
    with private_domain() as domain:
        context = Context()
        rclpy.init(
            args=[],
            context=context,
            domain_id=domain,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        yield context
        context.try_shutdown()


@pytest.fixture
def node(context: Context) -> Iterator[Node]:
    """Yield a node without parameters of its own."""
    node = Node('example', context=context)
    yield node
    node.destroy_node()


def test_every_value_has_a_dotted_name() -> None:
    """Nested models and mappings become dotted names, in the settings' order."""
    assert [entry.name for entry in entries(Example())] == [
        'joints', 'extra', 'method', 'rate', 'count', 'lowest', 'highest',
        'gains.a.p', 'gains.a.clamp', 'gains.b.p', 'gains.b.clamp',
        'blocks.time', 'blocks.a.p', 'blocks.a.clamp',
    ]


def test_values_types_and_ranges_are_declared(node: Node) -> None:
    """The node shows values, types, ranges, descriptions and the read-only mark."""
    SettingsParameters(node, Example())
    assert node.get_parameter('gains.b.p').value == 2.0
    assert node.get_parameter('gains.b.clamp').value == math.inf
    assert node.get_parameter('extra').type_ == Parameter.Type.STRING_ARRAY
    assert node.describe_parameter('joints').read_only
    assert node.describe_parameter('extra').read_only
    assert node.describe_parameter('gains.a.p').description == 'gain [N*m/rad]'
    assert node.describe_parameter('gains.a.p').floating_point_range[0].from_value == 0.0
    assert node.describe_parameter('count').integer_range[0].to_value == 9
    assert node.describe_parameter('method').additional_constraints == 'one of: splines, none'
    assert node.get_parameter_or('rate').value is None


def test_a_change_replaces_the_settings(node: Node) -> None:
    """A legal change arrives as new checked settings."""
    seen: list[Example] = []
    parameters = SettingsParameters(node, Example(), seen.append)
    result = node.set_parameters([Parameter('gains.a.p', value=7.5)])[0]
    assert result.successful, result.reason
    assert seen == [parameters.settings]
    assert seen[0].gains['a'].p == 7.5
    assert seen[0].gains['b'].p == 2.0


@pytest.mark.parametrize(
    ('name', 'value', 'word'),
    [
        ('method', 'cubic', 'method'),
        ('gains.a.p', -1.0, 'gains.a.p'),
        ('count', 10, 'count'),
        ('lowest', 5.0, 'lowest must not exceed highest'),
        ('joints', ['c'], 'read-only'),
        ('count', 1.5, 'type'),
    ],
)
def test_an_illegal_change_is_refused(node: Node, name: str, value: object, word: str) -> None:
    """What the settings refuse is refused with a reason and changes nothing."""
    seen: list[Example] = []
    parameters = SettingsParameters(node, Example(), seen.append)
    result = node.set_parameters([Parameter(name, value=value)])[0]
    assert not result.successful
    assert word in result.reason
    assert seen == []
    assert parameters.settings == Example()


def test_an_objection_is_the_reason(node: Node) -> None:
    """What the owner of the settings objects to is refused in its words and changes nothing."""
    parameters = SettingsParameters(
        node, Example(), objection=lambda settings: 'no seven' if settings.count == 7 else '')
    result = node.set_parameters([Parameter('count', value=7)])[0]
    assert (result.successful, result.reason) == (False, 'no seven')
    assert parameters.settings == Example()


def test_two_changes_that_are_legal_only_together(node: Node) -> None:
    """Parameters that are set atomically are checked together."""
    parameters = SettingsParameters(node, Example())
    result = node.set_parameters_atomically(
        [Parameter('lowest', value=5.0), Parameter('highest', value=6.0)]
    )
    assert result.successful, result.reason
    assert parameters.settings.lowest == 5.0


def test_what_was_not_given_stays_not_given(node: Node) -> None:
    """A change of one value does not turn the defaults of the others into given values."""
    parameters = SettingsParameters(node, Example())
    assert node.set_parameters([Parameter('blocks.a.p', value=7.5)])[0].successful
    blocks = parameters.settings.blocks
    assert blocks.a.p == 7.5
    assert blocks.a.model_fields_set == {'p'}
    assert 'count' not in parameters.settings.model_fields_set


def test_an_override_wins(context: Context) -> None:
    """A value given to the node at its start wins over the settings'."""
    node = Node('other', context=context, parameter_overrides=[Parameter('count', value=5)])
    seen: list[Example] = []
    parameters = SettingsParameters(node, Example(), seen.append)
    assert parameters.settings.count == 5
    assert seen == [parameters.settings]
    node.destroy_node()
