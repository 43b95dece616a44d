#!/usr/bin/env python3
"""Prints automatic's time over the best setting's, for each scene and error that deploy/tradeoff.sh measured.

    tests/bench/automatic_table.py FRESH [CHOSEN]

FRESH holds NAME/tradeoff.json.  The best setting is the fastest of the same study.  This favours it: of many equally
good settings, the luckiest one is chosen.  With CHOSEN, a study with other seeds, the best setting is also chosen from
that study and then measured by FRESH alone.  The goal is a ratio of at most 1.5.
"""

import json
import pathlib
import sys


def load(directory):
    files = sorted(pathlib.Path(directory).glob("*/tradeoff.json"))
    return {f.parent.name: json.loads(f.read_text()) for f in files}


def reached(report, setting, level):
    """Seconds to the level, and whether they are measured; None if the setting never reaches the level."""
    for s in report["settings"]:
        if s["name"] == setting:
            entry = s["time_to_error"][level]
            return (entry["seconds"], entry["how"] != "extrapolated") if entry["seconds"] else None
    return None


def ratio(report, best, level):
    automatic, other = reached(report, "automatic", level), best and reached(report, best, level)
    if not automatic or not other:
        return "-"
    mark = "" if automatic[1] and other[1] else "*"
    return f"{automatic[0] / other[0]:.2f}{mark}"


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    fresh, chosen = load(sys.argv[1]), load(sys.argv[2]) if len(sys.argv) == 3 else {}
    if not fresh:
        sys.exit(f"{sys.argv[1]}: no NAME/tradeoff.json")
    rows = [("scene", "error", "automatic [s]", "over the best here", "which", "over the best of other seeds", "which")]
    for scene, report in fresh.items():
        for level, entry in enumerate(report["levels"]):
            automatic = reached(report, "automatic", level)
            best = entry.get("best")
            before = chosen.get(scene)
            earlier = before["levels"][level].get("best") if before else None
            below = " (below the reference's error)" if entry["below_reference"] else ""
            rows.append((scene, f"{100 * entry['error']:g}%", f"{automatic[0]:.3g}" if automatic else "-",
                         ratio(report, best, level), (best or "none reached it") + below,
                         ratio(report, earlier, level) if earlier else "-", earlier or "-"))
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    for row in rows:
        print("  ".join(text.ljust(width) for text, width in zip(row, widths)).rstrip())
    print("* extrapolated by the rate of the largest amounts")


if __name__ == "__main__":
    main()
