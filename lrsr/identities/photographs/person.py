"""Who was photographed? Somebody by the checksum of the picture, usable wherever people are.

``lrsr reconstruct`` writes ``people.json``: which pictures of a folder can be reconstructed, where
the faces are on them, and how they are to be reconstructed. ``identities.photographs=FOLDER`` then
names these people to any command. The pictures stay where they are and must not change.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from lrsr.configuration import require
from lrsr.errors import InputError
from lrsr.files import read_bytes
from lrsr.identities.day.another_day import SAME_DAY, AnotherDay
from lrsr.identities.face.expression import Expression
from lrsr.identities.head import Head
from lrsr.identities.person import Person
from lrsr.identities.photographs.choices import HAIRS, KEPT, PHOTOGRAPHS_VERSION, Hair, Kept
from lrsr.identities.population import EVERYBODY

if TYPE_CHECKING:
    from lrsr.identities.photographs.reconstruct import Reconstruction

RECORD = "people.json"
FORMAT = 2
HALVES = ("development", "test")
_WORN = ("name", "day", "glasses", "cap", "face_mask")
"""What another day can bring to a photographed person."""

Five = tuple[tuple[float, float], ...]


class Network(NamedTuple):
    """A reconstructor of the user's: its ONNX file, and the checksum of all that belongs to it."""

    file: str
    sha256: str


@dataclass(frozen=True)
class Photographed:
    """Somebody on a photograph.

    Attributes:
        file: Absolute path of the picture.
        sha256: Of its bytes.
        five_px: ``(x, y)`` of eyes, nose and corners of the mouth on it.
        hair: "painted" or "none".
        expression: The "photograph"'s or "neutral".
        who: Their name; empty: they are called after the picture.
        others: Further photographs of the same person.
        reconstructor: The network that finds the face; None: the one that ships.
    """

    file: str
    sha256: str
    five_px: Five
    hair: Hair = "painted"
    expression: Kept = "photograph"
    reconstructor: Network | None = None
    who: str = ""
    others: "tuple[Photographed, ...]" = ()

    split = "photograph"
    """Of no split: nobody was drawn."""
    draw = 0
    population = EVERYBODY

    @property
    def id(self) -> str:
        """Stable name.

        Example:
            >>> Photographed("/a.png", "0123456789abcdef", ()).id
            'photograph-0123456789ab'
        """
        return self.who or f"{self.split}-{self.sha256[:12]}"

    @property
    def half(self) -> str:
        """Of all people "development" or "test", by their name: a picture more changes nothing.

        Example:
            >>> [Photographed("a.png", "", (), who=name).half for name in ("ann", "kim")]
            ['test', 'development']
        """
        return HALVES[hashlib.sha256(self.id.encode()).digest()[0] % 2]

    @property
    def index(self) -> int:
        """A number that all chance about this person follows from."""
        return int(self.sha256[:9], 16)

    def record(self) -> dict[str, Any]:
        """Return what makes this person's head, in plain values; neither name nor place does."""
        return {
            "photograph": self.sha256,
            "five_px": [list(point) for point in self.five_px],
            "hair": self.hair,
            "expression": self.expression,
            "version": PHOTOGRAPHS_VERSION,
        } | ({"reconstructor": self.reconstructor.sha256} if self.reconstructor else {})

    def reconstruction(self, texture_size: int) -> "Reconstruction":
        """Reconstruct this person; those of the last two are kept.

        Args:
            texture_size: Of the skin's albedo, px.

        Raises:
            InputError: The picture or the network is missing or was changed, or no face can be
                fitted.
        """
        return _reconstructed(self, texture_size)

    def head(
        self, expression: Expression, texture_size: int, another_day: AnotherDay = SAME_DAY
    ) -> Head:
        """Build the head.

        Args:
            expression: What the face does beyond what it keeps of the photograph.
            texture_size: Of the albedo, px.
            another_day: What is worn.

        Raises:
            InputError: The picture is missing or was changed, or the day changes what nobody knows
                of a photographed person.
        """
        for name, value in another_day.record().items():
            usual = getattr(SAME_DAY, name)
            wish = "as it is: a photographed person can only wear glasses, cap and face_mask"
            require(name in _WORN or value == usual, f"another_day.{name}", value, wish)
        made = self.reconstruction(texture_size)
        return made.head(self.id, self.record(), expression, another_day, self.index)


