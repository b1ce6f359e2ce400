# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Looks after recordings: what is in one, is it whole, save the rest of one, compare two."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from typing import Any

from rigid_body_sim.analysis.recorded_contacts import HOW_TO_RECORD, scene_has_contact, summarise
from rigid_body_sim.analysis.recorded_impacts import summarise as summarise_impacts
from rigid_body_sim.recording.bag_check import check
from rigid_body_sim.recording.bag_diff import Difference, compare
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.recovery import recover
from rigid_body_sim.runs.reading_guard import reads_recording
from rigid_body_sim.terminal import printable

SUMMARY = 'look after recordings: info, check, recover, diff'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare `bag info|check|recover|diff`."""
    actions = parser.add_subparsers(
        dest='action', required=True, metavar='info|check|recover|diff'
    )
    info = actions.add_parser('info', help='topics, counts, time span and how the run ended')
    info.set_defaults(do=_info)
    verify = actions.add_parser(
        'check', help='name everything that is wrong; exit 1 if anything is'
    )
    verify.set_defaults(do=_check)
    restore = actions.add_parser('recover', help='save what is whole of a torn recording')
    restore.set_defaults(do=_recover)
    differ = actions.add_parser(
        'diff', help='compare the messages of two recordings; exit 3 if they differ'
    )
    differ.set_defaults(do=_diff)
    for action in (info, verify, restore):
        action.add_argument('bag', metavar='BAG', help='bag directory or .mcap file')
    restore.add_argument(
        '-o', '--output', metavar='NEW', required=True, help='bag directory to write'
    )
    differ.add_argument('bag', metavar='A', help='bag directory or .mcap file')
    differ.add_argument('other', metavar='B', help='bag directory or .mcap file')
    for action in (info, verify, restore, differ):
        action.add_argument('--json', action='store_true', help='print one JSON object')


@reads_recording('bag')
def run(arguments: argparse.Namespace) -> int:
    """Do what was asked; returns the exit code."""
    return arguments.do(arguments)


def _info(arguments: argparse.Namespace) -> int:
    bag = Bag(arguments.bag)
    facts = _facts(bag)
    if arguments.json:
        print(json.dumps(facts))
        return 0
    for key in ('bag', 'complete', 'start', 'duration', 'messages'):
        print(f'{key + ":":<12}{facts[key]}{" s" if key in ("start", "duration") else ""}')
    _print_contacts(bag, facts['contacts'])
    _print_impacts(facts['impacts'])
    if bag.attachments:
        print(
            'attached:   '
            + ', '.join(f'{printable(n)} ({s} bytes)' for n, s in facts['attachments'].items())
        )
    for title, content in (
        ('manifest', bag.manifest),
        ('ending', bag.ending or {}),
        ('recovered', bag.recovered),
    ):
        _print_map(title, content)
    names = {name: printable(bag.wire_name(name)) for name in bag.topics}
    width = max(map(len, names.values()), default=0)
    print('topics:')
    for name, topic in bag.topics.items():
        count = bag.counts[name]
        print(f'  {names[name]:<{width}}  {printable(topic.type):<32}  {count:>9}')
    return 0


def _facts(bag: Bag) -> dict[str, Any]:
    return {
        'bag': str(bag.path),
        'complete': bag.complete,
        'start': bag.first_time / 1e9,
        'duration': (bag.last_time - bag.first_time) / 1e9,
        'messages': sum(bag.counts.values()),
        'topics': {
            bag.wire_name(name): {'type': topic.type, 'count': bag.counts[name]}
            for name, topic in bag.topics.items()
        },
        'contacts': None if (contacts := summarise(bag)) is None else asdict(contacts),
        'impacts': None if (impacts := summarise_impacts(bag)) is None else asdict(impacts),
        'attachments': {name: len(content) for name, content in bag.attachments.items()},
        'manifest': bag.manifest,
        'ending': bag.ending,
        'recovered': bag.recovered,
    }


def _print_contacts(bag: Bag, contacts: dict[str, Any] | None) -> None:
    """Say what touched, or how to record it."""
    if contacts is None:
        if scene_has_contact(bag):
            print(f'contacts:   not recorded; {HOW_TO_RECORD}')
        return
    print(
        f'contacts:   {contacts["contacts"]} in {contacts["messages"]} messages (of published '
        'ticks; what is between them is not recorded)'
    )
    for key, unit in (('largest_force', 'N'), ('deepest_gap', 'm')):
        if (extreme := contacts[key]) is not None:
            print(
                f'  {key.replace("_", " ") + ":":<16}{extreme["value"]:.4g} {unit} on '
                f'{printable(extreme["body"])} at {extreme["time"]:g} s'
            )


def _print_impacts(impacts: dict[str, Any] | None) -> None:
    """Say how many impacts there are at their instants, and which was the hardest."""
    if impacts is None:
        return
    kinds = ', '.join(f'{count} {kind}' for kind, count in impacts['kinds'].items() if count)
    print(f'impacts:    {impacts["impacts"]}{f" ({kinds})" if kinds else ""}')
    if (largest := impacts['largest_impulse']) is not None:
        a, b = map(printable, largest['bodies'])
        print(
            f'  largest impulse: {largest["value"]:.4g} N s of {a} on {b} at {largest["time"]:g} s'
        )


def _print_map(title: str, content: dict[str, str]) -> None:
    if not content:
        return
    print(f'{title}:')
    width = max(len(printable(key)) for key in content)
    for key, value in content.items():
        line = ' '.join(value.split())
        print(f'  {printable(key):<{width}}  {line if len(line) <= 80 else line[:77] + "..."}')


def _check(arguments: argparse.Namespace) -> int:
    findings = check(arguments.bag)
    if not findings:  # what is not whole is not interpreted
        from rigid_body_sim.runs.recorded_check import check_run  # slow to import

        findings = check_run(arguments.bag)
    if arguments.json:
        print(json.dumps({'bag': arguments.bag, 'findings': findings}))
    else:
        print('\n'.join(map(printable, findings)) if findings else f'{arguments.bag}: whole')
    return 1 if findings else 0


def _recover(arguments: argparse.Namespace) -> int:
    found = recover(arguments.bag, arguments.output)
    if arguments.json:
        print(json.dumps({'bag': arguments.output, **found._asdict()}))
        return 0
    until = '' if found.last_tick is None else f' up to tick {found.last_tick}'
    print(f'{arguments.output}: {found.messages} messages{until}, {found.dropped} dropped')
    print(f'{arguments.bag}: {found.problem or "all its messages are there"}')
    return 0


def _diff(arguments: argparse.Namespace) -> int:
    comparison = compare(Bag(arguments.bag), Bag(arguments.other))
    difference = comparison.difference
    if arguments.json:
        named = {} if difference is None else _plain(difference)
        print(json.dumps({'identical': not named, 'messages': comparison.equal, **named}))
    elif difference is None:
        print(f'identical: {comparison.equal} messages')
    else:
        distance = '' if difference.ulps is None else f' ({difference.ulps} ulps)'
        print(
            f'differ after {comparison.equal} equal messages: tick {difference.tick}, '
            f'{printable(difference.topic)}, {difference.field}: '
            f'{difference.a!r} and {difference.b!r}{distance}'
        )
    return 0 if difference is None else 3


def _plain(difference: Difference) -> dict[str, Any]:
    """The difference for JSON, which has no NaN: values as text."""
    return {**difference._asdict(), 'a': repr(difference.a), 'b': repr(difference.b)}
