"""python -m conquest.batch, as a user starts it. SPDX-License-Identifier: MIT"""

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from html import unescape
from pathlib import Path
from urllib.parse import unquote

import meshio
import numpy as np
import pyarrow.parquet
import pytest
import trimesh

import conquest
from conquest.batch import read
from conquest.batch.run import find_files

BATCH = [sys.executable, "-m", "conquest.batch"]
MANY = 40                                     # files of the tests that kill something
HERE = Path(__file__).resolve().parent


def ring(sections):
    return trimesh.creation.torus(2, 1, major_sections=sections, minor_sections=sections)


def write_many(source, count=MANY):
    """Rings of different sizes, in four formats and directories."""
    for k in range(count):
        path = source / f"of {k % 3}" / f"ring_{k}.{('off', 'obj', 'ply', 'stl')[k % 4]}"
        path.parent.mkdir(parents=True, exist_ok=True)
        ring(40 + k).export(path)
    return source


def write_some(source):
    """One file for each reader, and three that have no surface: by name, what the table has to say of them."""
    source.mkdir()
    ball, box = trimesh.creation.icosphere(2), trimesh.creation.box()
    ball.visual = trimesh.visual.TextureVisuals(uv=ball.vertices[:, :2])
    scene = trimesh.Scene()
    scene.add_geometry(ball, geom_name="ball")
    scene.add_geometry(box, geom_name="box", transform=trimesh.transformations.translation_matrix([3, 0, 0]))
    scene.export(source / "scene.glb")
    scene.export(source / "scene.3mf")
    ball.export(source / "ball.dae")
    ring(20).export(source / "ring & <ring>.OFF")
    (source / "twice.off").write_text("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 1\n")
    meshio.Mesh(np.eye(4, 3), [("quad", [[0, 1, 2, 3]]), ("triangle", [[0, 2, 1]])]).write(source / "cells.vtk")
    meshio.Mesh(np.eye(4, 3), [("triangle", [[0, 2, 1]]), ("line", [[0, 3]])], point_data={"heat": np.arange(4.0)}).write(
        source / "heat.vtk")
    (source / "more.off").write_text("OFF\n3 1 0\n0 0 0\n2 0 0\n0 1 1\n3 0 1 2\n3 0 2 1\n")
    (source / "bad.ply").write_text("nonsense\n")
    meshio.Mesh(np.eye(4, 3), [("tetra", [[0, 1, 2, 3]])]).write(source / "solid.vtu")
    (source / "readme.txt").write_text("no mesh\n")
    return {"scene.glb": (170, 332), "scene.3mf": (170, 332), "ball.dae": (162, 320), "ring & <ring>.OFF": (400, 800),
            "twice.off": (3, 2), "cells.vtk": (4, 3),
            "heat.vtk": (4, 1), "more.off": (3, 1), "bad.ply": "not a PLY file", "solid.vtu": "solid cells"}


def batch(*arguments, **more):
    done = subprocess.run([*BATCH, *arguments], capture_output=True, text=True, check=False, timeout=300,
                          **more)
    print(done.stdout, done.stderr)
    return done


def table(target):
    with open(target / "table.csv", encoding="utf-8", newline="") as file:
        return {row["file"]: row for row in csv.DictReader(file)}


def stamps(target):
    """What changes when a file is written again."""
    return {path.relative_to(target): (path.stat().st_ino, path.stat().st_mtime_ns)
            for suffix in ("cqm", "json", "png") for path in target.rglob(f"*.{suffix}")}


def check_all(source, target):
    """Nothing lost, nothing twice, nothing half: one row and one stream for each file, which decodes to what was read."""
    files = sorted(path.relative_to(source).as_posix() for path in source.rglob("*") if path.is_file())
    with open(target / "table.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["file"] for row in rows] == files
    assert sorted(path.relative_to(target).as_posix()[:-4] for path in target.rglob("*.cqm")) == files
    assert not [path for path in target.rglob(".*")]
    for row in rows:
        mesh = conquest.decode((target / (row["file"] + ".cqm")).read_bytes())
        sections = 40 + int(re.search(r"ring_(\d+)", row["file"])[1])
        assert (len(mesh.vertices), len(mesh.faces)) == (sections ** 2, 2 * sections ** 2)
        assert (row["vertices"], row["faces"], row["error"]) == (str(sections ** 2), str(2 * sections ** 2), "")


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.02)


