"""Reads every .inp below a folder with pintle, and tells by cause what is refused.

    python3 scripts/peers/deck_corpus.py DIR [--program target/debug/pintle] [--list CODE] [--back]

A deck counts as read if `pintle convert DECK --to json` succeeds. `--back` reads what was written once more. A file that another
deck includes is not a deck of its own, and is left out. The table goes to standard output: a row for each cause, then what crashed
and what took long. No deck is part of this repository.
"""

import argparse
import collections
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

SLOW = 5.0
INCLUDED = re.compile(rb"^\*\s*(?:include|node|element|mpc|amplitude)\b[^\n]*\binput\s*=\s*([^,\r\n]+)", re.I | re.M)


def read(program, deck, back):
    """The first code of what refuses the deck (None if it is read), all the words, and the seconds."""
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder) / "copy.inp"
        runs = [[program, "convert", str(deck), "-o", str(copy)]]
        if back:
            runs.append([program, "convert", str(copy), "--to", "json"])
        for run in runs:
            try:
                done = subprocess.run(run, capture_output=True, timeout=120, env={**os.environ, "NO_COLOR": "1"})
            except subprocess.TimeoutExpired:
                return "timeout", "", time.monotonic() - began
            words = done.stderr.decode(errors="replace")
            if done.returncode == 6:
                # Warnings stand beside errors; an error is marked by a cross.
                codes = re.findall(r"^([a-z]+::[a-z0-9-]+)\n\n?\s*×", words, re.M) or re.findall(r"\w+::[\w-]+", words)
                return (codes[-1] if codes else "unknown"), words, time.monotonic() - began
            if done.returncode:
                return f"exit {done.returncode}", words, time.monotonic() - began
    return None, "", time.monotonic() - began


def main():
    """Reads the arguments, then the decks, and writes the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--program", default="target/debug/pintle")
    parser.add_argument("--back", action="store_true", help="read what is written once more")
    parser.add_argument("--list", default="", help="print the messages of this code (or of all: ::)")
    options = parser.parse_args()
    files = sorted(path for path in options.folder.rglob("*") if path.suffix.lower() == ".inp" and path.is_file())
    included = set()
    for path in files:
        for name in INCLUDED.findall(path.read_bytes()[:5_000_000]):
            included.add((path.parent / name.decode(errors="replace").strip().strip('"')).resolve())
    decks = [path for path in files if path.resolve() not in included]
    if not decks:
        sys.exit(f"no deck below {options.folder}")
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        results = list(pool.map(lambda deck: read(options.program, deck, options.back), decks))
    causes = collections.Counter(code for code, _, _ in results)
    print(f"| decks | read | refused |\n|---|---|---|\n| {len(decks)} | {causes[None]} | {len(decks) - causes[None]} |\n")
    print("| cause | decks | for example |\n|---|---|---|")
    for cause, count in causes.most_common():
        if cause is not None:
            example = next(deck for deck, (code, _, _) in zip(decks, results) if code == cause)
            print(f"| `{cause}` | {count} | {example.relative_to(options.folder)} |")
    crashed = [deck for deck, (code, _, _) in zip(decks, results) if code in ("exit 70", "exit 101", "timeout")]
    slow = [(seconds, deck) for deck, (_, _, seconds) in zip(decks, results) if seconds > SLOW]
    print(f"\ncrashed: {len(crashed)}; longer than {SLOW:g} s: {len(slow)}; longest: {max(r[2] for r in results):.1f} s")
    for deck in crashed:
        print(f"crashed: {deck}")
    for seconds, deck in sorted(slow, reverse=True):
        print(f"{seconds:.1f} s: {deck}")
    for deck, (code, words, _) in zip(decks, results):
        if options.list and code and options.list in code:
            print(f"\n=== {deck}\n{words[:3000]}")
    return bool(crashed)


if __name__ == "__main__":
    sys.exit(main())
