"""Row 24: means of very many samples of two sizes, from their counts instead of sums."""
from mpmath import mpf

from table import Table


def tables():
    means = Table("means", """
The mean of `count` samples: number i is `large` where i modulo `period` is `offset`, else `small`.
""", "count large small period offset mean")
    many, whole = 10**8, 2**30
    for count, large, small, period, offset in (
            (whole, 0.1, 0.1, 1, 0),  # stalls in float at 2^21
            (whole, 1e30, 1.0, whole, 0),  # one among 1e9, at the beginning and at the end
            (whole, 1e30, 1.0, whole, whole - 1),
            (many, 16777216.0, 1.0, many, 0),  # in float each 1 is lost
            (many, 0.7, 1e-8, 1000, 3),
            (many, 1e8, 1e-8, 1000, 999),
            (many, 1.0, 1e-30, 7, 0),
            (many, 3e38, 0.1, 2, 1),
            (many, 1.0 + 2.0**-52, 1.0, 3, 1)):
        times = (count - offset + period - 1) // period
        means.add(count, large, small, period, offset,
                  (times * mpf(large) + (count - times) * mpf(small)) / count)
    yield means
