# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Finds words in packages that CONTRIBUTING.md's glossary replaces. Standard library only."""

from __future__ import annotations

from collections.abc import Iterator
import io
from pathlib import Path
import re
import sys
import tokenize

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ('armsim_ros', 'helpers', 'ros2')
#: What comments, docstrings and messages do not contain -> what they contain instead.
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
_NAMES = {'one', 'thing', 'things'}
_TEXT = {tokenize.COMMENT, tokenize.STRING, getattr(tokenize, 'FSTRING_MIDDLE', tokenize.STRING)}


def main() -> int:
    """Print each find with file and line; return 1 where there is any."""
    found = [line for package in PACKAGES for path in sorted((ROOT / package).rglob('*.py'))
             for line in _finds(path)]
    print(*found, sep='\n', end='\n' if found else '')
    return 1 if found else 0


def _finds(path: Path) -> Iterator[str]:
    where = path.relative_to(ROOT)
    for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding='utf-8')).readline):
        if token.type == tokenize.NAME and token.string in _NAMES:
            yield f"{where}:{token.start[0]}: the name '{token.string}': name what it is"
        elif token.type in _TEXT:
            for offset, text in enumerate(token.string.split('\n')):
                for word, better in _WORDS.items():
                    if match := word.search(text):
                        yield (f"{where}:{token.start[0] + offset}: '{match[0]}': "
                               f'better {better}')


if __name__ == '__main__':
    sys.exit(main())
