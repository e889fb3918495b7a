"""Would the tests notice if the code were wrong? The mutants of `cargo mutants`, all compiled into one program.

`cargo mutants` compiles the crate once for each mutant; here that would take days. This script takes its list of mutants,
writes every one of them into a copy of the sources behind a switch, `match mutated::among(k, k) { k => mutant, _ => original }`,
compiles that once, and records which of them each test reaches. Then, for each k, the tests that reach it are run, the short
ones first, until one fails. What does not compile is left out and counted. A mutant that every test passes has survived: each
must be explained in `verify/mutants.toml`.

    pip install -r scripts/requirements-mutants.txt && cargo install cargo-mutants
    python scripts/mutants.py build 'src/kinematics/measure.rs' 'src/kinematics/so3.rs' 'src/model/behavior/**/*.rs'
    python scripts/mutants.py run --jobs 4
    python scripts/mutants.py report        # fails on a survivor without an explanation, or an explanation without survivor

A mutant that is explained need not meet the tests that take longest (`--explained`). What noticed a mutant before the last build
is tried first after it.
"""

import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
HOME = pathlib.Path(os.environ.get("PINTLE_MUTANTS", ROOT / "target" / "mutants"))
TREE, LIST, TESTS, RESULTS = HOME / "tree", HOME / "mutants.json", HOME / "tests.json", HOME / "results.jsonl"
FORMER = HOME / "former.json"
EXPLAINED = ROOT / "verify" / "mutants.toml"
# The crate that every other one uses.
LOWEST = "kinematics"

SWITCH = """//! Which mutant is on: the number in `PINTLE_MUTANT`, none if it is absent. If `PINTLE_REACHED` names a file, the numbers of the
//! mutants whose place is reached are added to it instead, each at most once.
use std::io::Write;
use std::sync::atomic::{AtomicU32, Ordering};
const UNREAD: u32 = u32::MAX;
const RECORDED: u32 = u32::MAX - 1;
static ACTIVE: AtomicU32 = AtomicU32::new(UNREAD);
static REACHED: [AtomicU32; 1 << 10] = [const { AtomicU32::new(0) }; 1 << 10];
#[cold]
#[inline(never)]
fn seldom(active: u32, first: u32, last: u32) -> u32 {
    if active == RECORDED {
        for k in first..=last {
            let (word, bit) = (&REACHED[k as usize / 32], 1 << (k % 32));
            if word.load(Ordering::Relaxed) & bit == 0 && word.fetch_or(bit, Ordering::Relaxed) & bit == 0 {
                let path = std::env::var_os("PINTLE_REACHED").unwrap();
                let mut file = std::fs::OpenOptions::new().append(true).create(true).open(path).unwrap();
                file.write_all(format!("{k}\\n").as_bytes()).unwrap();
            }
        }
        return 0;
    }
    let told = std::env::var("PINTLE_MUTANT").ok().and_then(|k| k.parse().ok()).unwrap_or(0);
    ACTIVE.store(if std::env::var_os("PINTLE_REACHED").is_some() { RECORDED } else { told }, Ordering::Relaxed);
    among(first, last)
}
/// The mutant that is on, if it is one from `first` to `last`; else 0.
#[inline]
pub fn among(first: u32, last: u32) -> u32 {
    let active = ACTIVE.load(Ordering::Relaxed);
    if active >= RECORDED { seldom(active, first, last) } else if first <= active && active <= last { active } else { 0 }
}
/// Whether mutant `k` is on.
#[inline]
pub fn on(k: u32) -> bool {
    among(k, k) == k
}
"""

# Tests that reach a mutant are run in groups, the short ones first: those of up to so many seconds.
GROUPS = [0.03, 0.1, 0.3, 1.0, 3.0, 10.0, float("inf")]

# Tests that compile other programs: without the switches (`cargo`), or of text that other tests compare byte by byte (C, Fortran).
ELSEWHERE = ["commands::export::", "commands::handover::"]

