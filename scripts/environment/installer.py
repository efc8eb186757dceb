# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Why an environment cannot be made, in a sentence the user can act on."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from functools import cached_property
import os
from pathlib import Path
import re
import subprocess

from environment.machine import clean_environment, SetupError

_UNREACHABLE = re.compile(
    r'Retrying \(Retry|NewConnectionError|Temporary failure in name resolution|'
    r'Failed to establish a new connection|ProxyError|ConnectTimeoutError|Network is unreachable',
    re.IGNORECASE)
_FULL = re.compile(r'No space left on device')
_NO_RELEASE = re.compile(r'No matching distribution found for (\S.*)')
_SHOWN_LINES = 6


def pip_failure(task: str, output: str, log: Path) -> SetupError:
    """
    Explain a failed pip.

    :param task: what pip was to do, as the end of "cannot ...".
    :param output: everything that it printed.
    :param log: the file that holds the output.
    """
    see = f'; all of it: {log}'
    if _FULL.search(output):
        return SetupError(f'cannot {task}: the disk is full{see}')
    if _UNREACHABLE.search(output):
        return SetupError(
            f'cannot {task}: the Python package index does not answer; check the network, or '
            f'name a proxy (HTTPS_PROXY) or a mirror (PIP_INDEX_URL){see}')
    missing = _NO_RELEASE.search(output)
    if missing:
        return SetupError(
            f'cannot {task}: there is no {missing.group(1)} for this Python and platform{see}')
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    telling = [line for line in lines if re.match(r'(ERROR|error|fatal)\b', line)] or lines
    return SetupError('\n  '.join([f'cannot {task}{see}', *telling[-_SHOWN_LINES:]]))


_UV = 'uv>=0.5'
#: What of pip's configuration uv takes under which name; a list has one option for each value.
_OPTIONS = {
    'index-url': '--default-index',
    'extra-index-url': '--index',
    'find-links': '--find-links',
    'no-index': '--no-index',
    'constraint': '--constraints',
    'trusted-host': '--allow-insecure-host',
}
_SWITCHES = {'no-index'}
#: The same for what uv reads from its environment.
_VARIABLES = {'cert': 'SSL_CERT_FILE', 'client-cert': 'SSL_CLIENT_CERT',
              'proxy': 'ALL_PROXY', 'timeout': 'UV_HTTP_TIMEOUT'}

#: Of the path of a module: folders of tests in its package.
_OWN_TESTS = r'/site-packages/.+/tests?/'
_CPUS = len(os.sched_getaffinity(0))


class Installer:
    """
    Installs into one environment.

    :param venv: the environment's folder; pip's log is kept there.
    """

    def __init__(self, venv: Path) -> None:
        self._venv = venv
        self._python = venv / 'bin' / 'python'
        self._uv = venv / 'bin' / 'uv'
        self._log = venv / 'pip.log'

    def pip(self, task: str, words: Sequence[str | Path]) -> None:
        """
        Let pip install, without byte code.

        :param task: what is to be done, as the end of "cannot ...".
        :param words: options and requirements.
        :raises SetupError: where that fails.
        """
        with open(self._log, 'a+', encoding='utf-8', errors='replace') as stream:
            start = stream.seek(0, os.SEEK_END)
            status = subprocess.run([self._python, '-m', 'pip', 'install', '--no-compile', *words],
                                    stdin=subprocess.DEVNULL, stdout=stream,
                                    stderr=subprocess.STDOUT, env=clean_environment()).returncode
            stream.seek(start)
            if status != 0:
                raise pip_failure(task, stream.read(), self._log)

    def quick(self, task: str, words: Sequence[str | Path]) -> None:
        """
        Let uv install from where pip's configuration says; what it cannot do, pip does.

        :param task: what is to be done, as the end of "cannot ...".
        :param words: requirements, and options that uv and pip share.
        :raises SetupError: where pip fails too, with pip's reason.
        """
        try:
            if not self._uv.exists():
                self.pip('install uv', ['--only-binary', ':all:', _UV])
            if self._run_uv(words):
                return
        except SetupError:
            pass  # There is no uv for this platform or in this index.
        self.pip(task, words)

    def compile(self) -> None:
        """
        Make the byte code of all that is installed, except the packages' own tests.

        What Python says of a package's code then is not for the user, nor does the first program
        pay for it. Files that are not for this Python stay without.
        """
        for folder in self._venv.glob('lib/python*/site-packages'):
            packages = sorted(path for path in folder.iterdir() if path.suffix != '.dist-info')
            workers = [subprocess.Popen(
                [self._python, '-m', 'compileall', '-qq', '-x', _OWN_TESTS,
                 *packages[part::_CPUS]],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                env=clean_environment()) for part in range(min(_CPUS, len(packages)))]
            for worker in workers:
                worker.wait()

    def _run_uv(self, words: Sequence[str | Path]) -> bool:
        options, variables = self._uv_settings
        with open(self._log, 'a', encoding='utf-8', errors='replace') as stream:
            return subprocess.run(
                [self._uv, 'pip', 'install', '--python', self._python, *options, *words],
                stdin=subprocess.DEVNULL, stdout=stream, stderr=subprocess.STDOUT,
                env={**clean_environment(), **variables}).returncode == 0

    @cached_property
    def _uv_settings(self) -> tuple[list[str], dict[str, str]]:
        return uv_options(subprocess.run(
            [self._python, '-m', 'pip', 'config', 'list'], text=True, stdout=subprocess.PIPE,
            env=clean_environment()).stdout)


def uv_options(listed: str) -> tuple[list[str], dict[str, str]]:
    """
    Return the options and the environment that make uv look where pip looks.

    :param listed: what ``pip config list`` prints: ``section.name='value'`` in each line, the
        sections in the order in which they override each other.
    """
    settings = dict(_settings(listed))
    # As pip does: the best version of all indexes, not the first index that knows the name.
    options = ['--index-strategy', 'unsafe-best-match']
    for name, option in _OPTIONS.items():
        if name in _SWITCHES:
            options += [option] if settings.get(name, '').lower() in {'1', 'true', 'yes'} else []
        else:
            for value in settings.get(name, '').split():
                options += [option, value]
    return options, {variable: settings[name] for name, variable in _VARIABLES.items()
                     if name in settings}


def _settings(listed: str) -> Iterator[tuple[str, str]]:
    """Yield what applies to pip install: the command's own after what is for all commands."""
    rank = {'global': 0, 'install': 1, ':env:': 2}
    found = []
    for line in listed.splitlines():
        key, _, value = line.partition('=')
        section, _, name = key.rpartition('.')
        if section in rank:
            found.append((rank[section], name, str(ast.literal_eval(value))))
    yield from ((name, value) for _, name, value in sorted(found, key=lambda one: one[0]))
