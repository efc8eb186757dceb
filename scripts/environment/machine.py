# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the machine brings: the interpreter, a compiler, perhaps a sourced ROS installation."""

from __future__ import annotations

from dataclasses import dataclass
import importlib.util
import json
import os
from pathlib import Path
import shutil
import subprocess
import sys

_QUESTION = """
import json, platform, sys, sysconfig
variable = sysconfig.get_config_var
print(json.dumps({
    'version': platform.python_version(),
    'tag': str(variable('SOABI')) + '-' + sysconfig.get_platform(),
    'include': sysconfig.get_path('include'),
    'cc': variable('CC') or 'cc', 'cxx': variable('CXX') or 'c++'}))
"""


class SetupError(Exception):
    """Something that the environment needs is missing; the text names it and the remedy."""


@dataclass(frozen=True)
class Interpreter:
    """What has to be known of a Python interpreter to build for it."""

    version: str
    tag: str
    include: str
    cc: str
    cxx: str


def ask_interpreter(python: Path) -> Interpreter | None:
    """Return what an interpreter says of itself, None where it does not run."""
    try:
        answer = subprocess.run([python, '-I', '-S', '-c', _QUESTION], capture_output=True,
                                text=True, check=True, env=clean_environment())
    except (OSError, subprocess.CalledProcessError):
        return None
    return Interpreter(**json.loads(answer.stdout))


def clean_environment() -> dict[str, str]:
    """Return the environment for another interpreter and for pip."""
    environment = dict(os.environ, PIP_DISABLE_PIP_VERSION_CHECK='1', PIP_NO_INPUT='1',
                       PIP_USER='0', PYTHONHASHSEED='0')
    environment.setdefault('PIP_RETRIES', '2')
    environment.pop('PYTHONHOME', None)
    # The start-up hook of the rclpy wheels sets both, for its own environment's Python alone.
    if environment.pop('_ROS_WHEELS_BOOTSTRAP_COMPLETE', None):
        environment.pop('LD_LIBRARY_PATH', None)
    return environment


def check_venv_module() -> None:
    """Refuse a Python that cannot make environments, as Debian's without python3-venv."""
    if any(importlib.util.find_spec(name) is None for name in ('venv', 'ensurepip')):
        short = f'{sys.version_info[0]}.{sys.version_info[1]}'
        raise SetupError(
            f'{sys.executable} has no venv and ensurepip; install them '
            f'(Debian, Ubuntu: apt install python{short}-venv), or name another Python: '
            'make PYTHON=...')


def check_compiler(interpreter: Interpreter) -> None:
    """Refuse a machine that cannot compile the interface packages."""
    missing = []
    for variable, usual, package in (('CC', interpreter.cc, 'gcc'),
                                     ('CXX', interpreter.cxx, 'g++')):
        words = os.environ.get(variable, usual).split()
        if not words or shutil.which(words[0]) is None:
            missing.append((f'the compiler {words[0] if words else package}', package))
    if not Path(interpreter.include, 'Python.h').is_file():
        short = '.'.join(interpreter.version.split('.')[:2])
        missing.append((f'{interpreter.include}/Python.h', f'python{short}-dev'))
    if missing:
        raise SetupError(
            f'the ROS interface packages have to be compiled once, but this machine lacks '
            f'{" and ".join(thing for thing, _ in missing)}; install them (Debian, Ubuntu: '
            f'apt install {" ".join(package for _, package in missing)})')


def sourced_ros(version: str) -> Path | None:
    """
    Return the prefix of the ROS installation that this shell has sourced, None without one.

    :param version: the version of the Python that shall use it.
    :raises SetupError: where the installation is for another Python, or no Jazzy.
    """
    short = '.'.join(version.split('.')[:2])
    for entry in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep):
        if not entry or not has_package(Path(entry), 'rclpy') or is_environment(Path(entry)):
            continue
        distribution = os.environ.get('ROS_DISTRO', 'jazzy')
        if distribution != 'jazzy':
            raise SetupError(
                f'this shell has sourced ROS 2 {distribution} ({entry}), but armsim_ros is for '
                'Jazzy; source that one, or use a shell that has sourced none')
        if not any(Path(entry).glob(f'l*/python{short}/*-packages/rclpy')):
            raise SetupError(
                f'the sourced ROS installation {entry} is for another Python than {short}; '
                'name that one (make PYTHON=/usr/bin/python3 ...), or use a shell that has '
                'sourced none')
        return Path(entry)
    return None


def has_package(prefix: Path, package: str) -> bool:
    """Return whether a ROS package is installed under a prefix."""
    return (prefix / 'share/ament_index/resource_index/packages' / package).is_file()


def is_environment(prefix: Path) -> bool:
    """Return whether a prefix is a Python environment, whose packages came from pip."""
    return (prefix / 'pyvenv.cfg').is_file()
