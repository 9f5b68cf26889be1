import hashlib
import itertools
import json
import subprocess
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from fakes.scenes import EXPRESSIONS
from oracles.lids import pierced_mm

from lrsr.errors import InputError
from lrsr.identities import morphable
from lrsr.identities.gate.plausibility import check_face, check_hair
from lrsr.identities.head import Head
from lrsr.identities.morphable import (
    _STREAMS,
    RECIPE_VERSION,
    _stream,
    position_map,
    sample_head,
    sample_parameters,
    template,
)
from lrsr.identities.population import ANCESTRIES, EVERYBODY
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.topology import REGIONS

SIZE = 128
SEEDS = (0, 1, 5)


@pytest.fixture(scope="module")
def heads() -> dict[int, Head]:
    return {seed: sample_head(seed, texture_size=SIZE) for seed in SEEDS}


def digest(head: Head) -> str:
    total = hashlib.sha256(json.dumps(head.parameters, sort_keys=True).encode())
    for array in (head.pupils, head.landmarks):
        total.update(array.tobytes())
    for part in head.parts:
        for array in (part.vertices, part.faces, part.uv, part.albedo):
            total.update(np.ascontiguousarray(array).tobytes())
    return total.hexdigest()


def test_the_pupils_lie_on_the_x_axis_around_the_origin(heads: dict[int, Head]) -> None:
    for head in heads.values():
        np.testing.assert_allclose(head.pupils.mean(axis=0), 0.0, atol=1e-9)
        np.testing.assert_allclose(head.pupils[:, 1:], 0.0, atol=1e-9)
        assert head.pupils[0, 0] < 0 < head.pupils[1, 0]


def test_interpupillary_distances_are_those_of_adults() -> None:
    # Dodgson, "Variation and extrema of human interpupillary distance" (2004): 52 to 78 mm.
    distances = [sample_head(seed, texture_size=64).ipd_mm for seed in range(8)]
    assert 50 < min(distances) < max(distances) < 80


def test_landmarks_lie_where_their_names_say(heads: dict[int, Head]) -> None:
    for head in heads.values():
        left_eye, right_eye, nose, mouth_left, mouth_right = head.landmarks
        np.testing.assert_array_equal([left_eye, right_eye], head.pupils)
        assert mouth_left[0] < nose[0] < mouth_right[0]
        assert max(mouth_left[1], mouth_right[1]) < nose[1] < -15
        assert nose[2] > max(mouth_left[2], mouth_right[2])


def test_landmarks_lie_on_the_skin(heads: dict[int, Head]) -> None:
    for head in heads.values():
        skin = head.part("skin").vertices
        for point in head.landmarks[2:]:
            assert np.linalg.norm(skin - point, axis=1).min() < 2.0


def test_all_heads_have_the_same_parts_faces_uv_and_texture_sizes(heads: dict[int, Head]) -> None:
    first, *others = heads.values()
    for head in others:
        assert [p.name for p in head.parts] == [p.name for p in first.parts]
        for mine, theirs in zip(head.parts, first.parts, strict=True):
            np.testing.assert_array_equal(mine.faces, theirs.faces)
            np.testing.assert_array_equal(mine.uv, theirs.uv)
            assert mine.vertices.shape == theirs.vertices.shape
            assert mine.albedo.shape == theirs.albedo.shape


def test_the_parts_are_skin_eyes_lashes_hair_and_mouth(heads: dict[int, Head]) -> None:
    names = [part.name for part in heads[0].parts]
    assert names == ["skin", "left_eye", "right_eye", "lashes", "hair", "mouth"]
    assert heads[0].part("left_eye").vertices[:, 0].max() < 0


def test_the_skins_texture_has_the_asked_size(heads: dict[int, Head]) -> None:
    assert heads[0].part("skin").albedo.shape == (SIZE, SIZE, 3)


def test_every_number_is_a_finite_one_of_the_right_kind(heads: dict[int, Head]) -> None:
    for head in heads.values():
        for part in head.parts:
            assert np.isfinite(part.vertices).all()
            assert (part.vertices.dtype, part.faces.dtype) == (np.float32, np.int32)
            assert (part.uv.dtype, part.albedo.dtype) == (np.float32, np.float32)
            assert 0 <= part.albedo.min() <= part.albedo.max() <= 1
            assert part.faces.max() < len(part.vertices)


def test_the_lower_edge_lies_far_below_the_picture(heads: dict[int, Head]) -> None:
    basis = load_basis()
    surface = basis.surface
    shoulders = np.unique(surface.faces[surface.region == REGIONS.index("shoulders")])
    for head in heads.values():
        skin = head.part("skin").vertices
        assert skin[shoulders, 1].min() < -200
        assert skin[:, 1].min() == skin[shoulders, 1].min()


