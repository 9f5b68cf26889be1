"""Tests of lrsr/evaluation/score_files/: reading and systems."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.score_files.reading import read_scores
from lrsr.evaluation.score_files.system import Name, System
from lrsr.evaluation.scores import Scores

NATIVE = "probe,gallery,mated,score\na,A,1,0.9\na,B,0,0.1\nb,A,0,nan\nb,B,1,0.7\n"
MATRIX = ",ann,bob\nann,0.9,0.1\nbob,0.2,\nann,0.8,0.3\n"
BOB = (
    "probe_subject_id,probe_template_id,bio_ref_subject_id,bio_ref_template_id,score\n"
    "1,x,1,r,0.9\n2,y,1,r,0.1\n"
)
INSIGHTFACE = "image1_path,image2_path,label,score\na.jpg,b.jpg,1,0.9\nb.jpg,c.jpg,0,0.2\n"
LFW = "1\t1\nAnn_A\t1\t4\t0.9\nAnn_A\t1\tBob_B\t2\t0.1\n"


def one(tmp_path: Path, text: str, format: str | None = None, name: str = "mine.csv") -> System:
    path = tmp_path / name
    path.write_text(text)
    (system,) = read_scores([path], format).values()
    return system


def test_native_file_with_all_pairs_is_a_matrix(tmp_path: Path) -> None:
    system = one(tmp_path, NATIVE)
    assert isinstance(system.source, Scores)
    np.testing.assert_array_equal(system.source.matrix, [[0.9, 0.1], [np.nan, 0.7]])
    assert system.source.probe_ids == system.source.gallery_ids
    assert (system.probes, system.gallery) == (["a", "b"], ["A", "B"])


def test_people_are_those_whom_mated_pairs_link(tmp_path: Path) -> None:
    text = "probe,gallery,mated,score\na,b,1,1\nb,c,1,1\nd,a,0,0\n"
    source = one(tmp_path, text).source
    assert isinstance(source, PairScores)
    assert source.probe_ids == ("a", "a", "d")
    assert source.gallery_ids == ("a", "a", "a")


def test_subjects_may_stand_in_place_of_mated(tmp_path: Path) -> None:
    text = (
        "gallery_subject;probe_subject;gallery;probe;score\r\n"
        "ann;ann;1.png;1.png;0,5\r\nbob;ann;2.png;1.png;0,25\r\n"
    )
    with pytest.raises(InputError, match=r"line 2: score '0,5' is no number"):
        one(tmp_path, text)
    source = one(tmp_path, text.replace("0,5", "0.5").replace("0,25", "0.25")).source
    assert (source.genuine().tolist(), source.impostor().tolist()) == ([0.5], [0.25])


def test_systems_are_told_apart_by_what_their_columns_say(tmp_path: Path) -> None:
    path = tmp_path / "scores.csv"
    header = "probe,gallery,mated,method,landmarks,recogniser,score,option,ipd_px\n"
    lines = [f"a,{g},{m},{w},own,net,0.5,6,8\n" for w in ("base", "sr") for g, m in ("A1", "B0")]
    path.write_text(header + "".join(lines))
    assert list(read_scores([path])) == [
        Name("6", "8", "base", "own", "net"),
        Name("6", "8", "sr", "own", "net"),
    ]


def test_matrix_has_equal_identities_mated_and_several_probes_of_one(tmp_path: Path) -> None:
    source = one(tmp_path, MATRIX).source
    assert isinstance(source, Scores)
    np.testing.assert_array_equal(source.matrix, [[0.9, 0.1], [0.2, np.nan], [0.8, 0.3]])
    assert source.probe_ids == ("ann", "bob", "ann")
    assert source.genuine().tolist() == [0.9, 0.8]


def test_bob_calls_genuine_what_has_one_subject(tmp_path: Path) -> None:
    system = one(tmp_path, BOB)
    assert (system.source.genuine().tolist(), system.source.impostor().tolist()) == ([0.9], [0.1])
    assert (system.probes, system.gallery) == (["x", "y"], ["r"])


@pytest.mark.parametrize("text", ["1 1 x 0.9\n1 2 y 0.1\n", "1 r 1 x 0.9\n1 r 2 y 0.1\n"])
def test_older_texts_of_bob_are_read_where_declared(text: str, tmp_path: Path) -> None:
    source = one(tmp_path, text, "bob_columns").source
    assert (source.genuine().tolist(), source.impostor().tolist()) == ([0.9], [0.1])


def test_insightface_pairs_are_read_with_a_score(tmp_path: Path) -> None:
    source = one(tmp_path, INSIGHTFACE).source
    assert (source.genuine().tolist(), source.impostor().tolist()) == ([0.9], [0.2])


@pytest.mark.parametrize("format", [None, "lfw"])
def test_lfw_pairs_are_read_with_a_score(format: str | None, tmp_path: Path) -> None:
    system = one(tmp_path, LFW, format, "pairs.txt")
    assert (system.source.genuine().tolist(), system.source.impostor().tolist()) == ([0.9], [0.1])
    assert system.gallery == ["Ann_A/Ann_A_0004.jpg", "Bob_B/Bob_B_0002.jpg"]


def test_genuine_and_impostor_files_are_unnamed_pairs(tmp_path: Path) -> None:
    own, other = tmp_path / "g.txt", tmp_path / "i.txt"
    own.write_text("0.9\na.png b.png 0.8\n")
    other.write_text("0.1\n\n0.2\nnan\n")
    (system,) = read_scores([own, other], "genuine_impostor").values()
    assert system.source.genuine().tolist() == [0.9, 0.8]
    assert system.source.impostor().tolist() == [0.1, 0.2]
    assert not system.source.people_known


def test_gzip_utf_16_and_marks_are_read(tmp_path: Path) -> None:
    wanted = one(tmp_path, NATIVE).source
    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(NATIVE.encode()))
    (tmp_path / "b.csv").write_text(NATIVE, encoding="utf-16")
    (tmp_path / "c.csv").write_text(NATIVE, encoding="utf-8-sig")
    for name in ("a.csv.gz", "b.csv", "c.csv"):
        (system,) = read_scores([tmp_path / name]).values()
        assert system.source.genuine().tolist() == wanted.genuine().tolist()


def test_distances_turn_their_sign(tmp_path: Path) -> None:
    path = tmp_path / "d.csv"
    path.write_text(NATIVE)
    (system,) = read_scores([path], distance=True).values()
    assert system.source.genuine().tolist() == [-0.9, -0.7]


def test_qualities_are_those_of_the_probes(tmp_path: Path) -> None:
    path = tmp_path / "q.csv"
    path.write_text("probe,gallery,mated,score,norm\na,A,1,1,5\na,B,0,0,5\nb,A,0,0,\nb,B,1,1,\n")
    (system,) = read_scores([path], qualities=["norm"]).values()
    assert system.qualities["norm"] == pytest.approx([5, np.nan], nan_ok=True)


@pytest.mark.parametrize(
    ("text", "format", "says"),
    [
        ("", None, r"mine.csv is empty"),
        ("a b c\n", None, r"line 1: 'a b c' is no known header; say which of native"),
        ("probe,gallery,score\na,b,1\n", None, r"line 1: who is who\? Add a column mated"),
        ("probe,gallery,mated,score\na,b,2,1\n", None, r"line 2: mated '2': wanted 1 or 0"),
        ("probe,gallery,mated,score\na,b,1,x\n", None, r"line 2: score 'x' is no number"),
        ("probe,gallery,mated,score\na,b,1,1_0\n", None, r"line 2: score '1_0' is no number"),
        ("probe,gallery,mated,score\na,b,1,inf\n", None, r"line 2: score inf is infinite"),
        ("probe,gallery,mated,score\na,b,1\n", None, r"line 2: 3 cells, wanted 4"),
        ("probe,gallery,mated,score\n", None, r"holds no scores below its header"),
        ("probe,gallery,mated,score\na,b,1,1\na,b,1,1\n", None, r"line 3: a and b were scored"),
        ("probe,gallery,mated,score\na,b,1,1\nb,c,1,1\na,c,0,1\n", None, r"line 4: .* one person"),
        (
            "probe,gallery,probe_subject,gallery_subject,score\na,b,x,y,1\na,c,z,y,1\n",
            None,
            r"line 3: a shows z, and before it x",
        ),
        ("probe,gallery,mated,score,score\na,b,1,1,1\n", None, r"line 1: 2 columns score"),
        ('probe,gallery,mated,score\n"a,b,1,1\n', None, r"line \d: "),
        (",a,a\na,1,1\n", None, r"line 1: two columns a"),
        ("a b 1\n", "lfw", r"line 1: 'a b 1': wanted NAME I J SCORE"),
        ("1 2 3\n", "bob_columns", r"line 1: 3 columns, wanted 4 or 5"),
        ("x\n", "genuine_impostor", r"1 files: give genuine and impostor scores by turns"),
        (NATIVE, "excel", r"format=excel: wanted one of native"),
    ],
)
def test_what_cannot_be_read_is_told_with_file_line_and_remedy(
    text: str, format: str | None, says: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=says):
        one(tmp_path, text, format)


def test_files_that_cannot_be_opened_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent.csv: No such file"):
        read_scores([tmp_path / "absent.csv"])
    (tmp_path / "broken.csv.gz").write_bytes(gzip.compress(NATIVE.encode())[:-9])
    with pytest.raises(InputError, match=r"broken.csv.gz.*copy it again"):
        read_scores([tmp_path / "broken.csv.gz"])
    (tmp_path / "latin.csv").write_bytes(b"probe,gallery,mated,score\n\xe9,b,1,1\n")
    with pytest.raises(InputError, match=r"save it as UTF-8"):
        read_scores([tmp_path / "latin.csv"])
    with pytest.raises(InputError, match="no file of scores"):
        read_scores([])


def test_qualities_are_for_native_files(tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    path.write_text(MATRIX)
    with pytest.raises(InputError, match="quality=norm"):
        read_scores([path], qualities=["norm"])
