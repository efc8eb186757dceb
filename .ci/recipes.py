# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Runs the commands of the documented CI recipe and development container; run by .ci/dist."""

import json
import os
from pathlib import Path
import re
import subprocess
import sys

import yaml

PATIENCE = 300.0  # [s]


def main():
    """Run each recipe in a shell of its own; the arm that it starts ends with it."""
    text = Path(sys.argv[1]).read_text().partition('## Continuous integration')[2]
    blocks = dict(re.findall(r'```(yaml|json)\n(.*?)```', text, re.DOTALL))
    steps = [step['run'] for step in yaml.safe_load(blocks['yaml'])['jobs']['test']['steps']
             if 'run' in step]
    container = json.loads(blocks['json'])
    wait = next(step for step in steps if step.startswith('ros2 service call'))
    for commands in (steps, [container['postCreateCommand'], container['postStartCommand'], wait]):
        script = '\n'.join(['trap "kill %1; wait" EXIT', *commands])
        subprocess.run(['/bin/bash', '-ec', script], check=True, timeout=PATIENCE,
                       env={**os.environ, 'PIP_QUIET': '1'})
    log = Path('bringup.log').read_text()
    assert 'You can start planning now!' in log, log


if __name__ == '__main__':
    main()
