# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The classes that launch files import; ``armsim_ros.launch.names`` says under which names."""
