#!/usr/bin/env python3
"""Checks that a program was built with the hardening of PADR_HARDEN, and that the check can fail.

  hardened.py READELF PROGRAM...          one line per thing that is missing, and exit status 1 if there is any
  hardened.py READELF --can-fail CXX      builds samples that lack one thing each, and wants each to be found

What -fcf-protection does cannot be seen in a program where the system's own start files are built without it.
"""

import os
import re
import subprocess
import sys
import tempfile

SAMPLE = "#include <cstdio>\n#include <cstring>\n" \
         "int main(int n, char** v) { char b[32]; std::strcpy(b, v[n - 1]); return std::puts(b) < 0; }\n"
FLAGS = ["-O2", "-fPIE", "-U_FORTIFY_SOURCE", "-D_FORTIFY_SOURCE=2", "-fstack-protector-strong", "-pie",
         "-Wl,-z,relro,-z,now,-z,noexecstack"]  # fmt: skip


def missing(readelf, program):
    def read(*options):
        return subprocess.run([readelf, "-W", *options, program], stdout=subprocess.PIPE, text=True, check=True).stdout

    header, segments, dynamic, symbols = (read(o) for o in ("-h", "-l", "-d", "--dyn-syms"))
    found = []
    if not re.search(r"Type:\s+DYN", header):
        found.append("it is not position independent (-fPIE -pie)")
    if "GNU_RELRO" not in segments:
        found.append("its tables stay writable (-z relro)")
    if not re.search(r"BIND_NOW|Flags:.*\bNOW\b", dynamic):
        found.append("its symbols are bound late (-z now)")
    stack = re.search(r"GNU_STACK(?:\s+0x[0-9a-f]+){5}\s+([RWE ]+?)\s+0x", segments)
    if stack is None or "E" in stack[1]:
        found.append("its stack can be executed (-z noexecstack)")
    if "__stack_chk_fail" not in symbols:
        found.append("its stack is not guarded (-fstack-protector-strong)")
    if not re.search(r"__\w+_chk\b", symbols):
        found.append("calls of the C library are not checked (_FORTIFY_SOURCE)")
    return found


def can_fail(readelf, compiler):
    lacking = {
        "-pie": ["-no-pie", "-fno-pie"], "-z relro": ["-Wl,-z,norelro"], "-z now": ["-Wl,-z,lazy"],
        "-z noexecstack": ["-Wl,-z,execstack"], "-fstack-protector-strong": ["-fno-stack-protector"],
        "_FORTIFY_SOURCE": ["-U_FORTIFY_SOURCE"],
    }  # fmt: skip
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        source, program = os.path.join(folder, "sample.cpp"), os.path.join(folder, "sample")
        with open(source, "w") as f:
            f.write(SAMPLE)

        def build(more):
            subprocess.run([compiler, *FLAGS, *more, "-w", source, "-o", program], check=True)
            return missing(readelf, program)

        good = build([])
        if good:
            print(f"a sample that has everything: {good}")
            wrong = 1
        for name, flags in lacking.items():
            found = build(flags)
            if not any(name in line for line in found):
                print(f"a sample without {name} passes: {found}")
                wrong = 1
    return wrong


def main():
    readelf, *rest = sys.argv[1:]
    if rest[0] == "--can-fail":
        return can_fail(readelf, rest[1])
    status = 0
    for program in rest:
        for line in missing(readelf, program):
            print(f"{program}: {line}")
            status = 1
    return status


sys.exit(main())
