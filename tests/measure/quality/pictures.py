"""Curves, and contact sheets of shaded meshes.   SPDX-License-Identifier: MIT"""
import os

os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")  # renders without a screen
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import pyvista

CELL = 200     # pixels
GREY, RED = "#c8ccd4", "#e02020"
SAME = 1e-6    # per cent of the diagonal: no distance but rounding


def curves(rows, path):
    """RMS and Hausdorff distance against bytes, and against vertices for what has no bytes."""
    figure, axes = plt.subplots(2, 2, figsize=(13, 9))
    for line, (distance, name) in enumerate((("rms", "RMS"), ("hausdorff", "Hausdorff"))):
        for column, size in enumerate(("bytes", "vertices")):
            panel = axes[line][column]
            for codec in dict.fromkeys(row["codec"] for row in rows):
                points = sorted((row[size], row[distance]) for row in rows
                                if row["codec"] == codec and row[size] and row[distance] > SAME)
                if points and not (codec == "draco" and size == "vertices"):
                    panel.plot(*zip(*points), marker=".", label=codec)
            panel.set(xscale="log", yscale="log", xlabel=size, ylabel=f"{name} distance, % of the diagonal")
            panel.grid(alpha=0.4)
            panel.legend()
    figure.suptitle(rows[0]["mesh"])
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    plt.close(figure)


def sheet(lines, is_closed, path):
    """A line of pictures for each name: [(caption, mesh or None)]. Faces seen from behind are red if there is nothing
    that one could see from behind: if the mesh is closed."""
    columns = max(len(cells) for _, cells in lines)
    plotter = pyvista.Plotter(off_screen=True, shape=(len(lines), columns), border=False,
                              window_size=(CELL * columns, CELL * len(lines)))
    cells = [(line, column, name, cell) for line, (name, row) in enumerate(lines) for column, cell in enumerate(row)]
    for line, column, name, (caption, mesh) in cells:
        plotter.subplot(line, column)
        plotter.set_background("white")
        text = f"{name}: {caption}" if column == 0 else caption
        plotter.add_text(text, font_size=6, color="black", position=(4, CELL - 14))
        if mesh is None:
            continue
        behind = {"color": RED, "lighting": False} if is_closed else None
        plotter.add_mesh(pyvista.PolyData.from_regular_faces(*mesh), color=GREY, backface_params=behind)
    finest = max((cell for cell in cells if cell[3][1]), key=lambda cell: len(cell[3][1][1]))
    plotter.subplot(finest[0], finest[1])
    plotter.view_vector((0.7, 0.4, 1), viewup=(0, 1, 0))
    for line, column, *_ in cells:
        plotter.renderers[plotter.renderers.loc_to_index((line, column))].camera = plotter.camera
    plotter.screenshot(str(path))
    plotter.close()
