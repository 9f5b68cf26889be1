"""What does ``lrsr identities`` leave in its folder? Portraits, who they are, how different."""

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from torch.nn.functional import avg_pool2d

from lrsr.evaluation.distinctness import Drawn, summarise
from lrsr.experiments.report.demographics import draw_spread, spread
from lrsr.experiments.report.figures import draw_angles
from lrsr.experiments.report.sheets import draw_portraits
from lrsr.experiments.uniqueness import (
    Findings,
    Gallery,
    UniquenessSettings,
    find_distinct,
    make_roster,
    summary,
)
from lrsr.files import write_bytes, write_json
from lrsr.identities.gate.gate import tally
from lrsr.identities.roster import write_roster
from lrsr.pages import encode_face, png_uri, write_page
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.folder import write_manifest
from lrsr.pictures.image_files import write_png
from lrsr.pictures.maker import Maker, MitsubaMaker
from lrsr.pictures.picture import Picture
from lrsr.pictures.source import chunks
from lrsr.pictures.to_folder import Shoot
from lrsr.provenance import versions
from lrsr.recognition.memory import Memory
from lrsr.recognition.recognisers import load_encoder

_SHEET = 60
"""People on the contact sheet at most: the first ones, not chosen."""
_PICTURES = "gallery"

_REDRAWN = (
    "Each person is the first of their draws that is far enough from everybody before them, so a "
    "person stays the same however many follow."
)
_OTHERS = (
    "People of other splits were not compared with these: they cannot share a seed, but could look "
    "alike."
)
_DONE = (
    "Every picture is a gallery picture: frontal pose and light, not compressed, rendered by "
    "Mitsuba.",
    _REDRAWN,
    "Faces were cut out by the renderer's true landmarks: nobody was missed by a detector.",
)
_NOT_DONE = (
    "Everyone was compared by one picture; how much a person differs from himself in other poses "
    "and lights is the question of lrsr eval.",
    "The angle is that of one network, and shared light, camera and renderer make all pictures "
    "alike to it: read it against real photographs under one light, not against an album.",
    _OTHERS,
)
_OF_DRAWN = (_REDRAWN, _OTHERS)

logger = logging.getLogger(__name__)


class Uniqueness(UniquenessSettings):
    """Redraws look-alikes, and shows who is left; of photographed people it tells who is alike."""

    @property
    def photographed(self) -> bool:
        """Whether they are people on photographs, who are not drawn again."""
        return self.gallery.people.photographs is not None

    def run(
        self,
        folder: Path,
        cache: RenderCache,
        *,
        maker: Maker | None = None,
        progress: bool = True,
    ) -> Path:
        """Write roster, pictures with their manifest, figures and report into ``folder``.

        There is no roster of photographed people.

        Stopped at any moment, the same call goes on: what was rendered is in the cache.

        Args:
            folder: Of the run.
            cache: Where renderings are kept.
            maker: Renders; Mitsuba when None.
            progress: Show bars on stderr.

        Raises:
            InputError: A file or a folder is wrong, or an encoder is missing.
        """
        maker = maker or MitsubaMaker()
        memory = Memory(cache.folder / "recognition")
        encoder = load_encoder(self.encoder, self.model, device=self.device, memory=memory)
        gallery = Gallery(self, cache, encoder, maker, progress=progress)
        findings = find_distinct(self, gallery)
        if not self.photographed:
            roster = make_roster(self, findings, maker.versions["identities"])
            write_roster(folder / "roster.json", roster)
        portraits = _write_pictures(folder, gallery, findings)
        results = {
            **summary(findings),
            "encoder": dict(encoder.describe()),
            "gate": tally(person.gate for person in findings.people if person.gate),
            "distribution": spread(findings.people),
            "config": self.describe(),
            "versions": versions(),
        }
        write_json(folder / "results.json", results)
        write_json(folder / "distribution.json", results["distribution"])
        figures = _write_figures(folder, self, findings, portraits)
        gate = [] if self.photographed else [_gate_sentence(results["gate"])]
        said = [*_answer(self, findings), *gate]
        untrue = _OF_DRAWN if self.photographed else ()
        _write_page(folder, results, findings, portraits, figures, said, untrue)
        for sentence in said:
            logger.info("%s", sentence)
        return folder


def _answer(settings: Uniqueness, findings: Findings) -> list[str]:
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
    if settings.photographed:
        return [*sentences, _one_person(findings, settings.smallest_angle_deg)]
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


