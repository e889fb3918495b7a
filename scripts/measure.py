"""Measures speed and rewrites the tables in README.md and docs/ that tell it.

Usage: python3 scripts/measure.py [BLOCK ...] [--rounds 8] [--quick] [--core N] [--python VENV/bin/python]
                                  [--built FOLDER [--built-best FOLDER]]
       python3 scripts/measure.py --check | --shorten

Without a block, all of them. A block is the text between <!-- measured: NAME --> and <!-- end: NAME -->. What is compared is
measured in rounds that take turns, on one core, and of each the least time counts, so that a busy machine disturbs all alike; every
participant compares its numbers with the truth before it is timed. --check only verifies that the marks in the documents and the blocks here
are the same, and that each block tells when it was measured, on what and of which one commit. A short table that follows from a long one is
written with it; --shorten writes it again from the long one as it stands. --built takes the programs from a folder as
cargo leaves them, target/release say; each tells the commit that it was built from, which is what is written, and must be of the sources that
are checked out. What has a better build than they (num-dual: one unit, for this processor) never comes from there: cargo builds it here, or
has built it in the folder of --built-best by the command that is told where it is not there. Needs gcc, valgrind and, for the first time, a
network: the peers are installed under target/peers.
"""

import argparse
import datetime
import json
import math
import os
import pathlib
import platform
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import venv

import house
import peer_rules

ROOT = pathlib.Path(__file__).resolve().parent.parent
WORK = ROOT / "target" / "peers"
EXPLANATION = ROOT / "docs" / "explanation"
DOCUMENTS = (
    "README.md",
    *(f"docs/explanation/{page}.md" for page in ("assembly", "audit", "batches-by-hand", "build", "jax-casadi-num-dual", "other-checkers")),
    *(f"docs/explanation/{page}.md" for page in ("other-checkers-tables", "performance", "scale", "scale-tables", "solutions", "stress", "time-against-error")),
    "docs/how-to/sweep.md",
)
OPEN, CLOSE = "<!-- measured: {} -->", "<!-- end: {} -->"
OURS = "pintle"
# For those who keep their states in tiles; and a loop that only reads and writes as many bytes as OURS.
TILES, MOVED = "pintle, tiles", "the same bytes, moved"
# The least speed over each peer that pintle aims at, and with a hundred thousand states, which stay in no cache.
AIMS = {"JAX": (45, 45), "JAX, relative": (8, 8), "CasADi C": (2.8, 1.5), "num-dual": (15, 9), MOVED: (0.77, 0.77)}
WHAT = {
    OURS: "`Batch::rows_of_states`: arrays of states to dense rows, four elements at a time, three relative derivatives",
    TILES: "`Batch::rows_of`: the same from tiles of four states to tiles of four rows",
    MOVED: "sums what is read, and writes one number everywhere, on the same vector unit",
    "num-dual": "`DualSVec<f64, 12>`, a seed for each nodal degree of freedom; one unit of compilation, `target-cpu=native`",
    "CasADi C": "generated C, twelve derivatives, `gcc -O3 -march=native`",
    "JAX": "`jit(vmap(jacfwd))` by twelve degrees of freedom",
    "JAX, relative": "`jacfwd` by three relative ones, maps to twelve by hand",
}


def run(*command, **options):
    return subprocess.run(command, cwd=ROOT, check=True, text=True, stdout=subprocess.PIPE, **options).stdout


# The machine


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor()


def flags():
    known = ("avx2", "fma", "avx512f")
    text = pathlib.Path("/proc/cpuinfo").read_text()
    return "/".join(flag.upper() for flag in known if re.search(rf"\b{flag}\b", text))


def conditions(versions, rounds, loads, of_commit):
    load = f"load {min(loads):.1f} to {max(loads):.1f} on {os.cpu_count()} cores"
    versions = {**versions, "pintle": of_commit}
    named = ", ".join(f"{name} {version}" for name, version in sorted(versions.items(), key=lambda item: item[0].lower()))
    return (
        f"{datetime.date.today():%Y-%m-%d}, {processor()} ({flags()}), one core of {os.cpu_count()}, {load}; "
        f"minima of {rounds} interleaved rounds; {named}."
    )


# What a measurement depends on.
SOURCES = ("Cargo.toml", "Cargo.lock", "build.rs", "src", "benches", "decks", "examples", "scripts", "verify/scale/chain.rs")


def commit(*programs):
    """What is measured: the one commit that all programs were built from, as they tell it themselves; and whether the sources that are checked
    out differ from it, which those of programs that were built before must not."""
    told = {program: told_commit(program) for program in programs}
    if len(set(told.values())) != 1:
        lines = "\n".join(f"  {name}: {program}" for program, name in told.items())
        raise SystemExit(f"the programs were built from more than one commit, or do not tell it:\n{lines}")
    program, name = next(iter(told.items()))
    found = re.fullmatch(r"([0-9a-f]{10,40})(, with changes)?", name)
    if not found:
        raise SystemExit(f"{program} tells no commit: it is older than this script, or no release build of a repository")
    of_commit, has_changes = found.groups()
    differs = differ_from(of_commit)
    if BUILT and (differs or has_changes):
        raise SystemExit(f"{program} was built from {name}, and what is checked out are others, {checked_out()}: build it from them")
    return f"{of_commit} with changes" if differs or has_changes else of_commit


