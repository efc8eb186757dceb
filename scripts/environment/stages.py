# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The command line of env.py, and the stages of an environment, done again where needed."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
import fcntl
import hashlib
import json
import os
from pathlib import Path
import shutil
import subprocess
import sys
import tempfile

from environment.installer import Installer
from environment.interfaces import InterfaceWheel
from environment.machine import (
    ask_interpreter,
    check_venv_module,
    clean_environment,
    Interpreter,
    SetupError,
    sourced_ros,
)
from environment.sources import content_hash, copy_files, PACKAGE_SOURCES, requirements

#: The pip that comes with Python 3.10 to 3.12 searches very long among our dependencies' versions;
#: setuptools builds the package and the ros2 command inside the environment, without the network.
TOOLS = ('pip>=25', 'setuptools>=70.1')
_ROS2_COMMAND = 'ros2'
#: Python packages of ROS that no index has; a ROS installation brings its own.
_HELPERS = 'helpers'
#: The name moveit; an installed MoveIt comes before it.
_MOVEIT = 'distributions/moveit'
#: The stage of the byte code, which is of all that was installed.
_COMPILED = 'compiled'
Install = Callable[[str, Sequence[str | Path]], None]


class EnvironmentBuilder:
    """
    Brings one environment folder to the state of the source tree.

    :param root: the source tree.
    :param venv: the environment's folder.
    """

    def __init__(self, root: Path, venv: Path) -> None:
        self._root = root
        self._venv = venv
        self._python = venv / 'bin' / 'python'
        self._record = venv / 'armsim_env.json'
        self._installer = Installer(venv)
        self._done: dict[str, str] = {}
        if self._python.exists() and self._record.is_file():
            try:
                self._done = json.loads(self._record.read_text(encoding='utf-8'))
            except ValueError:
                self._done = {}

    def build(self, extras: Sequence[str], *, this_python: bool) -> None:
        """
        Do what is not done yet.

        :param extras: extras of setup.cfg beside the package's own requirements.
        :param this_python: make the environment anew where it has another Python than the
            running one; otherwise an environment that exists keeps its Python.
        :raises SetupError: where something is missing.
        """
        interpreter = self._recorded_interpreter()
        if interpreter is None or (this_python and interpreter.tag != _running().tag):
            interpreter = _running()
            self._done = {}
        ros = sourced_ros(interpreter.version)
        venv_key = _key([interpreter.version, interpreter.tag, str(ros)])
        if self._done.get('venv') != venv_key:
            self._make_venv(interpreter, ros)
            self._note('venv', venv_key)
        wheel = InterfaceWheel(self._root, interpreter, ros)
        needs_wheel = wheel.is_needed() and self._done.get('interfaces') != wheel.key
        log = self._log('interfaces')
        self._install('tools', TOOLS, self._installer.pip)
        # Of the packages of a ROS installation uv knows nothing.
        install = self._installer.quick if ros is None else self._installer.pip
        try:
            if needs_wheel and wheel.existing() is None:
                self._say('compiling the ROS interface packages beside it (a minute or two, once)')
                wheel.start(self._python, log)
            self._install('packages', [
                *requirements(self._root), *requirements(self._root, 'web'),
                *(requirements(self._root, 'ros') if ros is None else ())], install)
            for extra in extras:
                self._install(extra, requirements(self._root, extra), install)
            if needs_wheel:
                file = wheel.existing() or wheel.finish(log)
                install('install the ROS interface packages', [
                    '--force-reinstall', '--no-deps', file])
                self._note('interfaces', wheel.key)
        finally:
            wheel.clean_up()
        self._install_sources(
            [_ROS2_COMMAND, _MOVEIT, *(() if ros is not None else (_HELPERS,))], install)
        installed = _key(
            f'{stage} {key}' for stage, key in self._done.items() if stage != _COMPILED)
        if self._done.get(_COMPILED) != installed:
            self._installer.compile()
            self._note(_COMPILED, installed)

    def _recorded_interpreter(self) -> Interpreter | None:
        text = self._done.get('interpreter')
        return Interpreter(**json.loads(text)) if text else None

    def _make_venv(self, interpreter: Interpreter, ros: Path | None) -> None:
        check_venv_module()
        self._check_ownership()
        self._say(f'making {self._venv} with Python {interpreter.version}'
                  + (f', using the ROS installation {ros}' if ros else ''))
        shutil.rmtree(self._venv, ignore_errors=True)
        self._venv.mkdir(parents=True)
        self._record.write_text('{}', encoding='utf-8')  # the folder is ours from now on
        command = [sys.executable, '-m', 'venv', str(self._venv)]
        if ros is not None:
            command.append('--system-site-packages')
        made = subprocess.run(command, capture_output=True, text=True, env=clean_environment())
        if made.returncode != 0:
            raise SetupError(f'cannot make {self._venv}: '
                             f'{(made.stderr or made.stdout).strip()}')
        self._done = {}
        self._note('interpreter', json.dumps(vars(interpreter)))

    def _check_ownership(self) -> None:
        """
        Refuse a folder with files that this program did not make.

        :raises SetupError: names what the folder holds.
        """
        if not self._venv.exists() or self._record.is_file() or not any(self._venv.iterdir()):
            return
        found = sorted(path.name for path in self._venv.iterdir())
        kind = 'a Python environment made by another program' if 'pyvenv.cfg' in found else (
            f'other files ({", ".join(found[:3])}{", ..." if len(found) > 3 else ""})')
        raise SetupError(f'{self._venv} holds {kind} and is left as it is; '
                         'remove it, or choose another folder with VENV=DIR (--venv DIR)')

    def _install(self, stage: str, wanted: Iterable[str], install: Install) -> None:
        lines = sorted(wanted)
        if self._done.get(stage) == _key(lines):
            return
        estimate = ' (a minute or two)' if stage == 'packages' else ''
        self._say(f'installing {stage} from the Python package index{estimate}')
        install(f'install {stage}', lines)
        self._note(stage, _key(lines))

    def _install_sources(self, others: Sequence[str], install: Install) -> None:
        """
        Install the package and what belongs to it, from a copy that the build may litter.

        :param others: folders of the tree that are distributions of their own.
        """
        key = content_hash(self._root, [*PACKAGE_SOURCES, *others])
        if self._done.get('sources') == key:
            return
        self._say('installing armsim_ros')
        with tempfile.TemporaryDirectory(prefix='armsim_ros-') as name:
            copy = Path(name)
            copy_files(self._root, [*PACKAGE_SOURCES, *others], copy)
            install('install armsim_ros', [
                '--no-deps', '--no-build-isolation', '--no-index', '--no-cache-dir', copy,
                *(copy / folder for folder in others)])
        self._note('sources', key)

    def _note(self, stage: str, key: str) -> None:
        self._done[stage] = key
        self._record.write_text(json.dumps(self._done, indent=1), encoding='utf-8')

    def _log(self, name: str) -> Path:
        return self._venv / f'{name}.log'

    def _say(self, text: str) -> None:
        print(f'env: {text}', flush=True)


