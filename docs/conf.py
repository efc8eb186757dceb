# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How Sphinx makes the documentation: ``make docs``."""

project = 'armsim_ros'
author = 'armsim_ros authors'
extensions = ['myst_parser', 'sphinx.ext.autodoc']
source_suffix = {'.md': 'markdown'}
root_doc = 'index'
myst_heading_anchors = 4
autodoc_typehints = 'description'
autodoc_typehints_description_target = 'documented'
autodoc_member_order = 'bysource'
html_theme = 'alabaster'
html_theme_options = {'page_width': '1100px'}
# Links out of this folder lead into the source tree.
suppress_warnings = ['myst.xref_missing']
