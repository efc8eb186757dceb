# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Verbs that topics, services and actions share: list, type and find."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping

from armsim_ros2.parsing import argument, Arguments, flag, hidden, Verb
from armsim_ros2.session import graph_verb, Session

SHOW_TYPES = flag('-t', '--show-types', about='print types, too')


def name_argument(kind: str) -> Arguments:
    """Return a function that adds the argument for the name of a topic, service or action."""
    return argument(f'{kind}_name', help=f'name of the {kind}')


def count_option(kind: str) -> Arguments:
    """Return a function that adds the option to print only a number."""
    return flag('-c', f'--count-{kind}s', dest='count', about=f'print only the number of {kind}s')


def print_names(names: Mapping[str, list[str]], options: Namespace) -> None:
    """Print names, with their types if requested, or only their number."""
    if options.count:
        print(len(names))
        return
    for name, types in names.items():
        print(f'{name} [{", ".join(types)}]' if options.show_types else name)


def list_verb(kind: str) -> Verb:
    """Return the verb that lists all names of a kind."""
    def run(session: Session, options: Namespace) -> None:
        # What this imports is there once discovery is complete.
        session.names(kind)
        session.settle()
        print_names(session.names(kind, options.hidden), options)

    return graph_verb(f'print the {kind}s of the graph', run, SHOW_TYPES, count_option(kind),
                      hidden(kind))


def type_verb(kind: str) -> Verb:
    """Return the verb that prints the type of a name."""
    def run(session: Session, options: Namespace) -> None:
        print(*session.types_of(kind, getattr(options, f'{kind}_name')), sep='\n')

    return graph_verb(f'print the type of {"an" if kind == "action" else "a"} {kind}', run,
                      name_argument(kind), hidden(kind))


def find_verb(kind: str, example: str) -> Verb:
    """
    Return the verb that prints the names with a type.

    :param example: of a type, for the help.
    """
    def run(session: Session, options: Namespace) -> None:
        session.names(kind)
        session.settle()
        print_names({name: types for name, types in session.names(kind, options.hidden).items()
                     if options.wanted in types}, options)

    return graph_verb(f'print the {kind}s of a type', run,
                      argument('wanted', metavar=f'{kind}_type', help=f'such as {example}'),
                      count_option(kind), hidden(kind),
                      lambda parser: parser.set_defaults(show_types=False))
