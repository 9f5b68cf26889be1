"""An evaluation that is killed at any moment ends in the very results of an undisturbed one."""

import random
from pathlib import Path

from fakes.elsewhere import finish, run_script

RUNS = """
import os, signal, sys, time
from pathlib import Path
import pytest
import torch
from fakes.figures import draw_nothing
from fakes.painted import PaintedMaker
from lrsr.camera import Camera
from lrsr.experiments.conditions import Condition
from lrsr.experiments.verification import Verification
from lrsr.identities.roster import IdentityRange
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.sitting import Sitting
from lrsr.presets import preset
from lrsr.recognition.settings import RecognitionSettings
from lrsr.rendering.scene import Film, Quality, Scene

torch.set_num_threads(1)  # nothing that a fork would miss
draw_nothing(pytest.MonkeyPatch())
root, model, *moments = sys.argv[1:]
people, quality = IdentityRange(count=6), Quality(samples_per_pixel=4, texture_size=64)
scene = Scene(preset("lighting", "frontal"))
design = Verification(
    name="killed", question="?", people=people, quality=quality, seed=5, camera=Camera(),
    conditions=(Condition(1, scene, "none", 8.0), Condition(2, scene, "heavy", 8.0)),
    upscalers={"base": preset("sr", "base"), "bicubic2": preset("sr", "bicubic2")},
    gallery=Sitting(people, scene, Film(16.0), quality, "gallery", 5),
    recognition=RecognitionSettings(model=Path(model)),
)

class Slow(PaintedMaker):
    def render(self, head, recipe):
        time.sleep(0.02)
        return super().render(head, recipe)

def work(name):
    folder = Path(root) / name
    design.run(folder / "run", RenderCache(folder / "cache"), maker=Slow(), progress=False)

def run(name):
    child = os.fork()
    if child == 0:
        work(name)
        os._exit(0)
    return child

work("first")  # all that is imported on the way is there for the others
began = time.monotonic()
assert os.waitpid(run("quiet"), 0)[1] == 0
whole = time.monotonic() - began
killed = 0
for share in moments:
    child = run("killed")
    time.sleep(float(share) * whole)
    os.kill(child, signal.SIGKILL)
    killed += os.WIFSIGNALED(os.waitpid(child, 0)[1])
assert os.waitpid(run("killed"), 0)[1] == 0
print(killed)
"""


def test_killed_at_random_moments_it_ends_in_the_same_results(
    tmp_path: Path, tone_model: Path
) -> None:
    """Moments are shares of the time that a whole run takes."""
    draws = random.Random(0)
    moments = [f"{draws.uniform(0.05, 0.6):.3f}" for _ in range(4)]
    ended = finish(tmp_path / "told", run_script, RUNS, str(tmp_path), str(tone_model), *moments)
    assert ended.status == 0, ended.err
    assert int(ended.out) >= 2
    for name in ("results.json", "scores.csv", "report.html"):
        quiet, killed = (tmp_path / one / "run" / name for one in ("quiet", "killed"))
        assert killed.read_bytes() == quiet.read_bytes()
