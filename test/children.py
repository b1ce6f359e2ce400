# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What runs in a child of the process of the tests: it has imported everything already, shares its
kernels, and leaves nothing behind.
"""

import os
import pickle
import runpy
import signal
import sys
import tempfile
import traceback
from io import FileIO, TextIOWrapper

from .patience import HANGING


def run_script(path, *words):
    """
    Run a program as `python path words` does; give its exit code and all that it printed.
    """

    def run(file):
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
        sys.stdout = sys.stderr = TextIOWrapper(FileIO(1, 'w', closefd=False))
        sys.argv = [str(path), *map(str, words)]
        sys.path.insert(0, str(path.parent))
        try:
            runpy.run_path(str(path), run_name='__main__')
        finally:
            sys.stdout.flush()

    code, printed = _in_child(run)
    return code, printed.decode()


def result_of(work, *arguments):
    """
    Give what a function returns that is called in a child.
    """

    def run(file):
        pickle.dump(work(*arguments), file)

    code, printed = _in_child(run)
    assert code == 0, printed.decode()
    return pickle.loads(printed)


def _in_child(run):
    with tempfile.TemporaryFile() as file:
        child = os.fork()
        if child == 0:
            os._exit(_run(run, file))
        _, status = os.waitpid(child, 0)
        file.seek(0)
        return os.waitstatus_to_exitcode(status), file.read()


def _run(run, file):
    """
    Give the exit code of who runs; what went wrong stands in the file.
    """
    signal.alarm(int(HANGING))
    try:
        run(file)
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        file.write(traceback.format_exc().encode())
        return 1
    finally:
        file.flush()
    return 0