def differ_from(of_commit):
    """Whether the sources that are checked out differ from those of a commit; those of one that git does not know do."""
    return subprocess.run(("git", "diff", "--quiet", of_commit, "--", *SOURCES), cwd=ROOT, stderr=subprocess.DEVNULL).returncode != 0


def checked_out():
    """The commit that is checked out, and whether sources differ from it."""
    name = run("git", "rev-parse", "--short=12", "HEAD").strip()
    return f"{name} with changes" if differ_from(name) else name


def told_commit(program):
    """What a program says of its commit: pintle by --version, all others by --commit."""
    if pathlib.Path(program).name == "pintle":
        found = re.search(r"^commit: (.*)$", run(program, "--version"), re.MULTILINE)
        return found[1] if found else "none"
    return answer(program, "--commit")


def answer(program, question):
    """What a program answers at once; `none` of one that does not know the question."""
    try:
        return run(program, question, timeout=20, stderr=subprocess.DEVNULL).strip()
    except (subprocess.SubprocessError, OSError):
        return "none"


def stamp(of_commit):
    """When, on what and of which commit."""
    return f"{datetime.date.today():%Y-%m-%d}, {processor()} ({flags()}), pintle {of_commit}"


# Programs

# num-dual's functions are compiled with the program that calls them. In one unit they are inlined, as in the best build of a user; in the
# sixteen of the profile they are called, and take three to five times as long. That program is nothing else, and compiled for this processor.
BEST = {"num_dual": ("-C", "codegen-units=1", "-C", "target-cpu=native")}
# With such a build this variable holds its settings, which the program answers to --build.
SETTINGS = "PINTLE_BENCH_BUILD"

# Where programs are taken from instead of being built: --built, and those with a better build --built-best.
BUILT, BUILT_BEST = None, None


def built(folder, name, place):
    """The newest program in a folder of what is built that the pattern of a place finds."""
    found = [path for path in folder.glob(place) if path.is_file() and not path.suffix and os.access(path, os.X_OK)]
    if not found:
        raise SystemExit(f"{folder} has no program {name}: it would be {place}")
    return str(max(found, key=lambda path: path.stat().st_mtime))


def of_best_build(bench, program):
    """The program, which must have the settings that are told of it: with others it looks slower than it is."""
    wanted = " ".join(BEST[bench])
    if answer(program, "--build") == wanted:
        return program
    raise SystemExit(
        f"{program} was not built with {wanted}, and would look slower than it is. It is built here without --built-best; or by\n"
        f"{SETTINGS}='{wanted}' cargo rustc --profile bench --all-features --bench {bench} --target-dir FOLDER -- {wanted}\n"
        "where --built-best FOLDER/release finds it"
    )


def command():
    """Builds pintle; its program."""
    if BUILT:
        return built(BUILT, "pintle", "pintle")
    say("pintle: cargo builds it, where that is still to be done")
    messages = run("cargo", "build", "--release", "--all-features", "--bin", "pintle", "--message-format=json")
    artifacts = [message for message in map(json.loads, messages.splitlines()) if message["reason"] == "compiler-artifact"]
    return next(message["executable"] for message in artifacts if message["executable"])


def executable(bench):
    """Builds a bench; its program. One with a better build is never taken from among the others."""
    place, is_best = f"deps/{bench}-*", bench in BEST
    if is_best:
        return of_best_build(bench, built(BUILT_BEST, bench, place) if BUILT_BEST else compiled(bench, BEST[bench]))
    return built(BUILT, bench, place) if BUILT else compiled(bench)


def compiled(bench, settings=()):
    """The program of a bench as cargo builds it."""
    say(f"{bench}: cargo builds it, where that is still to be done")
    target = ("--profile", "bench", "--all-features", "--bench", bench)
    environment = {**os.environ, SETTINGS: " ".join(settings)} if settings else None
    messages = run("cargo", "rustc", *target, "--message-format=json", "--", *settings, env=environment)
    for message in map(json.loads, messages.splitlines()):
        if message["reason"] == "compiler-artifact" and message["target"]["name"] == bench and message["executable"]:
            return message["executable"]
    raise SystemExit(f"cargo built no program for the bench {bench}")


def rust_version():
    return run("rustc", "--version").split()[1]


def python_of_peers():
    wanted = ROOT / "scripts" / "peers" / "requirements.txt"
    python, installed = WORK / "venv" / "bin" / "python", WORK / "installed.txt"
    text = wanted.read_text() + (ROOT / "scripts" / "requirements.txt").read_text()
    if not installed.exists() or installed.read_text() != text:
        venv.create(WORK / "venv", with_pip=True)
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement", wanted)
        installed.write_text(text)
    return str(python)


