"""Do recreated cameras put methods in the order of SCface's real ones? Kendall's tau says so."""

from collections.abc import Sequence

from scipy.stats import kendalltau

from lrsr.experiments.table import Record

OF_SET, OF_HEADS, OF_NOBODY = "SCface ", "SCFace Syn ", "Recreated "
"""How the name of a part begins: photographs, the set's people rendered, synthetic people."""

_MOST_FEW = 3
"""Methods from which on their order says something."""


def find_agreements(rows: Sequence[Record]) -> list[Record]:
    """Return how alike real and recreated cameras order the methods, by their AUC.

    Each real camera is held against every recreation of its number, before heads of the set's
    people with the same kind of mugshots enrolled and before synthetic people, with landmarks of
    the same source and the same recogniser: Kendall's tau-b, 1 where the order is the same and -1
    where it is turned round; None where one of them ties all.

    Args:
        rows: Of all parts; ``setting`` says which part.
    """
    areas: dict[tuple[str, str, str], dict[str, float]] = {}
    for row in rows:
        if row["auc"] is not None:
            place = (row["recogniser"], row["landmarks"], row["setting"])
            areas.setdefault(place, {})[row["label"]] = row["auc"]
    found = []
    for (recogniser, landmarks, name), real in areas.items():
        if not name.startswith(OF_SET):
            continue
        camera, *_, mugshots = name.removeprefix(OF_SET).split(", ")
        for (*same, other), made in areas.items():
            shared = [label for label in real if label in made]
            words = other.split(", ")
            heads = words[0] == f"{OF_HEADS}scface_{camera}" and words[-1] == mugshots
            alike = heads or words[0] == f"{OF_NOBODY}scface_{camera}"
            if same != [recogniser, landmarks] or not alike or len(shared) < _MOST_FEW:
                continue
            tau = float(kendalltau([real[k] for k in shared], [made[k] for k in shared]).statistic)
            names = {"recogniser": recogniser, "landmarks": landmarks}
            told = {"real": name, "recreated": other, "methods": len(shared)}
            found.append({**names, **told, "kendall_tau": None if tau != tau else tau})
    return found
