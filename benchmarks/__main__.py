# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Run benchmarks by name: ``python -m benchmarks [NAME ...]``."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
import sys

#: What runs where no name is given, in this order.
USUAL = ('startup', 'joint_states', 'goals')


def main(names: list[str]) -> int:
    """Run the named benchmarks, or the usual ones."""
    known = sorted(
        path.stem
        for path in Path(__file__).parent.glob('*.py')
        if not path.stem.startswith('_') and 'def main(' in path.read_text(encoding='utf-8')
    )
    for name in names:
        if name not in known:
            print(f"no benchmark is called '{name}'; known: {', '.join(known)}", file=sys.stderr)
            return 2
    for name in names or USUAL:
        print(f'\n== {name}', flush=True)
        import_module(f'benchmarks.{name}').main()
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
