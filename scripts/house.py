"""Is the house light? Lines, folders, import circles, and sentences that a reader finishes.

Usage: python3 scripts/house.py            prints the figures
       python3 scripts/house.py --check    fails where one is beyond its limit

A circle is a set of source files of one crate that use each other, by the paths that they name. Sentences are those of pages and of doc
comments; code, tables and measured blocks do not count.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CRATES = ("kinematics", "scene", "model", "assembly", "symbolic", "audit", "check", "c/element", "bench", "sweep", "report", "compare", "solve", "pintle")
# Folders whose files are data, each a case of the same kind.
DATA = re.compile(r"(snapshots|faults|findings|seeds|regressions|work-precision|golden)\b")
LONG, TOO_LONG = 30, 40


def sources():
    return sorted((ROOT / "src").rglob("*.rs"))


def module(crate, path):
    parts = path.relative_to(ROOT / "src" / crate).with_suffix("").parts
    return parts[:-1] if parts[-1] in ("mod", "lib", "main") else parts


def expanded(text):
    """Each path that begins with crate:: or super::, of lists in braces too."""
    for head, list_ in re.findall(r"\b((?:crate|super)(?:::\w+)*)(?:::\{([^{}]*)\})?", text):
        if list_:
            yield from (f"{head}::{item.split(' as ')[0].strip()}" for item in list_.split(",") if item.strip())
        else:
            yield head


def uses(crate):
    """Which file of a crate names an item of which other: the one that has it, where another hands it on."""
    files = {module(crate, path): path for path in sorted((ROOT / "src" / crate).rglob("*.rs")) if "runtime" not in path.parts}
    texts = {
        name: re.sub(r"//.*", "", path.read_text()).split("#[cfg(test)]\nmod tests {")[0] for name, path in files.items()
    }
    handed = {
        name: {
            item.split(" as ")[-1].strip(): from_
            for from_, list_, one in re.findall(r"pub(?:\([^)]*\))? use ([\w:]+)::(?:\{([^{}]*)\}|(\w+));", text)
            for item in (list_ or one).split(",")
            if item.strip()
        }
        for name, text in texts.items()
    }
    graph = {}
    for name, path in files.items():
        # Where an item may be seen is no use of that place.
        text, found = re.sub(r"\bpub\([^)]*\)", "pub", texts[name]), set()
        for word in expanded(text):
            parts = word.split("::")
            at = name
            while parts and parts[0] in ("crate", "super", "self"):
                at = () if parts[0] == "crate" else at[:-1] if parts[0] == "super" else at
                parts = parts[1:]
            whole = at + tuple(parts)
            target = next((whole[:k] for k in range(len(whole), 0, -1) if whole[:k] in files), None)
            while target and (from_ := handed[target].get((*whole[len(target) :], "")[0])):
                inner = tuple(part for part in from_.split("::") if part not in ("crate", "self"))
                inner = inner if from_.startswith("crate") else target + inner
                if inner not in files:
                    break
                target = inner
            if target and target != name and path.name != "tests.rs":
                found.add(target)
        graph[name] = found
    return graph


def circles(crate):
    """The sets of more than three files that use each other (Tarjan)."""
    graph, index, low, stack, found = uses(crate), {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in graph[node]:
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            at = stack.index(node)
            found.append(stack[at:])
            del stack[at:]

    for node in graph:
        if node not in index:
            visit(node)
    return [sorted("/".join((crate, *node)) for node in circle) for circle in found if len(circle) > 3]


def folders():
    """The folders of more than fifteen files."""
    for top in ("src", "verify", "scripts"):
        for folder in sorted(path for path in (ROOT / top).rglob("*") if path.is_dir()):
            name = str(folder.relative_to(ROOT))
            count = sum(path.is_file() for path in folder.iterdir())
            if count > 15 and not DATA.search(name) and "__pycache__" not in name:
                yield f"{name}: {count}"


def orphans():
    """Source files of crates and tests that no other declares, so that nobody compiles them."""
    for path in [*sources(), *sorted((ROOT / "verify").rglob("*.rs"))]:
        if path.stem in ("lib", "main", "build") or DATA.search(str(path.parent.relative_to(ROOT))) or "runtime" in path.parts:
            continue
        folder, name = (path.parent.parent, path.parent.name) if path.stem == "mod" else (path.parent, path.stem)
        parents = [folder / f"{of}.rs" for of in ("mod", "lib", "main")] + [folder.with_suffix(".rs")]
        declared = re.compile(rf"^\s*(pub(\([^)]*\))? )?mod {name}\b\s*[;{{]|path = \"[^\"]*{re.escape(path.name)}\"", re.MULTILINE)
        tops = [*parents, ROOT / "Cargo.toml", *(ROOT / "src").glob("*/Cargo.toml")]
        if not any(top.is_file() and declared.search(top.read_text()) for top in tops):
            yield str(path.relative_to(ROOT))


def paragraphs(lines):
    text, fenced, generated = [], False, False
    for line in [*lines, ""]:
        bare = line.strip()
        fenced ^= bare.startswith("```")
        generated = (generated or bare.startswith("<!-- measured")) and not bare.startswith("<!-- end")
        item = re.match(r"([-*+]|\d+[.)])\s+", bare)
        stop = fenced or generated or not bare or bare.startswith(("|", "#", "```", "<", "!["))
        if (stop or item) and text:
            yield " ".join(text)
            text = []
        if not stop:
            text.append(bare[item.end() :] if item else bare)


def sentences(texts):
    for text in texts:
        plain = re.sub(r"\]\([^)]*\)", "]", re.sub(r"`[^`]*`", "x", text))
        for sentence in re.split(r"(?<=[.!?:;])\s+(?=[A-ZÄÖÜΣ`*|√∂«(\[0-9])", plain):
            yield len(sentence.split()), sentence


def pages():
    names = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")
    return [*(ROOT / name for name in names), *sorted((ROOT / "docs").rglob("*.md"))]


def comments(path):
    """Doc comments, a paragraph a run of lines."""
    lines = []
    for line in path.read_text().splitlines():
        found = re.match(r"\s*//[/!] ?(.*)", line)
        lines.append(found[1] if found else "")
    return lines


def figures():
    """(what, found, limit, which) of each row."""
    of_pages = [length for page in pages() for length, _ in sentences(paragraphs(page.read_text().splitlines()))]
    of_comments = [(length, path, text) for path in sources() for length, text in sentences(paragraphs(comments(path)))]
    long = [f"{path.relative_to(ROOT)}: {text[:90]}" for length, path, text in of_comments if length > TOO_LONG]
    round_ = [circle for crate in CRATES for circle in circles(crate)]
    crowded, alone = list(folders()), list(orphans())
    share = 100 * sum(length > LONG for length in of_pages) / max(1, len(of_pages))
    words = len((ROOT / "CHANGELOG.md").read_text().split())
    lines = sum(len(path.read_text().splitlines()) for path in sources())
    return [
        ("lines under `src`", lines, None, []),
        ("files under `src`", len(sources()), None, []),
        ("import circles of more than three files", len(round_), 0, [", ".join(circle) for circle in round_]),
        ("folders of more than fifteen files", len(crowded), 0, crowded),
        ("source files that nothing declares", len(alone), 0, alone),
        ("pages: % of sentences over 30 words", round(share, 1), 5, []),
        ("pages: sentences over 40 words", sum(length > TOO_LONG for length in of_pages), 0, []),
        ("doc comments: sentences over 40 words", len(long), 0, long),
        ("CHANGELOG: words", words, 400, []),
    ]


def main():
    beyond = 0
    for what, found, limit, which in figures():
        is_beyond = limit is not None and found > limit
        beyond += is_beyond
        print(f"{what}: {found}" + (f" (at most {limit})" if limit is not None else ""))
        for one in which:
            print(f"  {one}")
    if "--check" in sys.argv:
        print(f"{beyond} beyond the limit" if beyond else "all within their limits")
        sys.exit(bool(beyond))


if __name__ == "__main__":
    main()
