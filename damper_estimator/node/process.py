"""Settings of the process: real-time priority, and no pauses by the garbage collector."""

import gc
import os
from pathlib import Path


def tame_garbage_collector() -> None:
    """Exempts all present objects from collection, and leaves collecting to `collect_garbage`."""
    gc.collect()
    gc.freeze()
    gc.disable()


def collect_garbage() -> None:
    """Collects newer objects; short, because all older ones are exempt."""
    gc.collect()


def set_realtime_priority(priority: int) -> str:
    """Requests SCHED_FIFO for every thread of the process; 0 requests nothing.

    Returns:
        A message for the user if it is not permitted, else "".
    """
    if not priority:
        return ""
    try:
        for thread in Path("/proc/self/task").iterdir():
            os.sched_setscheduler(int(thread.name), os.SCHED_FIFO, os.sched_param(priority))
    except (OSError, AttributeError) as error:
        reason = getattr(error, "strerror", None) or error
        return (
            f"realtime_priority {priority} is not allowed here ({reason}); the node runs at ordinary priority. Allow "
            f"it with 'username - rtprio {priority}' in /etc/security/limits.conf and a new login, in a container with "
            f"--cap-add=SYS_NICE --ulimit rtprio={priority}"
        )
    return ""
