"""Rewrites the table in docs/audit.md of what the default rules of other derivative checkers notice.

Usage: python3 scripts/peer_rules.py     (needs cargo; takes a minute)
"""

import pathlib
import platform
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "audit.md"
BEGIN, END = "<!-- peer rules: begin -->", "<!-- peer rules: end -->"


def main():
    command = ["cargo", "run", "--release", "--quiet", "--locked", "--example", "peer_rules"]
    table = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()
    text = PAGE.read_text(encoding="utf-8")
    head, rest = text.split(BEGIN)
    _, tail = rest.split(END)
    stamp = f"Written by `scripts/peer_rules.py` on {platform.machine()}."
    PAGE.write_text(f"{head}{BEGIN}\n{stamp}\n\n{table}\n{END}{tail}", encoding="utf-8")


if __name__ == "__main__":
    main()
