#!/usr/bin/env python3
"""clang-tidy over a build by clang, several files at once. It remembers the preprocessed text of clean files,
with comments, and checks only files that have changed since. Prints each finding once; exit status 1 if there are any.

Usage: tidy.py [--newest N] CLANG_TIDY CLANG BUILD_FOLDER JOBS FOLDER...

  --newest N  only files that the last N commits have changed, or their headers; all if there are fewer commits

FOLDER is one of common, peer and tools; headers of all three are read where a file includes them.
"""

import concurrent.futures
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys

HEADERS = "/(common|peer|tools)/[^ ]*[.](h|cpp)$"
# Files of a unity build include others.
CHECKS = "-bugprone-suspicious-include"
LIMIT = 600  # s for one file


def run(command, **more):
    return subprocess.run(command, capture_output=True, check=False, timeout=LIMIT, **more)


def key_of(entry, clang, common):
    """What the findings of a file depend on; None if it cannot be preprocessed."""
    words = shlex.split(entry["command"])
    while words and not os.path.basename(words[0]).startswith("clang"):
        del words[0]  # a compiler cache comes before the compiler
    words = [w for w in words if w != "-c"]
    if "-o" in words:
        del words[words.index("-o") : words.index("-o") + 2]
    done = run([clang, *words[1:], "-E", "-C"], cwd=entry["directory"])
    if done.returncode:
        return None
    here = os.getcwd()  # the same text in another folder is as clean
    text = hashlib.sha256(common)
    text.update(shlex.join(words).replace(here, ".").encode())
    text.update(done.stdout.replace(here.encode(), b"."))
    return text.hexdigest()


def findings_of(entry, tidy, clang, build, common, cache):
    key = key_of(entry, clang, common)
    clean = key and os.path.join(cache, key)
    if clean and os.path.exists(clean):
        os.utime(clean)
        return [], True
    done = run([tidy, "-quiet", "-p", build, f"-header-filter={HEADERS}", f"-checks={CHECKS}", entry["file"]])
    text = done.stdout.decode(errors="replace") + done.stderr.decode(errors="replace")
    found = [line for line in text.splitlines() if re.search(r"\b(warning|error): ", line)]
    if done.returncode and not found:
        found = [f"{entry['file']}: error: clang-tidy ended with {done.returncode}: {text.strip()[-300:]}"]
    if clean and not found:
        with open(clean, "w", encoding="utf-8"):
            pass
    return found, False


def forget(cache, most=4000):
    """Of what was clean, what was looked for last stays."""
    files = sorted((f.path for f in os.scandir(cache)), key=os.path.getmtime)
    for path in files[:-most]:
        os.unlink(path)


def changed_by(newest):
    """Files that so many commits have changed, without their endings; None if there are not so many."""
    done = run(["git", "log", f"-{newest}", "--name-only", "--pretty=format:commit %h"])
    lines = done.stdout.decode(errors="replace").splitlines()
    if done.returncode or sum(line.startswith("commit ") for line in lines) < newest:
        return None
    return {os.path.splitext(line)[0] for line in lines if line.endswith((".cpp", ".h"))}


def has_changed(entry, changed):
    """The file itself, or one that it includes: those of a unity build are made of others."""
    if not os.path.exists(entry["file"]):
        return True  # not generated: clang-tidy says so
    with open(entry["file"], encoding="utf-8") as f:
        parts = [os.path.relpath(entry["file"]), *re.findall(r'#include "([^"]+)"', f.read())]
    return any(os.path.splitext(part)[0] in changed for part in parts)


def main():
    arguments = sys.argv[1:]
    changed = None
    if arguments[0] == "--newest":
        changed = changed_by(int(arguments[1]))
        del arguments[:2]
    tidy, clang, build, jobs, *folders = arguments
    ours = re.compile(f"/({'|'.join(folders)})/[^ ]*[.]cpp$")
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    cache = os.path.join(home, "padr-tidy")
    os.makedirs(cache, exist_ok=True)
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as f:
        entries = [e for e in json.load(f) if ours.search(e["file"])]
    with open(".clang-tidy", "rb") as f:
        common = f.read() + run([tidy, "--version"]).stdout + (HEADERS + CHECKS).encode()
    if not entries:
        sys.exit(f"tidy.py: {build} compiles no file of ours")
    if changed is not None:
        entries = [e for e in entries if has_changed(e, changed)]
    everything, known = set(), 0
    with concurrent.futures.ThreadPoolExecutor(int(jobs)) as pool:
        for found, was_known in pool.map(lambda e: findings_of(e, tidy, clang, build, common, cache), entries):
            everything.update(found)
            known += was_known
    print(f"{len(entries)} files, {known} of them known to be clean")
    print("\n".join(sorted(everything)))
    forget(cache)
    return 1 if everything else 0


if __name__ == "__main__":
    sys.exit(main())
