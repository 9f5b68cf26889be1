"""What happens where a path meets translucent skin? The two ways it can go on, and their light."""

from typing import Any

from lrsr.rendering.backend import dr, mi
from lrsr.rendering.diffusion import curved_gain
from lrsr.rendering.exit_points import find_exit
from lrsr.rendering.painted_skin import PaintedSkin


class SkinVertex:
    """What happens at a point of skin: light is reflected there, and enters at another point.

    Both are lit at every vertex; the path goes on by one of them.

    Attributes:
        interaction: Where light enters; off skin, the point itself.
        enters: Whether there is such a point.
    """

    def __init__(
        self, tracer: PaintedSkin, scene: Any, sampler: Any, si: Any, ray: Any, skin: Any
    ) -> None:
        self._reflection = tracer.reflection
        self._skin = skin
        albedo, self._roughness = tracer.look_up(si, skin)
        side = dr.mulsign(mi.Float(1), -dr.dot(si.n, ray.d))  # both sides of a sheet are skin
        self._here = mi.Frame3f(side * tracer.normal(si, skin))
        self._view = self._here.to_local(-ray.d)
        reflected = self._reflection.directional(self._view.z, self._roughness)
        self._entering = 1 - self._reflection.mean(self._roughness)
        albedo = dr.clip(albedo / self._entering, 0, 1)
        least = tracer.least_lobe_share
        scattered = (1 - reflected) * dr.mean(albedo)
        share = dr.clip(reflected / (reflected + scattered), least, 1 - least)
        self._share = dr.select(self._view.z > 0, share, 0)

        profile = tracer.profile(albedo, si.wavelengths)
        how = (profile, tracer.find, tracer.normal_share, skin)
        entry, weight = find_exit(scene, sampler, si, side * si.sh_frame.n, *how)
        bend = _curvature(si, entry, side)
        gain = curved_gain(albedo, bend * profile.mean_free_path_mm)
        self._through = weight * albedo * gain * (1 - reflected)
        self.enters = dr.any(self._through != 0)
        self.interaction = dr.select(
            skin & self.enters, mi.Interaction3f(entry), mi.Interaction3f(si)
        )
        self._there = mi.Frame3f(side * tracer.normal(entry, skin & self.enters))

    def reflect(self, direction: Any) -> tuple[Any, Any]:
        """Return the lobe times cos θ for light from there, and the density of drawing it."""
        light = self._here.to_local(direction)
        value, density = self._reflection.eval_pdf(self._view, light, self._roughness)
        return value, self._share * density

    def enter(self, direction: Any) -> tuple[Any, Any]:
        """Return what of that light enters and comes back, and the density of drawing it."""
        cosine = dr.maximum(dr.dot(self._there.n, direction), 0)
        value = self._through * (self._entered(cosine) * cosine * dr.inv_pi)
        return value, (1 - self._share) * cosine * dr.inv_pi

    def sample(self, choice: Any, uniform: Any) -> tuple[Any, Any, Any, Any]:
        """Draw how the path goes on.

        Args:
            choice: Of the two ways, [0, 1).
            uniform: Two numbers in [0, 1).

        Returns:
            The direction, its density, value over density, and whether skin reflected it.
        """
        mirrors = self._skin & (choice < self._share)
        out, lobe_density, lobe = self._reflection.sample(self._view, self._roughness, uniform)
        into = mi.warp.square_to_cosine_hemisphere(uniform)
        other = 1 - self._share
        density = dr.select(mirrors, self._share * lobe_density, other * into.z * dr.inv_pi)
        through = self._through * (self._entered(into.z) / other)
        weight = dr.select(mirrors, mi.Spectrum(lobe / self._share), through)
        direction = dr.select(mirrors, self._here.to_world(out), self._there.to_world(into))
        return direction, density, weight, mirrors

    def _entered(self, cosine: Any) -> Any:
        return (1 - self._reflection.directional(cosine, self._roughness)) / self._entering


def _curvature(here: Any, there: Any, side: Any) -> Any:
    """Return one over the radius of the circle through two points with their normals, mm⁻¹."""
    offset = there.p - here.p
    turned = side * dr.dot(there.sh_frame.n - here.sh_frame.n, offset)
    return turned / (dr.squared_norm(offset) + 1e-2)  # nearer than 0.1 mm it is noise
