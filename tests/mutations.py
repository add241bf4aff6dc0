"""Files with damage of all kinds, the same for each seed."""

import io
import re
import zipfile

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


def mutated(data, rng):
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


def mutated_npz(path, rng):
    """The archive at `path` with damage to its bytes, to a member, to a header or to a document."""
    kind = rng.integers(4)
    if kind == 0:
        return mutated(path.read_bytes(), rng)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = rng.choice([*members])
    if kind == 1:
        members[name] = mutated(members[name], rng)
    elif kind == 2:
        members[name] = mutated(members[name][:HEADER], rng) + members[name][HEADER:]
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