@contextmanager
def processes(*commands, **more):
    started = []
    try:
        for command in commands:
            started.append(subprocess.Popen([sys.executable, "-m", *command], **more))
        yield started
    finally:
        for process in started:
            process.kill()
            process.wait()


@contextmanager
def cluster(folder, *options, **more):
    """A scheduler and two workers on loopback: its address, and the processes of the workers."""
    about = folder / "scheduler.json"
    with processes(["distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
                    "--scheduler-file", str(about)]):
        wait_for(about.exists)
        address = json.loads(about.read_text(encoding="utf-8"))["address"]
        worker = ["distributed.cli.dask_worker", address, "--host", "127.0.0.1", "--nthreads", "1", "--no-dashboard",
                  "--local-directory", str(folder), *options]
        with processes(worker, worker, **more) as workers:
            yield address, workers


@pytest.fixture(scope="module", name="many")
def fixture_many(tmp_path_factory):
    return write_many(tmp_path_factory.mktemp("many"))


@pytest.fixture(scope="module", name="some")
def fixture_some(tmp_path_factory):
    """Source, target, what is expected, what the program has said."""
    folder = tmp_path_factory.mktemp("some")
    return folder / "in", folder / "out", write_some(folder / "in"), batch(folder / "in", folder / "out")


def test_each_kind_of_file_is_encoded_or_says_why_not(some):
    source, target, expected, done = some
    rows = table(target)
    assert done.returncode == 1 and "8 encoded, 2 not" in done.stdout and "1 .txt" in done.stdout
    assert sorted(rows) == sorted(expected)
    for name, what in expected.items():
        row, stream = rows[name], target / (name + ".cqm")
        if isinstance(what, str):
            assert what in row["error"] and row["vertices"] == "" and not stream.exists()
            assert f"{name}: {row['error']}" in done.stderr
        else:
            assert (int(row["vertices"]), int(row["faces"]), row["error"]) == (*what, "")
            assert int(row["bytes"]) == stream.stat().st_size
            assert int(row["file_bytes"]) == (source / name).stat().st_size
            assert float(row["ratio"]) == pytest.approx(int(row["file_bytes"]) / int(row["bytes"]), abs=0.001)
            assert conquest.decode(stream.read_bytes()).complete
    assert {name for name, row in rows.items() if row["set_aside"] not in ("", "0")} == {"twice.off", "cells.vtk"}


def test_what_is_dropped_is_in_the_table_and_on_the_page(some):
    _, target, _, _ = some
    told = {name: row["told"] for name, row in table(target).items() if row["told"]}
    assert told == {"cells.vtk": "changed: faces with more than three corners (1) are cut into triangles",
                    "heat.vtk": "dropped: heat, cells of type line, which a .cqm file does not have",
                    "more.off": "dropped: what follows the last face (line 7)",
                    "scene.glb": "dropped: the image of the texture, which a .cqm file does not have; "
                                 "changed: parts without texture coordinates (1) get some"}
    page = (target / "index.html").read_text(encoding="utf-8")
    assert all(text in page for text in told.values())


def test_the_page_shows_every_file(some):
    _, target, expected, _ = some
    page = (target / "index.html").read_text(encoding="utf-8")
    good = sorted(name for name, what in expected.items() if not isinstance(what, str))
    for pattern, suffix in ((r'<img src="([^"]*)"', ".png"), (r'<a href="([^"]*)"', ".cqm")):
        assert sorted(unquote(unescape(name)) for name in re.findall(pattern, page)) == [name + suffix for name in good]
    assert "ring &amp; &lt;ring&gt;.OFF" in page and "not a PLY file" in page and "<ring>" not in page
    pictures = {(target / (name + ".png")).read_bytes() for name in good}
    assert len(pictures) == len(good) - 1, "the two scenes are alike"
    assert all(picture.startswith(b"\x89PNG") for picture in pictures)


