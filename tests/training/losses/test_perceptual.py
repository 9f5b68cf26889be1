from pathlib import Path
from typing import Any

import pytest
import torch
from safetensors.torch import save_file
from torch import nn
from torchvision.models import vgg11

from lrsr.errors import InputError
from lrsr.training.losses.perceptual import PerceptualLoss

LAYER = 6  # the third convolution


@pytest.fixture(scope="module")
def vgg() -> nn.Module:
    """Nine million random numbers in place of ImageNet's."""
    with torch.device("meta"):
        network = vgg11(weights=None)
    generator = torch.Generator().manual_seed(0)
    network.features.load_state_dict(
        {
            name: torch.randn(p.shape, generator=generator) * 0.05
            for name, p in network.features.state_dict().items()
        },
        assign=True,
    )
    return network


@pytest.fixture(scope="module", params=[".pth", ".safetensors"])
def weights(
    vgg: Any, request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    path = tmp_path_factory.mktemp("vgg") / f"vgg11{request.param}"
    state = {f"features.{name}": value for name, value in vgg.features.state_dict().items()}
    if request.param == ".pth":
        torch.save(state | {"classifier.0.bias": torch.zeros(1)}, path)
    else:
        save_file(state, path)
    return path


def made(path: Path, **changes: Any) -> PerceptualLoss:
    given = {"weight": 1, "weights": path, "network": "vgg11", "layer": LAYER}
    return PerceptualLoss(**{**given, **changes})


def pictures(seed: int) -> torch.Tensor:
    return torch.rand(2, 3, 16, 20, generator=torch.Generator().manual_seed(seed))


def test_it_is_the_difference_of_torchvisions_features(vgg: Any, weights: Path) -> None:
    mean = torch.tensor([0.485, 0.456, 0.406]).view(3, 1, 1)
    deviation = torch.tensor([0.229, 0.224, 0.225]).view(3, 1, 1)
    with torch.no_grad():
        restored, true = (
            vgg.features[: LAYER + 1]((pictures(seed) - mean) / deviation) for seed in (0, 1)
        )
        found = made(weights)(pictures(0), pictures(1))
    assert float(found) == pytest.approx(float((restored - true).abs().mean()), rel=1e-5)


def test_the_true_picture_loses_nothing_and_others_have_a_gradient(weights: Path) -> None:
    loss, restored = made(weights), pictures(1).requires_grad_()
    assert float(loss(pictures(0), pictures(0))) == 0
    loss(restored, pictures(0)).backward()
    assert restored.grad is not None
    assert float(restored.grad.abs().max()) > 0


def test_what_it_looks_with_is_in_no_checkpoint(weights: Path) -> None:
    assert not made(weights).state_dict()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"weight": -1}, "module.losses.perceptual.weight=-1: wanted at least 0"),
        ({"network": "vgg12"}, "module.losses.perceptual.network=vgg12: wanted one of vgg11"),
        ({"network": "vgg13"}, "is not of torchvision's vgg13"),
        ({"layer": 21}, "module.losses.perceptual.layer=21: wanted 0 to 20, a layer of vgg11"),
        ({"layer": "last"}, "module.losses.perceptual.layer=last: wanted a whole number"),
        ({"weights": "nowhere.pth"}, r"nowhere\.pth: no weights of torchvision"),
    ],
    ids=str,
)
def test_a_wrong_setting_is_named(wrong: dict[str, Any], message: str, weights: Path) -> None:
    with pytest.raises(InputError, match=message):
        made(weights, **wrong)


def test_a_file_of_other_things_is_refused(tmp_path: Path) -> None:
    torch.save([1, 2], tmp_path / "list.pth")
    with pytest.raises(InputError, match=r"list\.pth: no weights of torchvision; get it again"):
        made(tmp_path / "list.pth")
