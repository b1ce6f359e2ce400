# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The words behind a verb: what is misspelt is named, with the nearest that there is."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any, NoReturn


class Paragraphs(argparse.HelpFormatter):
    """A description keeps its paragraphs, each as wide as the terminal."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        fill = super()._fill_text
        return '\n\n'.join(fill(each, width, indent) for each in text.strip().split('\n\n'))


def decimal(word: str) -> float:
    """Read a number as a scene has it; infinity and NaN are words that a verb refuses itself."""
    if word.strip().lstrip('+-').lower() not in ('inf', 'infinity', 'nan'):
        _check_digits(word)
    return float(word)


def whole(word: str) -> int:
    """Read a whole number as a scene has it."""
    _check_digits(word)
    return int(word)


def _check_digits(word: str) -> None:
    from rigid_body_sim.scene import numerals  # only for who gives a number

    if numerals.decimal(word.strip()) is None:
        raise argparse.ArgumentTypeError(f'{word!r} is no number{numerals.cure(word.strip())}')


class CommandLine(argparse.ArgumentParser):
    """
    A parser that asks about options and choices that there are none of before anything else: what
    is misspelt is not there, and would be missed first. Parsers of the actions of a verb do, too.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **{'formatter_class': Paragraphs, **options})
        self.register('type', float, decimal)
        self.register('type', int, whole)

    def parse_known_args(  # pyright: ignore[reportIncompatibleMethodOverride]  # overloads
        self, args: Any = None, namespace: Any = None
    ) -> Any:
        """Refuse an unknown option, or read the words as `argparse` does."""
        if self._subparsers is None:  # each action has a parser of its own, with its own options
            self._check_options(() if args is None else args)
        return super().parse_known_args(args, namespace)

    def print_help(self, file: Any = None) -> None:
        """Print the help; a full disk is an error here, too."""
        print(self.format_help(), end='', file=file, flush=True)

    def _check_options(self, words: Sequence[str]) -> None:
        known = [*self._option_string_actions]
        for word in words:
            name = word.partition('=')[0]
            if word == '--':
                return
            if name.startswith('--') and not any(option.startswith(name) for option in known):
                self._refuse('option', name, [option for option in known if option[1] == '-'])

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Name the nearest of the choices, as for every other name in this package."""
        if action.choices is not None and value not in action.choices:
            self._refuse(action.dest, value, [*map(str, action.choices)])

    def _refuse(self, what: str, word: str, known: Sequence[str]) -> NoReturn:
        from rigid_body_sim.physics.errors import choose_from  # only for who made a slip
        from rigid_body_sim.physics.model.numbers import shown

        cure = choose_from(word, known)
        self.exit(2, f'{self.prog}: error: unknown {what} {shown(word)}{cure}\n')
