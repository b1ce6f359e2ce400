# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
docs/scene_reference.md and config/scene.schema.json, from `rigid_body_sim.scene.grammar`.

    python tools/scene_reference.py           writes both
    python tools/scene_reference.py --check   exit code 1 where they are not what the code says

The schema is JSON Schema draft 7, which editors read. Numbers may be written as text too: PyYAML,
as YAML 1.1, reads 1e-3 so, and the reader of scenes takes what JSON and C call a number. A key
that may be absent may be empty.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from rigid_body_sim.scene import grammar as g  # noqa: E402

PAGE = ROOT / 'docs' / 'scene_reference.md'
SCHEMA = ROOT / 'config' / 'scene.schema.json'
SHAPE_OF_A_PART = 'shape_of_a_part'
HEADING = '## Reference\n'
DIGITS = r'(?:(?:0|[1-9][0-9]*)(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?'
DECIMAL = f'^[-+]?{DIGITS}$'
WHOLE = r'^[+]?(?:0|[1-9][0-9]*)(?:\.0*)?(?:[eE][+]?[0-9]+)?$'
NOT_NEGATIVE = rf'^(?:[+]?{DIGITS}|-0(?:\.0*)?)$'
Json = dict[str, Any]


# ------ the schema


def schema() -> str:
    """Give the text of the schema."""
    known = g.grammar()
    whole: Json = {
        '$schema': 'http://json-schema.org/draft-07/schema#',
        'title': 'A scene of rigid_body_sim',
        **_mapping(known['scene']),
        'definitions': {
            _safe(name): _mapping(part) for name, part in known.items() if name != 'scene'
        },
    }
    whole['definitions'][SHAPE_OF_A_PART] = _mapping(
        known['shape'], without=g.PART_KEYS['shape'].kind.without
    )
    integrator = whole['definitions']['integrator']
    names = {'type': 'string', 'enum': list(known['integrator'].variants)}
    whole['definitions']['integrator'] = {'anyOf': [names, integrator]}
    return json.dumps(whole, indent=1, ensure_ascii=False) + '\n'


def _mapping(part: g.Mappings, *, without: tuple[str, ...] = ()) -> Json:
    if part.variants:
        return _variants(part, without)
    found: Json = {
        'description': part.about,
        'type': 'object',
        'properties': {name: _property(key) for name, key in part.keys.items()},
        'additionalProperties': False,
    }
    if part.ignored:
        found['patternProperties'] = {f'^{part.ignored}': True}
    if required := [name for name, key in part.keys.items() if key.required]:
        found['required'] = required
    if part.rules:
        found['allOf'] = [_rule(rule) for rule in part.rules]
    return found


def _variants(part: g.Mappings, without: tuple[str, ...]) -> Json:
    variants = {name: each for name, each in part.variants.items() if name not in without}
    tag: Json = {'type': 'string', 'enum': list(variants)}
    if part.default_tag is None:
        need: Json = {'required': [part.tag]}
    else:
        tag = _or_nothing(tag)
        need = {}
    choices: list[Json] = []
    for name, each in variants.items():
        is_it: Json = {'properties': {part.tag: {'const': name}}, 'required': [part.tag]}
        if name == part.default_tag:
            absent = {'not': {'required': [part.tag]}}
            is_it = {'anyOf': [is_it, absent, {'properties': {part.tag: {'type': 'null'}}}]}
        then = _mapping(each)
        then['properties'] = {part.tag: True, **then['properties']}
        choices.append({'if': is_it, 'then': then})
    return {
        'description': part.about,
        'type': 'object',
        'properties': {part.tag: tag},
        **need,
        'allOf': choices,
    }


def _rule(rule: g.Rule) -> Json:
    then: list[Json] = [_given(path) for path in rule.needs]
    then += [{'not': _given(path)} for path in rule.excludes]
    if rule.any_of:
        then.append({'anyOf': [_given(path) for path in rule.any_of]})
    if rule.positive:
        then.append({'properties': {rule.positive: {'not': {'type': 'number', 'maximum': 0}}}})
    judged: Json = {'description': rule.sentence, 'allOf': then}
    asked: list[Json] = [{'not': _given(path)} for path in rule.absent]
    if rule.given:
        asked.append({'anyOf': [_given(path) for path in rule.given]})
    return {'if': {'allOf': asked}, 'then': judged} if asked else judged


