"""ICC profiles, written from the specification (ICC.1)."""

import struct

import numpy as np

from envlights.environment.colour.primaries import REC709
from tests.reference import srgb

BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
D50 = np.array([0.9642, 1.0, 0.8249])


def fixed(values):
    return b"".join(struct.pack(">i", round(float(value) * 65536)) for value in values)


def d50_columns(chromaticities):
    """XYZ of red, green and blue, adapted to D50."""
    points = np.reshape(chromaticities, (4, 2))
    x, y = points.T
    xyz = np.array([x / y, np.ones(4), (1 - x - y) / y])
    columns = xyz[:, :3] * np.linalg.solve(xyz[:, :3], xyz[:, 3])
    gains = (BRADFORD @ D50) / (BRADFORD @ xyz[:, 3])
    return np.linalg.inv(BRADFORD) @ np.diag(gains) @ BRADFORD @ columns


def gamma(exponent):
    return b"curv\0\0\0\0" + struct.pack(">IH", 1, round(exponent * 256))


IDENTITY = b"curv\0\0\0\0" + struct.pack(">I", 0)


def through(values):
    codes = np.round(np.asarray(values) * 65535).astype(">u2")
    return b"curv\0\0\0\0" + struct.pack(">I", len(codes)) + codes.tobytes()


def parametric(kind, *values):
    return b"para\0\0\0\0" + struct.pack(">HH", kind, 0) + fixed(values)


SRGB = parametric(3, 2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)
SRGB_SAMPLED = through(srgb.decode(np.linspace(0, 1, 1024)))


def assemble(tags, space=b"RGB ", kind=b"mntr"):
    table, data, start = b"", b"", 132 + 12 * len(tags)
    for tag, body in tags.items():
        table += tag + struct.pack(">II", start + len(data), len(body))
        data += body + b"\0" * (-len(body) % 4)
    head = struct.pack(">I4sI4s4s4s6H4s", start + len(data), b"none", 0x02400000, kind, space,
                       b"XYZ ", 2026, 1, 1, 0, 0, 0, b"acsp")  # fmt: skip
    return (head + bytes(28) + fixed(D50) + bytes(48)) + struct.pack(">I", len(tags)) + table + data


def description(name):
    return b"desc\0\0\0\0" + struct.pack(">I", len(name) + 1) + name.encode() + bytes(79)


def rgb(curves, chromaticities=REC709, name="test", **others):
    """RGB profile with one curve, or three."""
    curves = [curves] * 3 if isinstance(curves, bytes) else curves
    columns = [b"XYZ \0\0\0\0" + fixed(column) for column in d50_columns(chromaticities).T]
    tags = {b"desc": description(name), b"cprt": b"text\0\0\0\0none\0"}
    tags[b"wtpt"] = b"XYZ \0\0\0\0" + fixed(D50)
    tags |= dict(zip((b"rXYZ", b"gXYZ", b"bXYZ"), columns, strict=True))
    tags |= dict(zip((b"rTRC", b"gTRC", b"bTRC"), curves, strict=True))
    return assemble(tags | {key.encode(): value for key, value in others.items()})


def grey(curve):
    wtpt = b"XYZ \0\0\0\0" + fixed(D50)
    return assemble({b"desc": description("grey"), b"wtpt": wtpt, b"kTRC": curve}, b"GRAY")
