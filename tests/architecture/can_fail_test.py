#!/usr/bin/env python3
"""The architecture checks, tried on small trees and archives that break one rule each, and on ones that break none."""

import os
import subprocess
import tempfile
import unittest

import architecture


class Tree:
    """A small repository in a temporary folder."""

    def __init__(self, files):
        self.folder = tempfile.TemporaryDirectory()
        self.root = self.folder.name
        for path, text in files.items():
            full = os.path.join(self.root, path)
            os.makedirs(os.path.dirname(full), exist_ok=True)
            with open(full, "w", encoding="utf-8") as file:
                file.write(text)

    def __enter__(self):
        return self.root

    def __exit__(self, *_):
        self.folder.cleanup()


INCLUDE_CASES = [
    # file, its text, what the complaint must say (None: no complaint)
    ("common/sync/a.cpp", '#include "common/world/world.h"\n#include <vector>\n', None),
    ("common/model/a.h", '#include "common/model/b.h"\n', None),
    ("common/world/a.cpp", "#include <box2d/box2d.h>\n", None),
    ("common/wire/a.cpp", '#include "proto/wire.pb.h"\n#include <google/protobuf/message_lite.h>\n', None),
    ("common/replica/a.cpp", "// std::random_device and steady_clock stay outside\n", None),
    ("common/replica/a.cpp", 'const char* kWord = "std::thread";\n', None),
    ("peer/a.cpp", "#include <chrono>\n#include <boost/asio.hpp>\nauto t = std::chrono::steady_clock::now();\n", None),
    ("common/model/a.cpp", '#include <cstdio>\nauto f(char* s) { return std::snprintf(s, 9, "%d", 1); }\n', None),
    ("common/model/a.cpp", '#include <cstdio>\nauto f() { return std::puts("x"); }\n', "puts"),
    ("common/model/a.h", '#include "common/link/shim.h"\n', "points up"),
    ("common/world/a.cpp", '#include "common/sync/log.h"\n', "points up"),
    ("common/wire/a.cpp", '#include "common/replica/replica.h"\n', "points up"),
    ("common/extra/a.cpp", "int x;\n", "CORE_ORDER"),
    ("common/replica/a.cpp", '#include "common/extra/x.h"\n', "CORE_ORDER"),
    ("common/replica/a.cpp", '#include "peer/options.h"\n', "nothing of peer/"),
    ("common/replica/a.cpp", '#include "tools/lab/lab.h"\n', "nothing of tools/"),
    ("common/sync/a.cpp", "#include <box2d/box2d.h>\n", "Box2D"),
    ("common/sync/a.cpp", '  #  include "box2d/b2_world.h"\n', "Box2D"),
    ("common/replica/a.cpp", '#include "proto/wire.pb.h"\n', "belongs to common/wire"),
    ("peer/a.cpp", '#include "proto/trace.pb.h"\n', "belongs to common/trace"),
    ("tools/lab/a.cpp", '#include "proto/scenario.pb.h"\n', "belongs to common/scenarios"),
    ("common/wire/a.cpp", '#include "proto/other.pb.h"\n', "has no owner"),
    ("common/sync/a.cpp", "#include <google/protobuf/message.h>\n", "protobuf stays"),
    ("common/link/a.cpp", "#include <chrono>\n", "no clocks"),
    ("common/link/a.cpp", "#include <thread>\n", "no clocks"),
    ("common/link/a.h", "#include <mutex>\n", "no clocks"),
    ("common/trace/a.cpp", "#include <fstream>\n", "no clocks"),
    ("common/scenarios/a.cpp", "#include <filesystem>\n", "no clocks"),
    ("common/replica/a.cpp", "#include <sys/socket.h>\n", "no clocks"),
    ("common/replica/a.cpp", "#include <boost/asio/ip/udp.hpp>\n", "no clocks"),
    ("common/model/a.cpp", "int x = int(std::random_device{}());\n", "random_device"),
    ("common/model/a.cpp", 'auto* e = std::getenv("SEED");\n', "getenv"),
    ("common/model/a.cpp", "float f(float x) { return std::sqrt(std::floor(x)) + std::fmod(x, 2); }\n", None),
    ("common/model/a.cpp", "unsigned long long f(unsigned long long x) { return x; }\n", None),
    ("common/world/box2d_math.cpp", "float f(float x) { return sinf(x); }\n", None),
    ("common/model/a.cpp", "float f(float x) { return std::exp(x); }\n", "std::exp may be another"),
    ("common/model/a.cpp", "double f(double x) { return std::atan2(x, 1); }\n", "std::atan2"),
    ("common/model/a.cpp", "float f(float x) { return sinf(x); }\n", "sinf"),
    ("common/sync/a.h", "std::unordered_map<int, int> m;\n", "std::unordered_map"),
    ("common/sync/a.h", "std::size_t f(int i) { return std::hash<int>()(i); }\n", "std::hash"),
    ("common/link/a.cpp", "std::normal_distribution<double> d;\n", "std::normal_distribution"),
    ("common/link/a.cpp", "void f(V& v, R& r) { std::shuffle(v.begin(), v.end(), r); }\n", "std::shuffle"),
    ("common/trace/a.cpp", "float f(V& v) { return std::reduce(v.begin(), v.end()); }\n", "std::reduce"),
    ("common/scenarios/a.cpp", "double f(const std::string& s) { return std::stod(s); }\n", "std::stod"),
    ("common/model/a.cpp", "long f(int x) { return x; }\n", "long may be another"),
    ("common/model/a.cpp", "void f(unsigned long x);\n", ": long may be another"),
    ("common/model/a.cpp", "/* one\n two */ auto t = std::chrono::system_clock::now();\n", "a.cpp:2: system_clock"),
]


