# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Regular expressions as POSIX extends them, by which `simulation_interfaces` filters names.

Python's own are another language ([[:alpha:]] means something else) and may take hours for a name
of forty letters, in which no other thread runs. Here an expression becomes an automaton that is in
many states at once, so that a name costs its letters times the states at most, and the sets of
states are remembered: K. Thompson, "Regular expression search algorithm", CACM 11 (1968) 419.

Of IEEE Std 1003.1-2024, 9.4: . [ ] ( ) * + ? { } | ^ $ and \\ before them; the sets of the C
locale. There are no back-references, as there are none in POSIX.
"""

from __future__ import annotations

import string
from dataclasses import dataclass, field

LONGEST = 1000  # [characters] of an expression
DEEPEST = 50  # [-] brackets within brackets
MOST_STATES = 5000  # [-] of an automaton: a{1000} takes three thousand
MOST_KEPT = 10_000  # [-] steps that are remembered
SETS = {
    'alnum': string.ascii_letters + string.digits,
    'alpha': string.ascii_letters,
    'blank': ' \t',
    'cntrl': ''.join(map(chr, range(32))) + '\x7f',
    'digit': string.digits,
    'graph': string.ascii_letters + string.digits + string.punctuation,
    'lower': string.ascii_lowercase,
    'print': string.ascii_letters + string.digits + string.punctuation + ' ',
    'punct': string.punctuation,
    'space': string.whitespace,
    'upper': string.ascii_uppercase,
    'xdigit': string.hexdigits,
}
_SPECIAL = frozenset('^.[$()|*+?{\\')


class BadExpression(ValueError):
    """What is wrong with an expression, in words."""


@dataclass(frozen=True)
class Letters:
    """One letter out of a set; `others`: out of all that are not in it."""

    these: frozenset[str]
    others: bool = False

    def hold(self, letter: str) -> bool:
        """Whether it is one of them."""
        return (letter in self.these) != self.others


@dataclass
class State:
    """
    Where an automaton can be.

    letters : that lead on to `next`; None: it goes on without one
    only_at : 'start' or 'end' of the name where it goes on at all; '': anywhere
    next    : indices of states
    """

    letters: Letters | None = None
    only_at: str = ''
    next: list[int] = field(default_factory=list)


class Expression:
    """
    One expression; BadExpression if it is none.

    `matches` tells whether it stands for a whole name.
    """

    def __init__(self, text: str) -> None:
        if len(text) > LONGEST:
            raise BadExpression(f'it has {len(text)} characters; at most {LONGEST} are allowed')
        reader = _Reader(text)
        self._first, self._last = reader.read()
        self._states = reader.states
        self._steps: dict[tuple[frozenset[int], str], frozenset[int]] = {}

    def matches(self, name: str) -> bool:
        """Whether it stands for the name, from its first letter to its last."""
        here = self._reached({self._first}, 'start', at_end=not name)
        for number, letter in enumerate(name, start=1):
            at_end = number == len(name)
            key = (here, letter if not at_end else f'{letter}$')
            after = self._steps.get(key)
            if after is None:
                led = (s for s in here if (x := self._states[s].letters) and x.hold(letter))
                on = {after for s in led for after in self._states[s].next}
                after = self._reached(on, '', at_end=at_end)
                if len(self._steps) < MOST_KEPT:
                    self._steps[key] = after
            here = after
        return self._last in here

    def _reached(self, states: set[int], place: str, *, at_end: bool) -> frozenset[int]:
        """Add where the automaton gets without a letter."""
        reached, waiting = set(states), list(states)
        while waiting:
            state = self._states[waiting.pop()]
            blocked = state.only_at == 'start' != place or (state.only_at == 'end' and not at_end)
            if state.letters is None and not blocked:
                new = [s for s in state.next if s not in reached]
                reached.update(new)
                waiting += new
        return frozenset(reached)


Fragment = tuple[int, int]  # states where it begins and ends; nothing leads on from the end yet


class _Reader:
    """Reads one expression, and adds its states on the way."""

    def __init__(self, text: str) -> None:
        self.states: list[State] = []
        self._text = text
        self._at = 0
        self._depth = 0

    def _add(self, state: State) -> int:
        if len(self.states) >= MOST_STATES:
            raise BadExpression(f'it repeats its parts too often: over {MOST_STATES} states')
        self.states.append(state)
        return len(self.states) - 1

    def read(self) -> Fragment:
        """Read it all."""
        found = self._choice()
        if self._at < len(self._text):
            raise self._bad("')' that closes nothing")
        return found

    def _bad(self, what: str) -> BadExpression:
        return BadExpression(f'{what} at character {min(self._at + 1, len(self._text))}')

    def _choice(self) -> Fragment:
        branches = [self._branch()]
        while self._take('|'):
            branches.append(self._branch())
        start, end = self._add(State()), self._add(State())
        for first, last in branches:
            self.states[start].next.append(first)
            self.states[last].next.append(end)
        return start, end

    def _branch(self) -> Fragment:
        start = end = self._add(State())
        while self._at < len(self._text) and self._text[self._at] not in '|)':
            first, last = self._repeated()
            self.states[end].next.append(first)
            end = last
        return start, end

    def _repeated(self) -> Fragment:
        begin, depth = self._at, self._depth
        found = self._atom()
        after_atom = self._at
        while (times := self._times()) is not None:
            after = self._at
            found = self._repeat(found, (begin, after_atom, depth), *times)
            self._at, after_atom = after, after
        return found

    def _times(self) -> tuple[int, int | None] | None:
        """Read how often the last part may come: least and most, None: any number."""
        for sign, times in (('*', (0, None)), ('+', (1, None)), ('?', (0, 1))):
            if self._take(sign):
                return times
        if not self._take('{'):
            return None
        end = self._text.find('}', self._at)
        low, comma, high = self._text[self._at : max(end, self._at)].partition(',')
        numbers = [x for x in (low, high) if x]
        if end < 0 or not numbers or not all(x.isascii() and x.isdigit() for x in numbers):
            raise self._bad("'{' without numbers and '}'")
        least = int(low or 0)
        most = int(high) if high else None if comma else least
        if least > LONGEST or (most is not None and not least <= most <= LONGEST):
            raise self._bad(f"'{{' with numbers that are not ascending, at most {LONGEST},")
        self._at = end + 1
        return least, most

    def _repeat(
        self, found: Fragment, source: tuple[int, int, int], least: int, most: int | None
    ) -> Fragment:
        """Chain as many copies as are needed; each is read anew where it stands."""
        start = end = self._add(State())
        copies = [found]

        def copy() -> Fragment:
            if copies:
                return copies.pop()
            self._at, self._depth = source[0], source[2]
            return self._again(source[1])

        for _ in range(least):
            first, last = copy()
            self.states[end].next.append(first)
            end = last
        if most is None:
            first, last = copy()
            loop = self._add(State(next=[first]))
            self.states[end].next.append(loop)
            self.states[last].next.append(loop)
            return start, loop
        leave = self._add(State())
        for _ in range(most - least):
            self.states[end].next.append(leave)
            first, last = copy()
            self.states[end].next.append(first)
            end = last
        self.states[end].next.append(leave)
        return start, leave

    def _again(self, until: int) -> Fragment:
        """Read a part once more, with all that repeats it, up to where it ended."""
        begin, depth = self._at, self._depth
        found = self._atom()
        after_atom = self._at
        while self._at < until:
            times = self._times()
            assert times is not None  # it was read before
            after = self._at
            found = self._repeat(found, (begin, after_atom, depth), *times)
            self._at, after_atom = after, after
        return found

    def _atom(self) -> Fragment:
        letter = self._text[self._at]
        if letter in '*+?{':
            raise self._bad(f'{letter!r} that repeats nothing')
        self._at += 1
        if letter == '(':
            return self._group()
        if letter in '^$':
            return self._one(State(only_at='start' if letter == '^' else 'end'))
        if letter == '.':
            return self._one(State(letters=Letters(frozenset(), others=True)))
        if letter == '[':
            return self._one(State(letters=self._set()))
        if letter == '\\':
            if self._at >= len(self._text) or self._text[self._at] not in _SPECIAL | set(')}]/'):
                raise self._bad("'\\' that no special character follows")
            letter = self._text[self._at]
            self._at += 1
        return self._one(State(letters=Letters(frozenset(letter))))

    def _group(self) -> Fragment:
        self._depth += 1
        if self._depth > DEEPEST:
            raise self._bad(f'brackets in more than {DEEPEST} brackets')
        found = self._choice()
        if not self._take(')'):
            raise self._bad("'(' without ')'")
        self._depth -= 1
        return found

    def _one(self, state: State) -> Fragment:
        first, last = self._add(state), self._add(State())
        self.states[first].next.append(last)
        return first, last

    def _take(self, letter: str) -> bool:
        found = self._text.startswith(letter, self._at)
        self._at += found
        return found

    def _set(self) -> Letters:
        """Read a bracket expression behind its '['."""
        begin = self._at - 1
        others = self._take('^')
        these: set[str] = set()
        first = True
        while first or not self._take(']'):
            first = False
            if self._at >= len(self._text):
                self._at = begin
                raise self._bad("'[' without ']'")
            if self._text.startswith('[:', self._at):
                these.update(self._named_set())
                continue
            low = high = self._member()
            if self._text.startswith('-', self._at) and self._text[self._at + 1 :][:1] != ']':
                self._at += 1
                high = self._member()
            if high < low:
                raise self._bad(f'the range {low}-{high} that is empty')
            these.update(map(chr, range(ord(low), min(ord(high), 0x7F) + 1)))
            these.update((low, high))
        return Letters(frozenset(these), others=others)

    def _named_set(self) -> str:
        end = self._text.find(':]', self._at)
        name = self._text[self._at + 2 : max(end, self._at)]
        if end < 0 or name not in SETS:
            raise self._bad(f'the set [:{name}:]; allowed are {", ".join(SETS)};')
        self._at = end + 2
        return SETS[name]

    def _member(self) -> str:
        """Read one letter of a set, also as [.x.] or [=x=]."""
        for mark in '.=':
            if self._text.startswith(f'[{mark}', self._at):
                letter, close = self._text[self._at + 2 :][:1], self._text[self._at + 3 :][:2]
                if close != f'{mark}]':
                    raise self._bad(f'[{mark} that names no single letter')
                self._at += 5
                return letter
        if self._at >= len(self._text):
            raise self._bad("'[' without ']'")
        self._at += 1
        return self._text[self._at - 1]
