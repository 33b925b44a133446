"""A recording verified: its run done again from its own contents, each record compared with the recorded one."""

from __future__ import annotations

from collections.abc import Callable
from operator import itemgetter

from vdoor.emit import Emit
from vdoor.errors import RecordingError, VdoorError
from vdoor.recording.diff import Comparison, Listener, Report, ignore
from vdoor.recording.mcap import Recording

Rerun = Callable[[Recording, Emit], object]
"""Does a recorded run again and emits its records."""


def verify(recording: Recording, rerun: Rerun, *, listen: Listener = ignore) -> Report:
    """How a run done again compares with its recording, which is read as the run goes.

    A run that is refused half way has stopped: that is a difference. Raises `RecordingError` where the recording is
    damaged, and what `rerun` raises before its first record: then there is nothing to compare.
    """
    comparison = Comparison(map(itemgetter(1), recording), recording.types, listen=listen)
    try:
        rerun(recording, comparison)
    except RecordingError:
        raise
    except VdoorError as error:
        if comparison.records == 0:
            raise
        return comparison.finish(stopped=str(error))
    return comparison.finish()
