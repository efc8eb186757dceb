# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Users' launch files: evaluated, run by a small event loop, upstream's programs replaced."""
