import hashlib
import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from skimage.data import astronaut

from lrsr.errors import InputError
from lrsr.identities.day.another_day import AnotherDay
from lrsr.identities.face.expression import NEUTRAL
from lrsr.identities.photographs.person import Network, Photographed, read_photographed
from lrsr.identities.roster import IdentityRange

FIVE = ((205.0, 101.0), (247.0, 103.0), (224.0, 129.0), (202.0, 138.0), (244.0, 141.0))


def told(sha256: str, **changes: Any) -> dict[str, Any]:
    usual = {"file": "/nowhere/a.png", "five_px": FIVE, "hair": "none", "expression": "neutral"}
    return {**usual, "who": "", "sha256": sha256, **changes}


def folder_of(folder: Path, *people: dict[str, Any], version: int = 2) -> str:
    (folder / "people.json").write_text(json.dumps({"format": version, "people": people}))
    return str(folder)


def somebody(**changes: Any) -> Photographed:
    return Photographed(
        **{"file": "/nowhere/a.png", "sha256": "ab" * 32, "five_px": FIVE, **changes}
    )


def test_where_the_file_lies_does_not_count() -> None:
    here, there = somebody(), somebody(file="/elsewhere.png")
    assert here.record() == there.record()
    assert here.id == there.id == "photograph-abababababab"
    assert here.record() != somebody(hair="none").record()
    named = somebody(who="ann")
    assert (named.id, named.record(), named.index) == ("ann", here.record(), here.index)


def test_the_network_that_found_the_face_counts_by_its_checksum() -> None:
    usual, other = somebody(), somebody(reconstructor=Network("/a.onnx", "cd"))
    assert other.record() == {**usual.record(), "reconstructor": "cd"}
    assert other.record() == somebody(reconstructor=Network("/b.onnx", "cd")).record()


def test_a_folder_of_the_command_is_read(tmp_path: Path) -> None:
    network = {"file": "/a.onnx", "sha256": "cd"}
    people = [told("1" * 64), told("2" * 64), told("3" * 64, reconstructor=network)]
    given = folder_of(tmp_path, *people)
    chosen = IdentityRange(photographs=given, start=1, gallery="photograph")
    assert [one.record()["photograph"][0] for one in chosen.people()] == ["2", "3"]
    assert chosen.count == 2
    second, third = (one.record() for one in chosen.people())
    assert second["hair"] == "none"
    assert "reconstructor" not in second
    assert third["reconstructor"] == "cd"


def test_several_photographs_of_one_person_are_one_identity(tmp_path: Path) -> None:
    shown = [("ann", "1"), ("kim", "2"), ("ann", "3"), ("ann", "4")]
    given = folder_of(tmp_path, *(told(digit * 64, who=who) for who, digit in shown))
    ann, kim = read_photographed(tmp_path)
    assert (ann.id, ann.sha256[0], kim.id, kim.others) == ("ann", "1", "kim", ())
    assert [one.sha256[0] for one in ann.others] == ["3", "4"]
    assert ann.record() == somebody(sha256="1" * 64, hair="none", expression="neutral").record()
    everybody = IdentityRange(photographs=given)
    assert (everybody.count, everybody.enrolled) == (2, None)
    assert IdentityRange(photographs=given, gallery="photograph").enrolled == [ann, kim]


def test_who_has_another_photograph_can_be_enrolled_by_it(tmp_path: Path) -> None:
    shown = [("kim", "2"), ("ann", "1"), ("ann", "3")]
    given = folder_of(tmp_path, *(told(digit * 64, who=who) for who, digit in shown))
    chosen = IdentityRange(photographs=given, gallery="other_photograph")
    (head,), (enrolled,) = chosen.people(), chosen.enrolled or []
    assert (head.id, enrolled.id, chosen.count) == ("ann", "ann", 1)
    assert (head.record()["photograph"][0], enrolled.sha256[0]) == ("1", "3")


