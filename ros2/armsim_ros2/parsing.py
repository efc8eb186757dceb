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
DEFAULT_SPIN_TIME = 0.5


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
    while words and words[0] in ('--include-hidden-topics', '--include-hidden-services'):
        early.append(words.pop(0))
    if not words or words[0] in ('-h', '--help'):
        print(f'usage: ros2 {command} VERB ...\n\n{about}\n\n{listing(verbs)}\n\n'
              f'Call `ros2 {command} VERB -h` for the arguments of a verb.')
        return 0
    name, *rest = words
    if name not in verbs:
        raise CliError(unknown(f'ros2 {command}', 'verb', name, verbs), USAGE_STATUS)
    verb = verbs[name]
    parser = Parser(prog=f'ros2 {command} {name}', description=verb.about, allow_abbrev=False)
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


def exclusive(*arguments: tuple[tuple[str, ...], dict[str, Any]]) -> Arguments:
    """Return a function that adds arguments of which only one may be given."""
    def add(parser: Parser) -> None:
        group = parser.add_mutually_exclusive_group()
        for names, options in arguments:
            group.add_argument(*names, **options)

    return add


def flag(*names: str, about: str) -> Arguments:
    """Return a function that adds an option without a value."""
    return argument(*names, action='store_true', help=about)


def node_options(parser: Parser) -> None:
    """Add the options of every verb that reads the graph."""
    parser.add_argument('--spin-time', type=float, default=DEFAULT_SPIN_TIME, metavar='SECONDS',
                        help='longest time to wait for discovery (default: %(default)s)')
    parser.add_argument('-s', '--use-sim-time', action='store_true', help='use the time of /clock')
    parser.add_argument('--no-daemon', action='store_true',
                        help='accepted for compatibility; there is no daemon')


def hidden_topics(parser: Parser) -> None:
    """Add the option to include hidden topics."""
    parser.add_argument('--include-hidden-topics', action='store_true',
                        help='include topics whose names begin with an underscore')


def hidden_services(parser: Parser) -> None:
    """Add the option to include hidden services."""
    parser.add_argument('--include-hidden-services', action='store_true',
                        help='include services whose names begin with an underscore')


def yaml_argument(name: str, about: str) -> Arguments:
    """Return a function that adds a YAML text, from the command line or standard input."""
    return exclusive(
        ((name,), {'nargs': '?', 'default': '{}', 'help': about}),
        (('--stdin',), {'action': 'store_true', 'help': 'read the values from standard input'}))


def positive_float(text: str) -> float:
    """Return a number above 0."""
    value = float(text)
    if not value > 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not above 0")
    return value


def positive_int(text: str) -> int:
    """Return an integer above 0."""
    value = int(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not above 0")
    return value


def natural_int(text: str) -> int:
    """Return an integer from 0."""
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"'{text}' is negative")
    return value
