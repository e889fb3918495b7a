"""Runs the problems of solve_problems.py in every program of solve_programs.py and in pintle, and writes the table and the picture of
docs/explanation/solutions.md.

Usage: python scripts/peers/solve_run.py [--pintle target/debug/pintle] [--programs MuJoCo,DART]

The packages are named in solve_programs.py. The set-up of a program must be right without friction before it counts: its error falls with
its step. Errors are those of x at the end; creep is the largest speed in load_reversal, where nothing moves.
"""

import argparse
import json
import math
import platform
import re
import resource
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from solve_problems import BLOCK, END, FREE, REVERSAL, ROOT, block_end, free_at  # noqa: E402
from solve_programs import PROGRAMS  # noqa: E402

STEPS = {"h": [1e-2, 3e-3, 1e-3, 3e-4, 1e-4], "tolerance": [1e-3, 1e-5, 1e-7, 1e-9]}
PAGE = ROOT / "docs" / "explanation" / "solutions.md"
PICTURE = ROOT / "docs" / "explanation" / "work-precision" / "solutions.svg"
# A frictionless set-up is right where its error is below this with the smallest step, and falls.
RIGHT = 1e-3
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#e69f00", "#cc79a7", "#56b4e9", "#8a5a2b", "#6f4bd8", "#1b2027"]


def run(function, steps):
    """Error without friction, with friction, creep, seconds: for each step."""
    rows = []
    for step in steps:
        row = {"step": step}
        for problem, want in ((FREE, free_at(END)), (BLOCK, block_end()), (REVERSAL, 0.0)):
            spent = math.inf
            for _ in range(2):
                begin = time.process_time()
                try:
                    times, x, v = function(problem, step)
                except (ValueError, RuntimeError):
                    times, x, v = [], [math.nan], [math.nan]
                spent = min(spent, time.process_time() - begin)
            is_whole = len(times) > 0 and abs(times[-1] - END) < 1e-9
            row[problem.name] = abs(float(x[-1]) - want) if is_whole else math.nan
            row[problem.name + " seconds"] = spent
            if problem is REVERSAL:
                row["creep"] = float(np.max(np.abs(v))) if is_whole else math.nan
        rows.append(row)
    return rows


def order(rows, name):
    """The slope of the error between the two smallest steps above rounding."""
    kept = [(row["step"], row[name]) for row in rows if 1e-13 < row[name] < 1e-1]
    if len(kept) < 2:
        return math.nan
    (h, e), (k, d) = kept[-2:]
    return math.log(e / d) / math.log(h / k)


def pintle(program):
    """pintle itself, by its digits."""
    rows = []
    for digits in (4, 6, 8, 10, 12, 14):
        row = {"step": digits}
        for name, problem, want in (
            ("free", "block", free_at(END)), ("block", "block", block_end()), ("reversal", "load_reversal", 0.0),
        ):
            deck = (ROOT / "references" / problem / "deck.inp").read_text()
            scene = Path(tempfile.gettempdir()) / f"pintle-{name}.inp"
            scene.write_text(deck.replace("*FRICTION\n0.25", "*FRICTION\n0.") if name == "free" else deck)
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            told = subprocess.run(
                [program, "solve", str(scene), "--digits", str(digits), "--every", "0.05", "--format", "json", "--method", "extrapolation"],
                check=True, capture_output=True, text=True,
            ).stdout
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            row[name + " seconds"] = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            frames = [frame["connectors"]["101"] for frame in json.loads(told)["frames"]]
            row[name] = abs(frames[-1]["CU"][0] - want)
            if name == "reversal":
                row["creep"] = max(abs(frame["CV"][0]) for frame in frames)
        rows.append(row)
    return rows


def panel(left, title, x_name, names, results, y_name):
    """One log-log plot."""
    width, height, top = 330, 300, 40
    points = {
        name: [(max(row[x_name], 1e-4), row[y_name]) for row in rows if row[y_name] == row[y_name]] for name, rows in results.items()
    }
    floor = 1e-16
    xs = [x for all_ in points.values() for x, _ in all_]
    low, high = math.floor(math.log10(min(xs))), math.ceil(math.log10(max(xs)))
    bottom, up = -16, 0

    def at(x, y):
        across = left + (math.log10(x) - low) / (high - low) * width
        return f"{across:.1f},{top + height - (math.log10(max(y, floor)) - bottom) / (up - bottom) * height:.1f}"

    out = [f'<text class="axis" x="{left}" y="{top - 14}">{title}</text>']
    for power in range(low, high + 1):
        x = left + (power - low) / (high - low) * width
        out.append(f'<path class="grid" d="M{x:.1f} {top}V{top + height}"/><text x="{x:.1f}" y="{top + height + 16}" text-anchor="middle">1e{power}</text>')
    for power in range(bottom, up + 1, 4):
        y = top + height - (power - bottom) / (up - bottom) * height
        label = "0" if power == bottom else f"1e{power}"
        out.append(f'<path class="grid" d="M{left} {y:.1f}H{left + width}"/><text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end">{label}</text>')
    out.append(f'<text x="{left + width / 2}" y="{top + height + 34}" text-anchor="middle">CPU time (s)</text>')
    for colour, name in zip(COLOURS, names):
        line = [at(x, y) for x, y in points[name]]
        out.append(f'<polyline fill="none" stroke="{colour}" stroke-width="1.7" points="{" ".join(line)}"/>')
        out += [f'<circle fill="{colour}" r="2.6" cx="{p.split(",")[0]}" cy="{p.split(",")[1]}"/>' for p in line]
    return out


