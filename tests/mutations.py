"""Files with damage of all kinds, the same for each seed."""

import io
import re
import struct
import zipfile
import zlib

import numpy as np

#: What a number or a text of a JSON document may be instead.
STRANGE = (
    "null",
    "-1",
    "1e400",
    "NaN",
    '"x"',
    "[]",
    "{}",
    "2.5",
    "4294967296",
    "true",
    "-Infinity",
)
#: Bytes in which an array of NumPy says what it holds.
HEADER = 128


def mutate(data, rng):
    """`data` with one to three of: another byte or bit, bytes lost or inserted, the end cut off."""
    data = bytearray(data)
    for kind in rng.integers(5, size=rng.integers(1, 4)):
        at = int(rng.integers(len(data))) if data else 0
        if kind == 0:
            data[at : at + 1] = rng.bytes(1)
        elif kind == 1:
            data[at : at + 1] = bytes(
                byte ^ 1 << int(rng.integers(8)) for byte in data[at : at + 1]
            )
        elif kind == 2:
            del data[at : at + int(rng.integers(1, 40))]
        elif kind == 3:
            data[at:at] = rng.bytes(int(rng.integers(1, 20)))
        else:
            del data[at:]
    return bytes(data)


def mutated_json(text, rng):
    """`text` with one of its numbers or strings replaced."""
    places = list(re.finditer(r'-?\d+\.?\d*(?:e-?\d+)?|"[^"]*"', text))
    place = places[rng.integers(len(places))]
    return text[: place.start()] + rng.choice(STRANGE) + text[place.end() :]


def mutated_tokens(text, rng):
    """`text` with one of its items lost, doubled or exchanged for another."""
    tokens = re.split(r"(?<=[,{}\[\]:])", text)
    one, other = rng.integers(len(tokens), size=2)
    kind = rng.integers(3)
    if kind == 0:
        del tokens[one]
    elif kind == 1:
        tokens.insert(one, tokens[other])
    else:
        tokens[one], tokens[other] = tokens[other], tokens[one]
    return "".join(tokens)


def mutated_png(data, rng):
    """A PNG file with chunks damaged, lost, doubled or renamed, under right checksums."""
    chunks = []
    at = 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        chunks.append((kind, data[at + 8 : at + 8 + length]))
        at += 12 + length
    one = int(rng.integers(len(chunks)))
    kind, body = chunks[one]
    change = rng.integers(4)
    if change == 0:
        del chunks[one]
    elif change == 1:
        chunks.insert(int(rng.integers(len(chunks))), chunks[one])
    elif change == 2:
        chunks[one] = (mutate(kind, rng)[:4].ljust(4, b"x"), body)
    else:
        chunks[one] = (kind, mutate(body, rng))
    frames = [
        struct.pack(">I4s", len(body), kind) + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    ]
    return data[:8] + b"".join(frames)


def mutated_npz(path, rng):
    """The archive at `path` with damage to its bytes, to a member, to a header or to a document."""
    kind = rng.integers(4)
    if kind == 0:
        return mutate(path.read_bytes(), rng)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = rng.choice([*members])
    if kind == 1:
        members[name] = mutate(members[name], rng)
    elif kind == 2:
        members[name] = mutate(members[name][:HEADER], rng) + members[name][HEADER:]
    else:
        name = rng.choice(["report.npy", "parameters.npy"])
        text = str(np.load(io.BytesIO(members[name])))
        members[name] = as_npy(mutated_json(text, rng))
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for each, content in members.items():
            archive.writestr(each, content)
    return out.getvalue()


def as_npy(array):
    """The bytes of an array as NumPy saves it."""
    out = io.BytesIO()
    np.save(out, np.array(array))
    return out.getvalue()
