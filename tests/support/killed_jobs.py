"""A job of a batch whose process is killed; in a module of its own, since the processes of a batch import it."""

from __future__ import annotations

import os
import signal

from vdoor.batch.job import Job, Outcome, done


def die_at_first(job: Job) -> Outcome:
    """Kill the process that works on the first house; do the others."""
    if job.map_file.stem == "house0":
        os.kill(os.getpid(), signal.SIGKILL)
    return done(job)