# What a test may need of memory at most: a mutant may ask for any amount.
MEMORY = 6 << 30

COMPARISONS = {"==", "!=", "<", ">", "<=", ">="}


class Site:
    """A place in a file and the mutants of it that are still believed to compile."""

    def __init__(self, genre):
        self.genre, self.mutants = genre, []


def identify(mutants):
    """Numbers that do not depend on line numbers as long as the function does not change: the order in the list from 1."""
    for k, mutant in enumerate(mutants, 1):
        mutant["k"] = k
    return mutants


def crate(file):
    """The crate of a file: its folder under `src`."""
    return pathlib.PurePath(file).parts[1]


def switches(file):
    """How a file calls the module of the switches, which stands in the lowest crate."""
    return b"crate::mutated" if crate(file) == LOWEST else b"pintle_%s::mutated" % LOWEST.encode()


def key(mutant):
    """How `verify/mutants.toml` names a mutant: file, function and change, without line numbers."""
    return re.sub(r"^([^:]+):\d+:\d+: ", r"\1: ", mutant["name"])


def numbered(mutants):
    """{k: the mutant's key and which one of that key it is}: the same after changes elsewhere in the file."""
    count, found = collections.Counter(), {}
    for mutant in sorted(mutants, key=lambda m: m["k"]):
        count[key(mutant)] += 1
        found[mutant["k"]] = f"{key(mutant)} #{count[key(mutant)]}"
    return found


def remember():
    """Keeps which test noticed which mutant, for the next build."""
    if not (RESULTS.exists() and LIST.exists()):
        return
    former = json.loads(FORMER.read_text()) if FORMER.exists() else {}
    named = numbered(json.loads(LIST.read_text()))
    former |= {named[k]: line["caught"] for k, line in results().items() if line["caught"] and "::" in line["caught"]}
    FORMER.write_text(json.dumps(former, indent=0))


def constants(files):
    """The constants whose value has mutants, {crate: {name: path of its module}}: each becomes a function too, which what is no constant of
    the crate calls."""
    found = collections.defaultdict(dict)
    for file, mutants in files.items():
        source = (ROOT / file).read_bytes()
        lines = {m["span"]["start"]["line"] - 1 for m in mutants if m["genre"] in ("UnaryOperator", "BinaryOperator")}
        parts = pathlib.PurePath(file).with_suffix("").parts[2:]
        module = "::".join(("crate", *(part for part in parts if part not in ("mod", "lib"))))
        nodes = [syntax(source)]
        while nodes:
            node = nodes.pop()
            nodes += node.named_children
            value = node.child_by_field_name("value") if node.type == "const_item" else None
            if value and lines & set(range(value.start_point.row, value.end_point.row + 1)):
                path = module + "::" if node.parent.type == "source_file" else ""
                found[crate(file)][node.child_by_field_name("name").text] = path.encode()
    return found


def syntax(source):
    """The root of the syntax tree of a file."""
    import tree_sitter
    import tree_sitter_rust

    return tree_sitter.Parser(tree_sitter.Language(tree_sitter_rust.language())).parse(source).root_node


