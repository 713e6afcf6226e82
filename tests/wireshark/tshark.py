"""Reads a capture with tshark and the plugin as lists of (field, value) by frame, and compares it with the expected lists."""
import atexit
import ipaddress
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile

PLUGIN = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tools", "wireshark", "padr.lua")
# What hangs on other datagrams.
CONTEXT = ("padr.to", "padr.resend", "padr.resend.first", "padr.superseded", "padr.superseded.by", "padr.stale_mark",
           "padr.duplicate", "padr.lost", "padr.check_differs")  # fmt: skip


# Of no user's settings and plugins.
HOME = tempfile.mkdtemp()
atexit.register(shutil.rmtree, HOME)
SKIPPED = 77


class Mismatch(Exception):
    """Something is shown otherwise than it should be."""


def or_skip(*programs):
    """Ends the test as skipped if a program is missing."""
    missing = [program for program in ("tshark", *programs) if not shutil.which(program)]
    if missing:
        print(f"skipped: {' and '.join(missing)} not found (tools/deps.sh test)")
        sys.exit(SKIPPED)


def environment(home=HOME):
    return {**{name: value for name, value in os.environ.items() if not name.startswith(("XDG_", "WIRESHARK_"))}, "HOME": home}


def command(*arguments):
    """Ports that Wireshark gives to other protocols are among those that peers pick: heuristics are asked first."""
    return ["tshark", "-n", "-X", f"lua_script:{PLUGIN}", "-o", "udp.try_heuristic_first:TRUE", *arguments]


def run(*arguments):
    """Standard output; anything but a warning of being root on the other one is an error."""
    return output(command(*arguments), environment())


def output(words, env, **more):
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=env, **more)
    said = [line for line in done.stderr.splitlines() if not line.startswith("Running as user")]
    if done.returncode or said:
        raise Mismatch(f"{words}: exit code {done.returncode}: " + "\n".join(said))
    return done.stdout


def records(path, *arguments):
    """Each frame of a capture as tshark's JSON has it, objects as lists of pairs, for keys may come twice."""
    process = subprocess.Popen(command("-r", path, "-T", "json", "-J", "padr", *arguments), stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True, env=environment())  # fmt: skip
    lines = None
    for line in process.stdout:
        if line == "  {\n":
            lines = [line]
        elif lines is not None:
            lines.append("  }" if line.startswith("  }") else line)
            if line.startswith("  }"):
                yield json.loads("".join(lines), object_pairs_hook=list)
                lines = None
    said = [line for line in process.stderr if not line.startswith("Running as user")]
    if process.wait() or said:
        raise Mismatch(f"tshark: exit code {process.returncode}: {said}")


def member(pairs, key):
    return next((value for name, value in pairs if name == key), None)


def frames(path, *arguments):
    """By frame, a list of (field, text or None for a node), or None if the frame is not claimed."""
    for record in records(path, *arguments):
        layers = member(member(record, "_source"), "layers")
        if any(name == "_ws.lua.error" for name, _ in layers):
            raise Mismatch(f"an error in Lua: {layers}")
        found = member(layers, "padr")
        yield None if found is None else list(flat(found))


def flat(pairs):
    for name, value in pairs:
        if name.startswith("_ws.") or name.removesuffix("_tree") in CONTEXT:
            continue
        if isinstance(value, str):
            yield name, value
        else:
            if not name.endswith("_tree"):  # which is what is below a field that has a value itself
                yield name, None
            yield from flat(value)


def is_same(expected, shown):
    """A value and the text that tshark makes of it."""
    if expected is None or shown is None:
        return expected is None and shown is None
    if isinstance(expected, bool):
        return shown in (("1", "True") if expected else ("0", "False"))
    if isinstance(expected, float):
        both_none = math.isnan(expected) and math.isnan(float(shown))
        return both_none or struct.pack("<f", float(shown)) == struct.pack("<f", expected)
    if isinstance(expected, int):
        return int(shown, 0) == expected
    if isinstance(expected, bytes) and len(expected) == 48 and shown.count(":") < 15:
        expected = expected[:16]  # of a place and who is there, the place is shown
    if isinstance(expected, bytes) and len(expected) == 16 and ":" in shown and shown.count(":") < 15:
        return ipaddress.IPv6Address(expected) == ipaddress.IPv6Address(shown)
    if isinstance(expected, bytes):
        return shown.replace(":", "") == expected.hex()
    return shown == expected


def compare(where, expected, shown):
    """The number of values that were compared, all of them as they should be."""
    for n, (name, value) in enumerate(expected):
        if n >= len(shown) or shown[n][0] != name or not is_same(value, shown[n][1]):
            has = shown[n] if n < len(shown) else "no more"
            raise Mismatch(f"{where}: field {n} should be {name} = {value!r}, tshark has {has}")
    if len(shown) > len(expected):
        raise Mismatch(f"{where}: tshark has more: {shown[len(expected):]}")
    return sum(value is not None for _, value in expected)
