# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The walls between the rooms, read from the import statements, and the size of what stands in them.

A room may import what its row names, the standard library, and itself.
Who is not in the table may import anything but ROS.
Inside physics and contact arrows point downwards, from a room to those before it in FLOORS.

Every test reads all modules and names all that break its rule.
"""

import ast
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

NAME = 'rigid_body_sim'
ROOT = Path(__file__).parents[2]
MODULES = sorted((ROOT / NAME).rglob('*.py'))
HEADER = ['# Copyright 2026 rigid_body_sim maintainers', '# SPDX-License-Identifier: Apache-2.0']
NUMERIC = {'numpy', 'scipy'}
PEERS = {'dartpy', 'mujoco', 'pinocchio', 'pybullet', 'pydrake', 'rapier3d'}  # in report/peers
WALLS = {  # room -> what it may import besides the standard library and itself
    'physics': NUMERIC | {'numba', 'llvmlite'},  # the second comes with the first
    'exact': NUMERIC,
    'recording': {'numpy', 'mcap', 'yaml', 'lz4', 'zstandard', f'{NAME}.errors'},
    'scene': {'numpy', 'yaml', 'trimesh', 'coacd', 'lxml', 'yourdfpy'}
    | {f'{NAME}.physics', f'{NAME}.errors'},
    'report': NUMERIC
    | {'PIL', 'matplotlib', 'yaml', f'{NAME}.__version__', f'{NAME}.errors'}
    | {f'{NAME}.physics', f'{NAME}.exact', f'{NAME}.scene', f'{NAME}.recording.new_output'}
    | PEERS,
    'sweeps': {
        'numpy',
        'pyarrow',
        'pandas',
        'distributed',
        f'{NAME}.__version__',
        f'{NAME}.errors',
    }
    | {f'{NAME}.{room}' for room in ('physics', 'scene', 'recording', 'runs', 'stop_signals')}
    | {f'{NAME}.missing_packages'},
    'testing.plugin': {'pytest', f'{NAME}.testing'},  # every pytest of an environment loads it
    'errors': set(),
}
SPEAK_ROS = {'ros', 'testing', 'verbs.sim_node', 'verbs.view', 'verbs.wrench_pub'}
FLOORS = {  # room -> rooms and lone modules in it, the lowest first: arrows go down
    'physics': (
        'errors', 'arrays', 'compile', 'vectors', 'model', 'state', 'forces', 'integration',
        'contact', 'diagnostics', 'validation', 'stepper', 'simulation',
    ),
    'physics.contact': (
        'pair_rules', 'settings', 'suited_integrators', 'unresolved_motions', 'tick_settings',
        'tick_counts', 'array_groups', 'packed_bodies', 'solver_bodies', 'crew', 'helpers',
        'collision', 'solver', 'touching', 'islands', 'prescribed_bodies', 'works_of_drives',
        'events', 'energy', 'readout', 'tick_world', 'detection', 'assembly', 'substeps',
        'tick_end', 'step', 'world_arrays', 'world_readout', 'world_memory', 'pieces',
        'island_ticks', 'cut_ticks', 'ticks', 'world',
    ),
    'physics.integration': (
        'status', 'options', 'limits', 'free_rotation', 'schemes', 'integrator', 'orientation',
        'integrators', 'candidates', 'choose', 'lookout',
    ),
}  # fmt: skip
MOST_LINES = 80  # of a function in physics, its docstring counted
MOST_PARAMETERS = 12


def within(name: str, rooms: set[str]) -> bool:
    """
    Whether a dotted name is one of the rooms or lies inside one.
    """
    return any(name == room or name.startswith(f'{room}.') for room in rooms)


def tree_of(path: Path) -> ast.Module:
    """
    A module as Python reads it.
    """
    return ast.parse(path.read_text(encoding='utf-8'))


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """
    What stands directly below a node and is, or holds, a statement: expressions hold none.
    """
    kinds = ast.stmt | ast.excepthandler | ast.match_case
    return (child for child in ast.iter_child_nodes(node) if isinstance(child, kinds))


@cache
def imports(path: Path) -> set[str]:
    """
    Absolute dotted names of everything a module imports, function bodies included.
    """
    found, ahead = set(), [tree_of(path)]
    while ahead:
        node = ahead.pop()
        ahead += statements(node)
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path}:{node.lineno}: relative import; name the room'
            found |= {f'{node.module}.{alias.name}' for alias in node.names}
    return found


def room_of(path: Path) -> str:
    """
    Dotted name of a module below the package: `physics.model.scene`, `scene`, `verbs.view`.
    """
    return '.'.join(path.relative_to(ROOT / NAME).with_suffix('').parts).removesuffix('.__init__')


def is_ros(name: str) -> bool:
    """
    Whether an import is rclpy, a package of messages or services, or what comes with them.
    """
    top = name.partition('.')[0]
    return top.endswith(('_msgs', '_srvs', '_interfaces')) or top in {
        'rclpy',
        'rosidl_runtime_py',
        'rpyutils',
    }


@cache
def arrows() -> dict[str, set[str]]:
    """
    The modules of the package, by their dotted names below it, and which of these they import.
    """
    known = {f'{NAME}.{room_of(path)}' for path in MODULES}
    found = {}
    for path in MODULES:
        # `from room import name`: the name is a module, or stands in the module `room`
        named = {n if n in known else n.rpartition('.')[0] for n in imports(path)} & known
        found[room_of(path)] = {n.removeprefix(f'{NAME}.') for n in named} - {room_of(path)}
    return found


def in_circles(arrows: dict[str, set[str]]) -> list[str]:
    """
    Those from which arrows lead back to them.
    """

    def reached(start: str) -> set[str]:
        seen, ahead = set(), [start]
        while ahead:
            new = arrows[ahead.pop()] - seen
            seen |= new
            ahead += new
        return seen

    return sorted(room for room in arrows if room in reached(room))


def floor_of(room: str, whole: str) -> int:
    """
    On which floor of a room a module inside it stands.
    """
    floors = [k for k, name in enumerate(FLOORS[whole]) if within(room, {f'{whole}.{name}'})]
    assert floors, f'{room} stands on no floor of {whole}: give it one in FLOORS'
    return floors[0]


def functions(path: Path) -> Iterator[tuple[str, ast.FunctionDef]]:
    """
    The functions of a module with their names: `step._advance`, `stepper.Stepper.begin`.
    """

    def inside(node: ast.AST, name: str) -> Iterator[tuple[str, ast.FunctionDef]]:
        for child in statements(node):
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                own = f'{name}.{child.name}'
                if isinstance(child, ast.FunctionDef):
                    yield own, child
                yield from inside(child, own)
            else:
                yield from inside(child, name)

    return inside(tree_of(path), room_of(path).rpartition('.')[2])


def parameters(function: ast.FunctionDef) -> int:
    """
    How many parameters a function has, `self` not counted.
    """
    given = function.args
    several = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
    return len([one for one in several if one is not None and one.arg not in ('self', 'cls')])


def test_each_room_imports_only_what_its_wall_lets_through():
    strangers = {}
    for path in MODULES:
        room = room_of(path)
        for wall, allowed in WALLS.items():
            if within(room, {wall}):
                own = allowed | {f'{NAME}.{wall}'} | set(sys.stdlib_module_names)
                strangers[wall, room] = sorted(n for n in imports(path) if not within(n, own))
    assert not {place: names for place, names in strangers.items() if names}


def those_who_import(strange, except_rooms):
    """
    Modules outside of some rooms, with what they import of the strange.
    """
    found = {}
    for path in MODULES:
        if not within(room_of(path), except_rooms):
            found[room_of(path)] = sorted(name for name in imports(path) if strange(name))
    return {room: names for room, names in found.items() if names}


def test_only_the_ros_room_knows_ros_and_its_verbs_and_the_tests_of_users_know_it():
    assert not those_who_import(is_ros, {'ros'})
    assert not those_who_import(lambda name: within(name, {f'{NAME}.ros'}), SPEAK_ROS)


def test_nothing_leans_on_the_report_but_its_verb_and_the_one_that_lists_its_problems():
    report, verbs = {f'{NAME}.report'}, {'verbs.report', 'verbs.list'}
    assert not those_who_import(lambda name: within(name, report), {'report', *verbs})


def test_peers_are_imported_in_their_files_alone():
    assert not those_who_import(lambda name: within(name, PEERS), {'report.peers'})


def test_no_function_of_physics_outgrows_the_head_that_reads_it():
    too_large = {}
    for path in MODULES:
        if within(room_of(path), {'physics'}):
            for name, function in functions(path):
                lines = (function.end_lineno or 0) - function.lineno + 1
                if lines > MOST_LINES or parameters(function) > MOST_PARAMETERS:
                    too_large[name] = f'{lines} lines, {parameters(function)} parameters'
    assert not too_large


def test_how_many_lanes_a_kernel_of_contact_goes_over_is_no_constant_to_its_compiler():
    """
    It would go over them one by one: see `solver.iterations`.
    """
    rooms = [path for path in MODULES if within(room_of(path), {'physics.contact'})]
    texts = {path: path.read_text(encoding='utf-8') for path in rooms}  # quicker than trees
    of_lanes = {
        f'{room_of(path)}.{function.name}'
        for path in rooms
        if 'lanes' in texts[path]
        for _, function in functions(path)
        if 'lanes' in [given.arg for given in function.args.args[:1]]
    }
    assert 'physics.contact.islands.unsettled._extrapolate' in of_lanes
    names = {name.rpartition('.')[2] for name in of_lanes}
    constants = []
    for path in rooms:
        if not any(name in texts[path] for name in names):
            continue
        here = room_of(path)
        known = {name.rpartition('.')[2]: name.removeprefix(f'{NAME}.') for name in imports(path)}
        for call in (node for node in ast.walk(tree_of(path)) if isinstance(node, ast.Call)):
            owner, dot, name = ast.unparse(call.func).rpartition('.')
            called = f'{known.get(owner)}.{name}' if dot else known.get(name, f'{here}.{name}')
            first = ast.unparse(call.args[0]) if call.args else ''
            if called in of_lanes and (first.isdigit() or first.rpartition('.')[2] == 'LANES'):
                constants.append(f'{here}: {name}({first}, ...)')
    assert not constants


def test_no_modules_and_no_rooms_import_each_other_in_a_circle():
    assert not in_circles(arrows())
    rooms: dict[str, set[str]] = {}
    for module, others in arrows().items():
        room = module.partition('.')[0]
        rooms.setdefault(room, set()).update(other.partition('.')[0] for other in others)
        rooms[room].discard(room)
    assert not in_circles(rooms)


def test_arrows_inside_a_room_point_downwards():
    upwards = []
    for whole in FLOORS:
        inside = {room for room in arrows() if within(room, {whole})} - {whole}
        for room in inside:
            upwards += [
                f'{room} -> {other}'
                for other in arrows()[room] & inside
                if floor_of(other, whole) > floor_of(room, whole)
            ]
    assert not sorted(upwards)


def test_every_python_file_carries_the_licence():
    kept = ['setup.py', NAME, 'test', 'tools', 'benchmark', 'examples']
    files = [
        path
        for top in kept
        for path in [ROOT / top, *(ROOT / top).rglob('*.py')]
        if path.is_file()
    ]
    assert not [
        str(path) for path in files if path.read_text(encoding='utf-8').splitlines()[:2] != HEADER
    ]
