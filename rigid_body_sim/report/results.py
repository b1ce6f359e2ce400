# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a report found, as JSON and CSV.

    {"schema": 1,
     "made": {"date", "machine", "cpu", "cores", "load", "threads", "clock", "versions": {…},
              "compiled", "python", "seed", "repetitions", "quick", "interrupted", "command",
              "scene"},
     "problems": [{"name", "title", "kind", "description", "shows", "error_unit", "duration",
                   "instants", "reference", "useless", "points": [fields of `report.point.Point`],
                   "at_equal_error": [fields of `report.pareto.AtError`],
                   "at_equal_bodies": [see `report.throughput`], "verdict"}],
     "starts": [fields of `report.first_start.Start`],
     "absent": [{"engine", "reason"}]}

"command" is what makes the report again, null: `make report`; "scene" that of `--scene`, or null.
"kind" is "work_precision" (points differ in method and step) or "throughput" (in method and number
of bodies). A report of a user's scene has one problem, with "reference_error" and
"recommendation".
Costs are in seconds per simulated second; a number that is not known is null. The
schema's number changes when a field changes its meaning or goes; new fields may come.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording.new_output import not_written, replacing
from rigid_body_sim.report.pareto import at_equal_error, mark_front, verdict
from rigid_body_sim.report.point import Point
from rigid_body_sim.report.problem import THROUGHPUT, Problem
from rigid_body_sim.report.throughput import at_equal_bodies, throughput_verdict

SCHEMA = 1
JSON, CSV = 'report.json', 'report.csv'


def problem_results(problem: Problem, points: Sequence[Point]) -> dict[str, Any]:
    """Put together what was found on one problem; marks the front among the points."""
    mark_front(points)
    many = problem.kind == THROUGHPUT
    return {
        'name': problem.name,
        'title': problem.title,
        'heading': problem.heading,
        'kind': problem.kind,
        'description': problem.description,
        'shows': problem.shows,
        'error_unit': problem.error_unit,
        'duration': problem.duration,
        'instants': problem.instants,
        'reference': problem.reference,
        'useless': problem.useless,
        'points': [asdict(point) for point in points],
        'at_equal_error': [] if many else at_equal_error(points, problem.errors),
        'at_equal_bodies': at_equal_bodies(points) if many else [],
        'verdict': throughput_verdict(points)
        if many
        else verdict(points, problem.error_unit, problem.errors),
    }


def in_parts(problems: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Order problems by the parts of the report, those without a heading first."""
    headings = list(dict.fromkeys(['', *(problem.get('heading', '') for problem in problems)]))
    return sorted(problems, key=lambda problem: headings.index(problem.get('heading', '')))


def report(
    made: Mapping[str, Any],
    problems: Sequence[Mapping[str, Any]],
    absent: Sequence[Mapping[str, str]] = (),
    starts: Sequence[Mapping[str, Any]] = (),
) -> dict[str, Any]:
    """Put a whole report together."""
    return {
        'schema': SCHEMA,
        'made': dict(made),
        'problems': list(problems),
        'starts': [*starts],
        'absent': [*absent],
    }


def write(results: Mapping[str, Any], folder: Path) -> None:
    """Write `report.json` and `report.csv`."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise not_written(folder, error, 'make room, or choose another place') from error
    text = json.dumps(results, indent=1, allow_nan=False, ensure_ascii=False)
    write_whole(folder / JSON, text + '\n')
    write_whole(folder / CSV, csv_text(results))


def write_whole(path: Path, text: str) -> Path:
    """Write a file of text; a reader never meets a half-written one."""
    with replacing(path) as part:
        part.write_text(text, encoding='utf-8', newline='')
    return path


def read(folder: Path) -> dict[str, Any]:
    """Read `report.json`; UserError if it is none of ours."""
    path = folder / JSON
    try:
        results = json.loads(path.read_text(encoding='utf-8'))
    except (OSError, ValueError) as error:
        raise UserError(f'{path}: not a report: {error}; write one with `report -o`') from None
    if not isinstance(results, dict) or results.get('schema') != SCHEMA:
        schema = results.get('schema') if isinstance(results, dict) else None
        raise UserError(f'{path}: schema {schema!r}; this version reads {SCHEMA}: write it anew')
    return results


def csv_text(results: Mapping[str, Any]) -> str:
    """Write every point as a line: the name of its problem, then the fields of `Point`."""
    out = io.StringIO()
    names = ['problem', *(each.name for each in fields(Point))]
    writer = csv.DictWriter(out, names, lineterminator='\n')
    writer.writeheader()
    for problem in results['problems']:
        for point in problem['points']:
            writer.writerow({'problem': problem['name'], **point})
    return out.getvalue()
