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
import platform
import shutil
import sys
import tempfile

from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py

SOURCE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(SOURCE))

from build_support.build import build  # noqa: E402
from build_support.errors import BuildError  # noqa: E402
from build_support.packages import providing_prefix, read_packages, select  # noqa: E402
from build_support.platform_tag import newer_symbols, platform_tag  # noqa: E402

# What the modules import and link at run time, by the package that a sourced ROS would provide:
# from the oldest version that was tested up to the next that may change the messages' layout.
RUNTIME = {
    'trajectory_msgs': 'ros-jazzy-common-interfaces>=5.3.6,<5.4',
    'lifecycle_msgs': 'ros-jazzy-lifecycle-msgs>=2.0.3,<2.1',
    'action_msgs': 'ros-jazzy-action-msgs>=2.0.3,<2.1',
}

# The hash of the sources, if the caller of the build knows it; the wheel keeps it.
HASH_VARIABLE = 'ARMSIM_INTERFACES_HASH'


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
        if HASH_VARIABLE in os.environ:
            file = data / 'share/armsim_ros_interfaces/sources'
            file.parent.mkdir(parents=True)
            file.write_text(os.environ[HASH_VARIABLE], 'utf-8')
        folders = {}
        for path in sorted(data.rglob('*')):
            if path.is_file():
                folders.setdefault(str(path.parent.relative_to(data)), []).append(str(path))
        self.distribution.data_files = sorted(folders.items())


class PlatformWheel(bdist_wheel):
    """A wheel that is tagged with the oldest platform on which its libraries load."""

    def get_tag(self):
        """Return the tag; symbols that are too new for other machines are reported."""
        libraries = sorted((SCRATCH / 'target').rglob('*.so'))
        for library in libraries:
            if newer := newer_symbols(library):
                report(f'{library.name} needs {", ".join(newer)}')
        python, abi, _ = super().get_tag()
        return python, abi, platform_tag(libraries, platform.machine())


def report(line):
    """Print one line at once."""
    print(line, flush=True)


SCRATCH = Path(tempfile.mkdtemp(prefix='armsim-ros-interfaces-'))
atexit.register(shutil.rmtree, SCRATCH, ignore_errors=True)

setup(
    distclass=InterfaceDistribution,
    cmdclass={'bdist_wheel': PlatformWheel, 'build_py': BuildInterfaces},
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
