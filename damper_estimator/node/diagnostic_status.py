"""One status of ``/diagnostics`` (REP-107)."""

from collections.abc import Mapping
from socket import gethostname

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

HARDWARE = gethostname()
OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


def status(name: str, level: bytes, message: str, values: Mapping[str, object]) -> DiagnosticStatus:
    """One status with its values as text."""
    pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
    return DiagnosticStatus(level=level, name=name, message=message, hardware_id=HARDWARE, values=pairs)
