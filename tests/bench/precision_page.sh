#!/usr/bin/env bash
# Writes docs/precision.md from traversal_bench and precision_bench of the build folder $1.  Wants an idle machine.
set -euo pipefail
bench="$1/tests/bench"
cat <<'END'
# Precision and its price

What the server computes in, and why: two comparisons, each side by side in one run (`make precision` on an idle
machine; times are medians, and only their ratios travel to other machines).

## Light in float or in double

Rule: double, if it costs less than a tenth of a tile's time.  It costs next to nothing, as most formulas are worked out in
double either way; what differs is what they are given and where answers are kept.  So **lights compute in double** from
the receiver to the answer, and numbers are rounded to floats once, on the wire.

Lights of 1 m (sphere and cylinder 1 cm), receivers 1 cm to 16 m away; nanoseconds a sample, and the worst relative error
of the irradiance that a sample stands for: about the scene's zero, and 5 km from it, where floats are 0.2 to 0.5 mm apart.

END
"$bench/precision_bench"
cat <<'END'

Tiles of `BM_RenderTile` (`make bench`) when lights became double, against a build in which they were float (4f91bfd and b322fce,
between which other lines changed too; median of seven interleaved pairs, not measured by `make precision`): point 0.98,
sphere 0.96, many_points 1.08, bounces 0.92, demo 0.97 times the time.  The worst is within the tenth.

What stays in floats: vertices and rays, which Embree takes in nothing else; their errors are bounded
(`server/error_bounds.h`) and rows 22 and 23 of [the extremes](extremes.md) hold the bounds to double.

## Embree's robust or default traversal

A closed ball of triangles from within, 600,000 rays, every one of which has a hit: a third in any direction, a third
through vertices, a third through the middles of edges.  `lost`: nothing was found.  `off`: how far the hit is from
the triangle's plane in double, in float roundings of the largest coordinate.

END
"$bench/traversal_bench"
cat <<'END'

Default traversal loses rays that pass through edges and vertices; robust traversal loses a few of those aimed at vertices
to the last bit and none of the others, for about a tenth to a fifth of a ray's time.  Light that leaks through a wall is not a
price, so **the server always traverses robustly**; it has no option for it.
END
