"""Decodes a stream, and draws what its first bytes show. SPDX-License-Identifier: MIT"""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection  # type: ignore[import-untyped, import-not-found, unused-ignore]
from matplotlib.figure import Figure  # type: ignore[import-untyped, import-not-found, unused-ignore]

from ..decoder import Decoder

VERTICES = 3000                # are enough for a picture
STEPS = 500
INCHES, DPI = 2.0, 80          # 160 pixels
VIEW = np.array([[0.8, -0.6, 0.0], [0.3, 0.4, 0.866], [-0.52, -0.693, 0.5]])    # right, up, towards the eye
LIGHT = np.array([-0.3, 0.5, 0.81])


@dataclass(frozen=True)
class Seen:
    vertices: int
    faces: int
    set_aside: int
    png: bytes


def look(stream: bytes) -> Seen:
    """Decodes all of it, which shows that it can be. Raises StreamError."""
    decoder = Decoder()
    more = decoder.feed(stream, STEPS)
    while more and len(decoder.vertices) < VERTICES:
        more = decoder.feed(steps=STEPS)
    vertices, faces = decoder.vertices.copy(), decoder.faces.copy()
    decoder.feed()
    decoder.finish()
    if not len(faces):                                     # nothing is a surface
        vertices, faces = decoder.vertices, decoder.faces
    return Seen(len(decoder.vertices), len(decoder.faces), decoder.faces_aside, draw(vertices, faces))


def draw(vertices: Any, faces: Any) -> bytes:
    """A PNG: the triangles from behind to front, grey by how they face the light."""
    figure = Figure(figsize=(INCHES, INCHES), dpi=DPI)
    axes = figure.add_axes((0, 0, 1, 1), aspect="equal")
    axes.axis("off")
    if vertices.shape[1] == 3 and len(faces):
        centre = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        corners = ((vertices - centre) / (np.ptp(vertices, axis=0).max() or 1) @ VIEW.T)[faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normals, axis=1)
        light = 0.25 + 0.7 * np.abs(normals @ LIGHT) / np.where(length > 0, length, 1)
        order = corners[:, :, 2].mean(axis=1).argsort()
        grey = np.repeat(light[order, None].clip(0, 1), 3, axis=1)
        axes.add_collection(PolyCollection(corners[order, :, :2], facecolors=grey, edgecolors=grey, linewidths=0.3))
        axes.autoscale_view()
    png = io.BytesIO()
    figure.savefig(png, format="png", transparent=True)
    return png.getvalue()
