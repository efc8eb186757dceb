# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Users' launch files: evaluated, run by a small event loop, upstream's programs replaced.

Where a ROS installation with ``ros2 launch`` is sourced, that evaluates and runs the file, and
only ``overlay`` is used: it puts this package's programs under upstream's names. Everything else
serves machines without ROS, and the dry run. A launch takes this way through the files:

1. ``main`` reads the words and finds the file with ``lookup``, which knows packages, programs
   and Python modules, in installations and in sources that are not built.
2. It makes upstream's modules importable (``names``, with the table of ``api/modules``) and has
   the file read by ``files``: Python by running it, XML and YAML as elements of ``syntax``, which
   ``parser`` turns into actions.
3. ``engine`` visits the description, with events and timers. What a file consists of is in
   ``api/``: ``actions``, ``configuration``, ``substitutions``, ``paths`` and ``programs``,
   processes and nodes (``process``, ``ros_*``), ``events`` and their handlers, and the helpers of
   packages that launch files import (``moveit_configs``, ``launches``, ``nav2``).
4. A process is a ``process_spec``, which knows the upstream program that it is; ``mapping``
   decides what it becomes: a program of this package, another program, or a part of the
   simulation.
5. A ``runner`` starts it: the dry one prints, the other runs and ends processes. ``report``
   prints what the user should know; errors are of ``failures``.

``stand_ins/`` has launch files of Gazebo's packages, under their names, for files that include
them.
"""
