"""Shared by the scripts of this folder: 60 digits, rounding to floats, and tables."""
import pathlib
import struct

from mpmath import mp, mpf

mp.dps = 60


def as_float(x):
    """The float (32 bits) nearest to x, as a Python number."""
    return struct.unpack("f", struct.pack("f", float(x)))[0]


def _text(value):
    # Inputs are exact doubles: their shortest form reads back as the same.  References are rounded to 30 digits.
    return mp.nstr(value, 30, min_fixed=1, max_fixed=0) if isinstance(value, mpf) else repr(value)


class Table:
    def __init__(self, name, about, columns):
        self.name, self.about, self.columns, self.rows = name, about, columns.split(), []

    def add(self, *values):
        """Adds a row: inputs as Python numbers or words, references as mpf."""
        assert len(values) == len(self.columns), values
        self.rows.append([v if isinstance(v, str) else _text(v) for v in values])

    def text(self):
        lines = [f"# {line}" for line in self.about.strip().splitlines()]
        lines.append(" ".join(self.columns))
        lines += [" ".join(row) for row in self.rows]
        return "\n".join(lines) + "\n"

    def path(self, folder):
        return pathlib.Path(folder) / f"{self.name}.txt"
