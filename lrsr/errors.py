"""Which failures are the user's to mend: one line that names the file, the value and the remedy."""


class InputError(Exception):
    """What the user gave cannot be used; the command line prints the message and exits with 2.

    The message is one line: it names the file or the setting, the value found there, and what to
    do about it. Raise it at the place that knows all three.
    """


class ImageContractError(InputError, ValueError):
    """An image breaks the contract of :mod:`lrsr.images`; says what came and what was wanted."""


class NonFiniteError(RuntimeError):
    """A NaN or an infinity appeared in an image or a loss; the message says where."""


class DivergenceError(InputError, NonFiniteError):
    """Training has left all numbers behind; the message says at which step, and what to lower."""


class ScoreError(InputError, ValueError):
    """Scores cannot be evaluated; the message names the first offender and the remedy."""
