"""Row 32: texels as integers that are coded by the sRGB curve.  [IEC61966]"""
from mpmath import mpf

from table import Table


def linear(coded):
    return coded / mpf("12.92") if coded <= mpf("0.04045") else ((coded + mpf("0.055")) / mpf("1.055")) ** mpf("2.4")


def tables():
    codes = Table("srgb_codes", """
Linear values of integers of 8 and 16 bits that are coded as sRGB.
""", "bits code linear")
    for bits in (8, 16):
        largest = 2**bits - 1
        for code in sorted({0, 1, 2, largest // 300, largest // 25, largest // 24, largest // 7, largest // 2,
                            largest - 1, largest}):
            codes.add(bits, code, linear(mpf(code) / largest))
    yield codes
