"""What does ``lrsr identities`` leave in its folder? Portraits, who they are, how different."""

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.camera import Camera
from lrsr.evaluation.distinctness import Drawn, summarise
from lrsr.experiments.report.demographics import draw_spread, spread
from lrsr.experiments.report.figures import draw_angles
from lrsr.experiments.report.page import flat
from lrsr.experiments.report.sheets import draw_portraits
from lrsr.experiments.uniqueness import (
    Findings,
    Gallery,
    UniquenessSettings,
    find_distinct,
    gate_tally,
    make_roster,
    summary,
)
from lrsr.files import write_bytes, write_json, write_text
from lrsr.identities.roster import write_roster
from lrsr.pages import FILE, data_uri, encode_face, template
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.folder import Entry, write_manifest
from lrsr.pictures.image_files import write_png
from lrsr.pictures.maker import Maker, mitsuba_maker
from lrsr.pictures.picture import Picture
from lrsr.pictures.to_folder import Shoot, describe_picture
from lrsr.provenance import versions
from lrsr.recognition.encoders import load_encoder

SHEET = 60
"""People on the contact sheet at most: the first ones, not chosen."""
PICTURES = "gallery"
ROSTER = "roster.json"
REJECTED = 50
"""Lines of the report's table of who was redrawn, at most."""

DONE = (
    "Every picture is a gallery picture: frontal pose and light, not compressed, rendered by "
    "Mitsuba.",
    "Each person is the first of their draws that is far enough from everybody before them, so a "
    "person stays the same however many follow.",
    "Faces were cut out by the renderer's true landmarks: nobody was missed by a detector.",
)
NOT_DONE = (
    "Everyone was compared by one picture; how much a person differs from himself in other poses "
    "and lights is the question of lrsr eval.",
    "The angle is that of one network, and shared light, camera and renderer make all pictures "
    "alike to it: read it against real photographs under one light, not against an album.",
    "People of other splits were not compared with these: they cannot share a seed, but could look "
    "alike.",
)

_NAMES = {
    "min": "smallest",
    "p0_1": "0.1 %",
    "p1": "1 %",
    "p5": "5 %",
    "median": "median",
    "p95": "95 %",
    "max": "largest",
}

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Look:
    """What somebody looks like: ``(3, h, w)`` srgb, and a line under it."""

    face: NDArray[np.float32]
    caption: str


def check_uniqueness(
    settings: UniquenessSettings,
    folder: Path,
    *,
    cache: RenderCache,
    camera: Camera,
    model: Path | None = None,
    maker: Maker | None = None,
    progress: bool = True,
) -> Path:
    """Redraw look-alikes; write roster, pictures with their manifest, figures and report.

    Stopped at any moment, the same call goes on: what was rendered is in the cache.

    Args:
        settings: What is asked.
        folder: Of the run.
        cache: Where renderings are kept.
        camera: Takes every picture.
        model: ONNX embedder in place of the shipped one, with its contract beside it.
        maker: Renders; Mitsuba when None.
        progress: Show bars on stderr.

    Returns:
        ``folder``.

    Raises:
        InputError: A file or a folder is wrong, or an encoder is missing.
    """
    maker = maker or mitsuba_maker()
    encoder = load_encoder(settings.encoder, model)
    gallery = Gallery(settings, cache, encoder, camera, maker, progress=progress)
    findings = find_distinct(settings, gallery)
    roster = make_roster(settings, findings, maker.versions["identities"])
    write_roster(folder / ROSTER, roster)
    shown = {*findings.drawn[:SHEET]}
    shown |= {findings.drawn[k] for pair in findings.pairs for k in (pair.first, pair.second)}
    looks = _write_pictures(folder, gallery, findings.drawn, shown)
    made_by, gate = versions(), gate_tally(gallery, findings.drawn)
    written = {
        **summary(findings),
        "gate": gate,
        "distribution": spread(findings.people),
        "config": settings.describe(),
        "versions": made_by,
    }
    write_json(folder / "results.json", written)
    write_json(folder / "distribution.json", written["distribution"])
    figures = _write_figures(folder, settings, findings, looks)
    write_text(folder / FILE, _page(settings, findings, looks, figures, gate, made_by))
    for sentence in (*answer(settings, findings), gate_sentence(gate)):
        logger.info("%s", sentence)
    return folder


def answer(settings: UniquenessSettings, findings: Findings) -> list[str]:
    """Return what was found, in sentences."""
    angles, outcome = summarise(findings.angles_deg), findings.outcome
    people, least = len(findings.drawn), f"{settings.smallest_angle_deg:g}°"
    if angles["pairs"] == 0:
        return [f"{people} {_noun(people)}, nobody to compare with."]
    redrawn = sum(draw > 0 for draw in outcome.draws)
    sentences = [
        f"{people} people, {angles['pairs']:,} pairs: the nearest two are {angles['min']:.1f}°"
        f" apart, the median is {angles['median']:.1f}° ({settings.encoder} encoder)."
    ]
    if settings.smallest_angle_deg == 0:
        sentences.append("Nobody was redrawn, as no smallest angle was asked for.")
    elif outcome.unresolved:
        left = len(outcome.unresolved)
        sentences.append(
            f"{left} {_noun(left)} could not be brought {least} away from everybody in"
            f" {settings.most_redraws} redraws; {redrawn} redrawn."
        )
    else:
        done = "nobody had to be redrawn" if redrawn == 0 else f"{redrawn} redrawn for that"
        sentences.append(f"Everybody is at least {least} from everybody else; {done}.")
    return sentences