Somebody = Person | Photographed
"""Who can be made."""


@lru_cache(maxsize=2)
def _reconstructed(person: Photographed, texture_size: int) -> "Reconstruction":
    """Reconstruct somebody; the last two are kept, as one person is pictured many times.

    Raises:
        InputError: See :meth:`Photographed.reconstruction`.
    """
    from lrsr.identities.photographs.picture_file import decode, frame
    from lrsr.identities.photographs.reconstruct import reconstruct
    from lrsr.identities.photographs.reconstructor import shared_reconstructor

    try:
        content = read_bytes(Path(person.file))
    except OSError as error:
        why = error.strerror or error
        raise InputError(f"cannot read {person.file}: {why}; put it back") from error
    if hashlib.sha256(content).hexdigest() != person.sha256:
        raise InputError(f"{person.file} was changed: run lrsr reconstruct again")
    network = person.reconstructor
    reconstructor = shared_reconstructor(Path(network.file) if network else None)
    if network and reconstructor.digest != network.sha256:
        raise InputError(f"{network.file} was changed: run lrsr reconstruct again")
    photograph = frame(decode(content, person.file), np.array(person.five_px))
    return reconstruct(
        photograph,
        reconstructor=reconstructor,
        texture_size=texture_size,
        hair=person.hair,
        kept=person.expression,
    )


def read_photographed(folder: Path) -> tuple[Photographed, ...]:
    """Read who of a folder of ``lrsr reconstruct`` can be made, in order.

    The first photograph of a person makes the head; the others are beside it.

    Args:
        folder: With ``people.json``.

    Raises:
        InputError: There is no such file, or it is none of ours.
    """
    path = folder / RECORD
    try:
        content = json.loads(read_bytes(path))
    except OSError as error:
        remedy = f"lrsr reconstruct images=PICTURES out={folder} makes one"
        raise InputError(f"identities.photographs={folder}: no {RECORD} there; {remedy}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is no JSON: run lrsr reconstruct again") from error
    try:
        require(content["format"] == FORMAT, f"{path} format", content["format"], str(FORMAT))
        taken = [photographed_from(one) for one in content["people"]]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path} is no record of this version: run lrsr reconstruct again") from (
            error
        )
    if not taken:
        raise InputError(f"identities.photographs={folder}: nobody there could be reconstructed")
    people: dict[str, list[Photographed]] = {}
    for one in taken:
        people.setdefault(one.id, []).append(one)
    return tuple(replace(first, others=tuple(more)) for first, *more in people.values())


def photographed_from(told: Mapping[str, Any]) -> Photographed:
    """Return somebody as ``people.json`` has them.

    Raises:
        InputError: There is no such hair or expression.
    """
    require(told["hair"] in HAIRS, "hair", told["hair"], " or ".join(HAIRS))
    require(told["expression"] in KEPT, "expression", told["expression"], " or ".join(KEPT))
    five = tuple((float(x), float(y)) for x, y in told["five_px"])
    return Photographed(
        file=str(told["file"]),
        sha256=str(told["sha256"]),
        five_px=five,
        hair=cast("Hair", told["hair"]),
        expression=cast("Kept", told["expression"]),
        who=str(told["who"]),
        reconstructor=_network(told.get("reconstructor")),
    )


def _network(told: dict[str, str] | None) -> Network | None:
    return None if told is None else Network(str(told["file"]), str(told["sha256"]))
