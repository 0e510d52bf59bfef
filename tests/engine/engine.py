"""examples/engine in an X server without a screen: what it shows, and that it keeps its budgets.
SPDX-License-Identifier: MIT

    engine.py ENGINE CQM MESH DIR

Pictures of three moments are the same whatever arrives in a frame, so what was uploaded in parts is what was uploaded
at once; and they show the mesh that the command line decodes, drawn by another program. The last line is
`N passed, N failed`.
"""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

ENGINE, CQM, MESH, WORK = sys.argv[1], sys.argv[2], sys.argv[3], Path(sys.argv[4])
MOMENTS = [1000, 8000, 10 ** 9]
STEPS = 250
FOCUS, DISTANCE, SIDE, ANGLE = 2, 1.6, -0.4, 0.5        # of the engine's first instance
passed, failed = 0, 0


def check(name, condition):
    global passed, failed
    passed, failed = passed + bool(condition), failed + (not condition)
    if not condition:
        print("FAIL ", name)


def run(name, stream, *options, shots=(), status=0):
    """What the engine prints, and its pictures; the exit status must be as told."""
    files = [WORK / f"{name}-{k}.ppm" for k in range(len(shots))]
    words = [str(word) for moment, file in zip(shots, files) for word in ("--shot", moment, file)]
    done = subprocess.run([ENGINE, *options, *words, str(stream)], capture_output=True, text=True, timeout=120,
                          check=False)
    check(f"{name}: status {done.returncode}, {done.stderr}{done.stdout[-200:]}", done.returncode == status)
    return done.stdout, [np.asarray(Image.open(file)).astype(int) for file in files if file.exists()]


def shown(picture):
    """Where something is drawn."""
    return np.abs(picture - picture[0, 0]).max(axis=2) > 8


def silhouette(stream, moment, shape):
    """Where a mesh of the command line is, seen from the engine's place."""
    off = WORK / "moment.off"
    subprocess.run([CQM, "decode", "--quiet", "--vertices", str(moment), stream, off], check=True)
    counts, *rest = off.read_text().split("\n", 1)[1].split("\n", 1)
    count = int(counts.split()[0])
    numbers = np.array(rest[0].split(), float)
    vertices, faces = numbers[:3 * count].reshape(-1, 3), numbers[3 * count:].reshape(-1, 4)[:, 1:].astype(int)
    return draw(vertices, faces, shape)


def draw(vertices, faces, shape):
    low, high = BOX
    p = (vertices - low) / (high - low).max() * (4095 / 4096) - 0.5       # 12 bits: the grid has 4096 points
    x = np.cos(ANGLE) * p[:, 0] + np.sin(ANGLE) * p[:, 2] + SIDE
    z = np.cos(ANGLE) * p[:, 2] - np.sin(ANGLE) * p[:, 0] - DISTANCE
    height, width = shape
    points = np.stack([(1 + x * FOCUS * height / width / -z) * width / 2, (1 - p[:, 1] * FOCUS / -z) * height / 2], 1)
    picture = Image.new("1", (width, height))
    canvas = ImageDraw.Draw(picture)
    for face in faces:
        canvas.polygon([tuple(points[k]) for k in face], fill=1)
    return np.asarray(picture)


def box_of(path):
    lines = Path(path).read_text().split()
    positions = np.array(lines[4:4 + 3 * int(lines[1])], float).reshape(-1, 3)
    return positions.min(axis=0), positions.max(axis=0)


def instances(output, shot):
    """(faces, error in pixels, level) of each instance in a picture."""
    part = output.split("shot of ")[shot + 1]
    return [(int(f), float(e), int(k)) for f, e, k in
            re.findall(r"instance \d+: .*?(\d+) faces, error ([\d.]+) pixels, level (-?\d+)", part)]


def check_levels(output, shot, whole):
    chosen = instances(output, shot)
    check(f"shot {shot}: five instances", len(chosen) == 5)
    check(f"shot {shot}: what is further away has no more faces", chosen == sorted(chosen, key=lambda c: -c[0]))
    check(f"shot {shot}: an error of a pixel at most, or the finest mesh of now: {chosen}",
          all(error <= 1 or level == -1 for _, error, level in chosen))
    check(f"shot {shot}: several levels at once", len({level for _, _, level in chosen}) > (1 if shot == 0 else 3))
    check(f"shot {shot}: no more faces than there are", chosen[0][0] <= whole)


