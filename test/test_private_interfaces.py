# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which private names of other libraries this project uses: what a new version of them may break.

Each has its reason here, and tests that fail when the name is gone; requirements.txt and
setup.cfg limit the versions. Used as well, and documented nowhere by their libraries: toppra's
cy_seidel_solverwrapper (planning/timing/topp.py, test/planning/timing), and the place where viser
calls websockets' serve (nodes/web/server.py, test/nodes/web); and the C function by which rclpy
takes serialized messages, and the layout of its array (nodes/bridge/topic_reader.py,
test/nodes/bridge).
"""

import ast
from functools import cache
from pathlib import Path
import re

ROOT = Path(__file__).parents[1]
FOLDERS = ('armsim_ros', 'benchmarks', 'examples', 'helpers', 'ros2', 'scripts')
OWN = {'armsim_ros', 'armsim_ros2', 'benchmarks', 'tf2_py'}
MESSAGE = ('rosidl_generator_py', 'a message without the checks of its setters, which cost '
           'more than the transform', 'test/helpers')
GOAL = ('rclpy', 'no public call ends a goal as canceled that nobody asked to cancel',
        'test/nodes/simulation')
RESULTS = ('rclpy', 'rclpy keeps every result for its time in memory', 'test/nodes')
ANSWERS = ('rclpy', 'rclpy 7.1 drops answers that come before it has noted their request',
           'test/conformance/move_group')
TURNS = ('rclpy', 'its executors make a wait set of all endpoints twice for a request; no public '
         'hook keeps it', 'test/nodes/test_wait_set_executor.py')
#: Name -> library, reason, tests that use it.
KNOWN = {
    '_ActionsContainer': ('argparse', 'type of parsers and their groups', 'test/nodes/upstream'),
    '_option_string_actions': ('argparse', 'the options that a parser knows', 'test/tools'),
    '_exit': ('os', 'public in spite of its name', 'test/cli'),
    '_getframe': ('sys', 'public in spite of its name', 'test/nodes/test_lost_answers.py'),
    '_address': ('mujoco', 'compiling without holding the interpreter', 'test/sim'),
    '_add_info': ('gymnasium', 'its vector environments merge infos by it', 'test/env'),
    '_eval_find': ('xacro', '$(find) without ament', 'test/model'),
    '_messages': ('viser', 'a client of the page that is not a browser', 'benchmarks/bringup'),
    '_update_state': GOAL,
    '_goal_request': RESULTS,
    '_result_futures': RESULTS,
    '_action_type': RESULTS,
    '_cancel_goal_async': ANSWERS,
    '_get_result_async': ANSWERS,
    **dict.fromkeys(
        ('_executor_event', '_is_shutdown', '_sigint_gc', '_take_client', '_take_guard_condition',
         '_take_service', '_take_subscription', '_take_timer', '_take_waitable', '_tasks_lock'),
        TURNS),
    **dict.fromkeys(
        ('_check_fields', '_sec', '_nanosec', '_stamp', '_frame_id', '_child_frame_id', '_header',
         '_x', '_y', '_z', '_w', '_translation', '_rotation', '_transform'), MESSAGE),
}


#: A file without this has no private name.
PRIVATE = re.compile(r'\b_[^\W_]')


def private(name):
    """Return whether a name is private by Python's convention."""
    return name.startswith('_') and not name.startswith('__') and name != '_'


@cache
def defined_and_used():
    """Return the private names that the project defines, and places of those that it uses."""
    defined, used = set(), {}
    for path in sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob('*.py')
                       if 'build' not in path.relative_to(ROOT).parts):
        text = path.read_text(encoding='utf-8')
        if not PRIVATE.search(text):
            continue
        for node in ast.walk(ast.parse(text)):
            names = []
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                defined.add(node.name)
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                defined.add(node.id)
            elif isinstance(node, ast.Attribute):
                if isinstance(node.ctx, ast.Store) and getattr(node.value, 'id', '') == 'self':
                    defined.add(node.attr)
                else:
                    names = [node.attr]
            elif isinstance(node, ast.ImportFrom) and node.module.split('.')[0] not in OWN:
                names = [*node.module.split('.'), *(alias.name for alias in node.names)]
            elif isinstance(node, ast.Import):
                names = [part for alias in node.names for part in alias.name.split('.')]
            for name in filter(private, names):
                used.setdefault(name, []).append(f'{path.relative_to(ROOT)}:{node.lineno}')
    return defined, used


def test_every_private_name_of_another_library_is_known():
    """A new use needs a line in the list above."""
    defined, used = defined_and_used()
    foreign = {name: places for name, places in used.items()
               if name not in defined and name not in KNOWN}
    assert not foreign


def test_every_known_name_is_used_and_tested():
    """The list holds nothing that is gone."""
    _, used = defined_and_used()
    assert not KNOWN.keys() - used.keys()
    assert all((ROOT / where).exists() for _, _, where in KNOWN.values())
