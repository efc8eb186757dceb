# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bridge's arguments, which are parameters of its node, too."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

from armsim_ros.cli.arguments import FALSE_WORDS, TRUE_WORDS, UsageError
from armsim_ros.nodes.ports import read_values

#: Arguments of rosbridge_server that change nothing here.
IGNORED = {
    'delay_between_messages': 0.0, 'call_services_in_new_thread': True,
    'send_action_goals_in_new_thread': True, 'use_compression': False,
    'retry_startup_delay': 5.0, 'bson_only_mode': False,
}
#: Name -> default and meaning.
Arguments = dict[str, tuple[Any, str]]


def _setting(default: Any, text: str) -> Any:
    return field(default=default, metadata={'text': text})


@dataclass(frozen=True)
class BridgeSettings:
    """The values, checked; a field per argument."""

    port: int = _setting(9090, 'port of rosbridge; 0 takes any free port, which is printed')
    address: str = _setting(
        '127.0.0.1', 'address to listen at; others need a token, which is made')
    url_path: str = _setting('/', 'path of the websocket')
    certfile: str = _setting('', 'certificate for wss, with keyfile')
    keyfile: str = _setting('', 'key for wss, with certfile')
    token: str = _setting(
        '', 'what each client must bring, as ?token=... or Authorization: Bearer')
    origins: tuple[str, ...] = _setting(
        (), 'pages of other sites that may connect, such as https://a.example,null')
    topics_glob: tuple[str, ...] = _setting(
        (), 'topics that may be used, such as [/sunday/*, /tf]')
    services_glob: tuple[str, ...] = _setting((), 'services that may be called or served')
    actions_glob: tuple[str, ...] = _setting((), 'actions that may be used or served')
    params_glob: tuple[str, ...] = _setting(
        (), 'parameters that may be read or set through rosapi')
    read_only: bool = _setting(False, 'refuse everything that may change or move something')
    max_message_size: int = _setting(10_000_000, 'of a frame from a client [bytes]')
    max_clients: int = _setting(32, 'connections at the same time')
    max_client_backlog: int = _setting(16 << 20, 'what may wait for a slow client [bytes]')
    fragment_timeout: float = _setting(
        30.0, 'how long a fragmented message may stay incomplete [s]')
    unregister_timeout: float = _setting(
        1.0, 'how long a publisher stays after its last client [s]')
    default_call_service_timeout: float = _setting(
        0.0, 'longest wait for a service; 0 for ever [s]')
    cancel_on_disconnect: bool = _setting(False, 'cancel the goals of a client that leaves')
    websocket_ping_interval: float = _setting(
        20.0, 'how often connections are checked; 0 never [s]')
    websocket_ping_timeout: float = _setting(30.0, 'how long a client may take to answer that [s]')
    foxglove: str = _setting('false', 'serve Foxglove, too: false, read or control')
    foxglove_port: int = _setting(8765, 'port of Foxglove')
    mcap: str = _setting('', 'file that records what clients of Foxglove read')
    mcap_topics: tuple[str, ...] = _setting(
        (), 'topics that it records in any case, such as [/sunday/*, /tf]')
    packages_path: str = _setting('', 'folders that are searched first for packages of meshes')
    near: str = _setting('', 'files of the robot; packages around them are found, too')


#: A list is text on the command line.
ARGUMENTS: Arguments = {
    each.name: ('' if each.default == () else each.default, each.metadata['text'])
    for each in fields(BridgeSettings)}


def help_text(program: str = 'bridge',
              about: str = 'rosbridge v2, rosapi and Foxglove: the robot for clients without ROS',
              arguments: Arguments = ARGUMENTS) -> str:
    """Return the text of ``--help``."""
    width = max(map(len, arguments)) + len(':=VALUE')
    rows = [f'  {name + ":=VALUE":<{width}}  {text} (default: {_word(default)})'
            for name, (default, text) in arguments.items()]
    return '\n'.join([
        f'usage: {program} [NAME:=VALUE ...] [--ros-args ...]', '', about, '',
        'arguments (--name VALUE is the same as name:=VALUE):', *rows,
        f'  {"--ros-args ...":<{width}}  remappings and parameters, as for any ROS 2 program'])


def parse_bridge_arguments(argv: Sequence[str]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """
    Read the command line.

    :returns: the values that were given, and the words for ROS.
    :raises UsageError: names the known arguments.
    """
    values, ros_args = read_values(argv, (*ARGUMENTS, *IGNORED))
    return {name: text if name in IGNORED else checked(name, ARGUMENTS[name][0], text)
            for name, text in values.items()}, ros_args


def read_settings(given: Mapping[str, Any], parameter: Callable[[str, Any], Any]
                  ) -> tuple[BridgeSettings, list[str]]:
    """
    Return the settings, and the names of arguments that were given and change nothing.

    :param given: the values of the command line.
    :param parameter: declares a parameter with this value and returns the one in force.
    :raises UsageError: a value is wrong.
    """
    values = {name: checked(name, default, parameter(name, given.get(name, default)))
              for name, (default, _) in ARGUMENTS.items()}
    unused = []
    for name, default in IGNORED.items():
        value = parameter(name, given.get(name, default))
        if name == 'bson_only_mode' and str(value).lower() in TRUE_WORDS:
            raise UsageError('bson_only_mode is not supported: messages are JSON or CBOR')
        if name in given or value != default:
            unused.append(name)
    for each in fields(BridgeSettings):
        if each.default == ():
            values[each.name] = _listed(values[each.name])
    if bool(values['certfile']) != bool(values['keyfile']):
        raise UsageError('certfile and keyfile are given together, or neither')
    if values['read_only'] and values['foxglove'] == 'control':
        raise UsageError('read_only:=true and foxglove:=control exclude each other; '
                         'foxglove:=read only reads')
    if values['foxglove'] == 'false' and (values['mcap'] or values['mcap_topics']):
        raise UsageError('mcap records what Foxglove reads; add foxglove:=read')
    return BridgeSettings(**values), unused


def checked(name: str, default: Any, value: Any) -> Any:
    """
    Return a value of an argument's kind.

    :param default: of that kind.
    :param value: its text, or a parameter's value.
    :raises UsageError: names what is allowed.
    """
    text = str(value)
    if name == 'foxglove':
        word = {**dict.fromkeys(TRUE_WORDS, 'read'), **dict.fromkeys(FALSE_WORDS, 'false'),
                'read': 'read', 'control': 'control'}.get(text.lower())
        if word is None:
            raise UsageError(f"foxglove is '{text}'; allowed: false, read, control")
        return word
    if isinstance(default, bool):
        if text.lower() not in TRUE_WORDS + FALSE_WORDS:
            raise UsageError(f"{name} is '{text}'; allowed: true, false")
        return text.lower() in TRUE_WORDS
    if isinstance(default, (int, float)):
        try:
            number = type(default)(text)
        except ValueError:
            number = -1
        most = 65535 if name.endswith('port') else float('inf')
        if not 0 <= number <= most:
            top = ' to 65535' if name.endswith('port') else ''
            raise UsageError(f"{name} is '{text}'; allowed: a number from 0{top or ' on'}")
        return number
    return text


def _listed(text: str) -> tuple[str, ...]:
    """Return the entries of ``[a, b]`` or ``a,b``."""
    inner = text.strip().removeprefix('[').removesuffix(']')
    return tuple(entry.strip().strip('\'"') for entry in inner.split(',') if entry.strip())


def _word(default: Any) -> str:
    return str(default).lower() if isinstance(default, bool) else str(default) or "''"
