# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How Sphinx reads these pages: `make docs` builds them, and rosdoc2 (rosdoc2.yaml).

Formulas become MathML, which browsers draw themselves, so that the site needs no network. Links
to folders of the repository lead to the sources. Docstrings are plain text
with aligned legends; they stay so.
"""

import dataclasses
import importlib
import importlib.util
import inspect
import pydoc
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


def _kind(value) -> str:
    """Tell under which heading a name goes."""
    if inspect.ismodule(value):
        return 'Modules'
    if not inspect.isclass(value):
        return 'Functions'
    if issubclass(value, BaseException):
        return 'Errors'
    return 'Records' if dataclasses.is_dataclass(value) else 'Classes'


class PublicNames(SphinxDirective):
    """
    `public-names PACKAGE`: what a package offers by `__all__`, as autodoc shows it, by kind.

    Its lines are classes, and modules whose public classes follow, as far as the package does not
    offer them.
    """

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        """Give the pages of all names; plain values, such as the version, are left out."""
        package = importlib.import_module(self.arguments[0])
        named = {f'{package.__name__}.{name}': getattr(package, name) for name in package.__all__}
        for line in filter(None, map(str.strip, self.content)):
            found = pydoc.locate(line)
            its = vars(found).values() if inspect.ismodule(found) else [found]
            for value in filter(inspect.isclass, its):
                is_its = value.__module__ == line or value is found
                if is_its and not value.__name__.startswith('_') and value not in named.values():
                    named[f'{value.__module__}.{value.__name__}'] = value
        lines = []
        for kind in ('Functions', 'Classes', 'Records', 'Errors', 'Modules'):
            lines += [f'```{{rubric}} {kind}', '```', '']
            for path, value in named.items():
                if (callable(value) or inspect.ismodule(value)) and _kind(value) == kind:
                    how = 'class' if inspect.isclass(value) else 'function'
                    how = 'module' if inspect.ismodule(value) else how
                    place = value.__name__ if how == 'module' else path
                    is_plain = how == 'function' or hasattr(value, 'TYPE')  # forces: for kernels
                    lines += ['```{eval-rst}', f'.. auto{how}:: {place}']
                    lines += ['' if is_plain else '   :members:', '```', '']
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
