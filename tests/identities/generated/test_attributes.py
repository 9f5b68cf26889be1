import numpy as np
import pytest
from skimage.data import astronaut

from lrsr.identities.generated.attributes import (
    _TEXELS,
    ATTRIBUTES,
    AttributeMeter,
    _imbalances,
)
from lrsr.identities.photographs.picture_file import frame
from lrsr.identities.photographs.shot import Texels

FIVE_PX = np.array([[205.0, 101], [247, 103], [224, 129], [202, 138], [244, 141]])


@pytest.fixture(scope="module")
def meter() -> AttributeMeter:
    return AttributeMeter()


def test_a_mirror_changes_the_sides_and_nothing_else(meter: AttributeMeter) -> None:
    picture = astronaut()
    own = meter(frame(picture, FIVE_PX))
    mirrored = FIVE_PX[[1, 0, 2, 4, 3]] * [-1, 1] + [picture.shape[1] - 1, 0]
    other = meter(frame(np.ascontiguousarray(picture[:, ::-1]), mirrored))
    assert tuple(own) == ATTRIBUTES
    assert own["smile"] > 0.3 > own["jaw_open"]
    assert abs(own["yaw_deg"]) < 5
    assert own["yaw_deg"] == pytest.approx(-other["yaw_deg"], abs=2.5)
    assert own["light_across"] < -0.3
    assert own["light_across"] == pytest.approx(-other["light_across"], abs=0.05)
    for name in ("smile", "jaw_open", "light_above"):
        assert own[name] == pytest.approx(other[name], abs=0.05)


def test_where_no_skin_is_seen_light_is_not_known() -> None:
    nothing = np.zeros((_TEXELS, _TEXELS), np.float32)
    planes = np.zeros((_TEXELS, _TEXELS, 3), np.float32)
    seen = Texels(planes[..., :2], nothing, planes, nothing > 0)
    assert np.isnan(_imbalances(seen, planes)).all()


@pytest.mark.parametrize(("axis", "which"), [(0, 0), (1, 1)], ids=["across", "above"])
def test_light_from_one_side_is_found_there(axis: int, which: int) -> None:
    x, y = np.meshgrid(np.linspace(-0.7, 0.7, _TEXELS), np.linspace(0.7, -0.7, _TEXELS))
    normals = np.stack([x, y, np.sqrt(1 - x * x - y * y + 1e-9)], axis=-1).astype(np.float32)
    seen = Texels(normals[..., :2], normals[..., 2], normals, normals[..., 2] > -1)
    light = 0.3 * (1 + 0.4 * normals[..., axis])
    found = _imbalances(seen, np.repeat(light[..., None], 3, axis=2))
    assert found[which] > 0.1
    assert abs(found[1 - which]) < found[which] / 3
