#!/usr/bin/env bash
# Writes docs/precision.md to standard output, from what the benchmarks of a build folder print.  Wants an idle machine.
set -euo pipefail
usage="usage: $0 BUILD_FOLDER, such as build/release, in which traversal_bench, precision_bench and tile_precision_bench are built (make precision)"
[ $# -eq 1 ] || { echo "$0: $# arguments given, wants one; $usage" >&2; exit 2; }
bench="$1/tests/bench"
[ -d "$1" ] || { echo "$0: $1: no such folder; $usage" >&2; exit 2; }
for program in precision_bench tile_precision_bench traversal_bench; do
  [ -x "$bench/$program" ] || { echo "$0: $bench/$program is not built; $usage" >&2; exit 2; }
done
cat <<'END'
# Precision and its price

What the server computes in, and why: three tables, each of what one program measured side by side.  `make precision` writes all of this
page (it wants an idle machine; times are medians of processor time, and only their ratios travel to other machines).

## Light in float or in double: the error

Lights of 1 m (sphere and cylinder 1 cm), 40 receivers 1 cm to 16 m away; nanoseconds a sample, and the worst relative error against references of
30 digits ([ordinary_lights.txt](../tests/data/extremes/ordinary_lights.txt), made by [ordinary.py](../tests/data/extremes/ordinary.py), whose
formulas are not the code's): about the scene's zero, and 5 km from it, where floats are 0.2 to 0.5 mm apart.  What is compared is the value of a
sample, over its density where it has one; of disks, whose density is not even, the mean over all sample values.

END
"$bench/precision_bench"
cat <<'END'

Most formulas are worked out in double either way; what differs is what they are given and where answers are kept.

## Light in float or in double: the time

Rule: double, if it costs less than a tenth of a tile's time.  Tiles of 64 x 64 pixels, four paths each, of the scenes that Lucerna is compared
with pbrt-v4 by ([tests/data/reference](../tests/data/reference)) and of [demo.pbrt](../scenes/demo.pbrt), rendered by the server's renderer on one
thread.  In the same run the same paths are walked again, and lights in float and in double answer in turns what the paths ask: samples and
densities.  The share is what lights in double take of the tile's time, beyond which no other type could save anything; the cost is what they take longer
than lights in float, of the time that the tile would take with those.

END
"$bench/tile_precision_bench"
cat <<'END'

Numbers are rounded to floats once, on the wire.  What stays in floats before that: rays and the vertices that they hit, as Embree takes nothing
else (lights of meshes keep theirs in double too); their errors are bounded (`server/error_bounds.h`) and rows 22 and 23 of
[the extremes](extremes.md) hold the bounds to double.

## Embree's robust or default traversal

A closed ball of triangles from within, 600,000 rays, every one of which has a hit: a third in any direction, a third
through vertices, a third through the middles of edges.  `lost`: nothing was found.  `off`: how far the hit is from
the triangle's plane in double, in float roundings of the largest coordinate.

END
"$bench/traversal_bench"
cat <<'END'

Light that leaks through a wall is not a price, so **the server always traverses robustly**; it has no option for it.
END