class Includes(unittest.TestCase):
    def test_cases(self):
        for path, text, complaint in INCLUDE_CASES:
            with self.subTest(path=path, text=text), Tree({path: text}) as root:
                found = architecture.includes(root)
                if complaint is None:
                    self.assertEqual(found, [])
                else:
                    self.assertEqual(len(found), 1, found)
                    self.assertIn(complaint, found[0])

    def test_include_relative_to_the_file(self):
        with Tree({"common/sync/a.cpp": '#include "b.h"\n', "common/sync/b.h": ""}) as root:
            self.assertIn("from the repository root", "".join(architecture.includes(root)))


SYMBOL_CASES = [
    # a function body, what the complaint must say (None: no complaint)
    ("#include <vector>\nvoid f(std::vector<float>& v) { v.push_back(1); }", None),
    ("#include <cmath>\nfloat f(float x) { return std::sin(x); }", None),
    ("#include <chrono>\nauto f() { return std::chrono::steady_clock::now(); }", "steady_clock::now"),
    ("#include <chrono>\nauto f() { return std::chrono::system_clock::now(); }", "system_clock::now"),
    ("#include <ctime>\nlong f() { return std::time(nullptr); }", ": time"),
    ("#include <cstdlib>\nbool f() { return std::getenv(\"SEED\") != nullptr; }", ": getenv"),
    ("#include <random>\nunsigned f() { return std::random_device{}(); }", "random_device"),
    ("#include <cstdlib>\nint f() { return std::rand(); }", ": rand"),
    ("#include <cstdio>\nbool f() { return std::fopen(\"a\", \"r\") != nullptr; }", ": fopen"),
    ("#include <fstream>\nbool f() { return std::ifstream(\"a\").good(); }", "std::basic_"),
    ("#include <iostream>\nvoid f() { std::cout << 1; }", "std::cout"),
    ("#include <sys/socket.h>\nint f() { return socket(AF_INET, SOCK_DGRAM, 0); }", ": socket"),
    ("#include <thread>\nvoid f() { std::thread([] {}).join(); }", "std::thread"),
    ("#include <mutex>\n#include <pthread.h>\nvoid f(std::mutex& m) { m.lock(); }\n", "pthread_mutex_lock"),
]


class Symbols(unittest.TestCase):
    def test_cases(self):
        tools = {name: os.environ.get(name, default) for name, default in (("CXX", "c++"), ("AR", "ar"), ("NM", "nm"))}
        for text, complaint in SYMBOL_CASES:
            with self.subTest(text=text), Tree({"a.cpp": text}) as root:
                subprocess.run([tools["CXX"], "-std=c++20", "-O1", "-c", "a.cpp"], cwd=root, check=True)
                subprocess.run([tools["AR"], "rc", "liba.a", "a.o"], cwd=root, check=True)
                found = architecture.symbols(tools["NM"], [os.path.join(root, "liba.a")])
                if complaint is None:
                    self.assertEqual(found, [])
                else:
                    self.assertIn(complaint, "\n".join(found))

    def test_an_archive_that_is_not_there(self):
        with self.assertRaises(subprocess.CalledProcessError):
            architecture.symbols(os.environ.get("NM", "nm"), ["libnone.a"])


class Paths(unittest.TestCase):
    def test_cases(self):
        home, tmp = "/ho" + "me", "/tm" + "p"
        cases = [
            (f"cd {home}/someone/padr", True),
            (f'"{tmp}/padr.trace"', True),
            ("#include " + '"' + "/ro" + 'ot/x.h"', True),
            ("${TMPDIR:-" + tmp + "}", False),
            ("$root" + tmp + "/x", False),
            (f"docs{home}/x", False),
            ("the home/tmp folders", False),
        ]
        for line, bad in cases:
            with self.subTest(line=line), Tree({"docs/a.md": line + "\n"}) as root:
                self.assertEqual(len(architecture.paths(root)), int(bad))


class Cases(unittest.TestCase):
    def test_cases(self):
        rows = [
            ("| a row | an answer | `Suite.Written` |", None),
            ("| a row | an answer | `Suite.Written`, `Suite.Dreamt` |", "no test Suite.Dreamt"),
            ("| a row | an answer | see there |", "without a test: a row"),
            ("nothing", "no cases"),
        ]
        for row, complaint in rows:
            good = "| a row | an answer | `Suite.Written` |\n"
            for page, other in [("docs/cases.md", "docs/trust.md"), ("docs/trust.md", "docs/cases.md")]:
                files = {page: row + "\n", other: good, "tests/a/a_test.cpp": "TEST(Suite, Written) {}\n"}
                with self.subTest(row=row, page=page), Tree(files) as root:
                    found = architecture.cases(root)
                    if complaint is None:
                        self.assertEqual(found, [])
                    else:
                        self.assertIn(complaint, "\n".join(found))
                        self.assertIn(page, found[0])


class House(unittest.TestCase):
    def test_house(self):
        folders = [f"    common/{name}/   what it is\n" for name in architecture.CORE_ORDER[::-1]]
        arrow = "          |\n          v\n"
        whole = arrow + arrow.join(folders)
        for picture, complaint in [
            (whole, None),
            (arrow + arrow.join(folders[1:]), "the picture has"),
            (arrow + arrow.join(folders[::-1]), "from the top down it should be"),
            (arrow.join(folders), "arrows for"),
            ("", "the picture has"),
        ]:
            page = f"# Contributing\n\n## The house\n\n{picture}\n## Adding\n"
            with self.subTest(picture=picture), Tree({"CONTRIBUTING.md": page}) as root:
                found = architecture.house(root)
                if complaint is None:
                    self.assertEqual(found, [])
                else:
                    self.assertIn(complaint, "\n".join(found))


if __name__ == "__main__":
    unittest.main()
