# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Run benchmarks by name: ``python -m benchmarks [NAME ...] [--seconds 10] ...``."""

from __future__ import annotations

import argparse
from dataclasses import fields
from importlib import import_module
from pathlib import Path
import sys

from benchmarks.options import Options

#: Options -> shorter names of theirs.
SHORT = {'problems_of_a_scene': ('per-set',)}
#: What runs where no name is given, in this order.
USUAL = ('startup', 'joint_states', 'goals')


def main(words: list[str]) -> int:
    """Run the named benchmarks, or the usual ones."""
    modules = {
        path.stem: f'benchmarks.{path.parent.name}.{path.stem}'
        for path in sorted(Path(__file__).parent.glob('*/*.py'), key=lambda path: path.stem)
        if '\ndef main(options: Options)' in path.read_text(encoding='utf-8')}
    known = ', '.join(modules)
    parser = argparse.ArgumentParser(
        prog='benchmarks', description='Measurements; they print tables and assert nothing.')
    parser.add_argument('names', nargs='*', metavar='NAME', help=f'of {known}')
    for field in fields(Options):
        spelled = dict.fromkeys((field.name, field.name.replace('_', '-'), *SHORT.get(
            field.name, ())))
        parser.add_argument(
            *(f'--{name}' for name in spelled), dest=field.name, type=type(field.default),
            default=field.default, metavar=str(field.default),
        )
    given = vars(parser.parse_args(words))
    names = given.pop('names')
    for name in names:
        if name not in modules:
            parser.error(f"no benchmark is called '{name}'; known: {known}")
    for name in names or USUAL:
        print(f'\n== {name}', flush=True)
        import_module(modules[name]).main(Options(**given))
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
