# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Every installed type is the one that Jazzy's releases have."""

import ctypes
import re

from filled import filled, interface
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.type_support import check_for_type_support

PARTS = {
    'message': '', 'request': '_Request', 'response': '_Response',
    'goal': '_Goal', 'result': '_Result', 'feedback': '_Feedback'}
PYTHON_NAMES = {
    'float64': 'double', 'float32': 'float', 'bool': 'boolean', 'byte': 'octet', 'char': 'uint8'}


# Where the C structs of type supports keep the function that returns the hash.
MESSAGE, SERVICE, ACTION = 3, 8, 5


class TypeHash(ctypes.Structure):
    """The C struct rosidl_type_hash_t."""

    _fields_ = [('version', ctypes.c_uint8), ('value', ctypes.c_uint8 * 32)]


def parts(definitions, package):
    """Yield name, class and expected content of each message, request, goal ... of a package."""
    for name, definition in definitions.items():
        if name.startswith(f'{package}/'):
            for part, content in definition.items():
                attribute = PARTS[part].lstrip('_')
                cls = interface(name)
                yield name + PARTS[part], getattr(cls, attribute) if attribute else cls, content


def as_python(type_name):
    """Return a type as the Python classes write it: ``sequence<double>`` for ``float64[]``."""
    base, bracket, size = type_name.partition('[')
    base = base.replace('/msg/', '/')
    base = PYTHON_NAMES.get(base, base)
    return f'sequence<{base}>' if size == ']' else f'{base}{bracket}{size}'


def compiled_types(name):
    """Yield name, class and kind of an interface and of all that is generated from it."""
    cls = interface(name)
    if '/msg/' in name:
        yield name, cls, MESSAGE
    elif '/srv/' in name:
        yield from service_types(name, cls)
    else:
        yield name, cls, ACTION
        for part in ('Goal', 'Result', 'Feedback'):
            yield f'{name}_{part}', getattr(cls, part), MESSAGE
        yield f'{name}_FeedbackMessage', cls.Impl.FeedbackMessage, MESSAGE
        yield from service_types(f'{name}_SendGoal', cls.Impl.SendGoalService)
        yield from service_types(f'{name}_GetResult', cls.Impl.GetResultService)


def service_types(name, cls):
    """Yield the same for a service."""
    yield name, cls, SERVICE
    for part in ('Request', 'Response', 'Event'):
        yield f'{name}_{part}', getattr(cls, part), MESSAGE


def compiled_hash(cls, kind):
    """Return the hash that a middleware gets from the type support of a class."""
    check_for_type_support(cls)
    get_pointer = ctypes.pythonapi.PyCapsule_GetPointer
    get_pointer.restype = ctypes.c_void_p
    get_pointer.argtypes = [ctypes.py_object, ctypes.c_char_p]
    support = get_pointer(cls._TYPE_SUPPORT, None)
    function = ctypes.cast(support, ctypes.POINTER(ctypes.c_void_p))[kind]
    get_hash = ctypes.CFUNCTYPE(ctypes.POINTER(TypeHash), ctypes.c_void_p)(function)
    found = get_hash(support).contents
    return f'RIHS{found.version:02d}_{bytes(found.value).hex()}'


def test_hashes(definitions, type_hashes, package):
    """Every type, the generated ones too, has the hash of the releases."""
    found = {
        name: compiled_hash(cls, kind)
        for interface_name in definitions if interface_name.startswith(f'{package}/')
        for name, cls, kind in compiled_types(interface_name)}
    expected = {
        name: value for name, value in type_hashes.items() if name.startswith(f'{package}/')}
    assert found == expected


def test_serialization(definitions, package):
    """A message of every type comes back whole from its serialized form."""
    for name, cls, _ in parts(definitions, package):
        message = filled(cls)
        assert deserialize_message(serialize_message(message), cls) == message, name


def test_fields(definitions, package):
    """The fields of every type have the names, types and order of the releases."""
    for name, cls, content in parts(definitions, package):
        expected = [(field, as_python(type_name)) for type_name, field, _ in content['fields']]
        assert list(cls.get_fields_and_field_types().items()) == expected, name


def test_defaults(definitions, package):
    """A field has its default in a new message."""
    for name, cls, content in parts(definitions, package):
        for _, field, default in content['fields']:
            if default is not None:
                assert getattr(cls(), field) == default, f'{name}.{field}'


def test_constants(definitions, package):
    """Every type has the constants of the releases and no others."""
    for name, cls, content in parts(definitions, package):
        expected = {
            constant: bytes([value]) if type_name == 'byte' else value
            for type_name, constant, value in content['constants']}
        found = {
            attribute: getattr(cls, attribute) for attribute in dir(cls)
            if re.fullmatch('[A-Z][A-Z0-9_]*', attribute) and attribute != 'SLOT_TYPES'
            and not attribute.endswith('__DEFAULT')}
        assert found == expected, name
