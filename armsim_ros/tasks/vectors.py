# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Vector environments of the tasks, for ``gymnasium.make_vec``.

Each has the name of its task, by which Gymnasium imports it; an id with a function in place of
that name could not be written as JSON.
"""

from functools import partial

from armsim_ros.env.vector import vector_of
from armsim_ros.tasks import manipulation

Reach = partial(vector_of, manipulation.Reach)
PushCube = partial(vector_of, manipulation.PushCube)
PickCube = partial(vector_of, manipulation.PickCube)
PlaceCube = partial(vector_of, manipulation.PlaceCube)
StackCubes = partial(vector_of, manipulation.StackCubes)
