"""An interrupt at each step of a call, one after the other."""


class Interrupter:
    """Interrupts where a function of some files is entered or left, for the n-th time."""

    def __init__(self, number, within="pmjac_pin"):
        self.left, self._within = number, within

    def __call__(self, frame, event, arg):
        if self._within not in frame.f_code.co_filename:
            return None
        if event in {"call", "return"}:
            self.left -= 1
            if not self.left:
                raise KeyboardInterrupt
        return self