def pinned(core):
    return lambda: os.sched_setaffinity(0, {core})


class Peer:
    """A process that answers each line with the times of one round."""

    def __init__(self, command, core):
        self.process = subprocess.Popen(
            command, cwd=ROOT, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE, preexec_fn=pinned(core)
        )
        self.command = command
        self.greeting = self.answer()

    def answer(self):
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"{' '.join(map(str, self.command))}: ended with {self.process.wait()}")
        return json.loads(line)

    def round(self):
        print("round", file=self.process.stdin, flush=True)
        return self.answer()

    def end(self):
        self.process.stdin.close()
        self.process.wait()


# Tables


def table(head, lines):
    return "\n".join(["| " + " | ".join(line) + " |" for line in [head, ["---"] * len(head), *lines]])


def mean(values):
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values))


def peers(arguments):
    """pintle beside what a user would take instead."""
    WORK.mkdir(parents=True, exist_ok=True)
    python = arguments.python or python_of_peers()
    program, num_dual, states = executable("peers"), executable("num_dual"), WORK / "states.json"
    of_commit = commit(program, num_dual)
    run(program, "--export", states)
    folder = ROOT / "scripts" / "peers"
    participants = [
        Peer(command, arguments.core)
        for command in (
            [program, "--serve"],
            [num_dual, "--peers", states],
            [python, folder / "with_casadi.py", states],
            [python, folder / "with_jax.py", states],
        )
    ]
    errors, versions = {}, {"rustc": rust_version(), "num-dual": locked("num-dual")}
    for peer in participants:
        errors |= peer.greeting["errors"]
        versions |= peer.greeting.get("versions", {})
    least, per_round, loads = {}, [], []
    for number in range(arguments.rounds):
        loads.append(os.getloadavg()[0])
        # Each goes first as often as the others.
        shift = number % len(participants)
        times = {}
        for peer in participants[shift:] + participants[:shift]:
            times |= peer.round()
        per_round.append(times)
        for variant, batches in times.items():
            for batch, types in batches.items():
                for name, ns in types.items():
                    key = (variant, batch, name)
                    least[key] = min(least.get(key, math.inf), ns)
        say(f"peers: round {number + 1} of {arguments.rounds}, load {loads[-1]:.1f}")
    for peer in participants:
        peer.end()
    (WORK / "rounds.json").write_text(json.dumps({"rounds": per_round, "errors": errors, "loads": loads}))
    told = conditions(versions, arguments.rounds, loads, of_commit)
    blocks = peer_tables(least, per_round, errors)
    return {"peers": f"{told}\n\n{blocks}", "peers-summary": summary(least, errors, of_commit)}


def locked(crate):
    found = re.search(rf'name = "{crate}"\nversion = "([^"]+)"', (ROOT / "Cargo.lock").read_text())
    return found.group(1) if found else "?"


def ratio(least, variant, batch, names):
    return mean(least[variant, batch, name] / least[OURS, batch, name] for name in names)


def beyond_cache(least, batch, names):
    """How much longer pintle takes at a batch than with a thousand states, whose arrays the second cache holds: what memory costs it."""
    slower = mean(least[OURS, batch, name] / least[OURS, "1000", name] for name in names)
    return f"pintle takes {slower:.2f} times its time with 1 000 states"


def outcome(aim, found, each, rounds, bound):
    """Whether a mean reaches an aim, in how many single rounds it did, and which types by themselves do not."""
    parts = [f"{aim}: reached" if found >= aim else f"{aim}: not reached, {bound}"]
    often = sum(value >= aim for value in rounds)
    if 0 < often < len(rounds) or (often == 0 and found >= aim):
        parts.append(f"in {often} of {len(rounds)} single rounds")
    if below := [name for name, value in each.items() if value < aim]:
        parts.append(f"by themselves below: {', '.join(below)}")
    return "; ".join(parts)


def peer_tables(least, per_round, errors):
    names = list(errors[OURS])
    batches = sorted({batch for _, batch, _ in least}, key=int)
    lines = []
    for variant in WHAT:
        for batch in batches:
            if (variant, batch, names[0]) in least:
                cells = [f"{least[variant, batch, name]:.3g}" for name in names]
                lines.append([variant, f"{int(batch):,}".replace(",", " "), *cells])
    times = table(["ns per state", "batch", *names], lines)
    lines = []
    for own in (OURS, TILES):
        for variant, aims in AIMS.items():
            for batch in batches:
                aim = aims[batch == "100000"]
                if (variant, batch, names[0]) not in least:
                    continue
                each = [least[variant, batch, name] / least[own, batch, name] for name in names]
                found = mean(each)
                rounds = [
                    mean(times[variant][batch][name] / times[own][batch][name] for name in names) for times in per_round
                ]
                lines.append([
                    variant if own == OURS else f"{variant} ÷ {own}",
                    f"{int(batch):,}".replace(",", " "),
                    *(f"{value:.3g}" for value in each),
                    f"**{found:.3g}**",
                    f"{min(rounds):.3g} … {max(rounds):.3g}",
                    outcome(aim, found, dict(zip(names, each)), rounds, beyond_cache(least, batch, names)) if own == OURS else "",
                ])
    ratios = table(["times pintle's", "batch", *names, "geometric mean", "in single rounds", "aim"], lines)
    lines = [[variant, what, *(f"{errors[variant][name]:.0e}" for name in names)] for variant, what in WHAT.items()]
    accuracy = table(["largest error of 1000 states", "what it is", *names], lines)
    return f"{times}\n\n{ratios}\n\n{accuracy}"


