from dataclasses import replace

import pytest
from hydra import compose, initialize_config_dir
from omegaconf import DictConfig

from lrsr.errors import InputError
from lrsr.experiments.settings import (
    Condition,
    GallerySettings,
    IdentityRange,
    RenderingSettings,
    section,
    verification_settings,
)
from lrsr.paths import config_folder


def composed(*overrides: str) -> DictConfig:
    with initialize_config_dir(str(config_folder()), version_base="1.3"):
        return compose("eval", list(overrides))


def test_eval_without_arguments_is_option_1_at_ipd_8_with_100_identities() -> None:
    settings = verification_settings(composed())
    assert settings.identities == IdentityRange("test", 0, 100)
    assert settings.conditions == (Condition(1, 8.0, "frontal", "frontal", "none"),)
    assert settings.rendering.samples_per_pixel == 512


def test_demo_has_24_identities_and_all_six_methods() -> None:
    with initialize_config_dir(str(config_folder()), version_base="1.3"):
        settings = verification_settings(compose("demo"))
    assert settings.identities.count == 24
    assert len(settings.methods) == 6


def test_conditions_are_sizes_times_options() -> None:
    settings = verification_settings(composed("ipd_px=[8,11]", "options=[1,6]"))
    assert [(c.ipd_px, c.option) for c in settings.conditions] == [(8, 1), (8, 6), (11, 1), (11, 6)]
    assert settings.conditions[1].pose == "left"


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("options=[9]", r"options=9: wanted one of \[1, 2, 3, 4, 5, 6\]"),
        ("options=[]", "options"),
        ("methods=[]", "methods"),
        ("level=1.5", "level=1.5: wanted between 0 and 1"),
        ("level=high", "level=high"),
        ("seed=0.5", "seed=0.5: wanted a whole number"),
        ("ipd_px=2", "ipd_px=2.0: wanted at least 4"),
        ("ipd_px=wide", "ipd_px=wide"),
        ("identities.count=1", "identities.count=1: wanted at least 2"),
        ("identities.start=-1", "identities.start=-1"),
        ("identities.split=everyone", "identities.split=everyone"),
        ("identities.count=few", "identities.count"),
        ("gallery.ipd_px=1", "gallery.ipd_px"),
        ("gallery.samples_per_pixel=0", "gallery.samples_per_pixel=0"),
        ("rendering.samples_per_pixel=0", "rendering.samples_per_pixel=0"),
    ],
)
def test_a_wrong_value_names_the_setting_and_the_remedy(override: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        verification_settings(composed(override))


def test_an_unknown_compression_is_refused() -> None:
    with pytest.raises(InputError, match="compression=zip: wanted one of"):
        replace(Condition(1, 8.0, "frontal", "frontal", "none"), compression="zip")


@pytest.mark.parametrize(
    ("schema", "key"),
    [(IdentityRange, "identities"), (GallerySettings, "gallery"), (RenderingSettings, "rendering")],
)
def test_a_section_of_the_shipped_configuration_has_every_field(schema: type, key: str) -> None:
    assert isinstance(section(schema, composed(), key), schema)
