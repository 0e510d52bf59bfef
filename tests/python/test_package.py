"""The package itself. SPDX-License-Identifier: MIT"""

import importlib.metadata
import inspect
import re
import subprocess
import sys
from pathlib import Path

import conquest

ROOT = Path(__file__).resolve().parents[2]

USER = """
import numpy as np
import conquest

data: bytes = conquest.encode(np.eye(3), [[0, 1, 2]], bits={"positions": 14}, colors=np.zeros((3, 3), np.uint8))
data, to, face_to = conquest.encode(np.eye(3), [[0, 1, 2]], return_maps=True)
reveal_type(to)
reveal_type(conquest.decode(data).attributes)
reveal_type(conquest.Decoder().faces)
conquest.decode(7)
conquest.encode(np.eye(3), [[0, 1, 2]], goal="small")
"""


def mypy(*arguments):
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir=/dev/null", *arguments],
                          capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def test_the_version_is_that_of_the_header():
    header = (ROOT / "include/conquest.h").read_text(encoding="utf-8")
    version = re.search(r'CQ_VERSION_STRING "(.*)"', header)[1]
    assert conquest.__version__ == importlib.metadata.version("conquest") == version


def test_the_package_has_no_error_of_types():
    status, output = mypy("-p", "conquest")
    assert status == 0, output


def test_users_see_types(tmp_path):
    (tmp_path / "user.py").write_text(USER)
    _, output = mypy(str(tmp_path / "user.py"))
    assert re.search(r":7: note: Revealed type is .*ndarray.*32", output), output
    assert re.search(r":8: note: Revealed type is .*dict\[.*str, .*ndarray", output), output
    assert re.search(r":9: note: Revealed type is .*ndarray.*32", output), output
    assert re.findall(r":(\d+): error", output) == ["10", "11"], output


def test_everything_public_is_documented():
    public = [getattr(conquest, name) for name in conquest.__all__]
    public += [member for thing in public if inspect.isclass(thing) for name, member in vars(thing).items()
               if not name.startswith("_") and (callable(member) or isinstance(member, property))]
    assert len(public) > 20
    assert [thing for thing in public if not inspect.getdoc(thing)] == []


def test_readme_examples_run():
    """The Python of README.md, as it is there."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    examples = re.findall(r"```python\n(.*?)```", readme, re.S)
    assert examples
    for example in examples:
        exec(compile(example, "README.md", "exec"), {})  # pylint: disable=exec-used
