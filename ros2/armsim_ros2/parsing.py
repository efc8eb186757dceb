# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Command lines: commands, their verbs, and options that many verbs share."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NoReturn

from armsim_ros2.errors import CliError, hint

USAGE_STATUS = 2
_HIDDEN = '--include-hidden-'


class Parser(argparse.ArgumentParser):
    """A parser whose errors are failures."""

    def error(self, message: str) -> NoReturn:
        """Refuse the command line."""
        raise CliError(f'{self.format_usage()}{self.prog}: error: {message}', USAGE_STATUS)


#: Adds a verb's own arguments to its parser.
Arguments = Callable[[Parser], Any]


@dataclass(frozen=True)
class Verb:
    """
    A verb of a command.

    :param about: one line of help.
    :param run: gets the parsed arguments; returns the status, None for 0.
    :param arguments: functions that add arguments to the verb's parser.
    """

    about: str
    run: Callable[[argparse.Namespace], int | None]
    arguments: Sequence[Arguments] = field(default=())


def run_verb(command: str, about: str, verbs: Mapping[str, Verb], argv: Sequence[str]) -> int:
    """
    Parse a command's arguments and run the verb.

    :param argv: the arguments after the command.
    :returns: the status.
    :raises CliError: the arguments are wrong, or the verb failed.
    """
    words = list(argv)
    early: list[str] = []
    while words and words[0].startswith(_HIDDEN):
        early.append(words.pop(0))
    if not words or words[0] in ('-h', '--help'):
        print(f'usage: ros2 {command} VERB ...\n\n{about}\n\n{listing(verbs)}\n\n'
              f'Call `ros2 {command} VERB -h` for the arguments of a verb.')
        return 0
    name, *rest = words
    if name not in verbs:
        raise CliError(unknown(f'ros2 {command}', 'verb', name, verbs), USAGE_STATUS)
    verb = verbs[name]
    parser = Parser(prog=f'ros2 {command} {name}', description=verb.about)
    for add in verb.arguments:
        add(parser)
    return verb.run(parser.parse_args([*early, *rest])) or 0


def listing(verbs: Mapping[str, Verb | str]) -> str:
    """Return names with their lines of help, one per line."""
    width = max(map(len, verbs))
    return '\n'.join(f'  {name:{width}}  {verb if isinstance(verb, str) else verb.about}'
                     for name, verb in verbs.items())


def unknown(program: str, kind: str, name: str, known: Mapping[str, Any]) -> str:
    """Return the message about an unknown command or verb."""
    return (f"{program}: error: unknown {kind} '{name}'{hint(name, known)} "
            f'(choose from: {", ".join(known)})')


def argument(*names: str, **options: Any) -> Arguments:
    """Return a function that adds one argument."""
    return lambda parser: parser.add_argument(*names, **options)


def flag(*names: str, about: str, **options: Any) -> Arguments:
    """Return a function that adds an option without a value."""
    return argument(*names, action='store_true', help=about, **options)


def exclusive(*arguments: Arguments) -> Arguments:
    """Return a function that adds arguments of which only one may be given."""
    def add(parser: Parser) -> None:
        group: Any = parser.add_mutually_exclusive_group()
        for add_to in arguments:
            add_to(group)

    return add


def hidden(kind: str) -> Arguments:
    """
    Return a function that adds the option to include hidden names; actions are never left out.

    :param kind: topic, service, action or node.
    """
    if kind == 'action':
        return lambda parser: parser.set_defaults(hidden=True)
    return flag(f'{_HIDDEN}{kind}s', dest='hidden',
                about=f'include {kind}s whose names begin with an underscore')


def node_options(parser: Parser) -> None:
    """Add the options of every verb that reads the graph."""
    parser.add_argument('--spin-time', type=float, default=0.5, metavar='SECONDS',
                        help='longest time to wait for discovery (default: %(default)s)')
    parser.add_argument('-s', '--use-sim-time', action='store_true', help='use the time of /clock')
    parser.add_argument('--no-daemon', action='store_true',
                        help='accepted for compatibility; there is no daemon')


def yaml_argument(name: str, about: str) -> Arguments:
    """Return a function that adds a YAML text, from the command line or standard input."""
    return exclusive(argument(name, nargs='?', default='{}', help=about),
                     flag('--stdin', about='read the values from standard input'))


def positive_float(text: str) -> float:
    """Return a number above 0."""
    value = float(text)
    if not value > 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not above 0")
    return value


def positive_int(text: str) -> int:
    """Return an integer above 0."""
    positive_float(text)
    return int(text)


def natural_int(text: str) -> int:
    """Return an integer from 0."""
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"'{text}' is negative")
    return value
