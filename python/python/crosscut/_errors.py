"""The exceptions of the package. Their texts are those of the program."""


class Error(Exception):
    """Base of all exceptions of this package."""


class SettingsError(Error, ValueError):
    """A preset, setting or value that there is not, with the nearest right one."""


class ReadError(Error):
    """A recording that cannot be read: what was found instead, and what to do."""


class StageError(Error):
    """A stage that cannot answer: which, on which scan, and why.

    ``__cause__`` is the exception that a stage of one's own raised, if it raised one.
    """


class MissingPackageError(Error, ImportError):
    """A package that this part of crosscut needs and that is not installed, and how to install it."""


class LossWarning(UserWarning):
    """A part of a recording that is damaged or missing; the rest was read."""
