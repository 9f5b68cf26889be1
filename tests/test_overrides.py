"""Words as people type them reach Hydra as they were meant, or are refused with the right name."""

from pathlib import Path

import pytest
from fakes.configurations import compose_keys_once
from hydra.core.override_parser.overrides_parser import OverridesParser

from lrsr.errors import InputError
from lrsr.overrides import _OPEN, Overrides, fields_of, pieces_of
from lrsr.paths import config_folder


@pytest.fixture(autouse=True)
def once(monkeypatch: pytest.MonkeyPatch) -> None:
    compose_keys_once(monkeypatch)


def mended(*words: str, command: str = "render", sweep: bool = False) -> list[str]:
    return Overrides(command, [config_folder()], sweep).mended(words)


def value(word: str) -> object:
    return OverridesParser.create().parse_override(word).value()


@pytest.mark.parametrize(
    "text",
    [
        "~/probes", "größe", "北京", "my probes (1)", "run=3/p", "a,b", "x[1]", "[a]",
        "{y}", "it's", "$HOME/x", '"q', 'say "hi"', " lead", "trail ", "a\\b", "a\\",
        "a\\\\", '\\"', "#x", "a:b", "2024", "1e3", "007", "true", "nan", "a\nb",
        "x\ty", "*", "?", "a;b", "&", "|", "!x", "`ls`", "%s", "..", ".", "x==y", "(x)",
        "choice(a", "a b", "ü'b\"c", "😀",
    ],
)  # fmt: skip
def test_a_path_is_what_was_typed(text: str) -> None:
    for key in ("out", "paths.cache", "identities.roster"):
        (word,) = mended(f"{key}={text}")
        assert word.startswith(f"++{key}=")
        assert value(word) == text


@pytest.mark.parametrize("text", ["2024.10", "007", "1e3", "null2", "[a", "nan"])
def test_a_path_of_digits_stays_what_was_typed(text: str) -> None:
    for command, key in (("score", "files"), ("reconstruct", "ages"), ("generate", "generator")):
        assert value(mended(f"{key}={text}", command=command)[-1]) == text


def test_a_list_of_paths_is_one() -> None:
    assert value(mended("files=[a.csv,b.csv]", command="score")[0]) == ["a.csv", "b.csv"]


def test_no_path_is_null_and_quotes_can_be_the_users() -> None:
    assert value(mended("identities.roster=null")[0]) is None
    assert value(mended('out="größe (1)"')[0]) == "größe (1)"
    assert value(mended("out='a, b'")[0]) == "a, b"


def test_where_the_pictures_of_a_list_are_needs_no_quotes() -> None:
    typed = "ijb.path=frames/{video}_{frame:0>6}.jpg"
    mend = mended("experiment=ijb", typed, command="eval")
    assert value(mend[-1]) == typed.partition("=")[2]


def test_a_misspelt_section_is_refused_without_loading_what_the_experiment_is_made_of(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("lrsr.overrides.fields_of", None)  # would import PyTorch
    with pytest.raises(InputError, match=r"did you mean identities\.count"):
        mended("idnetities.count=3", command="eval")


@pytest.mark.parametrize(
    ("command", "word", "says"),
    [
        ("compare", "landmark=own", "did you mean recognition.landmarks?"),
        ("compare", "probe=x", "'probe': lrsr compare --help lists them"),  # not pose
        ("compare", "identities.count=3", "lrsr compare --help lists them"),  # it knows nobody
        ("upscale", "scale=2", "lrsr upscale --help lists them"),  # not paths.cache
        ("eval", "experimant=own", "did you mean experiment?"),
        ("eval", "case.images=x", "it is one of experiment=case"),
        ("compare", "cut.x=3", "'cut.x'; cut has ipds, longest_px"),
    ],
)
def test_nothing_far_fetched_is_offered(command: str, word: str, says: str) -> None:
    with pytest.raises(InputError) as refused:
        mended(word, command=command)
    assert str(refused.value).endswith(says)


@pytest.mark.parametrize(
    "word", ["recognition.recogniser=dlib", "probes.folders=x", "gallery.pse=left", "paths.rum=x"]
)
def test_a_section_of_an_experiment_takes_no_more_than_it_has(word: str) -> None:
    with pytest.raises(InputError, match="did you mean"):
        mended(word, command="eval")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("recognition=arcface", "data=images"), "data=images: does not go with train=arcface; "),
        (("sr=srcnn2x", "loss=identity"), "lrsr train train=srcnn2x has no loss to choose"),
        (("sr=bicubic2",), "sr=bicubic2: no such option"),  # as it was typed
    ],
)
def test_choices_that_do_not_go_together_are_refused(words: tuple[str, ...], says: str) -> None:
    with pytest.raises(InputError) as refused:
        mended(*words, command="train")
    assert str(refused.value).startswith(says)


