# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Build the ROS interface packages that PyPI lacks into one wheel.

``pip install ./interfaces`` or ``pip wheel --no-deps -w FOLDER ./interfaces``. Needs a C and a
C++ compiler and Python.h; pip's build isolation brings the rosidl generators. Nothing is written
to the source folder.

A package that a sourced ROS installation (AMENT_PREFIX_PATH) already offers to this Python is
left out, so that it is not shadowed; the output names it. The environment variable
ARMSIM_INTERFACES overrules that: ``all``, or the names of the packages to build. CC and CXX name
other compilers.
"""

import atexit
import os
from pathlib import Path
import shutil
import sys
import tempfile

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

SOURCE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(SOURCE))

from build_support.build import build  # noqa: E402
from build_support.errors import BuildError  # noqa: E402
from build_support.packages import providing_prefix, read_packages, select  # noqa: E402

# What the modules import and link at run time, by the package that a sourced ROS would provide.
RUNTIME = {
    'trajectory_msgs': 'ros-jazzy-common-interfaces',
    'lifecycle_msgs': 'ros-jazzy-lifecycle-msgs',
    'action_msgs': 'ros-jazzy-action-msgs',
}


class InterfaceDistribution(Distribution):
    """A distribution that is specific to the platform, and has no list of modules beforehand."""

    def has_ext_modules(self):
        """Tell that the wheel fits one Python version and platform only."""
        return True

    def is_pure(self):
        """Tell that the modules go to the platform's folder."""
        return False

    def has_pure_modules(self):
        """Tell that there are modules, so that the build command runs."""
        return True


class BuildInterfaces(build_py):
    """Generate and compile the packages in place of copying modules."""

    def run(self):
        """Build into the wheel's folder and hand over share/ as data files."""
        try:
            packages, provided = select(read_packages(SOURCE), os.environ)
            for name, prefix in provided.items():
                report(f'{name}: left out, {prefix} provides it')
            work = SCRATCH / 'work'
            work.mkdir()
            if packages:
                build(packages, provided, work, SCRATCH / 'target', report)
        except BuildError as error:
            sys.exit(f'armsim-ros-interfaces: {error}')
        if packages:
            shutil.copytree(SCRATCH / 'target/python', self.build_lib, dirs_exist_ok=True)
        data = SCRATCH / 'target/data'
        folders = {}
        for path in sorted(data.rglob('*')):
            if path.is_file():
                folders.setdefault(str(path.parent.relative_to(data)), []).append(str(path))
        self.distribution.data_files = sorted(folders.items())


def report(line):
    """Print one line at once."""
    print(line, flush=True)


SCRATCH = Path(tempfile.mkdtemp(prefix='armsim-ros-interfaces-'))
atexit.register(shutil.rmtree, SCRATCH, ignore_errors=True)

setup(
    distclass=InterfaceDistribution,
    cmdclass={'build_py': BuildInterfaces},
    packages=[],
    py_modules=[],
    install_requires=sorted(
        distribution for package, distribution in RUNTIME.items()
        if providing_prefix(package, os.environ) is None),
    options={
        'build': {'build_base': str(SCRATCH / 'build')},
        'egg_info': {'egg_base': str(SCRATCH)},
    },
)