def _given(path: str) -> Json:
    """Give the schema of a mapping in which what a rule names is there, and not empty."""
    path, _, wanted = path.partition('=')
    name, _, further = path.partition('.')
    kind: Json = {'not': {'type': 'null'}}
    if further:
        kind = {'type': 'object', **_given(further)}
    elif name == 'shape' and wanted:
        kind = {'type': 'object', 'properties': {'type': {'const': wanted}}, 'required': ['type']}
    elif wanted:
        kind = {'const': {'true': True}.get(wanted, wanted)}
    return {'required': [name], 'properties': {name: kind}}


def _property(key: g.Key) -> Json:
    kind = _kind(key.kind)
    said = _sentence(key)
    if not key.required:
        kind = _or_nothing(kind)
    kind = {**({'allOf': [kind]} if '$ref' in kind else kind), 'description': said}
    if key.default not in (None, {}, []):
        kind['default'] = key.default
    return kind


def _or_nothing(kind: Json) -> Json:
    """Let a value be empty."""
    if 'type' in kind and 'enum' not in kind and 'const' not in kind:
        types = kind['type'] if isinstance(kind['type'], list) else [kind['type']]
        return {**kind, 'type': [*types, 'null']}
    if 'enum' in kind:
        return {'enum': [*kind['enum'], None]}
    return {'anyOf': [kind, {'type': 'null'}]}


def _kind(kind: Any) -> Json:
    match kind:
        case g.Number():
            low = 'exclusiveMinimum' if kind.positive else 'minimum'
            least = 0.0 if kind.positive else kind.minimum
            limits = {low: least, 'maximum': kind.maximum}
            return {
                'type': ['number', 'string'],
                'pattern': DECIMAL if least is None else NOT_NEGATIVE,
                **{word: limit for word, limit in limits.items() if limit is not None},
            }
        case g.Whole():
            most = {} if kind.maximum is None else {'maximum': kind.maximum}
            return {
                'type': ['integer', 'string'],
                'pattern': WHOLE,
                'minimum': kind.minimum,
                **most,
            }
        case g.Numbers():
            return _list(_kind(kind.each), kind.count, kind.count)
        case g.Rows():
            row = _kind(g.Number('-'))
            rows = [_list(row, width, width) for width in kind.widths]
            if kind.columns:
                rows = [{**rows[0], 'items': [_kind(column) for column in kind.columns]}]
            each = [{'type': 'array', 'items': one, 'minItems': kind.least} for one in rows]
            return each[0] if len(each) == 1 else {'anyOf': each}
        case g.Words():
            return {'type': 'string', 'enum': list(kind.choices)}
        case g.Text():
            text: Json = {'type': 'string', 'minLength': 1}
            if kind.pattern:
                text['pattern'] = kind.pattern
            if kind.longest:
                text['maxLength'] = kind.longest
            return text
        case g.Truth():
            return {'type': 'boolean'}
        case g.Only():
            return {'const': kind.value}
        case g.ListOf():
            return _list(_kind(kind.each), kind.least, kind.most)
        case g.Either():
            return {'anyOf': [_kind(each) for each in kind.kinds]}
        case g.Named():
            return {
                'type': 'object',
                'propertyNames': {'pattern': kind.pattern, 'maxLength': g.LONGEST_NAME},
                'additionalProperties': _or_nothing(_kind(kind.each)),
            }
        case g.Part():
            name = SHAPE_OF_A_PART if kind.without else _safe(kind.name)
            return {'$ref': f'#/definitions/{name}'}
    raise TypeError(kind)


def _list(each: Json, least: int, most: int | None) -> Json:
    ends = {'minItems': least or None, 'maxItems': most}
    found: Json = {'type': 'array', 'items': each}
    return found | {word: end for word, end in ends.items() if end is not None}


def _safe(name: str) -> str:
    return name.replace('[', '').replace(']', '').replace(' ', '_')


def _sentence(key: g.Key) -> str:
    unit = _unit(key.kind)
    default = _default(key)
    text = key.meaning[:1].upper() + key.meaning[1:]
    if unit and f'[{unit}]' not in text:
        text += f' [{unit}]'
    return text + (f'. Default: {default}.' if default else '.')


# ------ the page


def page() -> str:
    """Give the page as it should be."""
    text = PAGE.read_text(encoding='utf-8')
    head = text[: text.index(HEADING) + len(HEADING)]
    return head + ''.join(reference())


def reference() -> Iterator[str]:
    """Give the lines of the reference."""
    known = g.grammar()
    for name, part in known.items():
        yield f'\n### `{name}`\n\n{part.about}\n'
        if part.variants:
            yield from _reference_of_variants(name, part)
        else:
            yield from _table(part)


