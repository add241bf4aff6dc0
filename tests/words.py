"""Check the words of the project: doc lines, names, phrases, numbers, and counts of ideas.

Without arguments everything is checked. With files or folders, a count for each folder follows
their violations. `--count` prints sizes of the code.
"""

import argparse
import ast
import io
import json
import os
import re
import sys
import tokenize
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]

OPENINGS = re.compile(
    r"\W*(what|whether|how|of|that|those|with|where|none|as|the\s+same)\b", re.IGNORECASE
)
LONGEST_SENTENCE = 25
#: Most public names at the top, most files beside the folders, and most files of a folder that is
#: not a list of equals.
TOP_NAMES, LOOSE_FILES, FOLDER_FILES = 40, 6, 20
LISTS = ("cli", "formats", "plot")
#: Most tuned numbers of the code, no more than today: settings and constants of both languages; and
#: most tags, markers and limits of the formats of pictures. The judgement of pictures that are no
#: panorama, and of suns in them, brought 10, and lights in metres 15; 2 were in a tuple, uncounted.
TUNED_NUMBERS, FORMAT_NUMBERS = 617, 65

# Irregular participles, and words in -ed that are none, or that are terms of the field.
IRREGULAR = re.compile(
    "begun|born|borne|bought|broken|brought|built|caught|chosen|done|drawn|driven|eaten|fallen|felt|"
    "flown|forgotten|fought|found|given|gone|grown|heard|held|hidden|hung|kept|known|laid|left|lost|"
    "made|meant|met|paid|said|sent|shown|shrunk|sold|sought|spent|stood|stuck|sunk|swept|sworn|"
    "swung|taken|taught|thought|thrown|t(?:old|orn)|understood|won|worn|written"
)
NO_PARTICIPLES = re.compile(
    "bleed|breed|clipped|embed|exceed|feed|fixed|hundred|need|proceed|seed|shared|shed|shred|signed|"
    "sized|speed|stretched|succeed|unsigned|weed"
)
PHRASES = [
    line.split("  ")
    for line in Path(__file__).with_name("phrases.txt").read_text(encoding="utf-8").splitlines()
    if not line.startswith("#")
]
DIALECT = re.compile("|".join(rf"\b(?:{phrase})\b" for phrase, _ in PHRASES), re.IGNORECASE)
BARE_POINT = re.compile(r"(?<![\w.\])}/\\*%`:])\.\d+(?:e[-+]?\d+)?(?![\w%.])")


class Text(NamedTuple):
    """Prose of a file: a comment, a docstring, a message."""

    line: int
    text: str
    is_doc: bool


class Name(NamedTuple):
    """A name that a file defines."""

    line: int
    name: str
    kind: str


class Violation(NamedTuple):
    """One broken rule."""

    path: Path
    line: int
    rule: str
    text: str


RUST_TOKEN = re.compile(
    r'(?<!\w)r(?P<h>#*)".*?"(?P=h)|"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])\'|//[^\n]*|/\*.*?\*/',
    re.DOTALL,
)
RUST_NAME = re.compile(
    r"^\s*(?:pub(?:\([^)]*\))?\s+)?(?:const\s+|async\s+)?"
    r"(?P<kind>struct|enum|trait|type|fn|mod)\s+(?P<name>\w+)",
    re.MULTILINE,
)


def blocks(lines: list[tuple[int, str, str]]) -> Iterator[Text]:
    """Comments of (line, marker, text), with adjacent lines of one marker joined."""
    start, last, marker, block = 0, -1, "", list[str]()
    for line, mark, text in [*lines, (-9, "", "")]:
        if line != last + 1 or mark != marker:
            if block:
                yield Text(start, "\n".join(block), marker in ("///", "//!"))
            start, marker, block = line, mark, []
        last = line
        block.append(text)


def rust(source: str) -> tuple[list[Text], list[Name]]:
    """Prose and names of a Rust file."""
    comments, texts = [], []
    for token in RUST_TOKEN.finditer(source):
        line, text = source.count("\n", 0, token.start()) + 1, token.group()
        if text.startswith("//"):
            marker = text[:3] if text[2:3] in ("/", "!") else "//"
            comments.append((line, marker, text[len(marker) :].strip()))
        elif text.startswith(('"', "r")):
            texts.append(Text(line, re.sub(r"\{[^{}]*\}|\\\n\s*", " ", text.strip('r#"')), False))
    code = RUST_TOKEN.sub(lambda token: "\n" * token.group().count("\n"), source)
    names = [
        Name(code.count("\n", 0, found.start("name")) + 1, found["name"], found["kind"])
        for found in RUST_NAME.finditer(code)
    ]
    return [*blocks(comments), *texts], names


