"""Where does a lens draw what it sees? Distorted, and each colour in a size of its own."""

from dataclasses import dataclass

import torch

from lrsr.camera.distortion import Distortion
from lrsr.camera.image_plane import mm_to_pixels, pixel_grid, pixels_to_mm
from lrsr.resampling import sample_bicubic


@dataclass(frozen=True)
class Warp:
    """Distortion and lateral colour.

    Attributes:
        distortion: Of the lens; also holds where the sensor's edge is.
        lateral_colour_um: How far outwards each colour lies at that edge, µm.
    """

    distortion: Distortion
    lateral_colour_um: tuple[float, ...] = (0.0, 0.0, 0.0)

    @property
    def is_off(self) -> bool:
        """Does everything come to lie where a pinhole camera draws it?"""
        return self.distortion.is_off and not any(self.lateral_colour_um)

    def draw(self, film: torch.Tensor, field: torch.Tensor, pitch_mm: float) -> torch.Tensor:
        """Draw the picture of a crop: each of its pixels looks where its light comes from.

        Args:
            film: ``(B, C, H, W)``, what a pinhole camera shows; C as many as colours.
            field: ``(1, 2)`` or ``(B, 2)``, the crop's middle on the sensor, mm from the axis.
            pitch_mm: Of the film's pixels, mm.

        Returns:
            ``(B, C, H, W)``; light per area of the picture, so that a flat scene stays flat;
            ``film`` itself if all is off.
        """
        if self.is_off:
            return film
        size, centre = (film.shape[-2], film.shape[-1]), field[:, None, None, None]
        sensor = pixels_to_mm(pixel_grid(size, film), size, pitch_mm, centre)
        if any(self.lateral_colour_um):
            outwards = film.new_tensor(self.lateral_colour_um) / 1000 / self.distortion.radius_mm
            sensor = sensor / (1 + outwards[:, None, None, None])
        scene = self.distortion.to_film(sensor, centre)
        return sample_bicubic(film, mm_to_pixels(scene, size, pitch_mm, torch.zeros_like(centre)))

    def move_points(
        self,
        points_px: torch.Tensor,
        size: tuple[int, int],
        field: torch.Tensor,
        pitch_mm: float,
    ) -> torch.Tensor:
        """Return where points of the film come to lie in the picture, in the middle colour.

        Args:
            points_px: ``(..., 2)`` (x, y), film pixels.
            size: (height, width) of the film.
            field: The crop's middle on the sensor, mm from the axis; broadcasts with the points.
            pitch_mm: Of the film's pixels, mm.

        Returns:
            ``(..., 2)``.
        """
        film = pixels_to_mm(points_px, size, pitch_mm, torch.zeros_like(field))
        return mm_to_pixels(self.distortion.to_sensor(film, field), size, pitch_mm, field)
