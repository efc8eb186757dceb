# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Interface classes by name, and messages in which every field has a value of its own."""

import importlib
import itertools
import re


def interface(name):
    """Return the class of an interface, for example of ``tf2_msgs/msg/TFMessage``."""
    package, kind, short = name.split('/')
    return getattr(importlib.import_module(f'{package}.{kind}'), short)


def filled(message_class, numbers=None):
    """
    Return a message without a field at its default.

    :param message_class: the class of the message.
    :param numbers: where the values come from; each number is used once.
    """
    numbers = itertools.count(1) if numbers is None else numbers
    message = message_class()
    for field, type_name in message_class.get_fields_and_field_types().items():
        setattr(message, field, _value(type_name, numbers))
    return message


def _value(type_name, numbers):
    sequence = re.fullmatch(r'sequence<([^,]+)(?:, \d+)?>', type_name)
    if sequence:
        return [_value(sequence[1], numbers) for _ in range(2)]
    fixed = re.fullmatch(r'(.+)\[(\d+)\]', type_name)
    if fixed:
        return [_value(fixed[1], numbers) for _ in range(int(fixed[2]))]
    if '/' in type_name:
        package, short = type_name.split('/')
        return filled(interface(f'{package}/msg/{short}'), numbers)
    number = next(numbers)
    if type_name in ('string', 'wstring'):
        return f'text {number}'
    if type_name == 'boolean':
        return True
    if type_name == 'octet':
        return bytes([1 + number % 100])
    if type_name in ('float', 'double'):
        return number + 0.5
    return 1 + number % 100
