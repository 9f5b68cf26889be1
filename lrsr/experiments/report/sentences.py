"""What must every report say of how faces were found and recognised?"""

from collections.abc import Sequence

from lrsr.recognition.settings import Landmarks, RecognitionSettings

_LANDMARKS = {
    "shared": "Shared landmarks: all methods have the true ones, scaled, so that no difference "
    "between them is the detector's.",
    "own": "Own landmarks: a detector looks for the face on each method's own picture, and on the "
    "enrolled one, as a user would; a picture without a face is a failure to acquire (FTA).",
}
_WHOLE = "Where no face was found, the whole picture stood for it, so that FTA does not count it."
_NO_DETECTOR = "No face detector was run: a detector's failures on such small faces come on top."
_SHIPPED = (
    "The shipped embedder has learned from faces of this renderer: its figures do not say how well "
    "people can be recognised. Read them beside those of a network that has learned from "
    "photographs, as recognition=[shipped,dlib] gives them."
)


def about_recognition(
    recognition: RecognitionSettings, landmarks: Sequence[Landmarks]
) -> tuple[list[str], list[str]]:
    """Return what was done, and what was not.

    Args:
        recognition: As asked for.
        landmarks: Of which sources there were any.
    """
    done = [_LANDMARKS[one] for one in landmarks]
    done += [_WHOLE] if recognition.fallback == "whole_image" else []
    ours = recognition.model is None and "shipped" in recognition.recognisers
    not_done = [] if "own" in landmarks else [_NO_DETECTOR]
    not_done += [_SHIPPED] if ours else []
    return done, not_done
