# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What clients of Foxglove may do, by our arguments or by those of foxglove_bridge."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import yaml

from armsim_ros.cli.arguments import UsageError
from armsim_ros.nodes.bridge.permissions import NamePatterns, Permissions
from armsim_ros.nodes.bridge.settings import (
    ARGUMENTS,
    Arguments,
    BridgeSettings,
    checked,
    read_settings,
)
from armsim_ros.nodes.ports import read_values

CLIENT_PUBLISH, SERVICES = 'clientPublish', 'services'
PARAMETERS, PARAMETERS_SUBSCRIBE = 'parameters', 'parametersSubscribe'
CONNECTION_GRAPH, ASSETS = 'connectionGraph', 'assets'
_READING = (CONNECTION_GRAPH, PARAMETERS_SUBSCRIBE, PARAMETERS, ASSETS)
_ASSETS = (r'^package://(?:[-\w%]+/)*[-\w%.]+\.'
           r'(?:dae|fbx|glb|gltf|jpeg|jpg|mtl|obj|png|stl|tif|tiff|urdf|webp|xacro)$')
_ALL = ['.*']

#: Arguments of the bridge that foxglove_bridge has, too; its ``port`` is Foxglove's.
_SHARED = ('address', 'certfile', 'keyfile', 'token', 'origins', 'max_clients', 'mcap',
           'mcap_topics', 'packages_path', 'near')
#: Parameters that only foxglove_bridge has.
_OWN: Arguments = {
    'tls': (False, 'serve wss, with certfile and keyfile'),
    'topic_whitelist': (_ALL, 'topics that clients see'),
    'service_whitelist': (_ALL, 'services that clients may call'),
    'param_whitelist': (_ALL, 'parameters, as /node.name, that clients may read or set'),
    'client_topic_whitelist': (_ALL, 'topics that clients may publish'),
    'best_effort_qos_topic_whitelist': (['(?!)'], 'topics that are read as best effort'),
    'asset_uri_allowlist': ([_ASSETS], 'addresses of meshes that clients may fetch'),
    'capabilities': ([CLIENT_PUBLISH, *_READING, SERVICES], 'what clients may do'),
    'include_hidden': (False, 'show hidden topics and services, too'),
    'ignore_unresponsive_param_nodes': (
        True, 'leave out nodes that did not answer when all parameters are read'),
}
#: Its parameters that change nothing here.
_WITHOUT_EFFECT = {'send_buffer_limit': 10_000_000, 'min_qos_depth': 1, 'max_qos_depth': 25,
                   'use_compression': False, 'disable_load_message': True}
FOXGLOVE_ARGUMENTS: Arguments = {
    'port': ARGUMENTS['foxglove_port'], **{name: ARGUMENTS[name] for name in _SHARED}, **_OWN}


@dataclass(frozen=True)
class FoxgloveRules:
    """
    What clients of Foxglove may do.

    :param permissions: names that they may use.
    :param capabilities: foxglove_bridge's names of what they may do at all.
    :param sets_parameters: whether they may set the parameters that they may read.
    :param assets: addresses that they may fetch.
    :param best_effort: topics that are read as best effort, whatever is offered.
    :param include_hidden: whether they see hidden names.
    :param ignores_silent_nodes: whether nodes that once did not answer are left out when all
        parameters are read.
    """

    permissions: Permissions
    capabilities: frozenset[str]
    sets_parameters: bool
    assets: NamePatterns
    best_effort: NamePatterns
    include_hidden: bool = False
    ignores_silent_nodes: bool = True

    @classmethod
    def of(cls, settings: BridgeSettings) -> FoxgloveRules:
        """Return what the bridge's argument ``foxglove`` allows."""
        controls = settings.foxglove == 'control'
        return cls(Permissions.of(settings), frozenset(
            (*_READING, CLIENT_PUBLISH, SERVICES) if controls else _READING), controls,
            NamePatterns.whitelist('asset_uri_allowlist', _ALL),
            NamePatterns.whitelist('best_effort_qos_topic_whitelist', ()))

    @property
    def controls(self) -> bool:
        """Whether clients may change anything."""
        return self.sets_parameters or bool({CLIENT_PUBLISH, SERVICES} & self.capabilities)


def parse_foxglove_arguments(argv: Sequence[str]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """
    Read the command line of foxglove_bridge.

    :returns: the values that were given, and the words for ROS.
    :raises UsageError: names the known arguments.
    """
    values, ros_args = read_values(argv, (*FOXGLOVE_ARGUMENTS, *_WITHOUT_EFFECT))
    return {name: _value(name, text) for name, text in values.items()}, ros_args


def read_foxglove_settings(given: Mapping[str, Any], parameter: Callable[[str, Any], Any]
                           ) -> tuple[BridgeSettings, FoxgloveRules, list[str]]:
    """
    Return the settings of foxglove_bridge, and the names of those that change nothing here.

    :param given: the values of the command line.
    :param parameter: declares a parameter with this value and returns the one in force.
    :raises UsageError: a value is wrong.
    """
    shared = {'foxglove_port': 'port', **{name: name for name in _SHARED}}

    def declare(name: str, default: Any) -> Any:
        """Declare a parameter of the bridge if this program has it, too."""
        own = shared.get(name)
        return default if own is None else parameter(own, given.get(own, default))

    settings, _ = read_settings({'foxglove': 'control'}, declare)
    values = {name: _value(name, parameter(name, given.get(name, default)))
              for name, (default, _) in _OWN.items()}
    unused = [name for name, default in _WITHOUT_EFFECT.items()
              if checked(name, default, parameter(name, given.get(name, default))) != default]
    if not values['tls']:
        settings = replace(settings, certfile='', keyfile='')
    elif not settings.certfile:
        raise UsageError('tls:=true needs certfile and keyfile')
    known = _OWN['capabilities'][0]
    capabilities = frozenset(values['capabilities'])
    if foreign := sorted(capabilities.difference(known)):
        unused.append(f'capabilities {", ".join(foreign)}')
    try:
        patterns = {name: NamePatterns.whitelist(name, values[name])
                    for name in values if name.endswith('list')}
    except ValueError as error:
        raise UsageError(str(error)) from None
    return settings, FoxgloveRules(
        Permissions(topics=patterns['topic_whitelist'], services=patterns['service_whitelist'],
                    actions=NamePatterns.globs('actions_glob'),
                    parameters=patterns['param_whitelist'],
                    client_topics=patterns['client_topic_whitelist']),
        capabilities.intersection(known), PARAMETERS in capabilities,
        patterns['asset_uri_allowlist'], patterns['best_effort_qos_topic_whitelist'],
        values['include_hidden'], values['ignore_unresponsive_param_nodes']), unused


def _value(name: str, value: Any) -> Any:
    """Return the value of a parameter, or of its text on the command line."""
    default = {**_WITHOUT_EFFECT, **{each: pair[0] for each, pair in FOXGLOVE_ARGUMENTS.items()}
               }[name]
    if not isinstance(default, list):
        return checked(name, default, value)
    if isinstance(value, str):
        with suppress(yaml.YAMLError):  # a regular expression by itself
            value = yaml.safe_load(value)
    if value is None:
        return []
    return [str(entry) for entry in value] if isinstance(value, (list, tuple)) else [str(value)]