def gate_sentence(gate: Mapping[str, Any]) -> str:
    """Say how many people the plausibility gate drew again.

    Args:
        gate: As :func:`lrsr.identities.gate.gate.tally` counts.
    """
    people, redrawn = gate["people"], gate["redrawn"]
    said = f"{redrawn} of {people} {_noun(people)} had a face or hair drawn again as implausible"
    left = gate["unresolved"]
    return f"{said}; {left} could not be made plausible." if left else f"{said}."


def _write_pictures(
    folder: Path, gallery: Gallery, drawn: Sequence[Drawn], shown: set[Drawn]
) -> dict[Drawn, Look]:
    """Write everyone's picture and the manifest; return the looks of those who are shown."""
    rows: list[Entry] = []
    shoot = Shoot(gallery.settings.gallery, gallery.camera)
    looks: dict[Drawn, Look] = {}
    for start in range(0, len(drawn), 64):
        some = drawn[start : start + 64]
        for one, picture in zip(some, gallery.photograph(some), strict=True):
            row = describe_picture(picture, gallery.recipe(one), shoot, gallery.maker.versions)
            write_png(folder / PICTURES / row.file, picture.image)
            rows.append(replace(row, file=f"{PICTURES}/{row.file}"))
            if one in shown:
                looks[one] = Look(picture.image.numpy(), _caption(picture))
    write_manifest(folder, rows)
    return looks


def _caption(picture: Picture) -> str:
    if picture.traits is None:
        return picture.identity_id
    return f"{picture.identity_id}  {picture.traits.sex[0]} {picture.traits.age_years:.0f}"


def _write_figures(
    folder: Path, settings: UniquenessSettings, findings: Findings, looks: Mapping[Drawn, Look]
) -> dict[str, str | None]:
    """Write the PNG files; return those that the report holds, too, as data URIs."""
    sheet = [looks[one] for one in findings.drawn[:SHEET]]
    portraits = draw_portraits(
        [look.face for look in sheet],
        [look.caption for look in sheet],
        columns=math.ceil(math.sqrt(1.6 * len(sheet))),  # about as wide as a screen
    )
    write_bytes(folder / "contact_sheet.png", portraits)
    figures: dict[str, bytes] = {}
    if findings.people:
        figures["distribution"] = draw_spread(findings.people)
    if len(findings.angles_deg):
        least = settings.smallest_angle_deg
        figures["angles"] = draw_angles(findings.angles_deg, least, settings.encoder)
        write_bytes(folder / "nearest_pairs.png", _draw_pairs(findings, looks))
    for name, png in figures.items():
        write_bytes(folder / f"{name}.png", png)
    return {
        name: data_uri(figures[name]) if name in figures else None
        for name in ("distribution", "angles")
    }


def _draw_pairs(findings: Findings, looks: Mapping[Drawn, Look]) -> bytes:
    faces, captions = [], []
    for pair in findings.pairs:
        first, second = (looks[findings.drawn[k]] for k in (pair.first, pair.second))
        faces += [first.face, second.face]
        captions += [f"{pair.angle_deg:.1f}°   {first.caption}", second.caption]
    return draw_portraits(faces, captions, columns=4, group=2)


def _page(
    settings: UniquenessSettings,
    findings: Findings,
    looks: Mapping[Drawn, Look],
    figures: Mapping[str, str | None],
    gate: Mapping[str, Any],
    made_by: Mapping[str, str],
) -> str:
    small = {
        one: {"face": encode_face(_halved(look.face)), "caption": look.caption}
        for one, look in looks.items()
    }
    found = summary(findings)
    rows = [("after redraws", found["angles_deg"]), ("first draws", found["first_angles_deg"])]
    return template("identities.html.j2").render(
        title=f"{len(findings.drawn)} {_noun(len(findings.drawn))}",
        answer=[*answer(settings, findings), gate_sentence(gate)],
        portraits=[small[one] for one in findings.drawn[:SHEET]],
        distribution_figure=figures["distribution"],
        angles_figure=figures["angles"],
        angle_names=list(_NAMES.values()),
        angle_rows=[
            (label, [f"{angles[name]:.1f}" for name in _NAMES])
            for label, angles in rows
            if angles["pairs"]
        ],
        pairs=[
            {
                "first": small[findings.drawn[pair.first]],
                "second": small[findings.drawn[pair.second]],
                "angle": f"{pair.angle_deg:.1f}",
            }
            for pair in findings.pairs
        ],
        rejected=found["rejected"][:REJECTED],
        rejected_left_out=max(0, len(found["rejected"]) - REJECTED),
        gate=gate,
        done=DONE,
        not_done=NOT_DONE,
        settings=list(flat(_settings(settings, findings))),
        versions=made_by,
        commit=made_by["git"],
        seed=settings.gallery.seed,
    )


def _settings(settings: UniquenessSettings, findings: Findings) -> dict[str, Any]:
    return {**settings.describe(), "recognition": dict(findings.encoder)}


def _halved(face: NDArray[np.float32]) -> NDArray[np.float32]:
    """Average 2 x 2 pixels, for a report of bearable size."""
    _, height, width = face.shape
    even = face[:, : height // 2 * 2, : width // 2 * 2]
    halved = even.reshape(3, height // 2, 2, width // 2, 2).mean(axis=(2, 4))
    return np.asarray(halved, dtype=np.float32)


def _noun(count: int) -> str:
    return "person" if count == 1 else "people"
