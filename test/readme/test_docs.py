# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The site builds without a warning, and what its pages show runs, word for word.

On a page, a block of `python -m rigid_body_sim …` lines is run in a folder of its own, in the
order of the page; YAML with a version is a scene, which the comment `Save it as NAME` puts there;
a block of Python is a program. Blocks of `text` are shown only.
"""

from __future__ import annotations

import importlib
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import rigid_body_sim
from rigid_body_sim.__main__ import VERBS, _split, main
from rigid_body_sim.command_line import CommandLine
from rigid_body_sim.scene import load_scene
from rigid_body_sim.scene.shipped_scenes import shipped_scenes

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
DOCS = ROOT / 'docs'
BLOCK = re.compile(r'^```([^\n]*)\n(.*?)^```$', flags=re.DOTALL | re.MULTILINE)
PAGES = (
    'api',
    'choosing_an_integrator',
    'error',
    'first_five_minutes',
    'recording_and_replay',
    'scene_reference',
    'sweep',
)
TABLE = re.compile(r'^```\{toctree\}\n(.*?)^```$', flags=re.DOTALL | re.MULTILINE)
LONGEST = 120  # letters of a line of the README


@pytest.fixture(scope='module')
def site(tmp_path_factory) -> Path:
    """The pages as `make docs` builds them: every warning is an error."""
    pytest.importorskip('sphinx')
    pytest.importorskip('myst_parser')
    folder = tmp_path_factory.mktemp('site')
    words = ('-m', 'sphinx', '-W', '--keep-going', '-q', '-b', 'html')
    result = subprocess.run(
        [sys.executable, *words, str(DOCS), str(folder)],
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return folder


@pytest.mark.long
def test_every_page_is_on_the_site_and_formulas_need_no_network(site):
    pages = {path.relative_to(DOCS).with_suffix('') for path in DOCS.rglob('*.md')}
    built = {path.relative_to(site).with_suffix('') for path in site.rglob('*.html')}
    assert pages <= built
    formulas = (site / 'lecture' / 'points.html').read_text(encoding='utf-8')
    assert formulas.count('<math') > 10
    for path in site.rglob('*.html'):
        text = path.read_text(encoding='utf-8')
        loaded = re.findall(r'<(?:script|img)[^>]* src="(https?://[^"]+)', text)
        loaded += re.findall(r'<link[^>]* rel="stylesheet"[^>]* href="(https?://[^"]+)', text)
        assert not loaded, f'{path.name} loads {loaded}'


@pytest.mark.long
def test_the_python_page_has_every_public_name(site):
    page = (site / 'api.html').read_text(encoding='utf-8')
    names = {name for name in rigid_body_sim.__all__ if callable(getattr(rigid_body_sim, name))}
    assert {name for name in names if f'id="rigid_body_sim.{name}"' not in page} == set()


def test_every_page_stands_in_a_table_of_contents():
    """What is in none, the site has on no way; how the site comes out is told in the long form."""
    listed = {DOCS / 'index'}
    for page in DOCS.rglob('*.md'):
        for table in TABLE.findall(page.read_text(encoding='utf-8')):
            named = [line.strip() for line in table.splitlines()]
            listed |= {page.parent / name for name in named if name and not name.startswith(':')}
    assert listed == {path.with_suffix('') for path in DOCS.rglob('*.md')}


@pytest.mark.parametrize('name', PAGES)
def test_what_a_page_shows_runs(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    ran = 0
    for language, text in BLOCK.findall((DOCS / f'{name}.md').read_text(encoding='utf-8')):
        if language == 'yaml' and 'version:' in text:
            load_scene(text.encode())
            if named := re.search(r'Save it as (\S+)\.$', text, flags=re.MULTILINE):
                Path(named[1]).write_text(text, encoding='utf-8')
            ran += 1
        elif language == 'python':
            exec(compile(text, f'{name}.md', 'exec'), {'__name__': '__main__'})
            ran += 1
        elif not language:
            for line in text.splitlines():
                words = shlex.split(line, comments=True)
                assert words[:3] == ['python', '-m', 'rigid_body_sim'], line
                assert main(words[3:]) == 0, capsys.readouterr()
                ran += 1
    assert ran, f'{name} shows nothing that runs'


def commands_shown():
    """Yield page, verb and words of the commands in all blocks, but those with gaps in them."""
    for page in [ROOT / 'README.md', *DOCS.rglob('*.md')]:
        for language, text in BLOCK.findall(page.read_text(encoding='utf-8')):
            if language not in ('', 'sh', 'bash', 'text', 'console'):
                continue
            for line in re.sub(r'\\\n', ' ', text).splitlines():
                found = re.match(
                    r'(?:\$ )?(?:\w+=\S+ )*(?:python -m |ros2 run )?rigid_body_sim (\w+) (.*)',
                    line,
                )
                if found and found[1] in VERBS and not re.search('[…[<|]', found[2]):
                    yield page.name, found[1], shlex.split(found[2], comments=True)


def test_commands_name_options_and_scenes_that_there_are():
    """A page may name `warm_up stack rain`, and nobody notices that there is no rain any more."""
    scenes, seen, lost = shipped_scenes(), 0, []
    for page, verb, words in commands_shown():
        parser = CommandLine(prog=verb)
        importlib.import_module(f'rigid_body_sim.verbs.{verb}').add_arguments(parser)
        own, for_ros = _split(words)
        try:
            asked = vars(parser.parse_args(own))
        except SystemExit:
            lost.append(f'{page}: {verb} {" ".join(words)}')
            continue
        named = asked.get('scene')
        named = [*named] if isinstance(named, list) else [named]
        named += [word.partition(':=')[2] for word in for_ros if word.startswith('scene:=')]
        for scene in named:
            seen += scene is not None
            if scene and str(scene).isidentifier() and str(scene) not in scenes:
                lost.append(f'{page}: {verb} {" ".join(words)}: no scene {scene}')
    assert not lost and seen > 20


def test_no_line_of_the_readme_is_too_long_for_a_terminal():
    lines = (ROOT / 'README.md').read_text(encoding='utf-8').splitlines()
    assert [line for line in lines if len(line) > LONGEST] == []


def test_the_citation_names_this_version():
    yaml = pytest.importorskip('yaml')
    cited = yaml.safe_load((ROOT / 'CITATION.cff').read_text(encoding='utf-8'))
    assert {'cff-version', 'message', 'title', 'authors'} <= set(cited)
    assert cited['version'] == rigid_body_sim.__version__
    assert f"version='{cited['version']}'" in (ROOT / 'setup.py').read_text(encoding='utf-8')


LINK = re.compile(r'\]\(([^)#\s]+)(?:#[^)]*)?\)')


def test_every_link_of_pages_and_readme_leads_to_a_file():
    lost = []
    for page in [ROOT / 'README.md', ROOT / 'ARCHITECTURE.md', *DOCS.rglob('*.md')]:
        lost += [
            f'{page.relative_to(ROOT)}: {target}'
            for target in LINK.findall(page.read_text(encoding='utf-8'))
            if '://' not in target and not (page.parent / target).exists()
        ]
    assert not lost
