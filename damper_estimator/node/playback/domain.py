"""A free ROS domain on this machine, so that rehearsals and tests do not meet other nodes."""

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager

from damper_estimator.errors import InputError

DOMAINS = range(20, 100)  # above 101 the ports can collide with those that Linux assigns


@contextmanager
def free_ros_domain() -> Iterator[int]:
    """Sets ``ROS_DOMAIN_ID`` to a free domain, and discovery to this machine, for this process and its children.

    The domain is reserved by the name of a socket, which the kernel frees when the process ends, in whatever way.

    Raises:
        InputError: if no domain is free.
    """
    with socket.socket(socket.AF_UNIX) as reserved:
        os.environ["ROS_DOMAIN_ID"] = str(_reserve(reserved))
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        yield int(os.environ["ROS_DOMAIN_ID"])


def _reserve(reserved: socket.socket) -> int:
    for domain in DOMAINS:
        try:
            reserved.bind(f"\0damper_estimator_domain_{domain}")
        except OSError:
            continue
        return domain
    raise InputError(
        f"ROS domains {DOMAINS.start} to {DOMAINS.stop - 1} are all in use by rehearsals; wait until one ends"
    )
