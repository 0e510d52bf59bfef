#!/usr/bin/env python3
"""What is measured, on surfaces whose distances are known.   SPDX-License-Identifier: MIT"""
import unittest

import numpy as np

import surface


def sheet(height, cells=8):
    """A square of side 1."""
    x, y = np.meshgrid(np.linspace(0, 1, cells + 1), np.linspace(0, 1, cells + 1))
    vertices = np.stack([x.ravel(), y.ravel(), np.full(x.size, float(height))], axis=1)
    a = np.array([y * (cells + 1) + x for y in range(cells) for x in range(cells)])
    faces = np.concatenate([np.stack([a, a + 1, a + cells + 2], 1), np.stack([a, a + cells + 2, a + cells + 1], 1)])
    return vertices, faces


class Measures(unittest.TestCase):
    def test_parallel_squares_have_their_distance_everywhere(self):
        rms, hausdorff = surface.distances(sheet(0.25), sheet(0))
        self.assertAlmostEqual(rms, 0.25)
        self.assertAlmostEqual(hausdorff, 0.25)

    def test_a_missing_half_counts_in_the_direction_that_sees_it(self):
        vertices, faces = sheet(0)
        half = vertices, faces[(vertices[faces][:, :, 0] <= 0.5).all(axis=1)]
        for pair in ((half, sheet(0)), (sheet(0), half)):
            rms, hausdorff = surface.distances(*pair)
            self.assertAlmostEqual(rms, (0.5 * 0.5**2 / 3) ** 0.5, places=2)
            self.assertAlmostEqual(hausdorff, 0.5)

    def test_faces_that_are_turned_over_are_counted(self):
        vertices, faces = sheet(0)
        turned = faces.copy()
        turned[[3, 50]] = turned[[3, 50]][:, ::-1]
        self.assertEqual(surface.flipped((vertices, faces), sheet(0.01)), 0)
        self.assertEqual(surface.flipped((vertices, turned), sheet(0.01)), 2)
        self.assertEqual(surface.flipped((vertices * 0, faces), sheet(0.01)), 0)

    def test_a_sheet_is_open_and_a_tetrahedron_closed(self):
        self.assertFalse(surface.is_closed(sheet(0)))
        self.assertTrue(surface.is_closed((np.eye(4, 3), np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))))

    def test_the_diagonal_of_a_square(self):
        self.assertAlmostEqual(surface.diagonal(sheet(7)[0]), 2**0.5)


if __name__ == "__main__":
    unittest.main()