def _one_person(findings: Findings, least_deg: float) -> str:
    """Say which photographed people look like one person under two names."""
    near = [
        " and ".join(findings.names[findings.drawn[k]] for k in (pair.first, pair.second))
        for pair in findings.pairs
        if pair.angle_deg < least_deg
    ]
    if not near:
        return f"Nobody is nearer than {least_deg:g}° to another."
    return f"Nearer than {least_deg:g}°, so perhaps one person by two names: {'; '.join(near)}."


def _gate_sentence(gate: Mapping[str, Any]) -> str:
    """Say how many people the plausibility gate drew again.

    Args:
        gate: As :func:`lrsr.identities.gate.gate.tally` counts.
    """
    people, redrawn = gate["people"], gate["redrawn"]
    return f"{redrawn} of {people} {_noun(people)} had a face or hair drawn again as implausible."


def _write_pictures(folder: Path, gallery: Gallery, findings: Findings) -> dict[Drawn, Picture]:
    """Write everyone's picture and the manifest; return the pictures that are shown."""
    drawn, rows = findings.drawn, []
    shown = {
        *drawn[:_SHEET],
        *(drawn[k] for pair in findings.pairs for k in (pair.first, pair.second)),
    }
    source = gallery.source(drawn)
    shoot = Shoot(gallery.settings.gallery, source.camera)
    portraits: dict[Drawn, Picture] = {}
    for place, pictures in chunks(source):
        for one, picture in zip(drawn[place], pictures, strict=True):
            row = shoot.entry(picture, gallery.recipe(one), gallery.maker.versions)
            row = replace(row, file=f"{_PICTURES}/{row.file}")
            write_png(folder / row.file, picture.image)
            rows.append(row)
            if one in shown:
                portraits[one] = picture
    write_manifest(folder, rows)
    return portraits


def _caption(picture: Picture) -> str:
    who = picture.traits
    return " ".join([picture.identity_id, *([f" {who.sex[0]} {who.age_years:.0f}"] if who else [])])


def _write_figures(
    folder: Path,
    settings: UniquenessSettings,
    findings: Findings,
    portraits: Mapping[Drawn, Picture],
) -> dict[str, str]:
    """Write the PNG files; return them as data URIs by name."""
    sheet = [portraits[one] for one in findings.drawn[:_SHEET]]
    figures = {
        "contact_sheet": draw_portraits(
            [one.image for one in sheet],
            [_caption(one) for one in sheet],
            columns=math.ceil(math.sqrt(1.6 * len(sheet))),  # about as wide as a screen
        )
    }
    if findings.people:
        figures["distribution"] = draw_spread(findings.people)
    if len(findings.angles_deg):
        least = settings.smallest_angle_deg
        figures["angles"] = draw_angles(findings.angles_deg, least, settings.encoder)
        figures["nearest_pairs"] = _draw_pairs(findings, portraits)
    for name, png in figures.items():
        write_bytes(folder / f"{name}.png", png)
    return {name: png_uri(png) for name, png in figures.items()}


def _draw_pairs(findings: Findings, portraits: Mapping[Drawn, Picture]) -> bytes:
    faces, captions = [], []
    for pair in findings.pairs:
        first, second = (portraits[findings.drawn[k]] for k in (pair.first, pair.second))
        faces += [first.image, second.image]
        captions += [f"{pair.angle_deg:.1f}°   {_caption(first)}", _caption(second)]
    return draw_portraits(faces, captions, columns=4, group=2)


def _write_page(
    folder: Path,
    results: Mapping[str, Any],
    findings: Findings,
    portraits: Mapping[Drawn, Picture],
    figures: Mapping[str, str],
    said: Sequence[str],
    untrue: Sequence[str],
) -> None:
    """Write the page; its pictures are halved, so that its size can be borne."""
    small = {
        one: {"face": encode_face(avg_pool2d(picture.image, 2)), "caption": _caption(picture)}
        for one, picture in portraits.items()
    }
    write_page(
        folder,
        "identities",
        title=f"{len(findings.drawn)} {_noun(len(findings.drawn))}",
        question="Is everybody somebody else, and who are they?",
        answer=said,
        results=results,
        figures=figures,
        portraits=[small[one] for one in findings.drawn[:_SHEET]],
        pairs=[
            [
                *(small[findings.drawn[k]] for k in (pair.first, pair.second)),
                f"{pair.angle_deg:.1f}",
            ]
            for pair in findings.pairs
        ],
        done=[one for one in _DONE if one not in untrue],
        not_done=[one for one in _NOT_DONE if one not in untrue],
        settings={**results["config"], "recognition": results["encoder"]},
        versions=results["versions"],
        seed=results["config"]["seed"],
    )


def _noun(count: int) -> str:
    return "person" if count == 1 else "people"