def render(source, mutants, dropped, called, mutated):
    """The text of a file with its mutants behind switches, for each line of it the mutants that stand there, and all of them.

    The constants `called` are read through their functions; `mutated` is the module of the switches.
    """
    lines = source.split(b"\n")

    def byte(position):
        line = lines[position["line"] - 1].decode()
        return (position["line"] - 1, len(line[: position["column"] - 1].encode()))

    sites = collections.defaultdict(lambda: None)
    for mutant in mutants:
        if mutant["k"] in dropped:
            continue
        place = byte(mutant["span"]["start"])
        site = sites[place, mutant["genre"]]
        if site is None:
            site = sites[place, mutant["genre"]] = Site(mutant["genre"])
        site.mutants.append(mutant)
    used = set()

    def take(genre, node):
        site = sites[(node.start_point.row, node.start_point.column), genre]
        if site:
            used.update(m["k"] for m in site.mutants)
            return site.mutants
        return []

    def text(node):
        """The node, its children rendered."""
        result, at = b"", node.start_byte
        for child in node.children:
            result += source[at : child.start_byte] + walk(child)
            at = child.end_byte
        return result + source[at : node.end_byte]

    def choice(alternatives, original):
        arms = b"".join(b"\n/*%d*/ %d => { %s }" % (k, k, alternative) for k, alternative in alternatives)
        return b"match %s::among(%d, %d) {%s\n_ => { %s } }" % (
            mutated, alternatives[0][0], alternatives[-1][0], arms, original,
        )

    def walk(node):
        kind = node.type
        if kind == "binary_expression":
            operator = node.child_by_field_name("operator")
            found = take("BinaryOperator", operator)
            if found:
                left, right = walk(node.child_by_field_name("left")), walk(node.child_by_field_name("right"))
                op = operator.text
                if op in (b"&&", b"||"):
                    k = found[0]["k"]
                    stop = b"%s::on(%d)" % (mutated, k) if op == b"&&" else b"!%s::on(%d)" % (mutated, k)
                    return b"({\n/*%d*/ let l__ = %s; if l__ == %s { l__ } else { %s } })" % (k, left, stop, right)
                by = b"&" if op.decode() in COMPARISONS else b""
                alternatives = [(m["k"], b"l__ %s r__" % m["replacement"].encode()) for m in found]
                return b"({ let (l__, r__) = (%s(%s), %s(%s)); %s })" % (
                    by, left, by, right, choice(alternatives, b"l__ %s r__" % op),
                )
        if kind == "compound_assignment_expr":
            operator = node.child_by_field_name("operator")
            found = take("BinaryOperator", operator)
            if found:
                left, right = node.child_by_field_name("left").text, walk(node.child_by_field_name("right"))
                alternatives = [(m["k"], b"%s %s r__" % (left, m["replacement"].encode())) for m in found]
                return b"{ let r__ = %s; %s }" % (right, choice(alternatives, b"%s %s r__" % (left, operator.text)))
        if kind == "unary_expression":
            found = take("UnaryOperator", node)
            if found:
                operand = walk(node.children[1])
                return b"({ let x__ = %s; %s })" % (
                    operand, choice([(found[0]["k"], b"x__")], node.children[0].text + b"x__"),
                )
        if kind == "match_arm":
            found = take("MatchArm", node)
            if found:
                k = found[0]["k"]
                pattern, value = node.child_by_field_name("pattern"), node.child_by_field_name("value")
                condition = pattern.child_by_field_name("condition")
                head = source[pattern.start_byte : condition.start_byte if condition else pattern.end_byte]
                guard = b"\n/*%d*/ !%s::on(%d)" % (k, mutated, k)
                if condition:
                    return head + guard + b" && (" + guarded(condition) + b") => " + walk(value) + b","
                return head + b" if" + guard + b" => " + walk(value) + b","
        if kind == "match_pattern" and node.child_by_field_name("condition"):
            condition = node.child_by_field_name("condition")
            return source[node.start_byte : condition.start_byte] + guarded(condition)
        if kind == "const_item" and (name := node.child_by_field_name("name")).text in called:
            value = node.child_by_field_name("value")
            body = walk(value)
            return node.text + b"\npub(crate) fn %s__() -> %s { %s }" % (
                name.text.lower(), node.child_by_field_name("type").text, body,
            )
        if kind in ("const_item", "use_declaration", "array_type", "line_comment", "block_comment"):
            return node.text
        if kind == "identifier" and node.text in called:
            return b"%s%s__()" % (called[node.text], node.text.lower())
        if kind == "struct_expression":
            body = node.child_by_field_name("body")
            base = [child for child in body.children if child.type == "base_field_initializer"]
            fields = [(child, take("StructField", child)) for child in body.children if base]
            if any(found for _, found in fields):
                result = b"{ let base__: %s = %s; %s {" % (
                    node.child_by_field_name("name").text, walk(base[0].named_children[0]), node.child_by_field_name("name").text,
                )
                for child, found in fields:
                    if child.type == "shorthand_field_initializer":
                        name, value = child.text, child.text
                    elif child.type == "field_initializer":
                        name, value = child.child_by_field_name("field").text, walk(child.child_by_field_name("value"))
                    else:
                        continue
                    if found:
                        value = choice([(found[0]["k"], b"base__." + name)], value)
                    result += b"%s: %s, " % (name, value)
                return result + b"..base__ } }"
        if kind == "function_item" and node.child_by_field_name("body"):
            body = node.child_by_field_name("body")
            found = next(filter(None, (take("FnValue", child) for child in body.named_children)), [])
            result = source[node.start_byte : body.start_byte] + b"{"
            returned = node.child_by_field_name("return_type")
            if found and returned and returned.text.startswith(b"impl "):
                alternatives = [(m["k"], b"Box::new(%s)" % m["replacement"].encode()) for m in found]
                return result + b"let b__: Box<dyn %s> = %s; b__ }" % (
                    returned.text[5:], choice(alternatives, b"Box::new(" + text(body) + b")"),
                )
            for m in found:
                result += b"\n/*%d*/ if %s::on(%d) { return %s; }\n" % (
                    m["k"], mutated, m["k"], m["replacement"].encode(),
                )
            return result + text(body)[1:]
        return text(node)

    def guarded(condition):
        found = take("MatchArmGuard", condition)
        result = walk(condition)
        for m in found:
            result = (
                b"\n/*%d*/ (%s::on(%d) || (%s))\n" if m["replacement"] == "true"
                else b"\n/*%d*/ (!%s::on(%d) && (%s))\n"
            ) % (m["k"], mutated, m["k"], result)
        return result

    rendered = walk(syntax(source))
    places = collections.defaultdict(list)
    for number, line in enumerate(rendered.split(b"\n"), 1):
        for k in re.findall(rb"/\*(\d+)\*/", line):
            places[number].append(int(k))
    return rendered, places, used