def test_parquet_has_what_csv_has(some):
    source, target, _, _ = some
    batch(source, target, "--table", "parquet")
    rows = pyarrow.parquet.read_table(target / "table.parquet").to_pylist()
    assert len(rows) == 10
    as_text = {row["file"]: {key: "" if value is None else str(value) for key, value in row.items()} for row in rows}
    for name, row in table(target).items():
        assert float(row.pop("ratio") or 0) == float(as_text[name].pop("ratio") or 0)
        assert row == as_text[name]


def test_only_what_changed_is_encoded_again(tmp_path):
    source, target = write_many(tmp_path / "in", 4), tmp_path / "out"
    assert batch(source, target).returncode == 0
    check_all(source, target)
    before = stamps(target)
    assert len(before) == 3 * 4

    def changed(*options):
        assert batch(source, target, *options).returncode == 0
        after = stamps(target)
        names = {path.name.rsplit(".", 1)[0] for path in after if before[path] != after[path]}
        before.update(after)
        return names

    os.utime(source / "of 0/ring_0.off")
    assert changed() == set()
    assert changed("--workers", "1") == set()
    path = source / "of 1/ring_1.obj"
    path.write_bytes(path.read_bytes() + b"# changed\n")
    assert changed() == {"ring_1.obj"}
    (target / "of 2/ring_2.ply.cqm").write_bytes(b"CQ")
    (target / "of 0/ring_3.stl.json").unlink()
    assert changed() == {"ring_2.ply", "ring_3.stl"}
    check_all(source, target)
    assert len(changed("--bits", "14")) == 4


def test_a_file_that_breaks_leaves_no_old_stream_and_is_tried_again(tmp_path):
    source, target = tmp_path / "in", tmp_path / "out"
    source.mkdir()
    ring(20).export(source / "a.off")
    assert batch(source, target).returncode == 0 and (target / "a.off.cqm").exists()
    whole = (source / "a.off").read_bytes()
    (source / "a.off").write_bytes(whole[:1000])
    assert batch(source, target).returncode == 1 and not list(target.glob("a.off*"))
    assert "line" in table(target)["a.off"]["error"]
    (source / "a.off").write_bytes(whole)
    assert batch(source, target).returncode == 0 and (target / "a.off.cqm").exists()


def test_a_worker_that_is_killed_loses_nothing(tmp_path, many):
    target = tmp_path / "out"
    with cluster(tmp_path, "--no-nanny") as (address, workers):
        with processes(["conquest.batch", str(many), str(target), "--scheduler", address]) as (client,):
            wait_for(lambda: len(list(target.rglob("*.json"))) >= 4)
            workers[0].kill()
            workers[0].wait()
            before = stamps(target)
            assert client.wait(timeout=300) == 0
            assert workers[1].poll() is None
    check_all(many, target)
    done = [path for path in before if path.suffix == ".json"]
    assert 4 <= len(done) < MANY, "it was killed in the middle"
    after = stamps(target)
    for record in done:
        for suffix in (".json", ".png", ".cqm"):
            path = record.with_suffix(suffix)
            assert before[path] == after[path], "done once"


def test_a_run_that_is_killed_is_continued(tmp_path, many):
    target, alone = tmp_path / "out", tmp_path / "alone"
    with cluster(tmp_path) as (address, _):
        with processes(["conquest.batch", str(many), str(target), "--scheduler", address]) as (client,):
            wait_for(lambda: len(list(target.rglob("*.json"))) >= 4)
            client.kill()
            client.wait()
        assert not (target / "table.csv").exists()
        before = stamps(target)
        assert batch(many, target, "--scheduler", address).returncode == 0
    check_all(many, target)
    done = [path for path in before if path.suffix == ".json"]
    assert 4 <= len(done) < MANY, "it was killed in the middle"
    after = stamps(target)
    assert all(before[path] == after[path] for path in done)
    assert batch(many, alone).returncode == 0
    streams = list(target.rglob("*.cqm"))
    assert len(streams) == MANY
    for path in streams:
        assert path.read_bytes() == (alone / path.relative_to(target)).read_bytes(), "as on this machine"


