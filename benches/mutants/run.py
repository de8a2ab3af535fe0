#!/usr/bin/env python3
"""Which changes of the code the tests of a crate notice: run.py CRATE PATH... [--sample N [--seed S]] [--out FILE]

Run it in a worktree that is thrown away, since it changes sources: `git worktree add --detach ../mutants && cd ../mutants`.
CRATE is a folder of the workspace, PATH a file or folder in it. All mutants of the paths are built at once, as switches (src/main.rs), so that the crate is compiled once
and not once for each. A first run of each test alone notes which switches it reaches; a mutant is then tried with the tests that reach it, the quickest first, until one
fails. With --sample N so many mutants are woven in, drawn at random, the same ones for the same seed. FILE (mutants.jsonl) has a line a mutant, and a run goes on from it.
"""
import argparse
import json
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROUNDS = 12  # of leaving out what does not compile
SLOW = (10.0, 20.0)  # seconds, and times what the test takes: then a mutant is noticed as one that hangs
WITHOUT = {"hull", "kinematics"}  # crates without the feature serde


def cargo(verb, crate, *more):
    features = [] if crate in WITHOUT else ["--features", "serde"]
    # What overflows or fails whatever it is given compiles, and fails where it runs.
    allowed = "-Awarnings -Aarithmetic_overflow -Aunconditional_panic"
    env = dict(os.environ, RUSTFLAGS=allowed, CARGO_PROFILE_DEV_DEBUG="false")
    command = ["cargo", *verb, "-p", f"curvlay-{crate}", *features, *more]
    return subprocess.run(command, env=env, capture_output=True, text=True)


def messages(output):
    for line in output.splitlines():
        if line.startswith("{"):
            yield json.loads(line)


def switches_at(span):
    """The switches that an error at a place of the sources may be of."""
    path = Path(span["file_name"])
    if not path.is_file() or path.is_absolute():
        return set()
    text, at = path.read_bytes(), span["byte_start"]
    before = re.findall(rb"switched\((\d+)\)", text[:at])[-1:]
    # An error of a whole `if` begins before its first switch.
    behind = re.findall(rb"^\(?if crate::mutant_switch::switched\((\d+)\)", text[at : at + 80])
    return {int(number) for number in before + behind}


def weave(crate, paths, sample, seed):
    """Weaves the mutants in, or so many of them, without those that do not compile; how many these are."""
    subprocess.run(["cargo", "build", "--release", "-q", "--manifest-path", HERE / "Cargo.toml"], check=True)
    tool = next(Path(os.environ.get("CARGO_TARGET_DIR", HERE / "target")).glob("release/curvlay-mutants"))
    files = [file for path in paths for file in ([crate / path] if (crate / path).is_file() else sorted((crate / path).rglob("*.rs")))]

    def woven_without(mutants):
        subprocess.run(["git", "checkout", "-q", "--", crate / "src"], check=True)
        (crate / "without.json").write_text(json.dumps(sorted(mutants)))
        subprocess.run([tool, crate, *(file.relative_to(crate) for file in files)], check=True)
        return {mutant["id"] for mutant in json.loads((crate / "mutants.json").read_text())}

    every = woven_without([])
    drawn = every if sample is None else set(random.Random(seed).sample(sorted(every), min(sample, len(every))))
    without = set()
    for _ in range(ROUNDS):
        woven_without(every - drawn | without)
        checked = cargo(["check", "-q", "--message-format=json"], crate.name)
        said = [item["message"] for item in messages(checked.stdout) if item["reason"] == "compiler-message"]
        errors = [message for message in said if message["level"] == "error"]
        if not errors:
            return len(without)
        spans = [span for error in errors for part in [error, *error["children"]] for span in part["spans"]]
        found = set().union(*map(switches_at, spans)) - without
        if not found:
            sys.exit(errors[0]["rendered"])
        without |= found
    sys.exit(f"{crate} does not compile after {ROUNDS} rounds")


