# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What cameras see: where they are, the state that they are shown, their pictures."""
