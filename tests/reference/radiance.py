"""Tokens of a Radiance description, as `readobj.c`, `fgetline.c` and `fgetword.c` cut them."""

import os
import re

#: Size of the buffers for a line and for a word.
_BUFFER = 2048
_SPACES = b" \t\n\v\f\r"


def tokens(path):
    """Kind and text of each token: comments, and words, whose quotes are removed.

    An exclamation mark at the start of a word would run a command.
    """
    text = path.read_bytes().lstrip(_SPACES)
    while text:
        assert text[:1] != b"!", f"a command: {text[:40]}"
        read = _line if text[:1] == b"#" else _word
        kind, token, text = read(text)
        yield kind, os.fsdecode(token)
        text = text.lstrip(_SPACES)


def _line(text):
    """Comment to the end of the line or of the buffer; a backslash hides the end of the line."""
    line = re.match(rb"#(?:\\\n|[^\n])*", text)[0][: _BUFFER - 1]
    return "comment", line, text[len(line) :]


def _word(text):
    if text[:1] in (b'"', b"'"):
        word, _, rest = text[1:].partition(text[:1])
    else:
        word = text.split(None, 1)[0]
        rest = text[len(word) :]
    assert len(word) < _BUFFER - 2
    return "word", word, rest
