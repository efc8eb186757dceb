# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The tutorial, word for word: each command in its order, each output compared."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys

from documents import blocks, ROOT, same_output

from armsim_ros.testing.program import private_domain, ros_environment, start_program

MODULES = {'ros2': ['-m', 'armsim_ros2'], 'armsim': ['-m', 'armsim_ros'], 'python': []}
LIMIT = 60
#: A joint that is faster than this moves [rad/s].
MOVES = 1e-3


class Reader:
    """
    Somebody who types what the page says, in a folder of their own.

    :param folder: where files are written and commands run.
    """

    def __init__(self, folder, domain):
        self.folder = folder
        self.environment = {**os.environ, **ros_environment(domain),
                            'PYTHONPATH': f'{ROOT}:{ROOT / "ros2"}'}
        self.printed = ''
        self.status = 0

    def start(self, line):
        """Start a command; its output is one text, as in a terminal."""
        program, *words = shlex.split(line)
        return subprocess.Popen(
            [sys.executable, *MODULES[program], *words], cwd=self.folder, text=True,
            env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def run(self, line):
        """Run a command to its end; returns what it prints."""
        process = self.start(line)
        out, _ = process.communicate(timeout=LIMIT)
        self.status = process.returncode
        return out

    def moves(self):
        """Whether the arm moves."""
        joints = json.loads(self.run('armsim state --json'))['joints']
        return any(abs(joint['velocity']) > MOVES for joint in joints)

    def follow(self, block):
        """Do what a block of commands or a file says."""
        if edit := re.fullmatch(r'edit (\S+): (.*) -> (.*)', block.comment):
            file = self.folder / edit[1]
            text = file.read_text()
            assert edit[2] in text
            file.write_text(text.replace(edit[2], edit[3]))
        if block.language == 'python':
            file = re.fullmatch(r'file: (\S+)', block.comment)[1]
            (self.folder / file).write_text(block.text)
        elif block.comment == 'at the same time':
            first, second = block.commands
            process = self.start(first)
            while not self.moves():
                assert process.poll() is None, process.stdout.read()
            self.printed = [self.run(second), process.communicate(timeout=LIMIT)[0]]
            self.status = process.returncode
        else:
            self.printed = [''.join(self.run(line) for line in block.commands)]


def test_the_tutorial_is_true(tmp_path):
    """Each output is the one of the page, numbers within the tolerance that stands beside it."""
    page = blocks(ROOT / 'docs/tutorial.md')
    started, *rest = [block for block in page if not block.reason]
    with private_domain() as domain, start_program(
            'bringup', domain, 'web:=true') as bringup:
        for line in started.text.splitlines():
            pattern = re.sub(r'\d+', r'\\d+', re.escape(line)).replace(r'\.\d+', r'(\.\d+)?')
            bringup.wait_for_line(f'^{pattern}$', LIMIT)
        reader = Reader(tmp_path, domain)
        for block in rest:
            if block.language != 'text':
                reader.follow(block)
                continue
            printed = reader.printed.pop(0)
            assert same_output(block.text, printed, block.comment), (
                f'{block.place}: the page has\n{block.text}\nprinted was\n{printed}')
        assert reader.status == 1  # of the command that was stopped
        bringup.signal(signal.SIGINT)
        assert bringup.wait(10) == 0
        assert bringup.output[-1] == '[bringup] all has stopped'
