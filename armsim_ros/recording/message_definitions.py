# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Definitions of ROS messages as a recording carries them.

The text of a type is followed by those of all types that it contains, each after a line of equals
signs and ``MSG: package/Type``; this is the schema encoding ``ros2msg`` of MCAP
(https://mcap.dev/spec/registry#ros2msg). The texts are read from the packages that are installed.
"""

from __future__ import annotations

from functools import lru_cache
import re

from armsim_ros.resources import share_folder

_SEPARATOR = '=' * 80
_FIELD = re.compile(r'^([A-Za-z][\w/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+[a-z]\w*', re.MULTILINE)
_PLAIN = frozenset((
    'bool', 'byte', 'char', 'float32', 'float64', 'string', 'wstring',
    *(f'{sign}int{bits}' for sign in ('', 'u') for bits in (8, 16, 32, 64)),
))


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


def _collect(package: str, name: str, texts: dict[str, str]) -> None:
    key = f'{package}/{name}'
    if key in texts:
        return
    text = _without_comments((share_folder(package) / 'msg' / f'{name}.msg').read_text('utf-8'))
    texts[key] = text
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
