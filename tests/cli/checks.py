"""Checks of the command line that are counted. The program is the first argument of the script that imports this.
SPDX-License-Identifier: MIT"""

import subprocess
import sys

CQM = sys.argv[1]
passed, failed = 0, 0


def check(name, condition):
    global passed, failed
    if condition:
        passed += 1
    else:
        failed += 1
        print("FAIL ", name)


def run(*arguments, status=0):
    """Standard error and output; the exit status must be as told."""
    done = subprocess.run([CQM, *map(str, arguments)], capture_output=True, check=False)
    check(f"cqm {' '.join(map(str, arguments))}: status {done.returncode}, {done.stderr.decode()}",
          done.returncode == status)
    return done.stderr.decode(), done.stdout.decode()


def finish():
    """Prints the counts; the exit status of the script."""
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


def run_tests(folder, tests):
    """All tests, with an empty folder for their files; the exit status of the script."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in folder.iterdir():
        path.unlink()
    for test in tests:
        test()
    return finish()
