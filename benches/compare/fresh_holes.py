"""Riddles the scans whose truth is known with other holes, fills them and measures the errors.

    fresh_holes.py MENISCUS CGAL_FILL MODELS SEEDS [-- OPTIONS OF FILL]

MODELS is the folder of the test models (the one with manifest.json); its `ref` has the scans. SEEDS is
a number: seeds 1 to SEEDS are taken. CGAL_FILL is the program that run.sh compiles. Each scan gets as
many holes as it has in the manifest, if there is room, of 0.8 to 1.2 times their radii: discs, ragged
and long ones, and pairs of discs. At least six rings of known vertices are between two holes.

The error of a new vertex is its distance from the scan over the radius of its hole (RMS distance of
the rim from its mean). Prints the RMS error of each mesh, its ratio to the better of CGAL's two
continuities, the geometric mean of the ratios, how well the expected errors were met, and the
warnings. Needs numpy and scipy. Continuous integration does not run this.
"""

import collections
import heapq
import json
import os
import subprocess
import sys
import tempfile

import numpy as np
from scipy.spatial import cKDTree

APART = 6


def read(path):
    rows = {"v": [], "f": []}
    with open(path) as file:
        for kind, *rest in filter(None, map(str.split, file)):
            if kind in rows:
                rows[kind].append(rest[:3])
    faces = [[int(corner.split("/")[0]) - 1 for corner in face] for face in rows["f"]]
    return np.array(rows["v"], float), np.array(faces)


def write(path, points, faces):
    with open(path, "w") as file:
        file.writelines("v %r %r %r\n" % tuple(map(float, p)) for p in points)
        file.writelines("f %d %d %d\n" % tuple(f + 1) for f in faces)


def boundary(faces):
    """The boundary loops, ordered by their lowest vertex; None if a vertex has two."""
    directed = {(int(f[k]), int(f[k - 2])) for f in faces for k in range(3)}
    following = {}
    for a, b in directed:
        if (b, a) not in directed:
            if b in following:
                return None
            following[b] = a
    loops = []
    while following:
        loop = [min(following)]
        while loop[-1] in following:
            loop.append(following.pop(loop[-1]))
        loops.append(loop[:-1])
    return loops


class Scan:
    def __init__(self, case, folder):
        self.name = case["name"].removesuffix("_riddled")
        self.points, self.faces = read(os.path.join(folder, case["truth"]["file"]))
        self.radii = [loop["radius"] for loop in case["loops"] if loop["has_truth"]]
        self.around = [set() for _ in self.points]
        for a, b, c in self.faces:
            for v, others in ((a, (b, c)), (b, (a, c)), (c, (a, b))):
                self.around[v].update(map(int, others))
        corners = self.points[self.faces]
        self.corners, self.tree = corners, cKDTree(corners.mean(1))

    def rings(self, vertices, count):
        for _ in range(count):
            vertices = vertices.union(*(self.around[v] for v in vertices))
        return vertices

    def within(self, centre, reach):
        """Lengths of the shortest paths along edges."""
        lengths, queue = {centre: 0.0}, [(0.0, centre)]
        while queue:
            length, v = heapq.heappop(queue)
            if length > min(reach, lengths[v]):
                continue
            for w in self.around[v]:
                longer = length + np.linalg.norm(self.points[v] - self.points[w])
                if longer < lengths.get(w, np.inf):
                    lengths[w] = longer
                    heapq.heappush(queue, (longer, w))
        return np.array(list(lengths)), np.array(list(lengths.values()))

    def hole(self, centre, radius, random):
        """The vertices of a hole of some shape that are connected to its centre."""
        near, lengths = self.within(centre, 2.6 * radius)
        from_centre = self.points[near] - self.points[centre]
        shape = random.integers(4)
        if shape == 0:
            inside = lengths < radius
        elif shape == 1:
            inside = lengths < radius * (1 + 0.35 * random.uniform(-1, 1, len(near)))
        elif shape == 2:
            axis = random.normal(size=3)
            along = from_centre @ (axis / np.linalg.norm(axis))
            across = np.maximum((from_centre**2).sum(1) - along**2, 0)
            inside = (lengths < 2 * radius) & (along**2 / 3.6 + 2.2 * across < radius**2)
        else:
            other = random.choice(near[(lengths > 0.8 * radius) & (lengths < 1.3 * radius)])
            apart = np.linalg.norm(self.points[near] - self.points[other], axis=1)
            inside = (lengths < 0.75 * radius) | ((apart < 0.75 * radius) & (lengths < 2.2 * radius))
        inside, found, stack = set(near[inside].tolist()), {centre}, [centre]
        while stack:
            new = (self.around[stack.pop()] & inside) - found
            found |= new
            stack.extend(new)
        return found

    def riddle(self, seed):
        """Points and faces with holes, and the vertices of boundary loops that the scan has itself."""
        random = np.random.default_rng([seed, len(self.points)])
        own = boundary(self.faces)
        border = {v for loop in own for v in loop}
        blocked, gone, count, faces = self.rings(border, APART), set(), 0, self.faces
        for _ in range(400):
            if count == len(self.radii):
                break
            centre = int(random.integers(len(self.points)))
            if centre in blocked:
                continue
            hole = self.hole(centre, self.radii[count] * random.uniform(0.8, 1.2), random)
            if len(hole) < 6 or self.rings(hole, APART) & blocked:
                continue
            left = faces[~np.isin(faces, list(hole)).any(1)]
            loops = boundary(left)
            if loops is None or len(loops) != len(own) + count + 1:
                continue
            faces, gone, count = left, gone | hole, count + 1
            blocked |= self.rings(hole, APART)
        used = np.unique(faces)
        number = np.full(len(self.points), -1)
        number[used] = np.arange(len(used))
        return self.points[used], number[faces], {int(number[v]) for v in border}

    def distances(self, points):
        best = np.full(len(points), np.inf)
        for column in self.tree.query(points, k=48)[1].T:
            best = np.minimum(best, to_triangles(points, *self.corners[column].transpose(1, 0, 2)))
        return best


