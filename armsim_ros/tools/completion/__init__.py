# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program completion: scripts for bash, zsh and fish, and the words that they propose."""
