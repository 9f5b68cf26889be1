import torch

from lrsr.training.backbone import Backbone, _Residual


def test_it_has_about_a_million_parameters_and_fits_in_five_megabytes() -> None:
    count = sum(p.numel() for p in Backbone().parameters())
    assert count == 949_728
    assert 4 * count < 5e6


def test_a_face_becomes_128_numbers() -> None:
    assert Backbone().eval()(torch.zeros(2, 3, 112, 112)).shape == (2, 128)


def test_a_block_that_halves_has_a_shortcut_that_halves() -> None:
    assert _Residual(4, 6, stride=2)(torch.zeros(2, 4, 8, 8)).shape == (2, 6, 4, 4)


def test_in_evaluation_a_face_does_not_see_its_batch() -> None:
    torch.manual_seed(0)
    network = Backbone().eval()
    faces = torch.rand(3, 3, 112, 112)
    with torch.no_grad():
        torch.testing.assert_close(network(faces)[1:2], network(faces[1:2]), atol=1e-5, rtol=1e-4)
