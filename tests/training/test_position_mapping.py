from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.lessons import everything, quiet
from fakes.maps import DrawnMaps, make_mapping

from lrsr.errors import InputError
from lrsr.identities.photographs.landmarker import Landmarker
from lrsr.sr.weights import read_checkpoint
from lrsr.training.map_network import MapNetwork
from lrsr.training.position_mapping import PositionMapping, _weights
from lrsr.training.position_maps import MAP_SIZE, RULE, resting_map
from lrsr.training.run import train

FIVE = np.array([[80.0, 90], [125, 96], [100, 118], [82, 140], [116, 146]])


def run(folder: Path, epochs: int, module: PositionMapping | None = None) -> Path:
    return train(
        module or make_mapping(),
        DrawnMaps(),
        folder=folder,
        trainer=partial(quiet, max_epochs=epochs),
        depends_on={"epochs": "any"},
    )


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run(tmp_path_factory.mktemp("maps") / "run", 2)


def test_a_network_begins_with_the_mean_face() -> None:
    network = MapNetwork().eval()
    with torch.no_grad():
        found = 112 * network(torch.randn(2, 3, 112, 112))
    np.testing.assert_allclose(found, np.stack([resting_map()] * 2), atol=1e-3)


def test_steps_bring_texels_nearer() -> None:
    module, (crops, maps) = make_mapping(), DrawnMaps().data.tensors
    module.trainer = type("Trainer", (), {"global_step": 0})()
    optimizer = module.make_optimizer(module.parameter_groups())
    losses = []
    for _ in range(14):
        loss = module.loss((crops, maps))
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(float(loss.detach()))
    assert losses[-1] < 0.8 * losses[0]


def test_the_loss_of_one_px_everywhere_is_that_of_the_mean_texel() -> None:
    module = make_mapping()
    module.portraits = lambda crops, maps, _: (crops.float() / 255, maps)  # type: ignore[assignment]
    module.trainer = type("Trainer", (), {"global_step": 0})()
    maps = torch.from_numpy(resting_map()).float().repeat(2, 1, 1, 1)
    maps[:, 1] += 3
    loss = module.loss((torch.zeros(2, 3, 112, 112, dtype=torch.uint8), maps))
    np.testing.assert_allclose(float(loss.detach()), 3 / 112, rtol=1e-3)


def test_features_count_most_and_nothing_counts_outside_the_skin() -> None:
    weights = _weights(4.0, 0.1)
    assert float(weights.mean()) == pytest.approx(1)
    kinds, counts = np.unique((weights / weights.max()).numpy().round(4), return_counts=True)
    np.testing.assert_allclose(kinds, [0, 0.025, 0.25, 1])
    assert counts.min() > 200


def test_a_run_leaves_a_model_that_any_photograph_can_be_given_to(finished: Path) -> None:
    landmarker = Landmarker(finished / "model.onnx")
    image = np.full((240, 220, 3), 0.5, np.float32)
    points = landmarker(image, FIVE).points_px
    module = make_mapping()
    module.load_state_dict(read_checkpoint(finished / "best.ckpt")["state_dict"])
    with torch.no_grad():
        crops = torch.from_numpy(RULE.of_five(FIVE).take(image)).permute(2, 0, 1)[None]
        both = [112 * module.eval()(seen)[0].double() for seen in (crops, crops.flip(-1))]
    both[1] = both[1].flip(-1)
    both[1][0] = 111 - both[1][0]
    true = RULE.of_five(FIVE).back(torch.stack(both).mean(0)[:2].flatten(1).T.numpy())
    np.testing.assert_allclose(points, true, atol=1e-2)


def test_a_resumed_run_ends_where_the_uninterrupted_one_does(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(PositionMapping, "ship", lambda *_: {})
    run(tmp_path, 1)
    run(tmp_path, 2)
    one, two = (read_checkpoint(at / "last.ckpt")["state_dict"] for at in (finished, tmp_path))
    assert one.keys() == two.keys()
    assert all(torch.equal(one[name], two[name]) for name in one)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"features": 0}, "module.features=0.*: wanted a number > 0"),
        ({"behind": -1}, "module.behind=-1.*: wanted a number >= 0"),
        ({"portraits": everything()}, "degradation=Degradation: wanted portraits"),
    ],
    ids=["features", "behind", "portraits"],
)
def test_what_cannot_be_learned_by_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make_mapping(**wrong)


def test_exports_say_who_made_them(finished: Path) -> None:
    contract = Landmarker(finished / "model.onnx").contract
    assert contract.source.startswith("lrsr train reconstructor=position_map")
    assert (contract.size_px, contract.unit_px) == (112, 112.0)
    assert len(contract.mirrored()) == MAP_SIZE**2