WORK.mkdir(parents=True, exist_ok=True)
for old in WORK.glob("*.ppm"):
    old.unlink()
BOX = box_of(MESH)
stream = WORK / "mesh.cqm"
subprocess.run([CQM, "encode", "--bits", "12", MESH, stream], check=True)
num_vertices, num_faces = map(int, Path(MESH).read_text().split()[1:3])

# Few steps a frame; as many as a millisecond allows, while the file still comes; single steps.
output, pictures = run("steps", stream, "--steps", str(STEPS), shots=MOMENTS)
_, arriving = run("arriving", stream, "--rate", "200000", shots=MOMENTS)
output_alone, alone = run("alone", stream, "--instances", "1", shots=MOMENTS)
_, single = run("single", stream, "--steps", "1", shots=[150])
_, at_once = run("at_once", stream, shots=[150])

check("three pictures", len(pictures) == len(arriving) == len(alone) == 3)
for k, moment in enumerate(MOMENTS):
    check(f"picture {k}: the same, however it arrives", np.array_equal(pictures[k], arriving[k]))
    check(f"picture {k}: something is there", 0.05 < shown(pictures[k]).mean() < 0.6)
    expected = silhouette(stream, min(moment, num_vertices), alone[k].shape[:2])
    common, either = (shown(alone[k]) & expected).sum(), (shown(alone[k]) | expected).sum()
    check(f"picture {k}: shows the decoded mesh, {common / either:.4f} of it", common / either > 0.985)
    check_levels(output, k, num_faces)
check("the pictures differ", all((shown(a) != shown(b)).any() for a, b in zip(pictures, pictures[1:])))
check("single steps show what many do", len(single) == 1 and np.array_equal(single[0], at_once[0]))

# A level that was kept is the mesh of the moment when it was complete. Two faces for each vertex: this mesh is closed.
faces, _, level = instances(output_alone, 2)[0]
check(f"the near instance is drawn from a level: {level}", level >= 0 and num_faces == 2 * num_vertices - 4)
_, then = run("then", stream, "--instances", "1", shots=[faces // 2 + 2])
light_then, light = then[0] / [1, 0.8, 0.7], alone[2] / [0.7, 0.8, 1]          # without the tints of the two
inside = shown(then[0])
check("a kept level stays as it was",
      (shown(alone[2]) == inside).all() and np.abs(light_then - light)[inside].max() < 4)

told = [int(n) for n in re.findall(r"shot of (\d+) vertices", output)]
check(f"the moments are those asked for: {told}", told == MOMENTS[:2] + [num_vertices])
most = int(re.search(r"steps of a frame: most (\d+)", output)[1])
check(f"no frame takes more steps than it may: {most}", most == STEPS)
frames = int(re.search(r"refining and uploading: (\d+)", output)[1])
check(f"nor fewer frames than that takes: {frames}", frames * STEPS >= num_vertices)
mean = int(re.search(r"uploaded in a frame that refines: mean (\d+)", output)[1])
check(f"a step uploads a vertex and about eight blocks: {mean}", mean < STEPS * (12 + 10 * 64 * 12) / 2)
check("times are printed", len(re.findall(r"median [\d.]+, 99 % [\d.]+, worst [\d.]+", output)) == 2)

# Streams that end too early or are damaged.
data = stream.read_bytes()
part = WORK / "part.cqm"
part.write_bytes(data[:len(data) // 2])
output, pictures = run("cut", part, shots=[10 ** 9])
check(f"a stream that is cut is drawn as far as it goes: {output[-60:]}",
      len(pictures) == 1 and shown(pictures[0]).any() and re.search(rf": \d+ of {num_vertices} vertices\n$", output))
part.write_bytes(data[:len(data) // 2] + bytes([data[len(data) // 2] ^ 1]) + data[len(data) // 2 + 1:])
run("damaged", part, shots=[10 ** 9], status=1)
part.write_bytes(b"OFF\n")
run("other", part, shots=[1], status=1)
run("missing", WORK / "no_such_file", shots=[1], status=1)
run("usage", stream, "--steps", "0", status=2)
print(f"{passed} passed, {failed} failed")
sys.exit(failed > 0 or passed == 0)
