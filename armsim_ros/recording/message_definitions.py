# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The full text of message definitions, as MCAP, rosbag2, rosapi and Foxglove have it.

A message definition is followed by those of all types that it contains, each after a line of
equals signs and ``MSG: package/Type``: the schema encoding ``ros2msg`` of MCAP
(https://mcap.dev/spec/registry#ros2msg). The texts are read from the installed packages.
"""

from __future__ import annotations

from functools import lru_cache
import re

from armsim_ros.resources import share_folder

_SEPARATOR = '=' * 80
_FIELD = re.compile(r'^([A-Za-z][\w/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+[a-z]\w*', re.MULTILINE)
_PLAIN = frozenset((
    'bool', 'byte', 'char', 'float32', 'float64', 'string', 'wstring',
    *(f'{sign}int{bits}' for sign in ('', 'u') for bits in (8, 16, 32, 64))))


@lru_cache
def message_definition(datatype: str) -> str:
    """
    Return the definition of a message type with those of all types in it.

    :param datatype: such as ``sensor_msgs/msg/JointState``.
    :raises ResourceError: the type or a nested type is not installed.
    """
    package, _, name = datatype.split('/')
    texts: dict[str, str] = {}
    _collect(package, name, texts)
    first = texts.pop(f'{package}/{name}')
    rest = [f'{_SEPARATOR}\nMSG: {key}\n{text}' for key, text in texts.items()]
    return '\n'.join([first, *rest])


def text_definition(package: str, text: str) -> str:
    """
    Return a text of fields with the definitions of all types in it.

    :param package: of types that are named without one.
    :raises ResourceError: a nested type is not installed.
    """
    text = _without_comments(text)
    texts: dict[str, str] = {}
    _collect_fields(package, text, texts)
    return '\n'.join([text, *(f'{_SEPARATOR}\nMSG: {key}\n{found}'
                              for key, found in texts.items())])


def _collect(package: str, name: str, texts: dict[str, str]) -> None:
    key = f'{package}/{name}'
    if key in texts:
        return
    text = _without_comments((share_folder(package) / 'msg' / f'{name}.msg').read_text('utf-8'))
    texts[key] = text
    _collect_fields(package, text, texts)


def _collect_fields(package: str, text: str, texts: dict[str, str]) -> None:
    for found in _FIELD.findall(text):
        if found in _PLAIN:
            continue
        *prefix, kind = found.split('/')
        owner = prefix[0] if prefix else 'std_msgs' if kind == 'Header' else package
        _collect(owner, kind, texts)


def _without_comments(text: str) -> str:
    lines = (line.partition('#')[0].rstrip() if '"' not in line else line.rstrip()
             for line in text.splitlines())
    return '\n'.join(line for line in lines if line) + '\n'
