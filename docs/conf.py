# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""How Sphinx reads these pages; rosdoc2 (rosdoc2.yaml) builds them so."""

project = 'rigid_body_sim'
copyright = '2026, rigid_body_sim maintainers'
extensions = ['myst_parser']
source_suffix = {'.md': 'markdown', '.rst': 'restructuredtext'}
root_doc = 'index'
exclude_patterns = ['_build']
myst_enable_extensions = ['dollarmath', 'amsmath']
myst_heading_anchors = 4
html_theme = 'sphinx_rtd_theme'