def test_the_halves_share_nobody_and_miss_nobody(tmp_path: Path) -> None:
    names = [f"person {number}" for number in range(40)]
    given = folder_of(
        tmp_path,
        *(told(f"{number:064x}", who=who) for number, who in enumerate(names)),
        *(told(f"{number + 99:064x}", who=who) for number, who in enumerate(names)),
    )
    halves = [
        {one.id for one in IdentityRange(photographs=given, part=part).people()}
        for part in ("development", "test")
    ]
    assert not halves[0] & halves[1]
    assert halves[0] | halves[1] == {*names}
    assert min(map(len, halves)) > 10


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"start": 1}, "identities.start=1: wanted 0 to 0"),
        ({"sex": "female"}, "people on photographs are who they are"),
        ({"roster": "r.json"}, "identities.roster=r.json: wanted no such choice"),
        ({"gallery": "film"}, "identities.gallery=film: wanted one of render, photograph, other"),
        ({"photographs": None, "gallery": "photograph"}, "or identities.photographs=FOLDER"),
        (
            {"photographs": None, "part": "test"},
            "identities.part=test: wanted all: identities.split",
        ),
        ({"part": "half"}, "identities.part=half: wanted one of all, development, test"),
        ({"part": "development"}, "wanted all: of 1 nobody is in it"),
        ({"gallery": "other_photograph"}, "of 1 people nobody has another one"),
    ],
)
def test_choices_that_cannot_be_are_refused(
    tmp_path: Path, settings: dict[str, Any], says: str
) -> None:
    given = {"photographs": folder_of(tmp_path, told("1" * 64, who="ann")), **settings}
    with pytest.raises(InputError, match=says):
        IdentityRange(**given)


@pytest.mark.parametrize(
    ("people", "version", "says"),
    [
        ([], 2, "nobody there could be reconstructed"),
        ([told("1" * 64)], 1, "format=1: wanted 2"),
        ([{"file": "a"}], 2, "is no record of this version"),
        ([told("1" * 64, hair="wig")], 2, "hair=wig: wanted painted or none"),
        ([told("1" * 64, expression="angry")], 2, "expression=angry"),
        ([told("1" * 64, reconstructor="a.onnx")], 2, "is no record of this version"),
    ],
)
def test_what_is_no_record_is_refused(
    tmp_path: Path, people: list[dict[str, Any]], version: int, says: str
) -> None:
    folder_of(tmp_path, *people, version=version)
    with pytest.raises(InputError, match=says):
        read_photographed(tmp_path)


def test_a_folder_of_pictures_alone_is_no_people(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no people.json there; lrsr reconstruct images="):
        read_photographed(tmp_path)


@pytest.mark.parametrize("content", [b"", b"{", b"[" * 100_000, bytes(range(256))], ids=len)
def test_a_broken_record_is_named(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "people.json").write_bytes(content)
    with pytest.raises(InputError, match=r"people\.json is no JSON: run lrsr reconstruct again"):
        read_photographed(tmp_path)


def test_a_picture_that_is_gone_or_changed_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot read /nowhere"):
        somebody().head(NEUTRAL, 64)
    path = tmp_path / "a.png"
    path.write_bytes(b"changed")
    with pytest.raises(InputError, match="was changed: run lrsr reconstruct again"):
        somebody(file=str(path)).head(NEUTRAL, 64)


def test_of_another_day_only_what_is_worn_is_known() -> None:
    with pytest.raises(InputError, match=r"another_day\.make_up=0\.5: wanted as it is"):
        somebody().head(NEUTRAL, 64, AnotherDay("made up", make_up=0.5))


def test_a_head_bears_the_person_s_name(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), np.ascontiguousarray(astronaut()[..., ::-1]))
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    person = somebody(file=str(path), sha256=digest)
    head = person.head(NEUTRAL, 64)
    assert head.identity_id == person.id
    assert head.parameters["photograph"] == digest
