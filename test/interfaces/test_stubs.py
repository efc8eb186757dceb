# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The type stubs of the interface packages describe the classes that rosidl_generator_py makes."""

import array
import ast
import importlib
from pathlib import Path

from build_support.stubs import write_stubs
import numpy as np
import pytest

KINDS = ('msg', 'srv', 'action')


@pytest.fixture(scope='session')
def stub_classes(source, tmp_path_factory):
    """Return a function that yields each message class of a package and its stub."""
    target = tmp_path_factory.mktemp('stubs')

    def pairs(stub, real):
        methods = {node.name for node in stub.body if isinstance(node, ast.FunctionDef)}
        if '__init__' in methods:
            yield real, stub
        for node in stub.body:
            if isinstance(node, ast.ClassDef):
                yield from pairs(node, getattr(real, node.name))

    def classes(package):
        write_stubs(package, source / package, target / package)
        for kind in KINDS:
            path = target / package / kind / '__init__.pyi'
            if path.is_file():
                module = importlib.import_module(f'{package}.{kind}')
                for node in ast.parse(path.read_text('utf-8')).body:
                    if isinstance(node, ast.ClassDef):
                        yield from pairs(node, getattr(module, node.name))

    return classes


def annotations(stub):
    """Return the type of each field as it is read, and as the constructor accepts it."""
    read = {}
    for node in stub.body:
        if isinstance(node, ast.AnnAssign) and not node.target.id.isupper() \
                and 'ClassVar' not in ast.unparse(node.annotation):
            read[node.target.id] = ast.unparse(node.annotation)
        elif isinstance(node, ast.FunctionDef) and any(
                ast.unparse(decorator) == 'property' for decorator in node.decorator_list):
            read[node.name] = ast.unparse(node.returns)
        elif isinstance(node, ast.FunctionDef) and node.name == '__init__':
            accepted = {
                word.arg: ast.unparse(word.annotation) for word in node.args.kwonlyargs}
    del accepted['check_fields']
    return read, accepted


def describe(value):
    """Return how a stub writes the type of a field's default value."""
    if isinstance(value, np.ndarray):
        return f'_NDArray[_numpy.{value.dtype}]'
    if isinstance(value, array.array):
        return f'_array[{"float" if value.typecode in "fd" else "int"}]'
    return type(value).__name__


def test_types(package, stub_classes):
    """A stub has the fields of its class, each with the type of its default value."""
    compared = 0
    for real, stub in stub_classes(package):
        read, accepted = annotations(stub)
        assert list(read) == list(accepted) == list(real.get_fields_and_field_types()), real
        for name, annotation in read.items():
            described = describe(getattr(real(), name))
            if described == 'list':
                assert annotation.startswith('list['), (real, name)
            else:
                # a message bears its package, its owner, or nothing, before its name
                last = annotation if '[' in annotation else annotation.rpartition('.')[2]
                assert described.rpartition('_')[2] == last if '_msgs' not in described and \
                    '[' not in described else described == annotation, (real, name)
            compared += 1
    assert compared


def test_accepted(package, stub_classes):
    """A field of a sequence accepts a tuple of its elements, and so does its stub."""
    for real, stub in stub_classes(package):
        read, accepted = annotations(stub)
        for name, annotation in read.items():
            if '[' in annotation:
                value = tuple(getattr(real(), name))
                real(check_fields=True, **{name: value})
                # Nobody makes the events of services but rclpy, of lists.
                assert '_Sequence[' in accepted[name] or stub.name == 'Event'


def test_constants(package, stub_classes):
    """A stub has the constants of its class, with their values."""
    for real, stub in stub_classes(package):
        metaclass = type(real)
        constants = {
            name for name, value in vars(metaclass).items()
            if isinstance(value, property) and not name.endswith('__DEFAULT')}
        stubs = {
            node.target.id: ast.literal_eval(node.value) for node in stub.body
            if isinstance(node, ast.AnnAssign) and node.value is not None}
        assert stubs == {name: getattr(real, name) for name in constants}, real


def test_installed(package):
    """The installed package is marked as typed and brings its stubs."""
    folder = Path(importlib.import_module(package).__file__).parent
    assert (folder / 'py.typed').is_file()
    for kind in KINDS:
        assert (folder / kind / '__init__.pyi').is_file() == (folder / kind).is_dir()
