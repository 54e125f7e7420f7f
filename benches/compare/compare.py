"""Runs both programs in turn and prints times and ratios; called by run.sh."""

import json
import math
import os
import subprocess
import sys
import tempfile

DEFAULT = ["torus_1hole", "sphere_a25", "sphere_a50", "sphere_a80", "sphere_n5000", "sphere_n50000"]
PARTS = ["patch", "prediction", "setup", "warm_start", "flow", "soundness"]


def cgal(program, path, continuity, leave):
    command = [program, path, str(continuity), "1"]
    for vertex in leave:
        command += ["--leave", str(vertex)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def meniscus(program, path, folder):
    out, report = os.path.join(folder, "out.obj"), os.path.join(folder, "report.json")
    command = [program, "fill", path, "-o", out, "--report", report, "--quiet"]
    subprocess.run(command, check=True, capture_output=True)
    with open(report) as file:
        return json.load(file)


def least(results, key):
    return min(key(r) for r in results)


def allowed(interior):
    """Share of CGAL's time (continuity 2) that Meniscus may take."""
    return 1.0 if interior < 2_000 else 0.6 if interior <= 20_000 else 0.4


def main():
    program, cgal_fill, models = sys.argv[1:4]
    with open(os.path.join(models, "manifest.json")) as file:
        cases = {case["name"]: case for case in json.load(file)["cases"]}
    totals = {}
    print(
        f"{'hole':<16} {'vertices':>8} {'patch':>7} {'predict':>7} {'setup':>7} {'warm':>7} {'flow':>7} {'sound':>7} {'total':>8} {'steps':>5} |"
        f" {'CGAL v':>7} {'C2':>8} {'C1':>8} {'C2 cpu':>8} | {'ours/C2':>7} {'allowed':>7} {'ours/C1':>7}   (ms)"
    )
    for name in sys.argv[4:] or DEFAULT:
        case = cases[name]
        path = os.path.join(models, case["file"])
        leave = [l["vertices"][0] for l in case["loops"] if not l["fill"]]
        large = sum(l["edges"] for l in case["loops"] if l["fill"]) > 400
        runs = int(os.environ.get("RUNS", "3" if large else "7"))
        ours, c2, c1 = [], [], []
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(runs):
                ours.append(meniscus(program, path, folder))
                c2.append(cgal(cgal_fill, path, 2, leave))
                ours.append(meniscus(program, path, folder))
                c1.append(cgal(cgal_fill, path, 1, leave))
        best = min(ours, key=lambda r: r["totals"]["timings"]["total"])
        times = best["totals"]["timings"]
        added = best["totals"]["vertices_added"]
        steps = max(hole["steps"] for hole in best["holes"])
        t2, t1 = least(c2, lambda r: r["ms_min"]), least(c1, lambda r: r["ms_min"])
        cpu = least(c2, lambda r: r["cpu_ms_min"])
        totals[name] = (added, times["total"])
        print(
            f"{name:<16} {added:>8} "
            + " ".join(f"{times[part]:>7.1f}" for part in PARTS)
            + f" {times['total']:>8.1f} {steps:>5} | {c2[0]['vertices_added']:>7} {t2:>8.1f} {t1:>8.1f} {cpu:>8.1f} |"
            + f" {times['total'] / t2:>7.2f} {allowed(added):>7.1f} {times['total'] / t1:>7.2f}"
            + ("" if times["total"] <= allowed(added) * t2 else "   over"),
            flush=True,
        )
    if "sphere_n5000" in totals and "sphere_n50000" in totals:
        (n, t), (m, u) = totals["sphere_n5000"], totals["sphere_n50000"]
        print(f"growth from sphere_n5000 to sphere_n50000: n^{math.log(u / t) / math.log(m / n):.2f} (allowed 1.25)")


if __name__ == "__main__":
    main()
