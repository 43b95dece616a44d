#!/usr/bin/python3
"""Runs the fuzz targets of build/fuzz one after the other.

    run_fuzz.py SHORT [TARGET...]          60 s each
    run_fuzz.py LONG [TARGET...]           a million runs each
    run_fuzz.py RUNS=N | SECONDS=N [TARGET...]

New inputs of a run stay in build/fuzz/corpus.  An input that ends a target, takes longer than 25 s
or 2 GB, or leaks is written to build/fuzz/findings, and the script ends with status 1.  Such an
input belongs into tests/fuzz/corpus, with the name found_..., when the code is mended.
"""
import os
import pathlib
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FUZZ = ROOT / "tests/fuzz"
BUILD = ROOT / "build/fuzz"
LONG_RUNS = 1_000_000
SHORT_SECONDS = 60
INPUT_SECONDS = 25
MEGABYTES = 2048


def bound(word):
    """The option of libFuzzer that ends a run."""
    if word == "SHORT":
        return f"-max_total_time={SHORT_SECONDS}"
    if word == "LONG":
        return f"-runs={LONG_RUNS}"
    name, _, number = word.partition("=")
    if name in ("RUNS", "SECONDS") and number.isdigit() and int(number) > 0:
        return f"-runs={number}" if name == "RUNS" else f"-max_total_time={number}"
    sys.exit(f"run_fuzz.py: {word}, allowed: SHORT, LONG, RUNS=N or SECONDS=N")


def fuzz(target, limit):
    """Prints one line, and returns whether the target ended well."""
    new, findings = BUILD / "corpus" / target, BUILD / "findings"
    new.mkdir(parents=True, exist_ok=True)
    findings.mkdir(parents=True, exist_ok=True)
    # libFuzzer's count of rare features took a quarter of the time of glTF files and a third of that
    # of requests.
    command = [BUILD / "tests/fuzz" / target, limit, "-entropic=0", f"-timeout={INPUT_SECONDS}",
               f"-rss_limit_mb={MEGABYTES}", f"-artifact_prefix={findings}/{target}-",
               "-print_final_stats=1", new, FUZZ / "corpus" / target]
    dictionary = FUZZ / "dictionaries" / f"{target}.dict"
    if dictionary.exists():
        command.insert(1, f"-dict={dictionary}")
    # OpenImageIO and Embree check what they allocate.  AddressSanitizer keeps freed memory, so a
    # target that frees large blocks would reach MEGABYTES without a fault.
    asan = ("allocator_may_return_null=1:detect_leaks=1:quarantine_size_mb=16:"
            "allocator_release_to_os_interval_ms=500")
    environment = {**os.environ, "ASAN_OPTIONS": asan,
                   "LSAN_OPTIONS": f"suppressions={FUZZ / 'lsan.supp'}:print_suppressions=0",
                   "LLVM_PROFILE_FILE": "/dev/null"}
    begin = time.monotonic()
    log = findings / f"{target}.log"
    with log.open("wb") as out:
        status = subprocess.run([str(part) for part in command], stdout=out, stderr=out,
                                env=environment, cwd=ROOT, check=False).returncode
    seconds = time.monotonic() - begin
    text = log.read_text(errors="replace")
    runs = re.search(r"stat::number_of_executed_units: *(\d+)", text)
    memory = re.search(r"stat::peak_rss_mb: *(\d+)", text)
    end = "no finding" if status == 0 else f"FINDING, see {log.relative_to(ROOT)}"
    print(f"{target:16} {runs[1] if runs else '?':>9} runs {seconds:7.0f} s "
          f"{memory[1] if memory else '?':>5} MB  {end}", flush=True)
    return status == 0


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    limit = bound(sys.argv[1])
    known = sorted(path.name for path in (FUZZ / "corpus").iterdir())
    targets = sys.argv[2:] or known
    for target in targets:
        if target not in known:
            sys.exit(f"run_fuzz.py: {target}, allowed: {', '.join(known)}")
        if not (BUILD / "tests/fuzz" / target).exists():
            sys.exit(f"run_fuzz.py: {target} is not built; make fuzz builds it")
    ended_well = [fuzz(target, limit) for target in targets]
    return 0 if all(ended_well) else 1


if __name__ == "__main__":
    sys.exit(main())
