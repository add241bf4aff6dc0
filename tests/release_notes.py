"""Notes of a release from the changelog: `python tests/release_notes.py v1.2.3`.

Ends with a sentence if the tag, the version of the crate and the newest entry are not the same.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent


def newest(changelog):
    """Version and text of the newest entry that has a date."""
    entries = re.split(r"^## ", changelog, flags=re.MULTILINE)[1:]
    dated = (
        re.match(r"\[?(\d[^\s\]]*)\]?\s+.*?(\d{4}-\d{2}-\d{2})\s*\n(.*)", entry, re.DOTALL)
        for entry in entries
    )
    version, _, text = next(found for found in dated if found).groups()
    return version, text.strip()


def main():
    """Print the notes."""
    tag = sys.argv[1].removeprefix("v")
    crate = re.search(r'^version = "(.+)"$', (ROOT / "Cargo.toml").read_text(), re.MULTILINE)[1]
    try:
        version, text = newest((ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))
    except StopIteration:
        sys.exit("CHANGELOG.md has no entry with a date: `## 1.2.3 - 2026-01-31`")
    if not tag == crate == version:
        sys.exit(
            f"the tag is {tag}, the crate {crate}, the newest entry {version}: make them equal"
        )
    print(text)


if __name__ == "__main__":
    main()