def build(patterns):
    """Writes the tree and compiles it, leaving out what does not compile."""
    listing = ["cargo", "mutants", "--workspace", "--list", "--json"]
    for pattern in patterns:
        listing += ["--file", pattern]
    mutants = identify(json.loads(subprocess.check_output(listing, cwd=ROOT)))
    for mutant in mutants:
        del mutant["diff"]
        mutant["line"] = (ROOT / mutant["file"]).read_text().split("\n")[mutant["span"]["start"]["line"] - 1].strip()
    shutil.rmtree(TREE, ignore_errors=True)
    for name in subprocess.check_output(["git", "ls-files"], cwd=ROOT, text=True).split("\n"):
        if name:
            (TREE / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, TREE / name)
    (TREE / "src" / LOWEST / "mutated.rs").write_text(SWITCH)
    library = TREE / "src" / LOWEST / "lib.rs"
    with library.open("a") as text:
        text.write("#[doc(hidden)]\npub mod mutated;\n")
    files = collections.defaultdict(list)
    for mutant in mutants:
        files[mutant["file"]].append(mutant)
    genres = {mutant["k"]: mutant["genre"] for mutant in mutants}
    constant, dropped, changed, called = set(), {}, dict.fromkeys(files), constants(files)
    while True:
        places, used = {}, set()
        for file, its in files.items():
            source = (ROOT / file).read_bytes()
            if changed[file] is None:
                changed[file] = strip(source, constant)
            rendered, places[file], here = render(changed[file], its, dropped, called[crate(file)], switches(file))
            used |= here
            if (TREE / file).read_bytes() != rendered:
                (TREE / file).write_bytes(rendered)
        bad = errors()
        if bad is None:
            break
        before = len(dropped) + len(constant)
        for file, line, message in bad:
            names = re.findall(r"`(?:[\w:<>, ]*::)?(\w+)(?:::<[\w, ]*>)?`", message)
            is_constant = file not in files or "in constants" in message and not {"among", "on"} & set(names)
            if "non-const" in message and is_constant:
                constant.update(names)
                changed = dict.fromkeys(files)
                continue
            for k in blamed(places.get(file, {}), line, message, genres):
                dropped.setdefault(k, message)
        if len(dropped) + len(constant) == before:
            sys.exit("cannot tell which mutant does not compile:\n" + "\n".join(map(str, bad[:20])))
        print(f"{len(dropped)} of {len(mutants)} left out so far", flush=True)
    for mutant in mutants:
        if mutant["k"] in dropped:
            mutant["left_out"] = dropped[mutant["k"]]
        elif mutant["k"] not in used:
            mutant["left_out"] = "no place found for it"
    remember()
    LIST.write_text(json.dumps(mutants, indent=1))
    for stale in (RESULTS, TESTS):
        stale.unlink(missing_ok=True)
    compiled = subprocess.run(
        ["cargo", "test", "--workspace", "--all-features", "--no-run", "--lib", "--test", "verify", "--message-format=json"],
        cwd=TREE, stdout=subprocess.PIPE, check=True, text=True,
    )
    programs = [
        artifact["executable"]
        for artifact in map(json.loads, compiled.stdout.splitlines())
        if artifact.get("executable") and artifact.get("profile", {}).get("test")
    ]
    (HOME / "programs.json").write_text(json.dumps(programs))
    left = sum("left_out" in m for m in mutants)
    print(f"{len(mutants)} mutants, {left} left out (they do not compile); programs: {programs}")


