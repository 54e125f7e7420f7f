"""Fills holes in graphs of nine functions and measures the errors.

    graphs.py MENISCUS[:OPTION...] ...

Each argument is a program with options of `fill`, separated by colons, as in
`meniscus:--energy:gradH2`. The graphs are over the square from -1 to 1, irregular triangles, 24, 40 and
60 vertices across, with a disc-shaped hole of radius 0.3 to 0.45. Prints for each hole and program the RMS
distance of the new vertices from the graph over the radius, and what filled it; at the end the geometric mean
of the errors of each program. Needs numpy and scipy. Continuous integration does not run this.
"""

import json
import os
import subprocess
import sys
import tempfile

import numpy as np
from scipy.spatial import Delaunay

GRAPHS = {
    "saddle": lambda x, y: x * x - y * y,
    "monkey saddle": lambda x, y: 0.5 * (x**3 - 3 * x * y * y),
    "waves": lambda x, y: 0.2 * np.sin(3 * x) * np.cos(3 * y),
    "bump": lambda x, y: 0.6 * np.exp(-2 * (x * x + y * y)),
    "paraboloid": lambda x, y: 0.5 * (x * x + y * y),
    "cylinder": lambda x, y: np.sqrt(4 - x * x),
    "parabolic cylinder": lambda x, y: 0.4 * x * x,
    "oblique waves": lambda x, y: 0.1 * np.sin(4 * x + 2 * y),
    "cubic": lambda x, y: 0.3 * x**3 + 0.2 * x * y,
}
# vertices across, radius of the hole
SIZES = [(24, 0.3), (40, 0.45), (60, 0.35)]
STEP = 1e-5


def graph(f, across, radius, seed):
    """Vertices and triangles of a graph with a hole."""
    rng = np.random.default_rng(seed)
    x, y = (c.ravel() for c in np.meshgrid(*2 * [np.linspace(-1, 1, across)]))
    edge = 2 / (across - 1)
    inner = np.maximum(abs(x), abs(y)) < 1 - edge / 2
    x[inner] += rng.uniform(-0.25, 0.25, inner.sum()) * edge
    y[inner] += rng.uniform(-0.25, 0.25, inner.sum()) * edge
    faces = Delaunay(np.c_[x, y]).simplices
    a, b, c = (np.c_[x, y][faces[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    faces = np.where((area < 0)[:, None], faces[:, ::-1], faces)[abs(area) > 1e-6]
    centre = rng.uniform(-0.3, 0.3, 2)
    missing = np.hypot(x - centre[0], y - centre[1]) < radius
    faces = faces[~missing[faces].any(1)]
    used, faces = np.unique(faces, return_inverse=True)
    x, y = x[used], y[used]
    return np.c_[x, y, f(x, y)], faces.reshape(-1, 3)


def write(path, points, faces):
    with open(path, "w") as file:
        file.writelines("v %r %r %r\n" % tuple(map(float, p)) for p in points)
        file.writelines("f %d %d %d\n" % tuple(f + 1) for f in faces)


def vertices(path):
    with open(path) as file:
        rows = [line.split()[1:4] for line in file if line.startswith("v ")]
    return np.array(rows, float)


def distances(f, points):
    """Distances from a graph, to first order."""
    x, y, z = points.T
    dx = (f(x + STEP, y) - f(x - STEP, y)) / (2 * STEP)
    dy = (f(x, y + STEP) - f(x, y - STEP)) / (2 * STEP)
    return (z - f(x, y)) / np.sqrt(1 + dx * dx + dy * dy)


def main():
    programs = [argument.split(":") for argument in sys.argv[1:]]
    errors = [[] for _ in programs]
    with tempfile.TemporaryDirectory() as folder:
        given, filled, report = (
            os.path.join(folder, name) for name in ("in.obj", "out.obj", "report.json")
        )
        for name, f in GRAPHS.items():
            for seed, (across, radius) in enumerate(SIZES):
                points, faces = graph(f, across, radius, seed)
                write(given, points, faces)
                row = []
                for (program, *options), of_program in zip(programs, errors):
                    command = [program, "fill", given, "-o", filled, "--report", report, "--quiet"]
                    subprocess.run(command + options, check=True, capture_output=True)
                    new = vertices(filled)[len(points) :]
                    error = np.sqrt(np.mean(distances(f, new) ** 2)) / radius
                    of_program.append(error)
                    with open(report) as file:
                        surface = json.load(file)["holes"][-1]["surface"]
                    expected = surface["expected_error"]
                    words = [surface["surface"], surface.get("energy", ""), str(surface["tension"])]
                    row.append(
                        f"{error:.2e} (expected {expected or float('nan'):.1e}) {' '.join(words)}"
                    )
                print(f"{name:<18} {across:>3}  " + " | ".join(row), flush=True)
    for argument, of_program in zip(sys.argv[1:], errors):
        print(f"{np.exp(np.mean(np.log(of_program))):.2e} {argument}")


if __name__ == "__main__":
    main()