def test_no_skin_lies_before_the_pupils(heads: dict[int, Head]) -> None:
    for head in heads.values():
        offset = head.part("skin").vertices[:, None] - head.pupils
        near = np.hypot(offset[..., 0], offset[..., 1]) < 1.5
        assert not (near & (offset[..., 2] > -5)).any()


def test_the_same_seed_gives_the_same_bytes_even_in_another_process(
    heads: dict[int, Head],
) -> None:
    code = (
        "import json, hashlib, numpy as np\n"
        "from lrsr.identities.morphable import sample_head\n"
        f"head = sample_head(5, texture_size={SIZE})\n"
        "total = hashlib.sha256(json.dumps(head.parameters, sort_keys=True).encode())\n"
        "[total.update(a.tobytes()) for a in (head.pupils, head.landmarks)]\n"
        "[total.update(np.ascontiguousarray(a).tobytes()) for p in head.parts\n"
        " for a in (p.vertices, p.faces, p.uv, p.albedo)]\n"
        "import sys; sys.stdout.write(total.hexdigest())\n"
    )
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert other.stdout == digest(heads[5])


def test_people_differ(heads: dict[int, Head]) -> None:
    assert len({digest(head) for head in heads.values()}) == len(SEEDS)
    a, b = (heads[seed].part("skin").vertices for seed in SEEDS[:2])
    assert np.linalg.norm(a - b, axis=1).mean() > 2


def test_a_head_is_called_after_its_seed(heads: dict[int, Head]) -> None:
    assert heads[5].identity_id == "seed-00000005"


def test_parameters_are_plain_and_say_who_it_is(heads: dict[int, Head]) -> None:
    parameters = heads[1].parameters
    assert json.loads(json.dumps(parameters)) == sample_parameters(1)
    assert parameters["recipe"] == RECIPE_VERSION
    assert parameters["sex"] in ("female", "male")


def test_everybody_is_an_adult_of_25_to_75(crowds: Mapping[str, list[dict[str, Any]]]) -> None:
    people = crowds["any"]
    assert all(25 <= p["age_years"] <= 75 for p in people)
    assert min(p["age_years"] for p in people) < 35
    assert max(p["age_years"] for p in people) > 60


def test_both_sexes_and_all_ancestries_are_about_equally_frequent() -> None:
    # Who there is is settled before the gate.
    people = [morphable._draw_traits(seed, EVERYBODY) for seed in range(150)]
    women = sum(p["sex"] == "female" for p in people)
    assert abs(women - 75) < 3 * np.sqrt(150 / 4)
    shares = np.mean([[p["ancestry"][race] for race in ANCESTRIES] for p in people], axis=0)
    # Var of a Dirichlet(.25) share: (1/3)(2/3) / (0.75 + 1)
    assert np.abs(shares - 1 / 3).max() < 3.5 * np.sqrt(2 / 9 / 1.75 / 150)


def test_the_gate_finds_everybody_a_face_and_hair(
    crowds: Mapping[str, list[dict[str, Any]]],
) -> None:
    redraws = [person["gate"]["redraws"] for people in crowds.values() for person in people]
    assert np.median(redraws) <= 2
    assert max(redraws) < 30


def test_streams_are_independent_and_repeatable() -> None:
    assert _stream(4, "hair").random() == _stream(4, "hair").random()
    assert len({_stream(s, n).random() for s in (4, 5) for n in ("hair", "eyes")}) == 4


def test_a_stream_drawn_again_is_another_and_the_first_is_what_it_always_was() -> None:
    draws = [_stream(4, "hair", attempt).random() for attempt in range(5)]
    assert len({*draws, _stream(5, "hair").random(), _stream(4, "eyes").random()}) == 7
    assert draws[0] == np.random.default_rng([4, _STREAMS.index("hair")]).random()


def refuse_first(monkeypatch: pytest.MonkeyPatch, check: str, count: int) -> None:
    """Let a gate refuse its first draws, whatever they are."""
    true_check, asked = getattr(morphable, check), itertools.count()

    def judge(*given: object) -> list[str]:
        return ["a whim"] if next(asked) < count else true_check(*given)

    monkeypatch.setattr(morphable, check, judge)


def test_a_face_that_is_refused_is_redrawn_and_all_else_about_the_person_stays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    usual = sample_parameters(1)
    refuse_first(monkeypatch, "check_face", count=usual["gate"]["redraws"] + 1)
    redrawn = sample_parameters(1)
    changed = {name for name in usual if usual[name] != redrawn[name]}
    assert changed == {"anatomy", "gate"}
    assert redrawn["gate"]["redraws"] > usual["gate"]["redraws"]
    assert redrawn["gate"]["failures"][0] == ["a whim"]


