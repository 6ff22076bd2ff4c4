#!/usr/bin/env python3
"""Do the tests notice a defect? Puts each of mutants.txt into a copy of the sources, builds it, and runs the tests.

A mutant is caught if a test fails, crashes or takes longer than the limit; one that does not compile is not. The tests that should
catch it run first; where they pass, all quick tests do (unless --expected-only). Results are appended to results.jsonl in the
scratch folder: the same command goes on where it was stopped, and takes up again a mutant whose text, file or tests have changed. Exit
code: 0 if at least 90 % of the mutants tried are caught, 1 if fewer, 2 where a mutant no longer fits the sources.
"""

import argparse
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TIERS = ("unit", "statistical", "oracle", "agreement", "faults")
REQUIRED_SHARE = 0.9


class Mutant:
    def __init__(self, name):
        self.name, self.file, self.tests = name, "", []
        self.before, self.after = [], []

    def text(self):
        return "\n".join(self.before), "\n".join(self.after)

    def key(self, source):
        """Changes with whatever the result depends on, but for the rest of the sources."""
        return hashlib.sha256(json.dumps([self.file, self.tests, self.before, self.after, source]).encode()).hexdigest()[:16]


def fail(message):
    print(message, file=sys.stderr)
    sys.exit(2)


def read_mutants(path):
    mutants = []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if line.startswith("["):
            mutants.append(Mutant(line.strip("[]")))
        elif line.startswith("-"):
            mutants[-1].before.append(line[1:])
        elif line.startswith("+"):
            mutants[-1].after.append(line[1:])
        elif line.startswith("file "):
            mutants[-1].file = line[5:].strip()
        elif line.startswith("tests "):
            for part in line[6:].split("|"):
                tier, _, pattern = part.strip().partition(": ")
                if tier not in TIERS or not pattern:
                    fail(f"{path}:{number}: '{part.strip()}'; expected TIER: FILTER with TIER one of {', '.join(TIERS)}")
                mutants[-1].tests.append((tier, pattern.strip()))
        elif line.strip() and not line.startswith("#"):
            fail(f"{path}:{number}: '{line}'; expected [name], file, tests, -before or +after")
    names = [m.name for m in mutants]
    for m in mutants:
        if names.count(m.name) > 1:
            fail(f"{path}: [{m.name}] occurs twice")
        if not m.tests:
            fail(f"{path}: [{m.name}] names no tests")
        source = ROOT / m.file
        if not source.is_file():
            fail(f"{path}: [{m.name}]: no file {m.file}")
        before, after = m.text()
        count = source.read_text().count(before) if before else 0
        if count != 1 or before == after:
            fail(f"{path}: [{m.name}]: its text occurs {count} times in {m.file}; expected once, and a change:\n{before}")
    return mutants


class Scratch:
    """A copy of the sources with a build of its own. It has the shape of the repository, so that ccache finds its objects."""

    def __init__(self, folder, jobs):
        self.folder, self.build, self.jobs = folder, folder / "build", jobs

    def prepare(self):
        listed = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-co", "--exclude-standard"], check=True,
                                capture_output=True, text=True).stdout.splitlines()
        for name in listed:
            source, copy = ROOT / name, self.folder / name
            if not source.is_file():
                continue
            if copy.is_file() and copy.read_bytes() == source.read_bytes():
                continue
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, copy)
            copy.chmod(source.stat().st_mode)
        if not (self.build / "build.ninja").is_file():
            launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
            self.run(["cmake", "-S", str(self.folder), "-B", str(self.build), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                      *launcher])

    def run(self, command):
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
        if done.returncode:
            fail(f"{' '.join(command)} failed:\n{(done.stdout + done.stderr)[-4000:]}")

    def compile(self, tiers):
        command = ["ninja", "-C", str(self.build), f"-j{self.jobs}", *(f"test_{tier}" for tier in tiers)]
        done = subprocess.run(command, capture_output=True, text=True)
        return done.returncode == 0, done.stdout + done.stderr

    def test(self, tier, pattern, limit):
        """The first test that fails; None where all pass."""
        # A failing test must not leave anything in the user's reference cache, nor find there what it should render.
        environment = dict(os.environ, XDG_CACHE_HOME=str(self.folder / "cache"))
        try:
            done = subprocess.run([str(self.build / "tests" / f"test_{tier}"), f"--gtest_filter={pattern}", "--gtest_fail_fast"],
                                  cwd=self.build / "tests", capture_output=True, text=True, errors="replace", timeout=limit,
                                  env=environment)
        except subprocess.TimeoutExpired:
            return "time limit"
        ran = re.search(r"Running (\d+) test", done.stdout)
        if done.returncode == 0:
            if not ran or ran[1] == "0":
                fail(f"test_{tier} has no test {pattern}")
            return None
        failed = re.search(r"\[  FAILED  \] (\S+)", done.stdout)
        return failed[1].rstrip(",") if failed else f"crash ({done.returncode})"

    def replace(self, name, before, after):
        path = self.folder / name
        text = path.read_text()
        if text.count(before) != 1:
            fail(f"{name} in {self.folder} is not as in the repository")
        path.write_text(text.replace(before, after))


