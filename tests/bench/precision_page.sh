#!/usr/bin/env bash
# Writes docs/precision.md to standard output, from benchmarks in a build folder.  Needs an idle machine.
set -euo pipefail
usage="usage: $0 BUILD_FOLDER, such as build/release, in which traversal_bench, precision_bench and tile_precision_bench are built (make precision)"
[ $# -eq 1 ] || { echo "$0: $# arguments given, allowed: one; $usage" >&2; exit 2; }
bench="$1/tests/bench"
[ -d "$1" ] || { echo "$0: $1: no such folder; $usage" >&2; exit 2; }
for program in precision_bench tile_precision_bench traversal_bench; do
  [ -x "$bench/$program" ] || { echo "$0: $bench/$program is not built; $usage" >&2; exit 2; }
done
cat <<'END'
# Precision and its price

This page shows what double precision and robust rays cost, and what they gain.  Each of the three tables comes from one program, which
measured its columns side by side.  `make precision` writes this page and needs an idle machine.  Times are medians of processor time.  Only
their ratios carry over to other machines.

## Light in float or in double: the error

Lights measure 1 m (sphere and cylinder 1 cm).  There are 40 receivers, 1 cm to 16 m away.  The table has nanoseconds a sample, and
the worst relative error ("off") near the scene's zero and 5 km from it.  At 5 km, floats are 0.2 to 0.5 mm apart.

References have 30 digits ([ordinary_lights.txt](../tests/data/extremes/ordinary_lights.txt)).  They come from
[ordinary.py](../tests/data/extremes/ordinary.py), by other formulas than the code's.  The error is that of a sample's value, divided by its density
where it has one.  The density of disks is not even, so disks use the mean over all sample values.

END
"$bench/precision_bench"
cat <<'END'

Both versions compute most formulas in double.  They differ in the type of their inputs and answers.

## Light in float or in double: the time

The rule is: double, if it costs less than a tenth of a tile's time.  Tiles have 64 x 64 pixels with four paths each.  The server's renderer renders
them on one thread.  The scenes are those that Lucerna compares with pbrt-v4 ([tests/data/reference](../tests/data/reference)), and
[demo.pbrt](../scenes/demo.pbrt).

The same run walks the same paths again.  Lights in float and in double return the samples and densities of these paths in turns.  In the table
an evaluation is one such sample or density.

- The share is the part of the tile's time that lights in double take.  No other type could save more.
- The cost is the additional time of lights in double, relative to the tile's time with lights in float.

END
"$bench/tile_precision_bench"
cat <<'END'

Numbers become floats once, on the wire.  Rays and the vertices that they hit are floats before that, because Embree takes nothing
else.  Lights of meshes keep their vertices in double too.  The errors of floats are bounded (`server/rays/error_bounds.h`).  Rows 22 and 23 of
[the extremes](extremes.md) compare these bounds with double.

## Embree's robust or default traversal

Rays start inside a closed ball of triangles, so each of the 600,000 rays has a hit.  A third goes in any direction, a third through vertices, a
third through the middles of edges.  "Lost" counts rays that found nothing, for each third.  "Off" is the distance of the hit from the
triangle's plane in double, in float roundings of the largest coordinate.

END
"$bench/traversal_bench"
cat <<'END'

A ray that leaks through a wall is an error, so **the server always traverses robustly**.  There is no option for it.
END