def blamed(places, line, message, genres):
    """The mutants that an error at a line is laid to: those of the line; the arms of a match; else the nearest above."""
    if "non-exhaustive" in message:
        arms = [k for n in range(line, line + 80) for k in places.get(n, []) if genres[k] == "MatchArm"]
        return arms[:1] or [
            k for n in range(line, line + 40) for k in places.get(n, []) if genres[k] == "MatchArmGuard"
        ][:2]
    for n in (line, line - 1, line + 1, line - 2, line - 3, line - 4):
        if places.get(n):
            return places[n]
    return []


def strip(source, constant):
    """`const fn` becomes `fn`, but for those that constants call."""
    return re.sub(
        rb"\bconst fn (\w+)", lambda m: m[0] if m[1].decode() in constant else b"fn " + m[1], source
    )


def errors():
    """The errors of the compiler, each with its places, or None."""
    checked = subprocess.run(
        ["cargo", "check", "--workspace", "--all-features", "--lib", "--message-format=json"], cwd=TREE, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True,
    )
    if checked.returncode == 0:
        return None
    found = []
    for line in checked.stdout.splitlines():
        message = json.loads(line).get("message")
        if isinstance(message, dict) and message["level"] == "error":
            for span in message["spans"]:
                if span["is_primary"]:
                    found.append((span["file_name"], span["line_start"], message["message"]))
    return found


def test(k, program, names, timeout):
    """The name of the first of these tests that fails with mutant k on, `timeout`, `crash`, or None."""
    if not names:
        return None
    environment = dict(os.environ, PINTLE_MUTANT=str(k), INSTA_UPDATE="no", RUST_BACKTRACE="0")
    start = time.monotonic()
    process = subprocess.Popen(
        [program, "--exact", *names, "--test-threads=1"], cwd=TREE, env=environment, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True, process_group=0,
    )
    timer = threading.Timer(timeout, lambda: stop(process))
    timer.start()
    caught, ended = None, False
    for line in process.stdout:
        if line.rstrip().endswith("... FAILED"):
            caught = line.split()[1]
            break
        ended |= line.startswith("test result: ok")
    stop(process)
    timer.cancel()
    process.wait()
    if caught or ended:
        return caught
    return "timeout" if time.monotonic() - start >= timeout else "crash"


