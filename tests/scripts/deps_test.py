#!/usr/bin/env python3
"""tools/deps.sh beside a dpkg and an apt-get that only say what they were asked.

Usage: deps_test.py REPOSITORY [unittest arguments]
"""

import os
import unittest

from stand_in import REPOSITORY, Case

DEPS = os.path.join(REPOSITORY, "tools", "deps.sh")

# Understands what the script asks: the format with its fields, and names of packages or none for all.
DPKG_QUERY = """#!/usr/bin/env python3
import re, sys
arguments = sys.argv[1:]
form = arguments[arguments.index("-f") + 1]
names = arguments[arguments.index("-f") + 2:]
found = 0
for line in open({database!r}):
    package, architecture, status = line.split()
    if names and package not in names: continue
    found += 1
    fields = {{"db:Status-Status": status, "Architecture": architecture, "Package": package}}
    print(re.sub(r"\\$\\{{([^}}]*)\\}}", lambda m: fields[m[1]], form).replace("\\\\n", "\\n"), end="")
sys.exit(0 if found or not names else 1)
"""
BUILD = ("g++ cmake ninja-build ccache pkg-config libbox2d-dev libboost-dev protobuf-compiler libprotobuf-dev libsodium-dev "
         "libspdlog-dev libfmt-dev libcli11-dev nlohmann-json3-dev libjs-dygraphs libminiupnpc-dev libnatpmp-dev").split()  # fmt: skip


class Deps(Case):
    def setUp(self):
        super().setUp()
        self.put("bin/dpkg-query", DPKG_QUERY.format(database=self.path("database")))
        self.put("bin/dpkg", '#!/bin/sh\n[ "$1" = --print-architecture ] && echo amd64\n')
        self.put("bin/apt-cache", '#!/bin/sh\n[ "$1" = policy ] && echo "  Candidate: 1"\n')
        self.put("bin/sudo", '#!/bin/sh\nexec "$@"\n')
        self.put("bin/apt-get", f'#!/bin/sh\necho "$@" >>"{self.path("apt")}"\n')
        self.put("apt", "")

    def deps(self, rows, *arguments):
        self.put("database", "".join(" ".join(row) + "\n" for row in rows))
        done = self.run_script(DEPS, *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def installed(self, but=()):
        return [(p, "all" if p in ("libjs-dygraphs", "libcli11-dev") else "amd64", "installed") for p in BUILD if p not in but]

    def test_what_is_there_is_not_installed_again(self):
        self.assertEqual(self.deps(self.installed(), "build"), "")
        self.assertEqual(self.text("apt"), "")

    def test_a_package_of_two_architectures_is_installed(self):
        rows = self.installed() + [("libbox2d-dev", "arm64", "installed"), ("libsodium-dev", "arm64", "installed")]
        self.deps(rows, "build")
        self.assertEqual(self.text("apt"), "")
        self.assertIn("libbox2d-dev                         installed: libbox2d-dev", self.deps(rows, "--list", "build"))

    def test_one_of_another_architecture_alone_is_missing(self):
        self.deps(self.installed(but=["libbox2d-dev"]) + [("libbox2d-dev", "arm64", "installed")], "build")
        self.assertIn("install -y --no-install-recommends libbox2d-dev\n", self.text("apt"))

    def test_one_that_was_removed_is_missing(self):
        for status in ("config-files", "half-installed"):
            self.deps(self.installed(but=["cmake"]) + [("cmake", "amd64", status)], "build")
            self.assertIn("install -y --no-install-recommends cmake\n", self.text("apt"))

    def test_the_newest_version_counts_if_it_is_of_this_machine(self):
        rows = [("clang-14", "arm64", "installed"), ("clang-16", "amd64", "installed"), ("clang-19", "arm64", "installed")]
        self.assertRegex(self.deps(rows, "--list", "check"), r"clang-14\|clang-@ +installed: clang-16\n")


APT_GET = """#!/bin/sh
echo "$@" >>"{apt}"
case "$*" in
  indextargets*) echo "http://archive.invalid/debian/ bookworm main" ;;
  *" update") for word; do case $word in Dir::Etc::SourceList=*) cat "${{word#*=}}" >>"{apt}" ;; esac; done ;;
  *" source "*) {source}; touch box2d_2.4.1-3.dsc ;;
esac
"""
DPKG_SOURCE = """#!/bin/sh
for word; do last=$word; done
mkdir -p "$last/include/box2d" && touch "$last/include/box2d/box2d.h"
"""


class Box2dSources(Case):
    """On other processors than x86-64 the package's sources, in place of the package."""

    def setUp(self):
        super().setUp()
        self.put("bin/dpkg-query", DPKG_QUERY.format(database=self.path("database")))
        self.put("bin/apt-cache", '#!/bin/sh\n[ "$1" = policy ] && echo "  Candidate: 1"\n')
        self.put("apt", "")
        with open(DEPS, encoding="utf-8") as f:
            self.put("tools/deps.sh", f.read())
        self.architecture("arm64")
        self.apt_get(source=":")
        self.put("bin/dpkg-source", DPKG_SOURCE)

    def architecture(self, name):
        self.put("bin/dpkg", f'#!/bin/sh\n[ "$1" = --print-architecture ] && echo {name}\n')
        packages = [p for p in BUILD if p != "libbox2d-dev"] + ["dpkg-dev"]
        self.put("database", "".join(f"{p} {name} installed\n" for p in packages))

    def apt_get(self, source):
        self.put("bin/apt-get", APT_GET.format(apt=self.path("apt"), source=source))

    def here(self, *arguments):
        return self.run_script(self.path("tools/deps.sh"), *arguments)

    def test_are_got_once_by_sources_of_our_own(self):
        done = self.here("build")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(os.path.exists(self.path("build/box2d/include/box2d/box2d.h")))
        asked = self.text("apt")
        self.assertRegex(asked, r"(?m)^deb-src (\[signed-by=\S+\] )?http://archive.invalid/debian/ bookworm main$")
        self.assertRegex(asked, r"Dir::Etc::SourceParts=/dev/null -o Dir::State::Lists=\S+ .* source --download-only box2d\n")
        self.assertNotIn("install", asked)
        self.put("apt", "")
        self.assertEqual(self.here("build").stdout, "")
        self.assertEqual(self.text("apt"), "")
        self.assertIn("installed: build/box2d", self.here("--list", "build").stdout)

    def test_that_do_not_come_leave_nothing_behind(self):
        self.apt_get(source="exit 100")
        self.assertNotEqual(self.here("build").returncode, 0)
        self.assertFalse(os.path.exists(self.path("build/box2d")))

    def test_are_got_on_x86_64_for_whoever_asks(self):
        self.architecture("amd64")
        self.assertIn("libbox2d-dev", self.here("--list", "build").stdout)
        self.assertNotIn("dpkg-dev", self.here("--list", "build").stdout)
        self.assertEqual(self.here("box2d").returncode, 0)
        self.assertTrue(os.path.exists(self.path("build/box2d")))

    def test_where_apt_knows_no_debian_it_says_what_to_do(self):
        self.put("bin/apt-get", "#!/bin/sh\n")
        done = self.here("build")
        self.assertEqual(done.returncode, 1)
        self.assertIn("unpack the sources of Box2D 2.4.1 into", done.stderr)


if __name__ == "__main__":
    unittest.main()
