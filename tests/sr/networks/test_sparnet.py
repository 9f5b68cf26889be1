import pytest
import torch

from lrsr.errors import InputError
from lrsr.images import resize_bicubic
from lrsr.sr.networks.sparnet import SPARNet, _Hourglass, _Unit


def small(**changes: object) -> SPARNet:
    torch.manual_seed(0)
    arguments: dict[str, object] = {"blocks": 2, "features": 8, "large_features": 4, "depth": 2}
    return SPARNet(**{**arguments, **changes})  # type: ignore[arg-type]


def convolution(inputs: int, outputs: int) -> int:
    return 9 * inputs * outputs + outputs


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_parameters_are_counted_by_hand(scale: int) -> None:
    def unit(features: int, depth: int) -> int:
        seen = features // 2
        hourglass = 2 * depth * convolution(seen, seen)
        ends = convolution(features, seen) + convolution(seen, 1)
        return 2 * convolution(features, features) + hourglass + ends

    expected = convolution(3, 40) + 6 * unit(40, 3) + convolution(40, 40)
    expected += convolution(40, 16 * scale**2) + unit(16, 3) + convolution(16, 3)
    count = sum(parameter.numel() for parameter in SPARNet(scale=scale).parameters())
    assert count == expected
    assert 4 * count <= 2_000_000  # bytes


def test_a_unit_adds_nothing_where_it_does_not_attend() -> None:
    torch.manual_seed(0)
    unit = _Unit(4, depth=1)
    torch.nn.init.constant_(unit.attend.bias, -1e9)
    features = torch.rand(1, 4, 6, 6)
    assert torch.equal(unit(features), features)


def test_a_unit_adds_all_of_its_residual_where_it_attends() -> None:
    torch.manual_seed(0)
    unit = _Unit(4, depth=1)
    torch.nn.init.constant_(unit.attend.bias, 1e9)
    features = torch.rand(1, 4, 6, 6)
    inner = torch.nn.functional.leaky_relu(unit.first(features), 0.2)
    torch.testing.assert_close(unit(features), features + unit.second(inner))


@pytest.mark.parametrize(("depth", "reach_px"), [(1, 6), (3, 24)])
def test_a_deeper_hourglass_sees_more_of_the_face(depth: int, reach_px: int) -> None:
    torch.manual_seed(0)
    hourglass = _Hourglass(2, depth)
    picture = torch.rand(1, 2, 65, 65, requires_grad=True)
    hourglass(picture)[0, 0, 32, 32].backward()
    assert picture.grad is not None
    columns = picture.grad.abs().sum((0, 1, 2)).nonzero().flatten()
    assert int(columns.max() - columns.min()) >= reach_px


@pytest.mark.parametrize("size", [(1, 1), (5, 7), (8, 13)], ids=str)
def test_odd_sizes_keep_their_size(size: tuple[int, int]) -> None:
    assert small(scale=3)(torch.rand(1, 3, *size)).shape == (1, 3, 3 * size[0], 3 * size[1])


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_near_bicubic_start_is_within_three_percent_of_bicubic(scale: int) -> None:
    noise = torch.rand(1, 3, 20, 20, generator=torch.Generator().manual_seed(0))
    smooth = torch.nn.functional.avg_pool2d(noise, 5, 1)
    with torch.no_grad():
        larger = small(scale=scale, initialisation="near-bicubic")(smooth)
    assert 0.0 < float((larger - resize_bicubic(smooth, scale)).abs().max()) < 0.03


def test_near_bicubic_start_can_learn_in_every_layer() -> None:
    network = small(initialisation="near-bicubic")
    network(torch.rand(1, 3, 9, 9)).square().mean().backward()
    assert all(bool((p.grad != 0).any()) for p in network.parameters())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scale": 5}, "module.arguments.scale=5: wanted a whole number, 2 to 4"),
        ({"blocks": 0}, "module.arguments.blocks=0: wanted a whole number, 1 to 64"),
        ({"features": 3}, "module.arguments.features=3: wanted a whole number, 4 to"),
        ({"large_features": 3}, "module.arguments.large_features=3: wanted a whole number, 4"),
        ({"depth": 5}, "module.arguments.depth=5: wanted a whole number, 1 to 4"),
    ],
    ids=str,
)
def test_arguments_out_of_range_are_refused(arguments: dict[str, int], message: str) -> None:
    with pytest.raises(InputError, match=message):
        SPARNet(**arguments)
