# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Finds words that CONTRIBUTING.md's glossary replaces, in packages, examples and pages."""

from __future__ import annotations

from collections.abc import Iterator
import io
from pathlib import Path
import re
import sys
import tokenize

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ('armsim_ros', 'distributions', 'helpers', 'ros2', 'examples')
#: Pages in Markdown; code in them is left out. The glossary itself is in CONTRIBUTING.md.
PAGES = ('README.md', 'docs/*.md')
#: What comments, docstrings, messages and pages do not contain -> what they contain instead.
WORDS = {
    r'look(s|ed|ing)? at': 'check, read',
    r'judg(e|es|ed|ing)': 'check, monitor',
    r"(the )?originals|original's|original stack": 'upstream',
    r'(planned )?flights?': 'batched updates',
    r'visitors?': 'session, user',
    r'somebody|nobody|anybody|everybody|whoever': 'the client, the caller, the node',
    r'him|himself|his': 'it, the user',
    r'mistakes?': 'error',
    r'stands?|stood|stands? in for': 'is, replaces, represents',
    r'gives? way': 'is overridden, yields',
    r'comes? late': 'is delayed',
    r'tells?|told|says?|said': 'report, log, print, publish',
    r'wish|wishes': 'request',
}
_WORDS = {re.compile(rf'(?<![\w-])({word})(?![\w-])', re.IGNORECASE): better
          for word, better in WORDS.items()}
_SPAN = re.compile(r'`[^`]*`')
_NAMES = {'one', 'thing', 'things'}
_TEXT = {tokenize.COMMENT, tokenize.STRING, getattr(tokenize, 'FSTRING_MIDDLE', tokenize.STRING)}


def main() -> int:
    """Print each find with file and line; return 1 where there is any."""
    found = [line for package in PACKAGES for path in sorted((ROOT / package).rglob('*.py'))
             for line in _finds(path)]
    found += [line for pattern in PAGES for path in sorted(ROOT.glob(pattern))
              for line in _finds_in_page(path)]
    print(*found, sep='\n', end='\n' if found else '')
    return 1 if found else 0


def _finds(path: Path) -> Iterator[str]:
    where = path.relative_to(ROOT)
    for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding='utf-8')).readline):
        if token.type == tokenize.NAME and token.string in _NAMES:
            yield f"{where}:{token.start[0]}: the name '{token.string}': name what it is"
        elif token.type in _TEXT:
            for offset, text in enumerate(token.string.split('\n')):
                yield from _finds_in_line(f'{where}:{token.start[0] + offset}', text)


def _finds_in_page(path: Path) -> Iterator[str]:
    where, code = path.relative_to(ROOT), False
    for number, line in enumerate(path.read_text(encoding='utf-8').splitlines(), 1):
        if line.lstrip().startswith('```'):
            code = not code
        elif not code and not line.startswith('    '):
            yield from _finds_in_line(f'{where}:{number}', _SPAN.sub('', line))


def _finds_in_line(place: str, text: str) -> Iterator[str]:
    for word, better in _WORDS.items():
        if match := word.search(text):
            yield f"{place}: '{match[0]}': better {better}"


if __name__ == '__main__':
    sys.exit(main())