def reach(programs, jobs, without):
    """What every test takes without a mutant, and which mutants it reaches: {program: {test: {seconds, reached}}}.

    Each test runs in a process of its own, so that what is computed once for all tests is reached by each.
    """
    found = json.loads(TESTS.read_text()) if TESTS.exists() else {}

    def trace(program, name):
        with tempfile.TemporaryDirectory() as folder:
            record = pathlib.Path(folder, "reached")
            start = time.monotonic()
            ended = subprocess.run(
                [program, "--exact", name], cwd=TREE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                env=dict(os.environ, PINTLE_REACHED=str(record), INSTA_UPDATE="no"),
            )
            took = time.monotonic() - start
            reached = sorted(set(map(int, record.read_text().split()))) if record.exists() else []
        return program, name, ended.returncode, {"seconds": took, "reached": reached}

    open_ones = []
    for program in programs:
        listed = subprocess.check_output([program, "--list"], cwd=TREE, text=True).splitlines()
        names = [line.removesuffix(": test") for line in listed if line.endswith(": test")]
        open_ones += [
            (program, name) for name in names
            if name not in found.setdefault(program, {}) and not name.startswith((*ELSEWHERE, *without))
        ]
    failed = []
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for program, name, code, result in pool.map(lambda it: trace(*it), open_ones):
            if code:
                failed.append(name)
            else:
                found[program][name] = result
    TESTS.write_text(json.dumps(found))
    if failed:
        sys.exit("these tests fail without any mutant: " + " ".join(failed))
    return found


def stop(process):
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


def entry_of(mutant, explained):
    """The place in the committed list of the entry that explains a mutant, or None."""
    for i, entry in enumerate(explained):
        if entry["mutant"] == key(mutant) and entry.get("line", mutant["line"]) == mutant["line"]:
            return i
    return None


