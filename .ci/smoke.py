# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Starts the installed bringup, waits until it plans, stops it; run by the wheel's environment."""

import signal
import subprocess
import sys
import threading

READY = 'You can start planning now!'
PATIENCE = 60.0  # [s]


def main():
    """Return 0 where the stack came up and went down as it should."""
    process = subprocess.Popen(['ros2', 'run', 'armsim_ros', 'bringup'], text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    watchdog = threading.Timer(PATIENCE, process.kill)
    watchdog.start()
    printed = []
    for line in process.stdout:
        printed.append(line)
        if READY in line:
            process.send_signal(signal.SIGINT)
    status = process.wait()
    watchdog.cancel()
    ready = any(READY in line for line in printed)
    if not ready or status != 0 or any('Traceback' in line for line in printed):
        sys.stdout.writelines(printed)
        print(f'bringup ended with status {status}, ready: {ready}')
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
