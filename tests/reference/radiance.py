"""Tokens of a Radiance description, as `readobj.c`, `fgetline.c` and `fgetword.c` cut them."""

import os
import re

#: Size of the buffers for a line and for a word.
_BUFFER = 2048
_SPACES = b" \t\n\v\f\r"


def tokens(path):
    """Kind and text of each token: comments, and words, whose quotes are removed.

    Where an object may begin, a mark of number begins a comment, and an exclamation mark would run
    a command.
    """
    text = path.read_bytes().lstrip(_SPACES)
    while text:
        assert text[:1] != b"!", f"a command: {text[:40]}"
        if text[:1] == b"#":
            kind, token, text = _line(text)
            yield kind, os.fsdecode(token)
        else:
            words, text = _object(text)
            yield from (("word", os.fsdecode(word)) for word in words)
        text = text.lstrip(_SPACES)


def _object(text):
    """Words of a primitive: modifier, type, name, and three lists behind their lengths."""
    words = []

    def take(number):
        nonlocal text
        for _ in range(number):
            _, word, text = _word(text.lstrip(_SPACES))
            words.append(word)

    take(3)
    for _ in range(3):
        take(1)
        take(int(words[-1]))
    return words, text


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
