# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Blocks of the pages, and what the comment above a block tells a test about it.

``<!-- not run: REASON -->``   the block is not executed
``<!-- beside a robot -->``    the program needs a robot that runs
``<!-- file: NAME -->``        the block is the content of a file that later commands use
``<!-- edit FILE: A -> B -->`` the file is changed before the commands run
``<!-- numbers: any -->``      the output has other numbers; ``within 0.5`` is a share of each
``<!-- or: A | B -->``         the output depends on timing, and may also be A or B
``<!-- last line -->``         the output has other lines before
``<!-- at the same time -->``  the first command still runs while the second does

``python test/support/documents.py`` prints how many blocks run, and the others with their reasons.
"""

from dataclasses import dataclass
from pathlib import Path
import re

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted((ROOT / 'docs').glob('*.md')))
_NUMBER = re.compile(r'-?\d+(?:\.\d+)?(?:e-?\d+)?')
_SMALLEST = 0.3
#: Wall time, which depends on the machine.
_PLANNED = re.compile(r'planned in [\d.]+')


@dataclass(frozen=True)
class Block:
    """
    A block between fences.

    :param line: of the opening fence.
    :param comment: above it, '' where there is none.
    """

    page: Path
    line: int
    language: str
    text: str
    comment: str

    @property
    def place(self):
        """File and line."""
        return f'{self.page.relative_to(ROOT)}:{self.line}'

    @property
    def reason(self):
        """Why it is not run, '' where it is."""
        return self.comment.partition('not run:')[2].strip()

    @property
    def commands(self):
        """The command lines, continued lines joined, prompts and remarks removed."""
        lines = self.text.replace('\\\n', ' ').splitlines()
        return [re.sub(r'^\$ |\s+# .*$', '', line.strip()) for line in lines if line.strip()]


def blocks(page):
    """Return the blocks of a page in their order."""
    found, comment, begin = [], '', None
    lines = page.read_text(encoding='utf-8').splitlines()
    for number, line in enumerate(lines, 1):
        stripped = line.strip()
        if stripped.startswith('```'):
            if begin is None:
                begin = number
                language = stripped[3:]
            else:
                text = '\n'.join(lines[begin:number - 1])
                found.append(Block(page, begin, language, text, comment))
                begin, comment = None, ''
        elif begin is None and (stripped or not comment):
            match = re.fullmatch(r'<!-- (.*) -->', stripped)
            comment = match[1] if match else ''
    assert begin is None, f'{page}: a block is not closed'
    return found


def all_blocks():
    """Return the blocks of all pages; directives of Sphinx are not blocks."""
    return [block for page in PAGES for block in blocks(page)
            if not block.language.startswith('{')]


def summary():
    """Return a line with the number of blocks that run, and a line per block that does not."""
    found = all_blocks()
    idle = [block for block in found if block.reason]
    return [f'documentation blocks: {len(found) - len(idle)} run, {len(idle)} not run:',
            *(f'  {block.place}: {block.reason}' for block in idle)]


def same_output(expected, actual, comment=''):
    """
    Return whether an output is what a page shows.

    :param comment: of the block, see above.
    """
    if comment.startswith('or: ') and actual.strip() in comment[4:].split(' | '):
        return True
    if 'last line' in comment:
        actual = actual.strip().splitlines()[-1]
    expected, actual = _PLANNED.sub('planned in', expected), _PLANNED.sub('planned in', actual)
    first, second = _NUMBER.sub('#', expected.strip()), _NUMBER.sub('#', actual.strip())
    if first.split() != second.split():
        return False
    if 'numbers: any' in comment:
        return True
    share = float((re.search(r'within ([\d.]+)', comment) or [0, '0'])[1])
    return all(abs(float(one) - float(other)) <= max(share * abs(float(one)),
                                                     share and _SMALLEST)
               for one, other in zip(_NUMBER.findall(expected), _NUMBER.findall(actual),
                                     strict=True))


if __name__ == '__main__':
    print(*summary(), sep='\n')