def test_a_comma_parts_values_in_a_multirun_only() -> None:
    assert mended("out=a b,ü", sweep=True) == ['++out="a b","ü"']
    assert mended('out="a,b",c', sweep=True) == ['++out="a,b","c"']
    assert mended("out=choice(a,b)", sweep=True) == ["++out=choice(a,b)"]
    assert pieces_of("a,b", sweep=False) == ["a,b"]


@pytest.mark.parametrize("text", ["Was ist (das)?", "größe", "a=b", "it's"])
def test_any_other_word_is_quoted_where_hydra_could_not_read_it(text: str) -> None:
    assert value(mended(f"question={text}", command="eval")[0]) == text


def test_values_stay_what_they_are() -> None:
    words = mended("seed=7", "ipd_px=8.5", "scales=[1,2]", "png16=true")
    assert [value(word) for word in words] == [7, 8.5, [1, 2], True]


@pytest.mark.parametrize(
    ("word", "says"),
    [
        ("ipd=20", "no setting 'ipd': did you mean ipd_px?"),
        ("+ipd=20", "no setting 'ipd': did you mean ipd_px?"),
        ("++ipd=20", "no setting 'ipd': did you mean ipd_px?"),
        ("ipd_px.x=20", "did you mean ipd_px?"),
        ("~ipd_px", "~ipd_px: cannot be taken away"),
        ("~pose", "choose one of down, frontal"),
        ("identities.cout=3", "did you mean identities.count?"),
        ("+identities.cout=3", "did you mean identities.count?"),
        ("rendering.smaples_per_pixel=3", "did you mean rendering.samples_per_pixel?"),
        ("samples_per_pixel=3", "did you mean rendering.samples_per_pixel or gallery"),
        ("camera.optics.f_numbr=2", "did you mean f_number?; camera.optics has astigmatism"),
        ("paths.rum=x", "did you mean paths.run?"),
        ("größe=3", "lrsr render --help lists them"),
        ("pose=lefft", "pose=lefft: no such option: did you mean left?"),
        ("pose=null", "choose one of down, frontal, left, up"),
        ("pos=left", "no setting 'pos': did you mean pose?"),
        ("pose=left,up", "add -m"),
        ("rendering/skin=tonne", "did you mean tone?"),
        ("+debug=smok", "did you mean smoke?"),
        ("+recognition=embedder", "lrsr render has no recognition to choose"),
        ("experiment=super_resolution", "lrsr render has no experiment to choose"),
        ("seed=0,1", "write [...] for a list, or add -m"),
        ("scales=[1", "write scales="),
        ("ipd_px=", "ipd_px=: give a value, or null for none"),
        ("out=  ", "out=: give a value"),
        ("pose=", "pose=: give a value"),
        ("probes", "'probes': write key=value"),
        ("=3", "write key=value"),
    ],
)
def test_what_nothing_reads_is_refused_with_what_was_meant(word: str, says: str) -> None:
    with pytest.raises(InputError) as refused:
        mended("camera=axis_p1435le", word)
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("command", "word", "wanted"),
    [
        ("render", "expression.units.jawOpen=0.2", "++expression.units.jawOpen=0.2"),
        ("render", "+expression.units.jawOpen=0.2", "++expression.units.jawOpen=0.2"),
        ("render", "camera.optics.coma_waves=0.1", "++camera.optics.coma_waves=0.1"),
        ("eval", "conditions.7.pose=left", "++conditions.7.pose=left"),
        ("eval", "conditions.1.pose=left", "++conditions.1.pose=left"),
        ("eval", "+debug=smoke", "+debug=smoke"),
        ("eval", "debug=smoke", "+debug=smoke"),
        ("render", "+pose=left", "pose=left"),
        ("render", "hydra.verbose=true", "hydra.verbose=true"),
    ],
)
def test_what_is_read_may_be_added_with_or_without_a_plus(
    command: str, word: str, wanted: str
) -> None:
    words = (
        mended("expression=blink", word) if command == "render" else mended(word, command=command)
    )
    if "camera" in word:
        words = mended("camera=axis_p1435le", word)
    assert wanted in words