def run(jobs, timeout, only, stride, longest, longest_explained, without):
    """Runs the tests for every mutant that has no result yet: those of up to `longest` seconds, or `longest_explained`."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    mutants, programs = json.loads(LIST.read_text()), json.loads((HOME / "programs.json").read_text())
    tests = reach(programs, jobs, without)
    seconds = {(program, name): test["seconds"] for program in programs for name, test in tests[program].items()}
    reaching = collections.defaultdict(list)
    for program, name in seconds:
        for k in tests[program][name]["reached"]:
            reaching[k].append((program, name))
    before = results()
    explained = tomllib.loads(EXPLAINED.read_text())["survivor"]
    limit = {
        m["k"]: longest if entry_of(m, explained) is None else min(longest, longest_explained) for m in mutants
    }
    open_ones = [
        m for m in mutants
        if "left_out" not in m and m["k"] % stride == 0 and (not only or m["file"].startswith(tuple(only)))
        and (m["k"] not in before or not before[m["k"]]["caught"] and before[m["k"]]["longest"] < limit[m["k"]])
    ]
    killers = collections.defaultdict(collections.Counter)
    former = json.loads(FORMER.read_text()) if FORMER.exists() else {}
    former = {k: former.get(place) for k, place in numbered(mutants).items()}

    def judge(mutant):
        """Tries the test that noticed a mutant before first, then those that noticed its neighbours in its function and its file."""
        started = time.monotonic()
        places = (mutant["file"], (mutant.get("function") or {}).get("function_name")), (mutant["file"], None)
        tried = before.get(mutant["k"], {"longest": 0.0})["longest"]
        able = {test for test in reaching[mutant["k"]] if tried <= seconds[test] < limit[mutant["k"]]}
        groups = [[test] for test in able if test[1] == former[mutant["k"]]]
        if not groups:
            groups = [[test] for place in places for test, _ in killers[place].most_common(2) if test in able]
        able -= {test for group in groups for test in group}
        for low, high in zip([0.0, *GROUPS], GROUPS):
            groups.append([test for test in able if low <= seconds[test] < high])
        caught = None
        for group in groups:
            for program in programs:
                names = sorted(name for p, name in group if p == program)
                allowed = timeout + 10.0 * sum(seconds[program, name] for name in names)
                caught = caught or test(mutant["k"], program, names, allowed)
                if caught and "::" in caught:
                    for place in places:
                        killers[place][program, caught] += 1
                if caught:
                    return mutant, caught, time.monotonic() - started
        return mutant, None, time.monotonic() - started

    count = collections.Counter()
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool, RESULTS.open("a") as file:
        for future in concurrent.futures.as_completed([pool.submit(judge, mutant) for mutant in open_ones]):
            mutant, caught, took = future.result()
            line = {
                "k": mutant["k"], "name": mutant["name"], "caught": caught, "longest": limit[mutant["k"]], "seconds": took,
            }
            file.write(json.dumps(line) + "\n")
            file.flush()
            count[bool(caught)] += 1
            if not caught:
                by = f"passes {len(reaching[mutant['k']])} tests" if reaching[mutant["k"]] else "not reached by any test"
                print("SURVIVED", mutant["k"], mutant["name"] + ":", by, flush=True)
    print(f"{count[True]} noticed, {count[False]} survived the tests of up to {longest} seconds")


def results():
    """The last result of each mutant."""
    lines = map(json.loads, RESULTS.read_text().splitlines()) if RESULTS.exists() else []
    return {line["k"]: line for line in lines}


def report():
    """Compares the survivors with the explained list."""
    mutants = {m["k"]: m for m in json.loads(LIST.read_text())}
    explained = tomllib.loads(EXPLAINED.read_text())["survivor"]
    compiling = {k: m for k, m in mutants.items() if "left_out" not in m}
    found = results()
    noticed = {k for k in compiling if k in found and found[k]["caught"]}
    places, open_ones, tried = collections.Counter(), [], []
    for k in compiling.keys() - noticed:
        entry = entry_of(mutants[k], explained)
        if k not in found or entry is None or places[entry] == explained[entry].get("count", 1):
            open_ones.append(k)
        else:
            places[entry] += 1
            tried.append(found[k]["longest"])
    print(f"{len(mutants)} mutants: {len(mutants) - len(compiling)} do not compile, {len(noticed)} were noticed, "
          f"{len(tried)} survived the tests of up to {min(tried, default=0.0)} seconds that reach them and are explained, "
          f"{len(open_ones)} are neither")
    for k in sorted(open_ones):
        last = f"survived the tests of up to {found[k]['longest']} seconds" if k in found else "not run"
        print(f"not explained: {mutants[k]['name']}: {last}")
    stale = [e for i, e in enumerate(explained) if places[i] < e.get("count", 1)]
    for entry in stale:
        print(f"explained, but noticed or not there: {entry['mutant']}")
    sys.exit(bool(open_ones or stale))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    building = commands.add_parser("build", help="write the mutants into a copy of the sources and compile it")
    building.add_argument("file", nargs="+", help="patterns of `cargo mutants --file`")
    running = commands.add_parser("run", help="run the tests for each mutant")
    running.add_argument("--jobs", type=int, default=os.cpu_count())
    running.add_argument("--timeout", type=float, default=20.0, help="seconds beyond ten times the usual ones")
    running.add_argument("--longest", type=float, default=float("inf"), help="only tests of up to so many seconds; to go on later")
    running.add_argument("--explained", type=float, default=3.0, help="the same for mutants that are explained")
    running.add_argument("--without", nargs="*", default=[], help="tests that are left out, by how their names begin")
    running.add_argument("--only", nargs="*", default=[], help="files whose mutants are run")
    running.add_argument("--stride", type=int, default=1, help="run one mutant in so many, for a sample")
    commands.add_parser("report", help="compare the survivors with the explained list")
    arguments = parser.parse_args()
    if arguments.command == "build":
        build(arguments.file)
    elif arguments.command == "run":
        run(
            arguments.jobs, arguments.timeout, arguments.only, arguments.stride, arguments.longest, arguments.explained,
            arguments.without,
        )
    else:
        report()


if __name__ == "__main__":
    main()
