# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Checks the examples of docs/library.md as a user's program is checked strictly: `make lint`."""

from __future__ import annotations

import os
from pathlib import Path
import re
import subprocess
import sys

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / 'docs' / 'library.md'
PROGRAM = ROOT / 'build' / 'library_page.py'


def main() -> int:
    """Return the status of mypy, which has checked what the program imports before."""
    PROGRAM.parent.mkdir(exist_ok=True)
    PROGRAM.write_text(examples(), encoding='utf-8')
    return subprocess.run([sys.executable, '-m', 'mypy', os.path.relpath(PROGRAM, ROOT)],
                          cwd=ROOT, check=False).returncode


def examples() -> str:
    """Return the examples of the page as one program."""
    text = PAGE.read_text(encoding='utf-8')
    return '\n\n'.join(re.findall(r'```python\n(.*?)```', text, re.DOTALL))


if __name__ == '__main__':
    sys.exit(main())