def run(crate, binary, test, limit, **more):
    """How a test ends: 0, another code, or `slow`; and the seconds it takes."""
    env = dict(os.environ, PROPTEST_RNG_SEED="1", PROPTEST_MAX_SHRINK_ITERS="0", PROPTEST_DISABLE_FAILURE_PERSISTENCE="1", RUST_BACKTRACE="0", RAYON_NUM_THREADS="1", **more)
    start = time.time()
    try:
        command = [binary, "--exact", test, "--test-threads", "1"]
        code = subprocess.run(command, cwd=crate, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=limit).returncode
    except subprocess.TimeoutExpired:
        code = "slow"
    return code, time.time() - start


def tests_of(crate):
    """All tests that need no data from elsewhere, each with its binary."""
    built = cargo(["test", "--lib", "--test", "all", "--no-run", "--message-format=json"], crate.name)
    binaries = [item["executable"] for item in messages(built.stdout) if item.get("executable")]
    if built.returncode:
        sys.exit(built.stderr)
    for binary in binaries:
        names = [subprocess.run([binary, "--list", "--format", "terse", *more], cwd=crate, capture_output=True, text=True).stdout.splitlines() for more in [[], ["--ignored"]]]
        yield from ((binary, line.removesuffix(": test")) for line in names[0] if line.endswith(": test") and line not in names[1])


def reached(crate, tests, workers):
    """For each switch the tests that reach it, the quickest first."""

    def look(item):
        binary, test = item
        with tempfile.NamedTemporaryFile() as file:
            code, seconds = run(crate, binary, test, 900, MUTANTS_REACHED=file.name)
            return binary, test, code, seconds, set(map(int, file.read().split()))

    by_switch = defaultdict(list)
    with ThreadPoolExecutor(workers) as pool:
        for binary, test, code, seconds, switches in pool.map(look, tests):
            if code != 0:
                print(f"{test} fails without a mutant ({code}): not used")
                continue
            for switch in switches:
                by_switch[switch].append((seconds, binary, test))
    return {switch: sorted(tests) for switch, tests in by_switch.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("crate", type=Path)
    parser.add_argument("paths", nargs="+")
    parser.add_argument("--sample", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("mutants.jsonl"))
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    args = parser.parse_args()
    crate = args.crate
    uncompiled = weave(crate, args.paths, args.sample, args.seed)
    mutants = json.loads((crate / "mutants.json").read_text())
    tests = list(tests_of(crate))
    print(f"{len(mutants)} mutants, {uncompiled} more do not compile; {len(tests)} tests", flush=True)
    tests_by_switch = reached(crate, tests, args.workers)
    done = {row["id"]: row for row in map(json.loads, args.out.read_text().splitlines())} if args.out.exists() else {}

    def judge(mutant):
        if mutant["id"] in done:
            return done[mutant["id"]]
        row = dict(mutant, became="survived" if mutant["id"] in tests_by_switch else "not reached")
        for seconds, binary, test in tests_by_switch.get(mutant["id"], []):
            code, _ = run(crate, binary, test, SLOW[0] + SLOW[1] * seconds, MUTANT=str(mutant["id"]))
            if code != 0:
                row = dict(row, became="slow" if code == "slow" else "caught", by=test)
                break
        with open(args.out, "a") as out:
            print(json.dumps(row), file=out)
        return row

    with ThreadPoolExecutor(args.workers) as pool:
        rows = list(pool.map(judge, mutants))
    for row in rows:
        if row["became"] in ("survived", "not reached"):
            print(f"{row['file']}:{row['line']}:{row['column']} {row['in']}: {row['what']} ({row['became']})")
    count = Counter(row["became"] for row in rows)
    noticed = (count["caught"] + count["slow"]) / max(len(rows), 1)
    print(f"{len(rows)} tried: {dict(count)}, {100 * noticed:.1f} % noticed")


main()
