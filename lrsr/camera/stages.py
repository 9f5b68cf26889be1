"""What does a picture look like after each stage of the camera? One photograph, step by step."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import torch
from torch import nn
from torch.nn import functional as F

from lrsr.camera.bayer import colour_of_sites, shifted
from lrsr.camera.exposure import expose
from lrsr.camera.optics import bin_pixels
from lrsr.images import linear_to_srgb

if TYPE_CHECKING:
    from lrsr.camera.camera import Camera
    from lrsr.spectra import Spectrum


def show_stages(
    camera: "Camera",
    linear: torch.Tensor,
    metered: torch.Tensor,
    seeds: Sequence[int] | None = None,
    spectrum: "Spectrum | None" = None,
) -> dict[str, torch.Tensor]:
    """Take a picture and keep what it looks like on the way.

    Args:
        camera: Takes it.
        linear: See :meth:`lrsr.camera.camera.Camera.forward`, as all below.
        metered: ``(B,)``.
        seeds: One for each image.
        spectrum: Of spectral bands.

    Returns:
        By the name of each step, in order, srgb ``(B, 3, H, W)`` to look at, of the last exposure:
        "film" (as fine as it comes), "lens", "pixels", "raw" (each photosite in its filter's
        colour, with noise), "interpolated", "colours" (balanced, through the matrix), "processed",
        "stored" (the camera's own file), "picture" (what the camera returns). Steps that the camera
        does not have are left out.

    Raises:
        ImageContractError: The images break the contract.
        InputError: A noisy camera got no seeds, or measured filters got three colours.
        NonFiniteError: A NaN or an infinity in the images.
    """
    made: dict[str, torch.Tensor] = {}
    stages = list(camera.named_children())
    hooks = [stage.register_forward_hook(partial(_keep, made, name)) for name, stage in stages]
    try:
        picture = camera(linear, metered, seeds, spectrum)
    finally:
        for hook in hooks:
            hook.remove()
    light = expose(camera.see(linear, spectrum), metered, camera.exposure_ev)
    steps = {"film": light}
    if "optics" in made:
        steps["lens"] = light = made["optics"]
    if camera.supersampling > 1:
        steps["pixels"] = bin_pixels(light, camera.supersampling)
    if camera.sensor is not None:
        steps["raw"] = _in_colours(camera, camera.sensor.light(made["sensor"]))
    names = {"mosaic": "interpolated", "colour": "colours"}
    steps |= {step: made[stage] for stage, step in names.items() if stage in made}
    shown = {step: linear_to_srgb(image) for step, image in steps.items()}
    names = {"processing": "processed", "stored": "stored"}
    shown |= {step: made[stage] for stage, step in names.items() if stage in made}
    if camera.stored is None or camera.quality is not None:
        shown["picture"] = picture
    return shown


def _keep(
    made: dict[str, torch.Tensor], name: str, _stage: nn.Module, _given: Any, result: torch.Tensor
) -> None:
    made[name] = result


def _in_colours(camera: "Camera", light: torch.Tensor) -> torch.Tensor:
    """Return the light of each photosite in its filter's colour, ``(B, 3, H, W)``."""
    if camera.mosaic is None:
        return light
    pattern = shifted(camera.mosaic.pattern, camera.origin_px)
    sites = colour_of_sites(pattern, (light.shape[-2], light.shape[-1]), light.device)
    return light * F.one_hot(sites, 3).permute(2, 0, 1).to(light)
