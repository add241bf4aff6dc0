"""Files do not change by themselves: two runs, on any number of threads, write the same bytes."""

import importlib.util

from tests.helpers import printed_by_threads

#: Writes every kind of file, and prints a hash of each.
CODE = """
import hashlib, os, tempfile, warnings
import envlights as el

warnings.simplefilter("ignore")  # of lights that are shown as points

os.chdir(tempfile.mkdtemp())
env = el.EnvMap(el.synthetic.hall(32).radiance)
rig = el.fit(env, lights=3, ambient="sh2")
found = el.detect(env)
lights, rest = el.split(env)
for target in el.export.TARGETS:
    for suffix in target.suffixes:
        if suffix != ".usdc" or {has_usd}:
            rig.save(f"rig{{suffix}}")
            found.save(f"found{{suffix}}")
            lights.save(f"removed{{suffix}}", *([rest] if target.shows.environment else []))
for suffix in (".exr", ".hdr"):
    rest.save(f"rest{{suffix}}")
rest.to("cube").save("cube.exr")
for suffix in (".png", ".svg", ".pdf"):
    el.plot.save(el.plot.picture(env, rig).figure, f"picture{{suffix}}")
room = el.synthetic.room(8, width=32)
el.TransferModel.fit(room.direct, room.indirect, rank=4).save("model.npz")
for name in sorted(os.listdir()):
    print(name, hashlib.sha256(open(name, "rb").read()).hexdigest())
"""


def test_two_runs_and_any_number_of_threads_write_the_same_bytes():
    """Each run is a process: it begins at another time, and has other hashes of strings."""
    has_usd = importlib.util.find_spec("pxr") is not None
    printed = printed_by_threads(CODE.format(has_usd=has_usd))
    files = [set(each.splitlines()) for each in printed]
    assert len(files[0]) > 40
    assert not set.union(*files) - set.intersection(*files)
