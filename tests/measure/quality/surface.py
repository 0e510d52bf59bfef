"""Distances between surfaces, and faces that are turned over.   SPDX-License-Identifier: MIT

libigl finds nearest points, exactly; here they are only sampled, with a fixed seed, and added up.
"""
import igl
import numpy as np

SAMPLES = 10000


def read(path):
    """Vertices and triangles of a mesh file."""
    vertices, faces = igl.read_triangle_mesh(str(path))
    return np.asarray(vertices, float), np.asarray(faces, np.int64)


def diagonal(vertices):
    return float(np.linalg.norm(vertices.max(axis=0) - vertices.min(axis=0)))


def normals(mesh):
    """Of all faces, as long as twice their area."""
    vertices, faces = mesh
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def sample(mesh, count):
    """Points that are spread evenly over the surface."""
    vertices, faces = mesh
    random = np.random.default_rng(1)
    area = np.linalg.norm(normals(mesh), axis=1)
    if area.sum() == 0:
        return vertices[faces[random.integers(len(faces), size=count), 0]]
    chosen = faces[random.choice(len(faces), size=count, p=area / area.sum())]
    u, v = random.random((2, count, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = (vertices[chosen[:, k]] for k in range(3))
    return a + u * (b - a) + v * (c - a)


def nearest(points, mesh):
    """Squared distances, and the faces that are nearest."""
    squares, faces = igl.point_mesh_squared_distance(points, *mesh)[:2]
    return np.maximum(squares, 0), faces


def distances(mesh, reference):
    """Symmetric RMS and Hausdorff distance: the larger of both directions."""
    rms, largest = 0, 0
    for one, other in ((mesh, reference), (reference, mesh)):
        of_surface = nearest(sample(one, SAMPLES), other)[0]
        of_vertices = nearest(one[0], other)[0]
        rms = max(rms, of_surface.mean())
        largest = max(largest, of_surface.max(), of_vertices.max())
    return float(np.sqrt(rms)), float(np.sqrt(largest))


def flipped(mesh, reference):
    """Faces that look away from where the reference surface looks, at its centre and towards its corners."""
    own = normals(mesh)
    theirs = normals(reference)
    away = np.flatnonzero(np.linalg.norm(own, axis=1) > 0)
    for weights in ((1, 1, 1), (4, 1, 1), (1, 4, 1), (1, 1, 4)):
        points = np.einsum("k,fkx->fx", np.array(weights) / sum(weights), mesh[0][mesh[1][away]])
        if len(away):
            away = away[np.einsum("fx,fx->f", own[away], theirs[nearest(points, reference)[1]]) < 0]
    return len(away)


def is_closed(mesh):
    edges = np.sort(np.concatenate([mesh[1][:, [0, 1]], mesh[1][:, [1, 2]], mesh[1][:, [2, 0]]]), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 2).all())