def summary(least, errors, of_commit):
    names = list(errors[OURS])
    parts = []
    labels = {
        "JAX": "JAX (`jit(vmap(jacfwd))`)",
        "JAX, relative": "JAX by relative variations",
        "CasADi C": "C generated by CasADi",
        "num-dual": "num-dual with twelve seeds",
    }
    for variant, label in labels.items():
        if variant not in errors:
            continue
        parts.append(f"{ratio(least, variant, '4096', names):.2g} × {label}")
    worst = max(errors[OURS].values())
    return (
        f"Values and Jacobians of 4096 states, from arrays to arrays, geometric means of five types, on one core: the speed of {', '.join(parts)},\n"
        f"to within {worst:.0e} of the largest entry of a row at the thousand states that are timed\n({stamp(of_commit)}; [docs/explanation/performance.md](docs/explanation/performance.md))."
    )


def work_precision(arguments):
    """Time against error: the ways of the bench and JAX on the same states, in rounds that take turns."""
    WORK.mkdir(parents=True, exist_ok=True)
    python = arguments.python or python_of_peers()
    program, num_dual = executable("work_precision"), executable("num_dual")
    of_commit = commit(program, num_dual)
    states, merged = WORK / "precision.json", WORK / "points.json"
    say("work-precision: states and their truth on 237 bits")
    run(program, "--export", states)
    folder = ROOT / "scripts" / "peers"
    participants = [
        Peer(command, arguments.core)
        for command in (
            [program, "--serve"],
            [num_dual, "--precision"],
            [python, folder / "with_casadi_precision.py", states],
            [python, folder / "with_jax_precision.py", states],
        )
    ]
    report, versions = participants[0].greeting, {"num-dual": locked("num-dual")}
    points = [point for peer in participants for point in peer.greeting["points"]]
    untimed = [one for peer in participants for one in peer.greeting["untimed"]]
    for number in range(arguments.rounds):
        shift = number % len(participants)
        times = {peer: peer.round() for peer in participants[shift:] + participants[:shift]}
        together = [time for peer in participants for time in times[peer]]
        for point, time in zip(points, together, strict=True):
            point["nanoseconds"] = time if number == 0 else min(point["nanoseconds"], time)
            point["slowest_round"] = max(point["slowest_round"], time)
        say(f"work-precision: round {number + 1} of {arguments.rounds}, load {os.getloadavg()[0]:.1f}")
    for peer in participants:
        peer.end()
    for peer in participants[1:]:
        versions |= peer.greeting.get("versions", {})
    report |= {"points": points, "untimed": untimed, "rounds": arguments.rounds}
    merged.write_text(json.dumps(report))
    folder = EXPLANATION / "work-precision"
    # Of the folder, figures of types are drawn here alone.
    for figure in folder.glob("*-*.svg"):
        figure.unlink()
    text = run(program, "--draw", merged, folder).rstrip()
    named = ", ".join(f"{name} {version}" for name, version in versions.items())
    return {
        "work-precision": f"{text}\n\nMeasured of commit {of_commit}, beside {named}. JAX: `jit(vmap(…))`, the same states in the same batches; CasADi:"
        " C generated for twelve derivatives, `gcc -O3 -march=native`, one state after the other."
    }


def say(text):
    print(f"{datetime.datetime.now():%H:%M:%S} {text}", file=sys.stderr, flush=True)


def printed(bench, *words, is_pinned=True):
    """What a bench prints, which interleaves and checks by itself; `words` are what it is told.

    It runs on one core, unless it takes all threads.
    """

    def block(arguments):
        say(f"{bench}: built, then run")
        program = executable(bench)
        of_commit = commit(program)
        before = os.getloadavg()[0]
        text = run(program, *words, preexec_fn=pinned(arguments.core) if is_pinned else None).rstrip()
        cores = f"one core of {os.cpu_count()}" if is_pinned else f"{os.cpu_count()} cores"
        load = f"load {before:.1f} to {os.getloadavg()[0]:.1f}"
        machine = f"{datetime.date.today():%Y-%m-%d}, {processor()} ({flags()}), {cores}, {load}"
        return {bench: f"{machine}; rustc {rust_version()}, pintle {of_commit}.\n\n```text\n{text}\n```"}

    return block


