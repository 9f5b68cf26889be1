import numpy as np
import pytest
import torch
from scipy.signal import correlate

from lrsr.errors import InputError
from lrsr.sr.networks.srcnn import SRCNN


def independent_srcnn(luminance: np.ndarray, weights: dict[str, np.ndarray]) -> np.ndarray:
    """The three layers by scipy, one channel after the other, no padding."""
    channels = luminance[None]
    for name in ("extract", "map", "reconstruct"):
        kernels, biases = weights[f"{name}.weight"], weights[f"{name}.bias"]
        channels = np.stack(
            [
                correlate(channels, kernel, mode="valid")[0] + bias
                for kernel, bias in zip(kernels, biases, strict=True)
            ]
        )
        if name != "reconstruct":
            channels = np.maximum(channels, 0.0)
    return channels[0]


def test_one_channel_srcnn_has_8129_parameters() -> None:
    assert sum(parameter.numel() for parameter in SRCNN().parameters()) == 8129


@pytest.mark.parametrize(("mapping_px", "weights"), [(1, 8_032), (3, 24_416), (5, 57_184)])
def test_9_1_5_9_3_5_and_9_5_5_have_the_published_number_of_weights(
    mapping_px: int, weights: int
) -> None:
    """Dong et al. (2016), section 4.3.2, without biases."""
    network = SRCNN(mapping_px=mapping_px)
    assert sum(p.numel() for p in network.parameters() if p.ndim == 4) == weights


def test_layers_are_those_of_the_papers_table_1() -> None:
    shapes = [tuple(p.shape) for name, p in SRCNN().named_parameters() if "weight" in name]
    assert shapes == [(64, 1, 9, 9), (32, 64, 1, 1), (1, 32, 5, 5)]


@pytest.mark.parametrize("mapping_px", [1, 5])
def test_forward_is_three_correlations_with_rectifiers_between(mapping_px: int) -> None:
    torch.manual_seed(3)
    network = SRCNN(mapping_px=mapping_px, initialisation="default").double()
    weights = {name: p.detach().numpy() for name, p in network.named_parameters()}
    luminance = torch.rand(1, 1, 19, 18, dtype=torch.float64)
    with torch.no_grad():
        restored = network(luminance)[0, 0].numpy()
    np.testing.assert_allclose(
        restored, independent_srcnn(luminance[0, 0].numpy(), weights), atol=1e-12
    )


@pytest.mark.parametrize(("mapping_px", "label_px"), [(1, 21), (3, 19), (5, 17)])
def test_training_patch_of_33_loses_its_border(mapping_px: int, label_px: int) -> None:
    network = SRCNN(mapping_px=mapping_px)
    assert network(torch.zeros(2, 1, 33, 33)).shape == (2, 1, label_px, label_px)
    assert network.border_px == (33 - label_px) / 2


@pytest.mark.parametrize("mapping_px", [1, 5])
@pytest.mark.parametrize("size", [(1, 1), (5, 40), (32, 32)], ids=str)
def test_replicate_padding_keeps_the_size(size: tuple[int, int], mapping_px: int) -> None:
    network = SRCNN(padding="replicate", mapping_px=mapping_px)
    assert network(torch.zeros(1, 1, *size)).shape == (1, 1, *size)


def test_padding_changes_nothing_six_pixels_from_the_edge() -> None:
    torch.manual_seed(0)
    bare, padded = SRCNN(initialisation="default"), SRCNN(padding="replicate")
    padded.load_state_dict(bare.state_dict())
    luminance = torch.rand(1, 1, 24, 24)
    inner = padded(luminance)[..., 6:-6, 6:-6]
    torch.testing.assert_close(inner, bare(luminance), rtol=0, atol=1e-6)


def test_repeated_edge_is_numpys_edge_mode() -> None:
    bare, padded = SRCNN(), SRCNN(padding="replicate")
    padded.load_state_dict(bare.state_dict())
    luminance = torch.rand(2, 1, 3, 4)
    edged = np.pad(luminance.numpy(), ((0, 0), (0, 0), (6, 6), (6, 6)), mode="edge")
    assert torch.equal(padded(luminance), bare(torch.from_numpy(edged)))


@pytest.mark.parametrize("mapping_px", [1, 5])
def test_near_identity_start_returns_its_input_within_two_percent(mapping_px: int) -> None:
    torch.manual_seed(0)
    luminance = torch.rand(1, 1, 32, 32)
    network = SRCNN(mapping_px=mapping_px, padding="replicate", initialisation="near-identity")
    with torch.no_grad():
        restored = network(luminance)
    assert 0.0 < float((restored - luminance).abs().max()) < 0.02


def test_near_identity_start_can_learn_in_every_layer() -> None:
    network = SRCNN(initialisation="near-identity")
    network(torch.rand(1, 1, 33, 33)).square().mean().backward()
    assert all(bool((p.grad != 0).any()) for p in network.parameters())


@pytest.mark.parametrize("mapping_px", [0, 2, 7, True, 1.0])
def test_other_middle_layers_are_refused(mapping_px: int) -> None:
    with pytest.raises(InputError, match=r"module.arguments.mapping_px=.*: wanted 1, 3 or 5"):
        SRCNN(mapping_px=mapping_px)