def test_hair_that_is_refused_is_redrawn_in_its_colour_on_the_same_face(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    usual = sample_parameters(1)
    refuse_first(monkeypatch, "check_hair", count=1)
    redrawn = sample_parameters(1)
    assert {name for name in usual if usual[name] != redrawn[name]} == {"hair", "gate"}
    assert redrawn["hair"]["hair_colour"] == usual["hair"]["hair_colour"]
    assert redrawn["gate"]["redraws"] == usual["gate"]["redraws"] + 1


def test_a_redrawn_person_is_the_same_one_every_time(monkeypatch: pytest.MonkeyPatch) -> None:
    people = []
    for _ in range(2):
        with monkeypatch.context() as patch:
            refuse_first(patch, "check_face", count=3)
            people.append(sample_parameters(5))
    assert people[0] == people[1]


def test_everybody_is_plausible_before_they_get_wrinkles() -> None:
    for seed in range(12):
        parameters, face = morphable._draw_person(seed, EVERYBODY)
        half_angle = parameters["appearance"]["iris"]["half_angle_rad"]
        assert check_face(face.skin, face.eyes, parameters["sex"], half_angle) == []
        assert check_hair(parameters["hair"], face.skin.astype(np.float32), seed) == []


def test_the_gate_does_not_choose_who_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    who = ("sex", "masculinity", "age", "ancestry", "appearance")
    usual = [sample_parameters(seed) for seed in range(8)]
    monkeypatch.setattr(morphable, "check_face", lambda *_: [])
    ungated = [sample_parameters(seed) for seed in range(8)]
    for one, other in zip(usual, ungated, strict=True):
        assert [one[name] for name in who] == [other[name] for name in who]


@pytest.mark.parametrize("seed", [0, 1])
def test_neither_expression_nor_texture_decides_who_is_drawn(seed: int) -> None:
    wanted = sample_parameters(seed)
    for expression, size in (("surprise", 64), ("blink", 64), ("neutral", 256)):
        head = sample_head(seed, texture_size=size, expression=EXPRESSIONS[expression])
        assert head.parameters == wanted


def test_lids_that_wrinkle_do_not_dip_into_the_eyes(heads: dict[int, Head]) -> None:
    for seed, head in heads.items():
        skin = head.part("skin").vertices.astype(np.float64)
        eyes = morphable._draw_person(seed, EVERYBODY)[1].eyes
        assert pierced_mm(skin, eyes, template().lids) < 0.1


def test_the_position_map_leads_from_texels_to_the_template() -> None:
    surface, chart = load_basis().surface, position_map(256)
    texel = np.clip((surface.uv * 256).astype(int), 0, 255)
    away = np.linalg.norm(chart.points[texel[:, 1], texel[:, 0]] - template().skin, axis=1)
    assert np.median(away) < 1.0
    assert chart.points.dtype == np.float32
    assert 0.7 < chart.mask.mean() < 0.95


def test_the_pupils_have_a_hundred_texels_between_them() -> None:
    chart = position_map(512)
    face = chart.mask & (np.abs(chart.points[..., 1] - 12) < 1) & (chart.points[..., 2] > -30)
    columns = np.arange(512)[None].repeat(512, 0)
    left = columns[face & (np.abs(chart.points[..., 0] + 32) < 1)].mean()
    right = columns[face & (np.abs(chart.points[..., 0] - 32) < 1)].mean()
    assert abs(right - left) > 85


def test_a_position_map_of_next_to_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="texture_size"):
        position_map(63)


@pytest.mark.parametrize("call", [sample_head, sample_parameters], ids=lambda f: f.__name__)
def test_a_negative_seed_is_refused(call: object) -> None:
    with pytest.raises(ValueError, match="seed must be >= 0"):
        call(-1)  # type: ignore[operator]  # both take a seed


@pytest.mark.parametrize("seed", [3.0, "3", None, True, np.array([3])], ids=str)
def test_a_seed_is_a_whole_number(seed: object) -> None:
    with pytest.raises(InputError, match=r"seed=.*: wanted a whole number"):
        sample_head(seed)  # type: ignore[arg-type]  # of a notebook
    with pytest.raises(InputError, match=r"texture_size=64\.0: wanted a whole number"):
        sample_head(3, texture_size=64.0)  # type: ignore[arg-type]


def test_a_tiny_texture_is_refused() -> None:
    with pytest.raises(ValueError, match="texture_size must be >= 64"):
        sample_head(0, texture_size=8)


def test_an_unknown_stream_is_refused() -> None:
    with pytest.raises(ValueError, match="tuple"):
        _stream(0, "voice")


def test_a_negative_seed_has_no_stream() -> None:
    with pytest.raises(ValueError, match="seed"):
        _stream(-1, "hair")
