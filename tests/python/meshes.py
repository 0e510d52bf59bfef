"""Meshes and attributes for the tests, and comparisons of meshes. SPDX-License-Identifier: MIT"""

import numpy as np
from hypothesis import strategies as st


def grid(width, height, closed):
    """Faces of a grid of quadrangles in two triangles each; closed: of a torus."""
    across, down = (width, height) if closed else (width - 1, height - 1)
    x, y = np.meshgrid(np.arange(across), np.arange(down), indexing="ij")

    def at(i, j):
        return (i % width) * height + j % height

    a, b, c, d = (np.ravel(at(x + i, y + j)) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int64)


def torus(width, height):
    """float64 vertices and faces."""
    u, v = np.meshgrid(np.arange(width) * 2 * np.pi / width, np.arange(height) * 2 * np.pi / height, indexing="ij")
    u, v = u.ravel(), v.ravel()
    return np.stack([(2 + np.cos(v)) * np.cos(u), (2 + np.cos(v)) * np.sin(u), np.sin(v)], 1), grid(width, height, True)


@st.composite
def meshes(draw):
    """(vertices, faces): a torus or a disc, in random places or on a smooth surface, numbered at random."""
    width, height = draw(st.integers(3, 12)), draw(st.integers(3, 12))
    faces = grid(width, height, draw(st.booleans()))
    random = np.random.default_rng(draw(st.integers(0, 2 ** 32)))
    vertices = torus(width, height)[0] if draw(st.booleans()) else random.normal(size=(width * height, 3))
    vertices = vertices * 10.0 ** draw(st.integers(-3, 3)) + random.normal(size=3)
    order = random.permutation(len(vertices))
    numbers = np.argsort(order)
    return vertices[order].astype(draw(st.sampled_from([np.float32, np.float64]))), numbers[faces]


@st.composite
def attributes(draw, num_vertices, num_faces):
    """Some attributes of each kind, as arguments of encode."""
    random = np.random.default_rng(draw(st.integers(0, 2 ** 32)))
    everything = {
        "normals": random.normal(size=(num_vertices, 3)),
        "texcoords": random.random((num_vertices, 2)),
        "colors": random.integers(0, 256, (num_vertices, draw(st.sampled_from([3, 4]))), np.uint8),
        "weights": random.random((num_vertices, 4)),
        "joints": random.integers(0, 300, (num_vertices, 4), np.uint16),
        "numbers": random.permutation(num_vertices),
        "groups": random.integers(0, 2 ** 32, num_vertices, np.uint64),
        "materials": random.integers(0, 5, num_faces),
        "generic": random.normal(size=(num_vertices, draw(st.integers(2, 4)))),
    }
    names = draw(st.lists(st.sampled_from(sorted(everything)), max_size=7, unique=True))
    return {name: everything[name] for name in names}


@st.composite
def triangles(draw):
    """(vertices, faces, texcoords, materials): a surface with seams, maybe with faces that are turned over; or a
    heap of faces, some of which are no surface."""
    random = np.random.default_rng(draw(st.integers(0, 2 ** 32)))
    if draw(st.booleans()):
        width, height = draw(st.integers(3, 9)), draw(st.integers(3, 9))
        vertices, faces = torus(width, height)
        texcoords = vertices[:, :2]
        seam = random.permutation(len(vertices))[:draw(st.integers(0, 12))]      # these have another row for some faces
        vertices = np.concatenate([vertices, vertices[seam]])
        texcoords = np.concatenate([texcoords, texcoords[seam] + 5])
        for row, vertex in enumerate(seam, width * height):
            some = random.random(len(faces)) < 0.5
            faces[some] = np.where(faces[some] == vertex, row, faces[some])
        if draw(st.booleans()):
            over = random.random(len(faces)) < 0.2
            faces[over] = faces[over][:, ::-1]
    else:
        count = draw(st.integers(1, 12))
        vertices, texcoords = random.integers(0, 3, (count, 3)), random.integers(0, 2, (count, 2))
        faces = random.integers(0, count, (draw(st.integers(0, 30)), 3))
    return vertices.astype(np.float32), faces, texcoords.astype(np.float32), random.integers(0, 4, len(faces))


def turned(faces):
    """Each face from its smallest vertex on."""
    faces = np.asarray(faces, np.int64)
    first = faces.argmin(axis=1)[:, None]
    return np.take_along_axis(faces, (first + np.arange(3)) % 3, 1)


def same_faces(faces, others):
    """Are these the same faces, in the same order, whatever the corner that each begins at?"""
    return np.array_equal(turned(faces), turned(others))


def step_of(vertices, bits):
    """The distance of the points of a grid that fits the vertices."""
    return np.ptp(vertices, axis=0).max() / (2 ** bits - 1)
