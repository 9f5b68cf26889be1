"""How would a case's recogniser score other people in its place? They are rendered and compared."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from lrsr.camera import Camera
from lrsr.configuration import as_list, as_mapping, as_number, as_word, require
from lrsr.evaluation.likelihood import split_ids
from lrsr.evaluation.score_files.system import Name, System
from lrsr.experiments.systems import Comparer, Comparison
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.pictures.sitting import Sitting, read_quality
from lrsr.pictures.source import Rendered, render_sources
from lrsr.presets import value_of
from lrsr.rendering.scene import Film, Scene

if TYPE_CHECKING:
    from omegaconf import DictConfig

_SCENE = ("pose", "lighting", "lens", "standpoint", "expression", "another_day")


@dataclass(frozen=True)
class Simulation:
    """People before the case's camera, and before others.

    Attributes:
        probes: As in the case.
        gallery: As they are enrolled.
        camera: Of the case.
        generic: By name, other ways to picture those who are calibrated on, by turns, by the
            reference camera.
        cache: Where renderings are kept.
        maker: Renders; Mitsuba when None.
        progress: Show bars.
    """

    probes: Sitting
    gallery: Sitting
    camera: Camera
    generic: Mapping[str, Sequence[Sitting]]
    cache: RenderCache
    maker: Maker | None = None
    progress: bool = True

    def render(self) -> int:
        """Render whatever the cache lacks; return how many pictures that were."""
        generic = [self.generic_probes(name) for name in self.generic]
        return render_sources([self.enrolled, self.seen, *generic])

    @property
    def seen(self) -> Rendered:
        """Everybody as in the case."""
        return self._rendered(self.probes, self.camera)

    @property
    def enrolled(self) -> Rendered:
        """Everybody's enrolled picture."""
        return self._rendered(self.gallery, self.camera.clean())

    def generic_probes(self, name: str) -> Rendered:
        """Return those who are calibrated on, in one of some ways, by turns."""
        ways, everybody = self.generic[name], self.probes.people.people()
        chosen = {*split_ids([person.id for person in everybody], self.probes.seed)[0]}
        people = [person for person in everybody if person.id in chosen]
        recipes = [ways[k % len(ways)].recipe(person) for k, person in enumerate(people)]
        return Rendered(recipes, Camera(), self.cache, self.maker, self.progress)

    def scores(self, comparer: Comparer) -> tuple[list[Comparison], dict[str, dict[Name, System]]]:
        """Return how everybody scores in the case, and by name in each other way."""
        ipd_px = self.probes.film.ipd_px
        case = comparer.compare(self.seen, self.enrolled, ipd_px=ipd_px)
        generic = {}
        for name in self.generic:
            found = comparer.compare(self.generic_probes(name), self.enrolled, ipd_px=ipd_px)
            generic[name] = {one.name: one.system for one in found}
        return case, generic

    def _rendered(self, sitting: Sitting, camera: Camera) -> Rendered:
        return Rendered(sitting.recipes(), camera, self.cache, self.maker, self.progress)


def read_generic(config: "DictConfig", probes: Sitting) -> dict[str, tuple[Sitting, ...]]:
    """Read the ways in which people are pictured who know nothing of the case.

    Raises:
        InputError: A value is wrong.
    """
    found = {}
    for name, ways in as_mapping(config.generic, "generic").items():
        sittings = []
        for k, way in enumerate(as_list(ways, f"generic.{name}")):
            place = f"generic.{name}.{k}"
            node = dict(as_mapping(way, place))
            ipd_px = as_number(node.pop("ipd_px", probes.film.ipd_px), f"{place}.ipd_px")
            require(ipd_px >= 4, f"{place}.ipd_px", ipd_px, "at least 4")
            for group in node:
                known = f"one of ipd_px, {', '.join(_SCENE)}"
                require(group in _SCENE, place, group, known)
            values = {group: value_of(group, node[group]) for group in node}
            scene = Scene(**{"lighting": value_of("lighting", "frontal"), **values})
            quality = read_quality(config).at(ipd_px)
            sittings.append(replace(probes, scene=scene, film=Film(ipd_px), quality=quality))
        require(bool(sittings), f"generic.{name}", [], "at least one way to picture people")
        found[as_word(name, "generic")] = tuple(sittings)
    return found