def docstrings(body: list[ast.stmt]) -> Iterator[ast.Constant]:
    """Strings that are statements: the docstrings of a block and of its attributes."""
    for statement in body:
        value = statement.value if isinstance(statement, ast.Expr) else None
        if isinstance(value, ast.Constant) and isinstance(value.value, str):
            yield value


def python(source: str) -> tuple[list[Text], list[Name]]:
    """Prose and names of a Python file."""
    texts, names, ignored = [], [], set()
    tree = ast.parse(source)
    for node in ast.walk(tree):
        is_class = isinstance(node, ast.ClassDef)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            for doc in docstrings(node.body):
                texts.append(Text(doc.lineno, str(doc.value), True))
                ignored.add(doc)
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            names.append(Name(node.lineno, node.name, "class" if is_class else "def"))
        help_text = node.value if isinstance(node, ast.keyword) and node.arg == "help" else None
        if isinstance(help_text, ast.Constant):
            texts.append(Text(help_text.lineno, str(help_text.value), True))
            ignored.add(help_text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in ignored:
            texts.append(Text(node.lineno, re.sub(r"\{[^{}]*\}", " ", node.value), False))
    comments = [
        (token.start[0], "#", token.string.lstrip("#").strip())
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
    ]
    # A copy with a change, `env.rotated(matrix)`, is Python's own convention: `sorted`, `reversed`.
    methods = {
        statement.lineno
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        for statement in node.body
        if isinstance(statement, ast.FunctionDef) and statement.name.endswith("ed")
    }
    return [*texts, *blocks(comments)], [name for name in names if name.line not in methods]


def notebook(source: str) -> tuple[list[Text], list[Name]]:
    """Prose of the text cells of a notebook; the line is the number of the cell."""
    cells = json.loads(source)["cells"]
    return [
        Text(number, without_code("".join(cell["source"])), False)
        for number, cell in enumerate(cells, 1)
        if cell["cell_type"] == "markdown"
    ], []


def markdown(source: str) -> tuple[list[Text], list[Name]]:
    """Prose of a page, without its code."""
    return [Text(1, without_code(source), False)], []


def without_code(text: str) -> str:
    """`text` with code in fences, in backticks and in doctests blanked; lines stay lines."""
    return re.sub(
        r"^\s*```.*?^\s*```|`[^`\n]*`|^\s*>>>.*?(?=\n\s*\n|\Z)",
        lambda code: " " + "\n" * code.group().count("\n"),
        text,
        flags=re.DOTALL | re.MULTILINE,
    )


READERS = {".rs": rust, ".py": python, ".pyi": python, ".md": markdown, ".ipynb": notebook}


def first_sentence(doc: str) -> str:
    """Everything before the first full stop or empty line."""
    paragraph = re.split(r"\n\s*\n", doc.strip())[0]
    return re.split(r"(?<!\be\.g)(?<!\bi\.e)(?<!\bal)(?<!\bcf)(?<!\bvs)[.!?](?=\s|$)", paragraph)[0]


def is_participle(name: str) -> bool:
    """True for one word that is a bare past participle."""
    word = name.strip("_")
    if not re.fullmatch(r"[A-Za-z][a-z]{3,}", word):
        return False
    word = word.lower()
    regular = word.endswith("ed") and not NO_PARTICIPLES.fullmatch(word)
    return regular or IRREGULAR.fullmatch(word) is not None


def violations_in(path: Path) -> Iterator[Violation]:
    """Broken rules of one file, without those about names of two files."""
    source = path.read_text(encoding="utf-8")
    texts, names = READERS[path.suffix](source)
    for line, text, is_doc in texts:
        sentence = first_sentence(text)
        if is_doc and (opening := OPENINGS.match(sentence)):
            yield Violation(
                path, line, "opening", f"{opening[1]!r} in: {sentence.split(chr(10))[0]}"
            )
        if is_doc and (words := len(sentence.split())) > LONGEST_SENTENCE:
            yield Violation(path, line, "length", f"{words} words: {sentence.split(chr(10))[0]}")
        prose = without_code(text) if re.search(r"\s", text.strip()) else ""
        for rule, pattern in (("phrase", DIALECT), ("digit", BARE_POINT)):
            for hit in pattern.finditer(prose):
                at = line + (prose.count("\n", 0, hit.start()) if path.suffix != ".ipynb" else 0)
                around = prose[max(0, hit.start() - 40) : hit.end() + 30]
                yield Violation(path, at, rule, f"{hit.group()!r} in: {' '.join(around.split())}")
    is_code = path.suffix in (".rs", ".py", ".pyi")
    for line, name, kind in [*names, *([Name(1, path.stem, "file")] if is_code else [])]:
        if is_participle(name):
            yield Violation(path, line, "participle", f"{kind} {name}")


def repeated_names(paths: list[Path]) -> Iterator[Violation]:
    """Types and files in `src/kernels` whose name another one has."""
    kernels = [path for path in paths if path.suffix == ".rs" and "kernels" in path.parts]
    seen: dict[tuple[str, str], Path] = {}
    for path in kernels:
        keys = [
            (name.name, "type", name.line)
            for name in rust(path.read_text(encoding="utf-8"))[1]
            if name.kind in ("struct", "enum", "trait")
        ]
        if path.name not in ("mod.rs", "tests.rs"):
            keys.append((path.name, "file", 1))
        for name, kind, line in keys:
            other = seen.setdefault((name, kind), path)
            if other is not path:
                also = f"{name}, also in {os.path.relpath(other)}"
                yield Violation(path, line, f"{kind} twice", also)


def too_many(package: Path, number_of_names: int, numbers: Counter[str]) -> Iterator[Violation]:
    """Counts of ideas above their limits: public names, files of a folder, tuned numbers."""
    counts = [
        ("names", package, number_of_names, TOP_NAMES),
        ("tuned", package, numbers["tuned"], TUNED_NUMBERS),
        ("of formats", package, numbers["format"], FORMAT_NUMBERS),
    ]
    for folder in (package, *(each for each in package.rglob("*") if each.is_dir())):
        most = LOOSE_FILES if folder == package else FOLDER_FILES
        if folder.name not in LISTS:
            files = [each for each in folder.iterdir() if each.suffix in (".py", ".pyi", ".typed")]
            counts.append(("files", folder, len(files), most))
    for what, where, number, most in counts:
        if number > most:
            yield Violation(where, 1, "too many", f"{number} {what}, at most {most}")


def public_names(package: Path) -> int:
    """Number of names in `__all__` of a package."""
    tree = ast.parse((package / "__init__.py").read_text(encoding="utf-8"))
    lists = (each for each in tree.body if isinstance(each, ast.Assign))
    named = (each for each in lists if getattr(each.targets[0], "id", "") == "__all__")
    return sum(len(ast.literal_eval(each.value)) for each in named)


def numbers_in(root: Path) -> Counter[str]:
    """Numeric constants of the code and numbers in settings: tuned ones, and those of formats."""
    rust = r"^\s*(?:pub(?:\([^)]*\))? )?const [A-Z]\w+: \[?(?:f32|f64|usize|u\d+|i\d+)\b.* = .*\d"
    python = r"^_?[A-Z][A-Z_\d]+(?:: [^=\n]+)? = [-(]?\d"
    patterns = ((root / "src", "*.rs", rust), (root / "python", "*.py", python))
    found: Counter[str] = Counter()
    for folder, files, pattern in patterns:
        for file in folder.rglob(files):
            kind = "format" if root / "src/formats" in file.parents else "tuned"
            found[kind] += len(re.findall(pattern, file.read_text(encoding="utf-8"), re.MULTILINE))
    return found


def files_in(paths: list[Path]) -> list[Path]:
    """All files to check under `paths`, sorted."""
    every = [file for path in paths for file in (path, *path.rglob("*")) if file.is_file()]
    return sorted(f for f in set(every) if f.suffix in READERS and "node_modules" not in f.parts)


def print_sizes() -> None:
    """Print lines of each language, and the number of tuned numbers."""
    for folder, files in (("src", "*.rs"), ("python/envlights", "*.py"), ("tests", "*.py")):
        lines = sum(len(file.read_text().splitlines()) for file in (ROOT / folder).rglob(files))
        print(f"{lines:6d} lines in {folder}")
    print(f"{public_names(ROOT / 'python/envlights'):6d} public names at the top")
    numbers = numbers_in(ROOT)
    print(f"{numbers['tuned']:6d} tuned numbers, and {numbers['format']} of formats")


def main() -> int:
    """Print violations; 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("paths", nargs="*", type=Path)
    parser.add_argument("--count", action="store_true", help="Print sizes of the code.")
    arguments = parser.parse_args()
    if arguments.count:
        print_sizes()
    folders = ("src", "python", "tests", "benchmarks", "docs", "notebooks", "fuzz/fuzz_targets")
    everything = [*ROOT.glob("*.md"), *(ROOT / folder for folder in folders)]
    paths = files_in(arguments.paths or everything)
    violations = [violation for path in paths for violation in violations_in(path)]
    violations += repeated_names(paths)
    if not arguments.paths:
        package = ROOT / "python/envlights"
        violations += too_many(package, public_names(package), numbers_in(ROOT))
    rules = Counter(violation.rule for violation in violations)
    for path, line, rule, text in violations:
        print(f"{os.path.relpath(path)}:{line}: {rule}: {text}")
    if arguments.paths:
        places = Counter((os.path.relpath(path.parent), rule) for path, _, rule, _ in violations)
        for (folder, rule), number in sorted(places.items()):
            print(f"{number:5d} {rule:12} {folder}")
    for rule, number in sorted(rules.items()):
        print(f"{number:5d} {rule}")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
