# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Types for Foxglove, as the full text of their definitions."""

from __future__ import annotations

from functools import cache

import foxglove

from armsim_ros.errors import ArmsimError
from armsim_ros.recording.message_definitions import message_definition, text_definition
from armsim_ros.resources import share_folder

ENCODING = 'ros2msg'


@cache
def topic_schema(type_name: str) -> foxglove.Schema | None:
    """Return the schema of a message type, None where its definition is not installed."""
    try:
        text = message_definition(type_name)
    except (ArmsimError, OSError, ValueError):
        return None
    return foxglove.Schema(name=type_name, encoding=ENCODING, data=text.encode())


@cache
def service_schema(type_name: str) -> foxglove.ServiceSchema | None:
    """Return the schemas of request and response, None where they are not installed."""
    package, _, name = type_name.split('/')
    try:
        text = (share_folder(package) / 'srv' / f'{name}.srv').read_text('utf-8')
        request, _, response = text.partition('\n---')
        if text.startswith('---'):
            request, response = '', text[3:]
        parts = [foxglove.MessageSchema(encoding='cdr', schema=foxglove.Schema(
            name=f'{type_name}_{part}', encoding=ENCODING,
            data=text_definition(package, content).encode()))
            for part, content in (('Request', request), ('Response', response))]
    except (ArmsimError, OSError, ValueError):
        return None
    return foxglove.ServiceSchema(type_name, request=parts[0], response=parts[1])