def test_parts_of_open_sections_can_be_taken_away_and_built() -> None:
    words = mended("~callbacks.best", "callbacks.mine._target_=a.b", command="train")
    assert words == ["~callbacks.best", "++callbacks.mine._target_=a.b"]
    assert "callbacks" in _OPEN


def test_of_two_the_last_counts_and_it_is_said(caplog: pytest.LogCaptureFixture) -> None:
    assert mended("seed=1", "pose=up", "+seed=2") == ["pose=up", "++seed=2"]
    assert "given twice, the last counts: seed" in caplog.text


def test_a_users_own_folder_of_configurations_has_its_own_groups(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "far.yaml").write_text("# @package _global_\nseed: 3\n")
    both = Overrides("render", [config_folder(), tmp_path])
    assert both.mended(["+mine=far"]) == ["+mine=far"]


def trainable(folder: Path) -> Overrides:
    (folder / "train").mkdir()
    for name in ("srcnn2x", "arcface"):
        (folder / "train" / f"{name}.yaml").write_text("epochs: 1\n")
    (folder / "train.yaml").write_text("defaults:\n  - train: null\n")
    return Overrides("train", [folder])


@pytest.mark.parametrize(
    "word", ["sr=srcnn2x", "recognition=srcnn2x", "reconstructor=srcnn2x", "train=srcnn2x"]
)
def test_what_to_train_has_four_names(word: str, tmp_path: Path) -> None:
    assert trainable(tmp_path).mended([word]) == ["train=srcnn2x"]


def test_one_network_is_trained_at_a_time(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="sr=srcnn2x and recognition=arcface: give one of them"):
        trainable(tmp_path).mended(["sr=srcnn2x", "recognition=arcface"])


def test_a_target_says_its_fields() -> None:
    assert fields_of("lrsr.overrides.Overrides") == {"command", "folders", "sweep"}
    assert fields_of("dataclasses.replace") is None


def test_a_target_that_is_not_there_is_the_users() -> None:
    with pytest.raises(InputError, match=r"_target_=lrsr\.none"):
        fields_of("lrsr.none")


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("recognition=embedder", "recognition=embedder"),
        ("recognition=dlib", '++recognition.recognisers="dlib"'),
        ("recognition=[shipped,dlib]", '++recognition.recognisers=["shipped","dlib"]'),
        ("recognition=[shipped, a b.onnx]", '++recognition.recognisers=["shipped","a b.onnx"]'),
        ("recognition.model=a,b.onnx", '++recognition.model="a,b.onnx"'),
    ],
)
def test_recognition_names_recognisers_or_an_option(typed: str, meant: str) -> None:
    assert mended(typed, command="eval") == [meant]


def test_recognisers_can_be_swept_over() -> None:
    swept = mended("recognition=shipped,dlib", command="eval", sweep=True)
    assert swept == ['++recognition.recognisers="shipped","dlib"']


@pytest.mark.parametrize(
    ("word", "wanted"),
    [
        ("probes=photos", '++probes.folder="photos"'),
        ("gallery=here/photos", '++gallery.folder="here/photos"'),
        ("gallery=photos", '++gallery.folder="photos"'),  # a folder that is there
        ('gallery="my photos"', '++gallery.folder="my photos"'),
        ("gallery=frontal", "gallery=frontal"),
        ("probes.folder=2024", '++probes.folder="2024"'),
    ],
)
def test_a_folder_of_photographs_may_be_given_without_its_key(
    word: str, wanted: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("photos", "my photos"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path)
    assert mended(word, command="eval") == [wanted]


@pytest.mark.parametrize(
    ("command", "word", "says"),
    [
        ("eval", "gallery=frontel", "no such option: did you mean frontal?"),
        ("render", "probes=photos", "no setting 'probes'"),
        ("render", "gallery=a/b", "no setting 'gallery.folder'"),
    ],
)
def test_what_is_neither_folder_nor_option_is_refused(command: str, word: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        mended(word, command=command)
