"""What the default rules of other derivative checkers notice: the table in docs/explanation/other-checkers-tables.md, which
`scripts/measure.py peer-rules` rewrites.

Usage: python3 scripts/peer_rules.py --check     (needs cargo, or the example built in PINTLE_PEER_RULES)

It tries all mutants again and compares: the same mistakes, as many mutants to one in a
hundred, pintle notices each of them without a false alarm, and the others what is written to two in a hundred, for the last digits of
sines and cosines differ between machines.
"""

import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "explanation" / "other-checkers-tables.md"
BLOCK = "peer-rules"
BEGIN, END = f"<!-- measured: {BLOCK} -->", f"<!-- end: {BLOCK} -->"


def measured(program=None):
    """The table, of a program that is built already or of the example as cargo builds it."""
    command = [program] if program else ["cargo", "run", "--profile", "test", "--quiet", "--locked", "--all-features", "--example", "peer_rules"]
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()


def written_table():
    table, mark, _ = PAGE.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)
    if not mark:
        raise SystemExit(f"{PAGE.name} has no {BEGIN} … {END}")
    return table


def rows(table):
    """The numbers of each row by title and mistake: percentages and counts, in their order."""
    found, title = {}, None
    for line in table.splitlines():
        if line.startswith("**"):
            title = re.match(r"\*\*(.*)\*\*", line)[1]
        elif line.startswith("| ") and not line.startswith("| |"):
            name, *cells = (cell.strip() for cell in line.strip("| ").split(" | "))
            found[title, name] = [[float(x) for x in re.findall(r"[\d.]+", cell)] for cell in cells]
    return found


# A rule notices an error if it does so in this share of the mutants (%).
NOTICED = 95.0


def shorter(table):
    """Of each rule the least relative error of an entry that it notices, and its false alarms, by the kind of states."""
    stamp, head = table.strip().split("\n\n")[0], next(line for line in table.splitlines() if line.startswith("| |"))
    names = [cell.strip() for cell in head.strip("| ").split(" | ")][:-1]
    found = {}
    for (title, name), cells in rows(table).items():
        if number := re.fullmatch(r"entry × \(1 \+ (.*)\)", name):
            least = found.setdefault(title, ["none"] * len(names))
            for rule, (share,) in enumerate(cells[: len(names)]):
                if share >= NOTICED and (least[rule] == "none" or float(number[1]) < float(least[rule])):
                    least[rule] = number[1]
        elif name == "*false alarms*":
            alarms = [f"{wrong:.0f} of {of:.0f}" for wrong, of in cells[: len(names)]]
            found[title] = [f"{least}; {alarm}" for least, alarm in zip(found[title], alarms)]
    lines = [["least relative error noticed; false alarms", *names], ["---"] * (len(names) + 1), *([title, *cells] for title, cells in found.items())]
    return f"{stamp}\n\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines)


def check():
    written, now = rows(written_table()), rows(measured(os.environ.get("PINTLE_PEER_RULES")))
    wrong = [f"only in one of them: {name}" for name in sorted(written.keys() ^ now.keys())]
    for name in written.keys() & now.keys():
        if name[1] == "*false alarms*":
            ours, *others = zip(written[name], now[name])
            near = ours[0] == ours[1] and ours[1][0] == 0
            near = near and all(abs(old[0] - new[0]) <= 0.02 * new[1] + 1 for old, new in others)
        else:
            *rates, (old, new) = zip(written[name], now[name])
            near = rates[0] == ([100.0], [100.0]) and abs(old[0] - new[0]) <= 0.01 * new[0]
            near = near and all(abs(old[0] - new[0]) <= 2 for old, new in rates[1:])
        if not near:
            wrong.append(f"{': '.join(name)}: written {written[name]}, now {now[name]}")
    if wrong or not now:
        raise SystemExit("\n".join([f"{PAGE.name} is not what is measured now:", *wrong]))
    print(f"{len(now)} rows of {PAGE.name} are what is measured now")


if __name__ == "__main__":
    if sys.argv[1:] != ["--check"]:
        raise SystemExit(__doc__)
    check()
