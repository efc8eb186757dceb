# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Every public name of moveit_py can be called as upstream, and returns a value of that type."""

import ast
from importlib import import_module
import inspect
from pathlib import Path
from types import NoneType, UnionType
from typing import get_args, get_origin, get_type_hints, Union

import pytest
import yaml

pytestmark = pytest.mark.statement('A4', 'C1')

FACTS = yaml.safe_load(Path(__file__).with_name('signatures.yaml').read_text())


def entries():
    """Yield module, name and facts of each class and function."""
    for module, names in FACTS.items():
        for name, facts in names.items():
            yield pytest.param(module, name, facts, id=f'{module}.{name}')


def calls():
    """Yield module, path and ways of each function and method."""
    for module, names in FACTS.items():
        for name, facts in names.items():
            members = {name: facts} if isinstance(facts, list) else {
                f'{name}.{method}': ways for method, ways in facts.get('calls', {}).items()}
            for path, ways in members.items():
                for way in ways:
                    yield pytest.param(module, path, way, len(ways), id=f'{path}{way}')


def found(module, path):
    """Return what a dotted path names."""
    value = import_module(module)
    for part in path.split('.'):
        value = getattr(value, part)
    return value


def short(hint):
    """Return the name of a type without its arguments; of an optional type, that of the type."""
    if get_origin(hint) in (Union, UnionType):
        hint, = (each for each in get_args(hint) if each is not NoneType)
    origin = get_origin(hint) or hint
    return 'None' if origin is NoneType else origin.__name__



@pytest.mark.parametrize(('module', 'path', 'way', 'ways'), list(calls()))
def test_it_is_called_as_upstream(module, path, way, ways):
    """Arguments by position and by name, their defaults, and the type of the result."""
    function = found(module, path)
    if function is object.__init__:
        assert way == '()'
        return
    fact = ast.parse(f'def f{" ".join(way.split())}: ...').body[0]
    signature = inspect.signature(function)
    if '.' in path:
        signature = signature.replace(parameters=list(signature.parameters.values())[1:])
    names = [argument.arg for argument in fact.args.args]
    only = [argument.arg for argument in fact.args.kwonlyargs]
    signature.bind(*names, **dict.fromkeys(only))
    if not any(name.startswith('_') for name in names):
        signature.bind(**dict.fromkeys([*names, *only]))
    values = [ast.literal_eval(each) for each in (*fact.args.defaults, *fact.args.kw_defaults)]
    if ways == 1:
        optional = [*names[len(names) - len(fact.args.defaults):], *only]
        parameters = signature.parameters
        assert dict(zip(optional, values, strict=True)) == {
            name: parameters[name].default for name in optional}
        if not any(name.startswith('_') for name in names):
            assert [*names, *only] == list(parameters)
        assert all(parameters[name].kind is inspect.Parameter.KEYWORD_ONLY for name in only)
    if fact.returns is not None:
        hint = get_type_hints(function)['return']
        kinds = get_args(hint) if ways > 1 and get_origin(hint) is UnionType else [hint]
        assert ast.unparse(fact.returns) in {short(each) for each in kinds}


@pytest.mark.parametrize(('module', 'name', 'facts'), list(entries()))
def test_it_has_the_properties_of_upstream(module, name, facts):
    """Properties with their types, those that can be set, and fields with their defaults."""
    kind = found(module, name)
    if isinstance(facts, list):
        return
    for each, text in facts.get('properties', {}).items():
        mode, _, wanted = text.rpartition(' ')
        member = getattr(kind, each)
        assert (member.fset is not None) == (mode == 'rw'), each
        assert short(get_type_hints(member.fget)['return']) == wanted, each
    for each, wanted in facts.get('attributes', {}).items():
        assert get_type_hints(kind)[each].__name__ == wanted
    for each, wanted in facts.get('fields', {}).items():
        assert getattr(kind(), each) == wanted


@pytest.mark.parametrize('module', list(FACTS))
def test_a_module_offers_nothing_else(module):
    """What a star import brings is what upstream has."""
    assert set(FACTS[module]) <= set(import_module(module).__all__)
    assert {name for name in import_module(module).__all__
            if not inspect.ismodule(getattr(import_module(module), name))} == set(FACTS[module])


def test_star_import():
    """All modules of moveit.core, and all classes of moveit.planning."""
    space = {}
    exec('from moveit import *', space)
    modules = {name.rpartition('.')[2] for name in FACTS if name.startswith('moveit.core.')}
    assert modules | {*FACTS['moveit.planning'], 'World', 'get_launch_params_filepaths'} == {
        name for name in space if name != '__builtins__'}
