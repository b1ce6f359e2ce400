# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Names that a user gives, against those that are known."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import nearest


def chosen(
    given: Sequence[str] | None, known: Iterable[str], *, option: str, what: str
) -> list[str]:
    """
    Return the names given, each once, in their order; all that are known where none is given.

    Raises UserError for an unknown one; it names the nearest.
    """
    names = list(known)
    if not given:
        return names
    for name in given:
        if name not in names:
            near = nearest(name, names)
            cure = '' if near is None else f'did you mean {near!r}? '
            raise UserError(
                f'{option}: {what} {name!r} is unknown; {cure}allowed: {", ".join(sorted(names))}'
            )
    return list(dict.fromkeys(given))
