# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How Sphinx reads these pages: `make docs` builds them, and rosdoc2 (rosdoc2.yaml).

Formulas become MathML, which browsers draw themselves, so that the site needs no network. Links
to folders of the repository lead to the sources. Docstrings are plain text
with aligned legends; they stay so.
"""

import importlib.util
import inspect
import re
import sys
from pathlib import Path

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx import addnodes
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
SOURCES = 'https://github.com/rigid-body-sim/rigid_body_sim/blob/main/'

project = 'rigid_body_sim'
copyright = '2026, rigid_body_sim maintainers'
extensions = ['myst_parser', 'sphinx.ext.autodoc']
source_suffix = {'.md': 'markdown', '.rst': 'restructuredtext'}
root_doc = 'index'
exclude_patterns = ['_build']
myst_enable_extensions = ['dollarmath', 'amsmath']
myst_heading_anchors = 4
autodoc_member_order = 'bysource'
autodoc_typehints = 'none'
html_theme = 'furo' if importlib.util.find_spec('furo') else 'sphinx_rtd_theme'
html_static_path = ['_static']
html_css_files = ['site.css']
html_title = 'rigid_body_sim'
html_copy_source = False
html_math_renderer = 'mathml'


class PublicNames(SphinxDirective):
    """`public-names`: what a module offers by `__all__`, each as autodoc shows it."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Give the pages of all names; those that are no classes and functions are left out."""
        module = importlib.import_module(self.arguments[0])
        lines = []
        for name in sorted(module.__all__, key=str.lower):
            value = getattr(module, name)
            kind = 'class' if inspect.isclass(value) else 'function'
            if not callable(value):
                continue
            lines += ['```{eval-rst}', f'.. auto{kind}:: {module.__name__}.{name}']
            lines += ['   :members:', ''] if kind == 'class' else ['']
            lines += ['```', '']
        return self.parse_text_to_nodes('\n'.join(lines))


LEGEND = re.compile(r'^(?: |\S+(?:, \S+)* +: )')


def as_plain_text(_app, _what, _name, _object, _options, lines) -> None:
    """Write a docstring as reStructuredText: prose as prose, equations and legends as they are."""
    written: list[str] = []
    for paragraph in '\n'.join(lines).strip('\n').split('\n\n'):
        rows = paragraph.splitlines()
        if any(LEGEND.match(row) for row in rows):
            written += ['.. code-block:: text', '', *(f'   {row}' for row in rows), '']
        else:
            written += [*(_prose(row) for row in rows), '']
    lines[:] = written


def _prose(row: str) -> str:
    parts = row.split('`')
    if len(parts) % 2 == 0:
        return re.sub(r'([*_|`\\])', r'\\\1', row)
    for i, part in enumerate(parts):
        parts[i] = f'``{part}``' if i % 2 else re.sub(r'([*_|\\])', r'\\\1', part)
    return ''.join(parts)


def _mathml(writer, node, *, block: bool) -> None:
    writer.body.append(tex2mathml(node.astext(), as_block=block))
    raise nodes.SkipNode


def folders_of_sources(app, doctree) -> None:
    """Let a link to a folder of the repository lead to its sources."""
    here = Path(app.env.doc2path(app.env.docname)).parent
    for node in list(doctree.findall(addnodes.pending_xref)):
        folder = (here / node.get('reftarget', '')).resolve()
        if folder.is_dir() and folder.is_relative_to(ROOT) and folder != here:
            address = SOURCES + folder.relative_to(ROOT).as_posix()
            node.replace_self(nodes.reference('', '', *node.children, refuri=address))


def setup(app) -> None:
    """Register what is above."""
    app.add_html_math_renderer(
        'mathml',
        (lambda writer, node: _mathml(writer, node, block=False), None),
        (lambda writer, node: _mathml(writer, node, block=True), None),
    )
    app.add_directive('public-names', PublicNames)
    app.connect('autodoc-process-docstring', as_plain_text)
    app.connect('doctree-read', folders_of_sources)