def _reference_of_variants(name: str, part: g.Mappings) -> Iterator[str]:
    if name == 'integrator':
        yield '\n`integrator: NAME`, or `{name: NAME, OPTION: …}`.\n'
        yield '\n| name | what it keeps | options, default and limits |\n|---|---|---|\n'
        for each, variant in part.variants.items():
            options = '; '.join(
                f'`{key}`: {_default(option)} ({_allowed(option.kind)})'
                for key, option in variant.keys.items()
            )
            yield f'| `{each}` | {_cell(variant.about)} | {_cell(options)} |\n'
        yield '\n| option | what it is |\n|---|---|\n'
        for key, meaning in g.OPTION_MEANINGS.items():
            yield f'| `{key}` | {_cell(meaning)} |\n'
        return
    if part.default_tag:
        yield f'\nWithout `{part.tag}` it is `{part.default_tag}`.\n'
    for each, variant in part.variants.items():
        yield f'\n#### `{part.tag}: {each}`\n\n'
        yield f'{variant.about}\n'
        yield from _table(variant)


def _table(part: g.Mappings) -> Iterator[str]:
    if part.keys:
        yield '\n| key | holds | unit | default | meaning |\n|---|---|---|---|---|\n'
        for name, key in part.keys.items():
            default = 'must be there' if key.required else _default(key)
            unit = _unit(key.kind)
            yield (
                f'| `{name}` | {_allowed(key.kind)} | {unit} | {_cell(default)} | '
                f'{_cell(key.meaning)} |\n'
            )
    if part.ignored:
        yield (
            f'\nA key that begins with `{part.ignored}` is read by nobody: a place for anchors '
            '(`&`) that bodies repeat (`*`, `<<`).\n'
        )
    if part.rules:
        yield '\n' + ''.join(f'- {rule.sentence[:1].upper()}{rule.sentence[1:]}.\n' for rule in part.rules)  # noqa: E501  # fmt: skip


def _default(key: g.Key) -> str:
    if key.otherwise:
        return key.otherwise
    if key.default is None:
        return ''
    return f'`{json.dumps(key.default)}`'.replace('"', '')


def _unit(kind: Any) -> str:
    match kind:
        case g.Number():
            return kind.unit
        case g.Numbers() | g.ListOf():
            return _unit(kind.each)
        case g.Rows():
            return kind.units
        case g.Either():
            return ' or '.join(dict.fromkeys(unit for each in kind.kinds if (unit := _unit(each))))
    return ''


def _allowed(kind: Any) -> str:
    match kind:
        case g.Number():
            return 'number' + _limits(kind)
        case g.Whole():
            most = '' if kind.maximum is None else f' to {kind.maximum}'
            return f'whole number, {kind.minimum}{most}' + ('' if most else ' or more')
        case g.Numbers():
            each = 'number' if isinstance(kind.each, g.Number) else 'whole number'
            return f'{kind.count} {each}s' + _limits(kind.each)
        case g.Rows():
            return f'{kind.least} or more rows of {" or ".join(map(str, kind.widths))} numbers'
        case g.Words():
            return ', '.join(f'`{word}`' for word in kind.choices)
        case g.Text():
            return kind.what + (f', up to {kind.longest}' if kind.longest else '')
        case g.Truth():
            return '`true`, `false`'
        case g.Only():
            return f'`{kind.value}`'
        case g.ListOf():
            least = f', {kind.least} or more' if kind.least and kind.least != kind.most else ''
            return f'list{least} of: {_allowed(kind.each)}'
        case g.Either():
            return ', or '.join(_allowed(each) for each in kind.kinds)
        case g.Named():
            return f'names with a mapping each: {_allowed(kind.each)}'
        case g.Part():
            return f'[{kind.name}](#{_anchor(kind.name)})' + (
                f' but {", ".join(kind.without)}' if kind.without else ''
            )
    raise TypeError(kind)


def _limits(kind: Any) -> str:
    if isinstance(kind, g.Whole):
        return f', {kind.minimum} or more'
    if kind.positive:
        return ', positive'
    if kind.minimum is not None and kind.maximum is not None:
        return f' from {kind.minimum:g} to {kind.maximum:g}'
    return '' if kind.minimum is None else f', {kind.minimum:g} or more'


def _anchor(name: str) -> str:
    return ''.join(letter for letter in name if letter.isalnum() or letter in ' _').replace(
        ' ', '-'
    )


def _cell(text: str) -> str:
    return text.replace('|', '\\|').replace('<', '\\<')


if __name__ == '__main__':
    wanted = {PAGE: page(), SCHEMA: schema()}
    if '--check' in sys.argv:
        sys.exit(any(text != path.read_text(encoding='utf-8') for path, text in wanted.items()))
    for path, text in wanted.items():
        path.write_text(text, encoding='utf-8')