def picture(results):
    names = list(results)
    out = [
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 960 390" role="img">',
        "<title>Error against CPU time: a mass on a spring without friction, and with friction that sticks and slips</title>",
        "<style>svg{font:12px system-ui,sans-serif;fill:#5b6470}.grid{stroke:#e3e6ea}.axis{fill:#1b2027;font-weight:600}</style>",
        '<rect width="960" height="390" fill="#fff"/>',
    ]
    out += panel(60, "error without friction", "free seconds", names, results, "free")
    out += panel(460, "error with friction", "block seconds", names, results, "block")
    for i, (colour, name) in enumerate(zip(COLOURS, names)):
        y = 52 + 20 * i
        out.append(f'<path d="M810 {y - 4}h16" stroke="{colour}" stroke-width="2"/><text x="832" y="{y}">{name}</text>')
    PICTURE.write_text("\n".join([*out, "</svg>"]) + "\n")


def short(x):
    if x != x:
        return "fails"
    return "0" if x == 0 else f"{x:.0e}".replace("e-0", "e-")


def table(results, versions):
    lines = [
        "| program | order without friction | error without | error with friction | speed while stuck | CPU time |",
        "|---|---|---|---|---|---|",
    ]
    for name, rows in results.items():
        best = rows[-1]
        slope_ = order(rows, "free") if name not in ("pintle", "SciPy Radau", "SUNDIALS CVODE") else math.nan
        told = "by digits" if slope_ != slope_ else f"{slope_:.1f}"
        title = f"{name} {versions[name]}".strip()
        lines.append(
            f"| {title} | {told} | {short(best['free'])} | {short(best['block'])} | {short(best['creep'])} | {best['block seconds']:.2g} s |"
        )
    return lines


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--pintle", default=str(ROOT / "target" / "debug" / "pintle"))
    parser.add_argument("--programs", default=",".join(PROGRAMS))
    given = parser.parse_args()
    results, versions = {}, {}
    for name in given.programs.split(","):
        function, package, kind = PROGRAMS[name]
        rows = run(function, STEPS[kind])
        right = [row["free"] for row in rows]
        assert right[-1] < RIGHT and right[-1] <= 0.5 * max(right[:-1]), f"{name}: the set-up without friction is not right: {right}"
        results[name], versions[name] = rows, version(package)
        print(name, versions[name], rows[-1], flush=True)
    results["pintle"] = pintle(given.pintle)
    told = subprocess.run([given.pintle, "--version"], check=True, capture_output=True, text=True).stdout
    versions["pintle"] = "dev build" if "dev" in given.pintle or "debug" in given.pintle else told.split()[1]
    picture(results)
    others = {name: rows[-1] for name, rows in results.items() if name != "pintle"}
    creeps = {name: row["creep"] for name, row in others.items() if row["creep"] == row["creep"]}
    errors = {name: row["block"] for name, row in others.items() if row["block"] == row["block"]}
    least, most = min(errors, key=errors.get), max(errors, key=errors.get)
    summary = (
        f"With friction the errors at the smallest step are {short(errors[least])} ({least}) to {short(errors[most])} ({most}), pintle's is "
        f"{short(results['pintle'][-1]['block'])}. While the mass sticks its speed is {short(min(creeps.values()))} "
        f"({min(creeps, key=creeps.get)}) to {short(max(creeps.values()))} ({max(creeps, key=creeps.get)}); pintle's is "
        f"{short(results['pintle'][-1]['creep'])}, bit for bit ({time.strftime('%Y-%m-%d')}, {platform.machine()}, {platform.python_version()})."
    )
    block = "\n".join(["<!-- table: solve-peers -->", *table(results, versions), "", summary, "<!-- table ends: solve-peers -->"])
    text = PAGE.read_text()
    PAGE.write_text(re.sub(r"<!-- table: solve-peers -->.*?<!-- table ends: solve-peers -->", lambda _: block, text, flags=re.S))


if __name__ == "__main__":
    main()
