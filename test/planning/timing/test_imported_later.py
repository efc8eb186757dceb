# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Timing needs neither plots nor scipy; who wants them has them all the same."""

from __future__ import annotations

import subprocess
import sys

CHECK = """
import sys
import armsim_ros.planning.timing.topp
assert 'toppra' in sys.modules
assert not any(name.partition('.')[0] == 'matplotlib' for name in sys.modules)
assert 'scipy' not in sys.modules
assert 'ssl' not in sys.modules
import toppra.algorithm.algorithm as algorithm
assert callable(algorithm.plt.plot)
import matplotlib.pyplot
assert algorithm.plt.plot is matplotlib.pyplot.plot
import toppra
spline = toppra.SplineInterpolator([0.0, 1.0, 2.0], [[0.0], [1.0], [2.0]])
assert abs(float(spline(0.5)[0]) - 0.5) < 1e-9
from toppra.solverwrapper import ecos_solverwrapper
assert ecos_solverwrapper.scipy.sparse.lil_matrix((3, 2)).shape == (3, 2)
import scipy.interpolate
assert scipy.interpolate.CubicSpline([0.0, 1.0], [0.0, 1.0])(0.5) == 0.5
"""


def test_timing_comes_without_plots_and_splines_and_has_them_all_the_same():
    """In a process of its own: others here may have imported it."""
    subprocess.run([sys.executable, '-c', CHECK], check=True)
