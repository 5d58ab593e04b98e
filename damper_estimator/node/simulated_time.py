"""Simulated time that goes on if its clock stops while messages keep arriving."""

PATIENCE = 2.0  # s, as long as messages arrive although the clock stands still; a clock may tick once a second


class SimulatedTime:
    """The time by which inputs and desired forces get old; final.

    A simulation that pauses sends no messages, and time stands still rightly. Where messages go on without a clock
    (``use_sim_time`` on a vehicle, or a clock that has died), nothing would ever be too old: time goes on at the pace
    of this machine.
    """

    def __init__(self) -> None:
        self._value = float("nan")
        self._moved = self._heard = float("-inf")  # steady, s

    @property
    def has_stopped(self) -> bool:
        """Whether messages have arrived although the clock stands still."""
        return self._heard - self._moved > PATIENCE

    def hear(self, steady: float) -> None:
        """A message arrived at the steady time, s."""
        self._heard = steady

    def seconds(self, clock: float, steady: float) -> float:
        """The time, s.

        Args:
            clock: s, of the simulation's clock; 0 before its first message.
            steady: s.
        """
        if clock != self._value:
            self._value, self._moved = clock, steady
        return clock + (steady - self._moved if self.has_stopped else 0.0)