def test_a_file_that_kills_workers_is_a_row(tmp_path):
    source, target = tmp_path / "in", tmp_path / "out"
    source.mkdir()
    for k in range(8):
        ring(10 + k).export(source / f"ring_{k}.off")
    ring(10).export(source / "killer.glb")
    done = batch(source, target, "--workers", "2",
                 env=os.environ | {"DASK_DISTRIBUTED__WORKER__PRELOAD": str(HERE / "killer.py")})
    rows = table(target)
    assert done.returncode == 1 and len(rows) == 9
    assert {name for name, row in rows.items() if row["error"]} == {"killer.glb"}
    assert "died" in rows["killer.glb"]["error"]


def test_bad_usage(tmp_path):
    (tmp_path / "empty").mkdir()
    assert batch(tmp_path / "empty", tmp_path / "out").returncode == 2
    assert batch(tmp_path).returncode == 2
    assert batch(tmp_path, tmp_path / "out", "--bits", "25").returncode == 2
    assert not (tmp_path / "out").exists()


# -- Readers --


def test_a_scene_keeps_places_materials_and_texture_coordinates(some):
    arguments = read.read(some[0] / "scene.glb")
    mesh = conquest.decode(conquest.encode(**arguments, bits=16))
    assert sorted(mesh.material_names) == ["ball", "box"]
    of_box = mesh.attributes["materials"] == mesh.material_names.index("box")
    assert of_box.sum() == 12 and not of_box.all()
    corners = mesh.vertices[mesh.faces[of_box].ravel()]
    assert corners.min(axis=0) == pytest.approx([2.5, -0.5, -0.5], abs=1e-3)
    ball = np.setdiff1d(np.unique(mesh.faces[~of_box]), mesh.faces[of_box])
    assert np.abs(mesh.attributes["texcoords"][ball] - mesh.vertices[ball, :2]).max() < 0.01


def test_cells_become_triangles_with_their_groups(tmp_path):
    points = np.random.default_rng(1).random((8, 3))
    meshio.Mesh(points, [("line", [[0, 1]]), ("quad", [[0, 1, 2, 3], [4, 5, 6, 7]]), ("triangle", [[0, 1, 4]])],
                cell_data={"gmsh:physical": [[1], [5, 9], [5]], "gmsh:geometrical": [[1], [5, 9], [5]]},
                field_data={"wall": np.array([5, 2]), "edge": np.array([1, 1])}).write(
                    tmp_path / "a.msh", file_format="gmsh22")
    arguments = read.read(tmp_path / "a.msh")
    assert arguments["faces"].tolist() == [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [0, 1, 4]]
    assert arguments["materials"].tolist() == [0, 0, 1, 1, 0] and arguments["material_names"] == ["wall", "9"]


def test_buffers_of_gltf_count_as_part_of_it(tmp_path):
    for name, data in trimesh.Scene(trimesh.creation.box()).export(file_type="gltf").items():
        (tmp_path / name).write_bytes(data)
    (gltf,) = tmp_path.glob("*.gltf")
    assert read.companions(gltf) == sorted(tmp_path.glob("*.bin")) != []


def test_what_is_in_the_target_is_not_encoded(tmp_path):
    ring(10).export(tmp_path / "a.off")
    (tmp_path / "out").mkdir()
    ring(10).export(tmp_path / "out/b.off")
    assert find_files(tmp_path, tmp_path / "out") == (["a.off"], {})
    assert find_files(tmp_path, tmp_path) == (["a.off", "out/b.off"], {})
