# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 interface``: read from the definition files; only ``proto`` imports a type."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterable
import sys

from armsim_ros2.errors import CliError, hint
from armsim_ros2.interfaces import all_names, definition_file, KINDS, load, nested_type
from armsim_ros2.packages import prefix_of, resources
from armsim_ros2.parsing import argument, exclusive, flag, Parser, Verb
from armsim_ros2.values import to_yaml

_TITLES = {'msg': 'Messages', 'srv': 'Services', 'action': 'Actions'}


def _kinds(options: Namespace) -> list[str]:
    """Return the requested kinds, in the order of the lists; all if none is requested."""
    chosen = [kind for kind, wanted in zip(
        KINDS, (options.only_msgs, options.only_srvs, options.only_actions), strict=True)
        if wanted]
    return chosen or list(KINDS)


def _of_kinds(kinds: Iterable[str], package: str | None = None) -> list[str]:
    names = all_names(package)
    return [name for kind in kinds for name in names if name.split('/')[1] == kind]


def _list(options: Namespace) -> None:
    for kind in _kinds(options):
        print(f'{_TITLES[kind]}:')
        for name in _of_kinds([kind]):
            print(f'    {name}')


def _package(options: Namespace) -> None:
    name = options.package_name
    prefix_of(name, "Unknown package '{}'")
    for full in _of_kinds(_kinds(options), name):
        print(full)


def _packages(options: Namespace) -> None:
    kinds = _kinds(options)
    if kinds == list(KINDS):
        names = list(resources('rosidl_interfaces'))
    else:
        names = sorted({name.split('/')[0] for name in _of_kinds(kinds)})
    for name in names:
        print(name)


def _show(options: Namespace) -> None:
    name = options.type
    if name == '-':
        name = sys.stdin.readline().strip()
        if not name:
            raise CliError('the passed value is empty', 2)
    _print_definition(name, not options.no_comments, options.all_comments, 0)


def _print_definition(name: str, comments: bool, nested_comments: bool, depth: int) -> None:
    package = name.split('/')[0]
    for line in definition_file(name).read_text(encoding='utf-8').splitlines():
        text = line.rstrip()
        code, _, comment = (part.strip() for part in text.partition('#'))
        # As upstream, which keeps a # without a text.
        shown = text if comments or not comment else code
        if comments or shown:
            print('\t' * depth + shown if shown else '')
        nested = nested_type(code, package)
        if nested:
            _print_definition(nested, nested_comments, nested_comments, depth + 1)


def _proto(options: Namespace) -> None:
    parts = options.type.split('/')
    kind = parts[1] if len(parts) == 3 else 'msg'
    if kind not in KINDS:
        raise CliError(f"Invalid name '{options.type}'{hint(options.type, all_names())}")
    found = load(options.type, kind, "Could not find the interface '{}'")
    part = {'srv': 'Request', 'action': 'Goal'}.get(kind)
    text = to_yaml(getattr(found, part)() if part else found())
    print(text if options.no_quotes else f'"{text}"')


def _only(parser: Parser) -> None:
    for letter, name, about in (('m', 'msgs', 'messages'), ('s', 'srvs', 'services'),
                                ('a', 'actions', 'actions')):
        parser.add_argument(f'-{letter}', f'--only-{name}', action='store_true',
                            help=f'only {about}')


_type = argument('type', help='such as std_msgs/msg/String; - reads it from standard input')

VERBS = {
    'list': Verb('print the names of all interfaces', _list, [_only]),
    'package': Verb('print the interfaces of a package', _package, [
        argument('package_name', help='name of the package'), _only]),
    'packages': Verb('print the packages with interfaces', _packages, [_only]),
    'proto': Verb('print the default values of an interface as YAML', _proto, [
        _type, flag('--no-quotes', about='print them without quotes')]),
    'show': Verb('print the definition of an interface', _show, [
        exclusive(flag('--all-comments', about='print comments of nested types, too'),
                  flag('--no-comments', about='print neither comments nor empty lines')),
        _type]),
}