def _running() -> Interpreter:
    interpreter = ask_interpreter(Path(sys.executable))
    if interpreter is None:
        raise SetupError(f'{sys.executable} does not start; name another Python: '
                                 'make PYTHON=...')
    return interpreter


def _key(words: Iterable[str]) -> str:
    return hashlib.sha256('\0'.join(words).encode()).hexdigest()[:32]


ROOT = Path(__file__).resolve().parent.parent.parent


def run(argv: Sequence[str]) -> int:
    """
    Make or complete the environment.

    :returns: 0, or 1 after one message that says what is missing.
    """
    parser = argparse.ArgumentParser(prog='env.py',
                                     description='Make or complete the environment.')
    parser.add_argument('--venv', type=Path, default=ROOT / '.venv',
                        help='the environment (default: .venv in the source tree)')
    parser.add_argument('--with', dest='extras', action='append', default=[], metavar='EXTRA',
                        help='an extra of setup.cfg to install as well: test, lint')
    parser.add_argument('--this-python', action='store_true',
                        help='make the environment anew where it has another Python than this')
    arguments = parser.parse_args(argv)
    folder = os.open(ROOT, os.O_RDONLY)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX)
        EnvironmentBuilder(ROOT, arguments.venv.absolute()).build(
            arguments.extras, this_python=arguments.this_python)
    except SetupError as failure:
        print(f'env: {failure}', file=sys.stderr)
        return 1
    except OSError as error:
        print(f'env: cannot write {error.filename or arguments.venv}: {error.strerror}; make the '
              'folder writable, or choose others with VENV=DIR and XDG_CACHE_HOME=DIR',
              file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print('env: interrupted; the next run goes on from here', file=sys.stderr)
        return 130
    finally:
        os.close(folder)
    return 0
