"""What goes wrong, in the words of the command line ``mlr-ga``."""


class Error(Exception):
    """Any error of mlr.

    Attributes
    ----------
    exit_status : int
        The exit status with which the command line ends for the same reason.
    """

    exit_status = 2


class BadInput(Error, ValueError):
    """Wrong usage or unreadable input: an argument, an array or a file."""

    exit_status = 2


class CannotAnswer(Error):
    """The recording cannot answer: too short, no motion, sampled too slowly, mostly missing."""

    exit_status = 1