def try_mutant(scratch, mutant, expected_only, limit):
    before, after = mutant.text()
    original = (scratch.folder / mutant.file).read_text()
    scratch.replace(mutant.file, before, after)
    try:
        tiers = list(dict.fromkeys(tier for tier, _ in mutant.tests))
        compiled, output = scratch.compile(tiers)
        if not compiled:
            errors = [line for line in output.splitlines() if "error" in line]
            return "does not compile", errors[0][-120:] if errors else ""
        for tier, pattern in mutant.tests:
            if failed := scratch.test(tier, pattern + "-Long*", limit):
                return "caught", failed
        if expected_only:
            return "survived", "the tests expected to catch it"
        scratch.compile(TIERS)
        for tier in TIERS:
            if failed := scratch.test(tier, "-Long*", 4 * limit):
                return "caught by others", failed
        return "survived", "all quick tests"
    finally:
        (scratch.folder / mutant.file).write_text(original)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--list", action="store_true", help="the mutants, and what is known of them")
    parser.add_argument("--only", metavar="NAME", action="append", help="this mutant; repeatable; tried anew")
    parser.add_argument("--expected-only", action="store_true", help="do not run all quick tests where the expected ones pass")
    parser.add_argument("--scratch", type=pathlib.Path, default=ROOT / "build" / "mutation", help="default: build/mutation")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--limit", type=float, default=300, help="seconds for the tests of a mutant; default 300")
    options = parser.parse_args()

    mutants = read_mutants(HERE / "mutants.txt")
    unknown = set(options.only or []) - {m.name for m in mutants}
    if unknown:
        fail(f"no mutant {', '.join(sorted(unknown))}; --list names them")
    scratch = Scratch(options.scratch.resolve(), options.jobs)
    results_file = scratch.folder / "results.jsonl"
    results = {}
    if results_file.is_file():
        for line in results_file.read_text().splitlines():
            result = json.loads(line)
            results[result["key"]] = result
    keys = {m.name: m.key((ROOT / m.file).read_text()) for m in mutants}
    if not options.list:
        scratch.folder.mkdir(parents=True, exist_ok=True)
        scratch.prepare()
        for mutant in mutants:
            wanted = mutant.name in options.only if options.only else keys[mutant.name] not in results
            if not wanted:
                continue
            began = time.monotonic()
            verdict, by = try_mutant(scratch, mutant, options.expected_only, options.limit)
            result = {"name": mutant.name, "key": keys[mutant.name], "verdict": verdict, "by": by,
                      "seconds": round(time.monotonic() - began, 1)}
            with results_file.open("a") as out:
                out.write(json.dumps(result) + "\n")
            results[result["key"]] = result
            print(f"{mutant.name}: {verdict} ({by}), {result['seconds']} s", file=sys.stderr, flush=True)

    tried = [results[keys[m.name]] for m in mutants if keys[m.name] in results]
    width = max(len(m.name) for m in mutants)
    for mutant in mutants:
        result = results.get(keys[mutant.name], {"verdict": "not tried", "by": ""})
        print(f"{mutant.name:{width}}  {result['verdict']:16}  {result['by']}")
    caught = sum(r["verdict"].startswith("caught") for r in tried)
    print(f"{caught} of {len(tried)} caught, {len(mutants) - len(tried)} not tried")
    return 0 if options.list or not tried or caught >= REQUIRED_SHARE * len(tried) else 1


if __name__ == "__main__":
    sys.exit(main())