def lanes(arguments):
    """The bench of lanes, and what it says in one sentence."""
    told = stamp(commit(executable("lanes")))
    blocks = printed("lanes")(arguments)
    text = blocks["lanes"]
    means = re.findall(r"geometric mean of the speed: (\d+) %", text)
    speeds = [int(speed) for speed in re.findall(r"speed (\d+) %", text)]
    errors = [float(error) for error in re.findall(r"largest errors: lanes (\S+) (\S+)", text) for error in error]
    if not means:
        return blocks | {"lanes-summary": f"The machine lacks the vector unit for which rows are written by hand ({told})."}
    first = speeds[: len(speeds) // len(means)]
    return blocks | {
        "lanes-summary": f"Batches of four connectors reach {means[0]} % of the speed of rows differentiated by hand for the same vector unit"
        f" ({min(first)} to {max(first)} %),\nwith second derivatives {means[1]} %, with errors of at most {max(errors):.1e} of the largest entry"
        f" of a row at the states that are timed there\n({told}; [docs/explanation/performance.md](docs/explanation/performance.md))."
    }


def solutions(arguments):
    """What the problems of references/ take, on doubles and on 237 bits."""
    [doubles] = printed("solutions", is_pinned=False)(arguments).values()
    [wide] = printed("solutions", "wide", is_pinned=False)(arguments).values()
    text = wide.split("```text\n")[1]
    return {"solutions": f"{doubles.removesuffix('```')}\non 237 bits, 25 digits\n{text}"}


def instructions(arguments):
    """What callgrind counts for a tile of four states, of batches and of rows by hand."""
    program = executable("lanes")
    of_commit, lines = commit(program), []
    for name in ("SLIDE-PLANE", "REVOLUTE", "TRANSLATOR", "ROTATION", "CARDAN"):
        say(f"instructions: {name}")
        cells = []
        for order in ("rows", "second"):
            lanes, by_hand = (per_tile(program, who, order, name) for who in ("lanes", "hand"))
            cells += [f"{lanes:.0f}", f"{by_hand:.0f}", f"{100 * by_hand / lanes:.0f} %"]
        lines.append([name, *cells])
    beyond = "ROTATION beyond half a turn"
    say(f"instructions: {beyond}")
    cells = [[f"{per_tile(program, 'lanes', order, beyond):.0f}", "–", "–"] for order in ("rows", "second")]
    lines.append([beyond, *cells[0], *cells[1]])
    head = ["instructions of a tile", "rows", "by hand", "", "second derivatives", "by hand", ""]
    return {"instructions": f"{stamp(of_commit)}, {run('valgrind', '--version').strip()}.\n\n{table(head, lines)}"}


def per_tile(program, who, order, name):
    """Of two runs that differ in how often they go through their tiles, so that all else cancels."""
    found = []
    for count in ("10", "210"):
        command = ("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, "--once", who, order, name, count)
        done = subprocess.run(command, cwd=ROOT, check=True, text=True, capture_output=True)
        found.append((int(re.search(r"Collected : (\d+)", done.stderr)[1]), int(done.stdout)))
    (before, fewer), (after, more) = found
    return (after - before) / (more - fewer)


def audited(program, *arguments):
    """The report of an audit, and the seconds of processor and of time that it took."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    report = json.loads(run(program, "audit", "--format", "json", *arguments))
    spent, elapsed = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter() - start
    return report, sum(getattr(spent, of) - getattr(before, of) for of in ("ru_utime", "ru_stime")), elapsed


def swept(program, *parts):
    """The seconds of time and of processor that sweeps take, all of them at once."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    running = [subprocess.Popen([program, "sweep", "--format", "json", *words], cwd=ROOT, stdout=subprocess.PIPE, text=True) for words in parts]
    told = [process.communicate()[0] for process in running]
    if any(process.returncode for process in running):
        raise SystemExit("a sweep failed")
    spent, elapsed = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter() - start
    return json.loads(told[0]), sum(getattr(spent, of) - getattr(before, of) for of in ("ru_utime", "ru_stime")), elapsed


def sweep(arguments):
    """Sweeps of all types: what a state costs, and how threads and processes divide it."""
    program, cores = command(), os.cpu_count()
    of_commit = commit(program)
    few = "1e5" if arguments.quick else "2e7"
    one = ("--states", few, "--threads", "1")
    with tempfile.TemporaryDirectory() as folder:
        ways = {
            "values, rows and laws, one thread": [(*one, "--oracle-share", "0")],
            "with a thousandth judged, one thread": [one],
            f"the same, {cores} threads": [("--states", few, "--threads", str(cores))],
            f"the same, {cores} processes": [(*one, "--range", f"{i}/{cores}", "--out", folder) for i in range(cores)],
        }
        lines, digests = [], []
        for name, parts in ways.items():
            say(f"sweep: {name}")
            report, spent, elapsed = swept(program, *parts)
            if "--out" in parts[0]:
                report, _, _ = swept(program, ("--merge", folder))
            digests.append(report["digest"])
            lines.append((name, few, spent, elapsed))
    if len(set(digests[1:])) != 1:
        raise SystemExit(f"one sweep, more than one digest: {digests[1:]}")
    alone = lines[1][3] / float(few)

    def cells(name, states, spent, elapsed):
        each = elapsed / float(states)
        ideal = "" if name.endswith("one thread") else f"{100 * alone / cores / each:.0f} %"
        return [name, states, duration(spent), duration(elapsed), f"{each * 1e6:.2f} µs", ideal]

    found = table(["sweep", "states", "processor", "time", "a state", "of ideal speed"], [cells(*line) for line in lines])
    hours = alone / 3600
    return {
        "sweep": f"{stamp(of_commit)}, {cores} cores.\n\n{found}\n\nOn paper 1e9 states take {hours * 1e9:.2f} hours of one core, 1e12 take {hours * 1e12:.0f}; the digest of {few} states is\n`{digests[1]}`."
    }


def proof(arguments):
    """The audit at many states: how many numbers, the largest error, what of the mutants was noticed."""
    program, many = command(), 100 if arguments.quick else 10_000
    of_commit = commit(program)
    states = ("--states", str(many), "--near-singular-states", str(many))
    say(f"proof: pintle audit {' '.join(states)}")
    report, processor_time, elapsed = audited(program, *states)
    checks = [(check, subject["name"]) for subject in report["subjects"] for check in subject["checks"]]
    scores = [check["score"] for check, _ in checks if "oracle" in check["against"]]
    noticed, survived = (sum(score[of] for score in scores) for of in ("killed", "survived"))
    largest, whose = max((check["largest"] or 0, name) for check, name in checks)
    _, short, short_elapsed = audited(program)
    return {
        "proof": f"{stamp(of_commit)}, {os.cpu_count()} cores: with all oracles, {many:,} random and {many:,} near-singular states a type and the gallery with its\n"
        f"frictions {report['compared']:,} numbers, the largest error {largest:.2f} of the tolerance ({whose}), {counted(report['mismatches'], 'mismatch')};\n"
        f"{noticed:,} of {noticed + survived:,} mutants that change enough were noticed. {processor_time:.0f} s of processor, {elapsed:.0f} s of time; at the default number of\n"
        f"states {short:.0f} s of processor, {short_elapsed:.1f} s of time."
    }


def counted(count, what):
    return f"no {what}" if count == 0 else f"{count} {what}{'es' if what.endswith('h') else 's'}" if count > 1 else f"1 {what}"


def of_peer_rules(arguments):
    """What the default rules of other derivative checkers notice: scripts/peer_rules.py measures it."""
    say("peer-rules: mutants under the rules of others")
    program = BUILT and built(BUILT, "peer_rules", "examples/peer_rules")
    # Without --built it is built with the profile of tests, which knows no commit, from what is checked out.
    of_commit = commit(program) if program else checked_out()
    return {peer_rules.BLOCK: f"{stamp(of_commit)}.\n\n{peer_rules.measured(program)}"}


# What b4e184f, one crate, took on such a machine.
BEFORE = {
    "clean clone → first output of `cargo run --release -- eval`": "8 min 40 s",
    "… processor time": "14 min 48 s",
    "… memory of the largest process": "3.5 GB",
    "program": "44 MB",
    "one line changed in a report → the release program is there again": "some 6 min",
    "`bash scripts/test.sh` from a clean clone": "36 min 49 s",
    "lines under `src`": "95,400",
    "files under `src`": "377",
    "import circles of more than three files": "16 (counted otherwise)",
    "folders of more than fifteen files": "8, the largest of 46",
    "pages: % of sentences over 30 words": "36",
    "pages: sentences over 40 words": "131",
    "doc comments: sentences over 40 words": "120",
    "CHANGELOG: words": "6,659",
}


def duration(seconds):
    return f"{seconds:.0f} s" if seconds < 90 else f"{int(seconds) // 60} min {seconds % 60:.0f} s"


def timed(command, folder):
    """Seconds of time and of processor that a command takes until its output ends, and the most memory of one process so far (bytes)."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith("CARGO")}
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, cwd=folder, env=clean, check=True, stdout=subprocess.DEVNULL)
    elapsed, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return elapsed, spent, after.ru_maxrss * 1024


def build(arguments):
    """The house itself: a clean clone built, a line of it changed, all its tests; lines, circles, folders, sentences."""
    of_commit = checked_out()
    with tempfile.TemporaryDirectory() as folder:
        clone = pathlib.Path(folder) / "pintle"
        run("git", "clone", "--quiet", str(ROOT), str(clone))
        say("build: a clean clone")
        run("cargo", "fetch", "--quiet", "--locked", "--manifest-path", str(clone / "Cargo.toml"))
        elapsed, spent, memory = timed(["cargo", "run", "--release", "--quiet", "--locked", "--", "eval"], clone)
        size = (clone / "target/release/pintle").stat().st_size
        say("build: a line changed")
        with (clone / "src/report/words.rs").open("a") as file:
            file.write("// A line.\n")
        changed, _, _ = timed(["cargo", "build", "--release", "--quiet"], clone)
        run("git", "-C", str(clone), "checkout", "--quiet", ".")
        found = {
            "clean clone → first output of `cargo run --release -- eval`": duration(elapsed),
            "… processor time": duration(spent),
            "… memory of the largest process": f"{memory / 1e9:.1f} GB",
            "program": f"{size / 1e6:.1f} MB",
            "one line changed in a report → the release program is there again": duration(changed),
        }
        if not arguments.quick:
            say("build: all tests of the clone")
            shutil.rmtree(clone / "target")
            found["`bash scripts/test.sh` from a clean clone"] = duration(timed(["bash", "scripts/test.sh"], clone)[0])
    found |= {what: f"{number:,}" for what, number, _, _ in house.figures()}
    lines = [[what, before, found.get(what, "not measured")] for what, before in BEFORE.items()]
    return {"build": f"{stamp(of_commit)}, {os.cpu_count()} cores, packages fetched before.\n\n{table(['what', 'before', 'now'], lines)}"}


# Short tables for pages with an answer


def cells(line):
    return [cell.strip() for cell in line.strip("| ").split(" | ")]


def shorter_peers(block):
    """How many times pintle's time each takes, the geometric mean of the types, by the number of states; and its largest error."""
    stamp, *tables = block.strip().split("\n\n")
    times, ratios, errors = ([cells(line) for line in one.splitlines()] for one in tables)
    times = {(name, batch): [float(ns) for ns in found] for name, batch, *found in times[2:]}
    at = ratios[0].index("geometric mean")
    means = {(row[0], row[1]): row[at].strip("*") for row in ratios[2:]}
    batches = sorted({batch for _, batch in times}, key=lambda batch: int(batch.replace(" ", "")))
    for (name, batch), found in times.items():
        means.setdefault((name, batch), f"{mean(ns / of for ns, of in zip(found, times[OURS, batch])):.3g}")
    lines = [[name, *(means.get((name, batch), "–") for batch in batches), max(found, key=float)] for name, _, *found in errors[2:]]
    return f"{stamp}\n\n" + table(["times pintle's", *(f"{batch} states" for batch in batches), "largest error"], lines)


# The blocks of which each short table is a part.
SHORT = {"peers-short": ("peers", shorter_peers), "peer-rules-short": (peer_rules.BLOCK, peer_rules.shorter)}


def shortened(blocks):
    return {name: shorter(blocks[long]) for name, (long, shorter) in SHORT.items() if long in blocks}


# The blocks that each measurement writes.
MEASUREMENTS = {
    peers: ("peers", "peers-summary"),
    work_precision: ("work-precision",),
    printed("single"): ("single",),
    lanes: ("lanes", "lanes-summary"),
    instructions: ("instructions",),
    printed("demand"): ("demand",),
    printed("audit"): ("audit",),
    printed("scale"): ("scale",),
    printed("history", is_pinned=False): ("history",),
    printed("threads", is_pinned=False): ("threads",),
    printed("arrays", is_pinned=False): ("arrays",),
    printed("forms"): ("forms",),
    solutions: ("solutions",),
    printed("stress", "--picture", str(EXPLANATION / "stress.svg")): ("stress",),
    printed("notice", "--picture", str(EXPLANATION / "notice.svg")): ("notice",),
    sweep: ("sweep",),
    proof: ("proof",),
    printed("assembly"): ("assembly",),
    of_peer_rules: (peer_rules.BLOCK,),
    build: ("build",),
}


# Documents


def marks(text):
    return re.findall(r"<!-- measured: (\S+) -->", text), re.findall(r"<!-- end: (\S+) -->", text)


def documents():
    return [*sorted((ROOT / "docs").rglob("*.md")), *sorted(ROOT.glob("*.md"))]


def lack(block):
    """What keeps a block from being a measurement of one commit; nothing of one that is complete."""
    # The environment of a report has the version before the commit.
    commits = re.findall(r"\b(?:pintle|commit) (?:[\d.]+ \()?([0-9a-f]{10,40})\b", block)
    if not re.search(r"\b20\d\d-\d\d-\d\d\b", block):
        return "tells no date"
    if not re.search(r"\b20\d\d-\d\d-\d\d, [^,;\n]+ \([A-Z0-9/-]*\)", block):
        return "tells no machine"
    if not commits:
        return "tells no commit"
    if "with changes" in block:
        return "is of sources that no commit holds"
    if len({name[:10] for name in commits}) > 1:
        return f"tells more than one commit: {', '.join(sorted(set(commits)))}"
    return None


# What is complete, and what is not after such a change: looked at with every --check.
COMPLETE = "2026-01-31, A(R) Processor(TM) @ 2.20GHz (AVX2/FMA), one of 4 cores; pintle 0.1.0 (0123456789ab), rustc 1.2.3. Measured of commit 0123456789."
INCOMPLETE = {
    "no date": ("2026-01-31, ", ""),
    "no machine": ("A(R) Processor(TM) @ 2.20GHz (AVX2/FMA), ", ""),
    "no commit": ("0123456789", "HEAD"),
    "no commit holds": ("9.", "9 with changes."),
    "more than one": ("commit 0123456789", "commit 9876543210"),
}


def blocks(text):
    return {name: text.split(OPEN.format(name), 1)[1].split(CLOSE.format(name), 1)[0] for name in marks(text)[0]}


def check(complete):
    """Whether marks and measurements agree; if `complete`, also whether every block was measured."""
    assert lack(COMPLETE) is None
    assert all(what in (lack(COMPLETE.replace(*change)) or "") for what, change in INCOMPLETE.items())
    known = {name for names in MEASUREMENTS.values() for name in names} | set(SHORT)
    found, wrong, all_ = [], [], {}
    for path in documents():
        opened, closed = marks(path.read_text())
        where = path.relative_to(ROOT)
        if opened != closed:
            wrong.append(f"{where}: the marks {opened} are closed as {closed}")
        if opened and str(where) not in DOCUMENTS:
            wrong.append(f"{where}: holds marks, and is not in DOCUMENTS")
        wrong += [f"{where}: nothing measures {name}" for name in opened if name not in known]
        if complete and opened == closed:
            lacking = {name: lack(block) for name, block in blocks(path.read_text()).items()}
            wrong += [f"{where}: {name} {what}: measure.py {name} measures it" for name, what in lacking.items() if what]
            all_ |= blocks(path.read_text())
        found += opened
    wrong += [f"{name} is in no document" for name in sorted(known - set(found))]
    wrong += [f"{name} is in more than one place" for name in sorted(set(found)) if found.count(name) > 1]
    stale = [name for name, text in shortened(all_).items() if all_.get(name, "").strip() != text]
    wrong += [f"{name} does not follow from {SHORT[name][0]}: measure.py --shorten writes it" for name in stale]
    print("\n".join(wrong) or f"{len(found)} measured blocks, each known")
    return not wrong


def shorten():
    rewrite({name: text for path in documents() for name, text in blocks(path.read_text()).items()}, only=SHORT)


def rewrite(blocks, only=None):
    blocks = {name: text for name, text in (blocks | shortened(blocks)).items() if only is None or name in only}
    for document in DOCUMENTS:
        path = ROOT / document
        text = path.read_text()
        for name in marks(text)[0]:
            if name in blocks:
                begin, end = OPEN.format(name), CLOSE.format(name)
                before, rest = text.split(begin, 1)
                after = rest.split(end, 1)[1]
                text = f"{before}{begin}\n{blocks[name]}\n{end}{after}"
        path.write_text(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    known = [name for names in MEASUREMENTS.values() for name in names]
    parser.add_argument("blocks", nargs="*", metavar="BLOCK", help=", ".join(known))
    parser.add_argument("--rounds", type=int, help="rounds that take turns [default: 8, with --quick 1]")
    parser.add_argument("--quick", action="store_true", help="one round, to see that it works: the numbers mean little")
    parser.add_argument("--core", type=int, default=max(os.sched_getaffinity(0)))
    parser.add_argument("--python", help="an interpreter that has what scripts/peers/requirements.txt names")
    parser.add_argument("--check", action="store_true", help="verify the marks and that each block has a date and a commit; measure nothing")
    parser.add_argument("--built", type=pathlib.Path, metavar="FOLDER", help="take programs from here, as target/release has them")
    parser.add_argument("--shorten", action="store_true", help="write the short tables again from the long ones; measure nothing")
    of_best = f"take {', '.join(BEST)} from here, which has a better build and never comes from --built"
    parser.add_argument("--built-best", type=pathlib.Path, metavar="FOLDER", help=of_best)
    arguments = parser.parse_args()
    global BUILT, BUILT_BEST
    BUILT, BUILT_BEST = (folder and folder.resolve() for folder in (arguments.built, arguments.built_best))
    arguments.rounds = arguments.rounds or (1 if arguments.quick else 8)
    if unknown := set(arguments.blocks) - set(known):
        parser.error(f"no such block: {', '.join(sorted(unknown))}")
    if arguments.shorten:
        return shorten()
    if not check(arguments.check):
        sys.exit(1)
    if not arguments.check:
        for measure, names in MEASUREMENTS.items():
            if not arguments.blocks or set(names) & set(arguments.blocks):
                rewrite(measure(arguments))


if __name__ == "__main__":
    main()
