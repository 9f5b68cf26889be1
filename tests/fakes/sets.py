"""Made-up copies of published sets: their folders and names, and people made of tones."""

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from lrsr.recognition.alignment import TEMPLATE_IPD_PX, TEMPLATE_PX


def points_of(ipd_px: float, side: int) -> NDArray[np.float64]:
    """Return where the five landmarks of a made-up face lie, ``(5, 2)`` px."""
    points: NDArray[np.float64] = (
        (TEMPLATE_PX - 55.5) * ipd_px / TEMPLATE_IPD_PX + side / 2 - 0.5
    ).round(2)
    return points


def tones(person: int, side: int, *, seed: int = 0, noise: int = 25) -> NDArray[np.uint8]:
    """Return somebody: 6 by 6 tones over the frame and a little noise, ``(side, side, 3)``."""
    coarse = np.random.default_rng(person).integers(0, 230, (6, 6, 3), np.uint8)
    face = cv2.resize(coarse, (side, side), interpolation=cv2.INTER_LINEAR)
    grain = np.random.default_rng(seed + person).integers(0, noise, face.shape, np.uint8)
    return np.asarray(face + grain, np.uint8)


def write_picture(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write a picture, as JPEG or PNG, and the folder that it is to be in."""
    path.parent.mkdir(parents=True, exist_ok=True)
    how = [cv2.IMWRITE_JPEG_QUALITY, 95] if path.suffix.lower() == ".jpg" else []
    path.write_bytes(cv2.imencode(path.suffix, pixels, how)[1])


def write_face(path: Path, person: int, side: int = 48, *, seed: int = 0, noise: int = 25) -> None:
    """Write somebody; see :func:`tones`."""
    write_picture(path, tones(person, side, seed=seed, noise=noise))


def write_scface(
    root: Path,
    people: Iterable[int],
    *,
    cameras: Sequence[int] = (1, 3),
    folders: bool = False,
    coordinates: bool = True,
    mugshots: Sequence[str] = ("original", "cropped"),
) -> Path:
    """Write a made-up SCface at distance 1.

    Args:
        root: Is made.
        people: Numbers.
        cameras: Numbers.
        folders: A folder for each distance and camera, in place of one for all.
        coordinates: Write ``all.txt``.
        mugshots: Kinds.
    """
    lines = []
    for person in people:
        for kind, side in zip(mugshots, (96, 64), strict=False):
            suffix = "jpg" if kind == "original" else "JPG"
            name = f"mugshot_frontal_{kind}_all/{person:03d}_frontal.{suffix}"
            write_face(root / name, person, side)
        lines.append((f"{person:03d}_frontal", points_of(32, 96)))
        for camera in cameras:
            one = (
                "surveillance_cameras_distance_1/cam_{0}" if folders else "surveillance_cameras_all"
            )
            stem = f"{person:03d}_cam{camera}_1"
            write_face(root / one.format(camera) / f"{stem}.jpg", person, 40, seed=1000 * camera)
            lines.append((stem, points_of(11 - camera, 40)))
    if coordinates:
        text = "".join(f"{stem}\t{four(points)}\n" for stem, points in lines)
        (root / "all.txt").write_text(f"name\tcoordinates\n{text}")
    return root


def four(points: NDArray[np.float64]) -> str:
    """Return eyes, nose and the middle of the mouth as SCface writes them."""
    told = [*points[:3], points[3:].mean(axis=0)]
    return "\t".join(f"{value:.2f}" for value in np.ravel(told))


def cells(names: Sequence[Any]) -> NDArray[np.object_]:
    """Return text as MATLAB's cells, ``(n, 1)``, or ``(n, 2)`` for pairs."""
    wide = [[name] if isinstance(name, str) else [*name] for name in names]
    return np.array(wide, dtype=object)


def write_listing(path: Path, kind: str, files: dict[str, int]) -> None:
    """Write names and numbers of people as the sets' lists have them."""
    path.parent.mkdir(parents=True, exist_ok=True)
    numbers = np.array([*files.values()], np.uint16)[:, None]
    savemat(path, {f"{kind}_set": cells([*files]), f"{kind}_ids": numbers})


def write_tinyface(root: Path, people: int = 4, distractors: int = 3) -> Path:
    """Write a made-up TinyFace: two gallery pictures and a probe of everybody, and strangers."""
    test = root / "Testing_Set"
    gallery = {f"{p}_{n}.jpg": p for p in range(1, people + 1) for n in (1, 2)}
    probes = {f"{p}_9.jpg": p for p in range(1, people + 1)}
    for folder, files in (("Gallery_Match", gallery), ("Probe", probes)):
        for number, (file, person) in enumerate(files.items()):
            write_face(test / folder / file, person, 20 + number % 2, seed=number)
    for number in range(distractors):
        write_face(test / "Gallery_Distractor" / f"{number}_stranger.jpg", 900 + number, 20)
    write_listing(test / "gallery_match_img_ID_pairs.mat", "gallery", gallery)
    write_listing(test / "probe_img_ID_pairs.mat", "probe", probes)
    return root


def write_survface(root: Path, people: int = 4, strangers: int = 3) -> Path:
    """Write a made-up QMUL-SurvFace: pairs, and a search with strangers."""
    search, verify = root / "Face_Identification_Test_Set", root / "Face_Verification_Test_Set"
    gallery = {f"{p}_cam1_{n}.jpg": p for p in range(1, people + 1) for n in (1, 2)}
    mated = {f"{p}_cam2_1.jpg": p for p in range(1, people + 1)}
    for folder, files in (("gallery", gallery), ("mated_probe", mated)):
        for number, (file, person) in enumerate(files.items()):
            write_face(search / folder / file, person, 22, seed=number)
        write_listing(search / f"{folder}_img_ID_pairs.mat", folder, files)
    for number in range(strangers):
        write_face(search / "unmated_probe" / f"{800 + number}_cam2_1.jpg", 800 + number, 22)
    positive = [(f"{p}_cam1_1.jpg", f"{p}_cam2_1.jpg") for p in range(1, people + 1)]
    negative = [(f"{p}_cam1_1.jpg", f"{p % people + 1}_cam2_1.jpg") for p in range(1, people + 1)]
    for file in {file for pair in positive for file in pair}:
        write_face(verify / "verification_images" / file, int(file.split("_")[0]), 22)
    for word, pairs in (("positive", positive), ("negative", negative)):
        name = f"{word}_pairs_names"
        savemat(verify / f"{name}.mat", {name: cells(pairs)})
    return root


def write_table(path: Path, rows: Sequence[dict[str, object]]) -> None:
    """Write a CSV file with the columns of its first row."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def write_ijb(root: Path) -> Path:
    """Write a made-up IJB: subjects 1, 2 in one gallery and 3, 4 in the other.

    Subject k is template k in ``gallery_S1.csv`` or ``gallery_S2.csv``, two stills, and template
    100 + k in ``probe.csv``, a still and two frames of one video. Stills hold a face of 24 px at
    (10, 4) of 64 px; frames, two faces of 20 px side by side, those of k and its neighbour.
    """
    side, small = 24, 20
    galleries: dict[str, list[dict[str, object]]] = {"S1": [], "S2": []}
    probes: list[dict[str, object]] = []

    def row(template: int, who: int, file: str, sighting: int, *box: int) -> dict[str, object]:
        columns = ("FACE_X", "FACE_Y", "FACE_WIDTH", "FACE_HEIGHT")
        told = {"TEMPLATE_ID": template, "SUBJECT_ID": who, "FILENAME": file}
        return {**told, "SIGHTING_ID": sighting, **dict(zip(columns, box, strict=True))}

    for who in range(1, 5):
        for number in range(3):
            file = f"img/{who}_{number}.png"
            scene = np.full((48, 64, 3), 30, np.uint8)
            scene[4 : 4 + side, 10 : 10 + side] = tones(who, side, seed=number)
            write_picture(root / file, scene)
            template, rows = 100 + who, probes
            if number:
                template, rows = who, galleries["S1" if who < 3 else "S2"]
            rows.append(row(template, who, file, 10 * who + number, 10, 4, side, side))
    for number in range(2):
        for pair in ((1, 2), (3, 4)):
            file = f"frames/{pair[0]}_{number}.png"
            scene = np.full((48, 64, 3), 30, np.uint8)
            for place, who in enumerate(pair):
                left = 2 + 30 * place
                scene[8 : 8 + small, left : left + small] = tones(who, small, seed=9 + number)
                probes.append(row(100 + who, who, file, 500 + who, left, 8, small, small))
            write_picture(root / file, scene)
    for name, rows in galleries.items():
        write_table(root / "protocols" / f"gallery_{name}.csv", rows)
    write_table(root / "protocols" / "probe.csv", probes)
    return root