def to_triangles(p, a, b, c):
    """Distances of points from triangles, row by row."""
    best = np.full(len(p), np.inf)
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    inside = np.ones(len(p), bool)
    for u, v in ((a, b), (b, c), (c, a)):
        edge = v - u
        inside &= (np.cross(edge, p - u) * normal).sum(1) >= 0
        along = ((p - u) * edge).sum(1) / np.maximum((edge**2).sum(1), 1e-300)
        best = np.minimum(best, np.linalg.norm(p - u - np.clip(along, 0, 1)[:, None] * edge, axis=1))
    return np.where(inside, np.abs(((p - a) * normal).sum(1)), best)


def errors(scan, given, border, path):
    """The errors of new vertices, by the hole's number in the order of the loops of the input."""
    points, faces = read(path)
    count = len(given[0])
    assert (points[:count] == given[0]).all(), "given vertices moved"
    loops = [loop for loop in boundary(given[1]) if not border & set(loop)]
    at_rim = {v: k for k, loop in enumerate(loops) for v in loop}
    label, stack = {}, []
    around = collections.defaultdict(set)
    for face in faces[(faces >= count).any(1)].tolist():
        for v in face:
            around[v].update(face)
    for v, k in at_rim.items():
        stack.extend((w, k) for w in around[v] if w >= count)
    while stack:
        v, k = stack.pop()
        if v not in label:
            label[v] = k
            stack.extend((w, k) for w in around[v] if w >= count and w not in label)
    new = sorted(label)
    distances = scan.distances(points[new]) if new else []
    found = [[] for _ in loops]
    for v, distance in zip(new, distances):
        rim = given[0][loops[label[v]]]
        radius = np.sqrt(((rim - rim.mean(0)) ** 2).sum(1).mean())
        found[label[v]].append(distance / radius)
    return found


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def main():
    end = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    meniscus, cgal_fill, models, seeds = sys.argv[1:end]
    with open(os.path.join(models, "manifest.json")) as file:
        cases = [c for c in json.load(file)["cases"] if c["name"].endswith("_riddled")]
    ratios, met, codes, holes = [], [], collections.Counter(), 0
    print(f"{'scan':<16} {'seed':>4} {'holes':>5} {'error':>8} {'CGAL C1':>8} {'C2':>8} {'ratio':>6}")
    for scan in (Scan(case, models) for case in cases):
        for seed in range(1, int(seeds) + 1):
            points, faces, border = scan.riddle(seed)
            with tempfile.TemporaryDirectory() as folder:
                path, out, report = (os.path.join(folder, n) for n in ("in.obj", "out.obj", "r.json"))
                write(path, points, faces)
                command = [meniscus, "fill", path, "-o", out, "--report", report, "--quiet"]
                subprocess.run(command + sys.argv[end + 1 :], check=True, stderr=subprocess.DEVNULL)
                found = errors(scan, (points, faces), border, out)
                with open(report) as file:
                    fills = json.load(file)["holes"]
                others = []
                for continuity in "12":
                    command = [cgal_fill, path, continuity, "1", "-o", out]
                    for v in border:
                        command += ["--leave", str(v)]
                    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
                    others.append(rms(sum(errors(scan, (points, faces), border, out), [])))
            error = rms(sum(found, []))
            ratios.append(error / min(others))
            holes += len(fills)
            codes.update(code for fill in fills for code in fill["warning_codes"])
            if not border:
                for fill in fills:
                    expected = (fill.get("surface") or {}).get("expected_error")
                    new = found[fill["loop"] - 1]
                    met += [rms(new) / expected] if new and expected else []
            print(f"{scan.name:<16} {seed:>4} {len(found):>5} {error:8.4f} {others[0]:8.4f} {others[1]:8.4f} {ratios[-1]:6.2f}", flush=True)
    print(f"geometric mean of the ratios {np.exp(np.mean(np.log(ratios))):.3f}, above 1 in {sum(r > 1 for r in ratios)} of {len(ratios)}")
    met = np.log(met)
    print(f"error over expected error: median {np.exp(np.median(met)):.2f}, within a factor of 3 in {np.mean(abs(met) < np.log(3)):.0%} of {len(met)} holes")
    print(f"warnings of {holes} holes: {dict(codes)}")


if __name__ == "__main__":
    main()
