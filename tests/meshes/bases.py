#!/usr/bin/env python3
"""What meshes come down to: bases.py CQM FOLDER MESH...

Encodes each mesh. Of those that are spheres, all components of genus 0 and without boundary, each component must have at
most 8 vertices in the base. The last line is `N passed, N failed`, counted by meshes.   SPDX-License-Identifier: MIT"""

import json
import pathlib
import subprocess
import sys

MOST = 8


def run(*arguments):
    return subprocess.run([*map(str, arguments)], check=True, capture_output=True).stdout


def components(path):
    """Numbers of vertices of the components of an OFF file, largest first."""
    words = path.read_text().split()
    vertices, faces = int(words[1]), int(words[2])
    parent = list(range(vertices))

    def find(v):
        while parent[v] != v:
            parent[v] = parent[parent[v]]
            v = parent[v]
        return v

    at = 4 + 3 * vertices
    for corners in (words[k + 1:k + 4] for k in range(at, at + 4 * faces, 4)):
        a, b, c = (find(int(v)) for v in corners)
        parent[b] = parent[c] = a
        parent[find(c)] = parent[find(b)] = a
    count = {}
    for v in range(vertices):
        root = find(v)
        count[root] = count.get(root, 0) + 1
    return sorted(count.values(), reverse=True)


def main():
    cqm, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    passed = failed = others = 0
    for mesh in sys.argv[3:]:
        stream, base = folder / "mesh.cqm", folder / "base.off"
        run(cqm, "encode", "--quiet", "--channels", "positions", mesh, stream)
        report = json.loads(run(cqm, "info", "--json", stream))
        if report["genus"] or report["boundary_loops"]:
            others += 1
            continue
        run(cqm, "decode", "--level", 0, stream, base)
        sizes = components(base)
        assert len(sizes) == report["components"] and sum(sizes) == report["base_vertices"]
        if sizes[0] <= MOST:
            passed += 1
        else:
            failed += 1
            print(f"FAIL  {mesh}: {sum(size > MOST for size in sizes)} of {len(sizes)} components have more than "
                  f"{MOST} vertices in the base, at most {sizes[0]}")
    print(f"{others} meshes are no spheres")
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
