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

This page shows the cost and the gain of double precision and of robust rays.  In short: double costs less than a tenth
of a tile's time.  In the scenes of this page, robust rays take less than a fifth longer than default rays.  Both are
always on.

    make precision

This command writes this page.  It needs an idle machine.  Each of the three tables comes from one program, which
measured its columns side by side.  Times are medians of processor time.  Only their ratios apply to other machines.

## Light in float or in double: the error

Area lights are 1 m wide, except the sphere and the cylinder of 1 cm.  There are 40 receivers, 1 cm to 16 m away.  The
table has nanoseconds a sample, and the worst relative error ("off") near the origin and 5 km from it.  At 5 km,
neighbouring floats are 0.2 to 0.5 mm apart.

References have 30 digits ([ordinary_lights.txt](../tests/data/extremes/ordinary_lights.txt)).
[ordinary.py](../tests/data/extremes/ordinary.py) computes them with other formulas than the code's.  The error is that
of a sample's value, divided by its density if it has one.  The density of a disk's samples is not uniform, so disks use
the mean over all sample values.

END
"$bench/precision_bench"
cat <<'END'

Both versions compute most formulas in double.  They differ in the type of their inputs and results.

## Light in float or in double: the time

The rule is: use double if it costs less than a tenth of a tile's time.  Tiles have 64 x 64 pixels with four paths for
each pixel.  The server's renderer renders them on one thread.  The scenes are those that Lucerna compares with pbrt-v4
([tests/data/reference](../tests/data/reference)), and [demo.pbrt](../scenes/demo.pbrt).

Then the same program follows the same paths again, and evaluates only the lights: alternately in float and in double.
In the table, an evaluation is one sample or one density of a light.

- The share is the part of the tile's time that lights in double take.  No cheaper type could save more than this share.
- The cost is the additional time of lights in double, relative to the tile's time with lights in float.

END
"$bench/tile_precision_bench"
cat <<'END'

Answers become floats once, in the message.  Rays and the vertices that they hit are floats before that, because Embree
accepts only floats.  Lights of meshes also keep their vertices in double.  Bounds on the errors of floats are in
`server/rays/error_bounds.h`.  Rows 22 and 23 of [the extremes](extremes.md) compare these bounds with double.

## Embree's robust or default traversal

All 600,000 rays of a row start inside a closed ball of triangles, so each ray has a hit.  A third of the rays have
random directions, a third go through vertices, a third through the middles of edges.  "Lost" counts rays without a hit,
for each third.  "Off" is the largest error of a hit's distance along its ray, in float roundings of the largest
coordinate.

END
"$bench/traversal_bench"
cat <<'END'

A ray that leaks through a wall is an error, so **the server always traverses robustly**.  No option changes this.
END
