# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The programs of the bridge: our own, and the one that replaces foxglove_bridge."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from armsim_ros.nodes.bridge.foxglove_rules import (
    FOXGLOVE_ARGUMENTS,
    FoxgloveRules,
    parse_foxglove_arguments,
    read_foxglove_settings,
)
from armsim_ros.nodes.bridge.settings import (
    BridgeSettings,
    help_text,
    parse_bridge_arguments,
    read_settings,
)

Declare = Callable[[str, Any], Any]


@dataclass(frozen=True)
class Configuration:
    """
    What a program serves.

    :param settings: of its servers.
    :param rosbridge: whether it serves rosbridge and rosapi.
    :param foxglove: what clients of Foxglove may do; None where it is not served.
    :param unused: what was given and changes nothing.
    """

    settings: BridgeSettings
    rosbridge: bool
    foxglove: FoxgloveRules | None
    unused: Sequence[str]


@dataclass(frozen=True)
class Interface:
    """
    A program as its users see it.

    :param node: the name of its node, by which launch files and clients know it.
    :param help_text: returns the text of ``--help``.
    :param parse: returns the values of a command line, and the words for ROS.
    :param read: returns the configuration for these values; the second argument declares a
        parameter and returns its value.
    :param foxglove_port: the argument that is the port of Foxglove.
    """

    node: str
    help_text: Callable[[], str]
    parse: Callable[[Sequence[str]], tuple[dict[str, Any], tuple[str, ...]]]
    read: Callable[[Mapping[str, Any], Declare], Configuration]
    foxglove_port: str


def _read_bridge(given: Mapping[str, Any], parameter: Declare) -> Configuration:
    settings, unused = read_settings(given, parameter)
    return Configuration(
        settings, True, None if settings.foxglove == 'false' else FoxgloveRules.of(settings),
        unused)


def _read_foxglove_bridge(given: Mapping[str, Any], parameter: Declare) -> Configuration:
    settings, rules, unused = read_foxglove_settings(given, parameter)
    return Configuration(settings, False, rules, unused)


BRIDGE = Interface('rosbridge_websocket', help_text, parse_bridge_arguments, _read_bridge,
                   'foxglove_port')
FOXGLOVE_BRIDGE = Interface(
    'foxglove_bridge', partial(help_text, 'foxglove_bridge', 'Foxglove, as foxglove_bridge',
                               FOXGLOVE_ARGUMENTS),
    parse_foxglove_arguments, _read_foxglove_bridge, 'port')
