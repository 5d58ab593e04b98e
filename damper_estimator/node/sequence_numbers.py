"""Lost messages and two publishers of one damper, found by the sequence numbers on one topic. Independent of ROS.

Every publisher numbers its messages 1, 2, 3, ...; the middleware delivers those of one publisher in order and does not
name the publisher of a message.
"""

from collections.abc import Set

CONFIRMING = 3.0  # s within which a damper's numbers must fall twice; a restarted publisher makes them fall once
_MOST_LINES = 32


class Losses:
    """Counts the messages missing between the received ones, of all publishers together; final.

    Each message continues the line of numbers that ends closest below it. A mix-up of two publishers does not matter:
    after both have sent again the sum of the gaps is the same. A number below all lines, and the first jump after
    another publisher was discovered, begin a line: how many messages it sent before it discovered us is unknown.

    Attributes:
        lost: messages.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._lines: list[int] = []  # last numbers, the most recently used line first
        self._begun = self._matched = 0

    def matched(self, total: int) -> None:
        """Notes the total number of publishers discovered so far."""
        self._matched = total

    def take(self, number: int) -> None:
        """Notes the number of one message."""
        lines = self._lines
        if lines and number == lines[0] + 1:  # nearly always
            lines[0] = number
            return
        below = [line for line in lines if line < number]
        if not below or (max(below) + 1 != number and self._begun < self._matched):
            self._begun += 1
            del lines[_MOST_LINES - 1 :]
        else:
            last = max(below)
            self.lost += number - last - 1
            lines.remove(last)
        lines.insert(0, number)


class DoubleSenders:
    """Finds dampers with more than one publisher: the numbers of the messages that contain one do not rise; final.

    If one publisher ends and another begins they fall as well, but only once, and after a silence.

    Attributes:
        confirmed: messages by damper, once its numbers have fallen again.
    """

    def __init__(self) -> None:
        self.confirmed: dict[str, int] = {}
        self._last: dict[Set[str], tuple[int, float]] = {}
        self._fallen: dict[str, float] = {}
        self._highest = 0

    def take(self, number: int, dampers: Set[str], now: float, silence: float) -> bool:
        """Whether one message is suspect; to be called while there is more than one publisher.

        Args:
            number: of the message.
            dampers: contained in it; hashable.
            now: steady time, s.
            silence: s after which another publisher can take over, because the filter is reset.
        """
        doubled: set[str] = set()
        if number <= self._highest:
            for others, (last, at) in self._last.items():
                if number <= last and now - at <= silence:
                    doubled |= others & dampers
        self._last[dampers] = number, now
        if number > self._highest:
            self._highest = number
        elif len(self._last) > _MOST_LINES or not doubled:
            self._forget(now - silence)
        for name in doubled:
            if now - self._fallen.get(name, float("-inf")) <= CONFIRMING:
                self.confirmed = {**self.confirmed, name: self.confirmed.get(name, 0) + 1}
            self._fallen[name] = now
        return bool(doubled)

    def _forget(self, before: float) -> None:
        self._last = {dampers: (last, at) for dampers, (last, at) in self._last.items() if at >= before}
        self._highest = max((last for last, _ in self._last.values()), default=0)
