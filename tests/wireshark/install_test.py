"""Doing what tools/wireshark/README.md says: its two lines install the plugin, its filters are ones, its rules colour, and its
way without Lua shows what it says.

Usage: install_test.py REPOSITORY
"""
import os
import re
import shutil
import sys
import tempfile
from collections import Counter

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "conformance"))

import history_test  # noqa: E402
import pcap  # noqa: E402
import tshark  # noqa: E402
from decoder import decode  # noqa: E402
from datagrams_test import vectors  # noqa: E402
from sealed import ENCRYPT, sealed  # noqa: E402



def blocks(text):
    """The indented commands of a page, each as one text."""
    return [re.sub(r"^    ", "", found, flags=re.M).strip() for found in re.findall(r"(?:^    .*\n)+", text, re.M)]


class Installed:
    def __init__(self, home, repository):
        self.home, self.repository, self.env = home, repository, tshark.environment(home)

    def shell(self, script, **more):
        return tshark.output(["bash", "-euc", script], {**self.env, **more}, cwd=self.repository)

    def tshark(self, *arguments):
        return tshark.output(["tshark", *arguments, "-n"], self.env, cwd=self.repository)


def check_fields(installed):
    """Wireshark knows the fields without being told of the plugin, and naming it besides does no harm."""
    known = {line.split("\t")[2] for line in installed.tshark("-G", "fields").splitlines() if "\tpadr." in line}
    assert len(known) > 150, known
    assert installed.tshark("-X", f"lua_script:{tshark.PLUGIN}", "-v").startswith("TShark")


def check_protobuf(installed, path):
    """With names as wire.proto is there, not at all without it, without names if that is asked for."""
    def shows(*arguments):
        return len(re.findall(r"Field\(\d+\): link = ", installed.tshark("-r", path, "-V", *arguments)))

    proto = os.path.join(installed.home, ".config", "wireshark", "protobuf", "wire.proto")
    assert shows() > 20 and shows("-o", "padr.protobuf:Never") == 0
    os.rename(proto, proto + ".away")
    assert shows() == 0 and "Protocol Buffers" not in installed.tshark("-r", path, "-V")
    assert "<UNKNOWN>" in installed.tshark("-r", path, "-V", "-o", "padr.protobuf:Always")
    os.rename(proto + ".away", proto)


def check_filters(installed, path, text):
    """Whatever the page's table has in its first column finds something, or is a field at least."""
    rows = re.findall(r"^\| (`padr.*?`) \|", text, re.M)
    filters = [each for row in rows for each in re.findall(r"`(.*?)`", row)]
    assert len(filters) > 10, filters
    hits = Counter({each: len(installed.tshark("-r", path, "-Y", each).splitlines()) for each in filters})
    assert sum(count > 0 for count in hits.values()) > 6, hits


def check_colours(installed, path):
    """Every rule but the last resort for some frame, and no frame of ours without one."""
    rules = os.path.join(installed.repository, "tools", "wireshark", "colorfilters")
    shutil.copy(rules, os.path.join(installed.home, ".config", "wireshark"))
    with open(rules, encoding="utf-8") as file:
        names = [line.split("@")[1] for line in file if line.startswith("@")]
    coloured = Counter(installed.tshark("-r", path, "--color", "-T", "fields", "-e", "frame.coloring_rule.name").splitlines())
    assert set(coloured) == set(names), (coloured, names)


def check_without_lua(home, repository, path, script):
    """The page's commands, where there is no plugin: the values that our decoder reads."""
    shutil.copy(path, os.path.join(home, "play.pcap"))
    bare = Installed(home, repository)
    out = bare.shell(re.sub(r"\b(play|state|bare)\.pcap", rf"{home}/\1.pcap", script))
    shown = [line.split("\t")[0].split(",")[0] for line in out.splitlines()]
    wanted = []
    for datagram in pcap.read(path):
        if datagram and datagram[:3] == b"Pd\x90":
            wanted.append(str(decode(datagram)["seq"]))
    assert shown == wanted and len(wanted) > 20, (shown, wanted)


def check_keylog(installed, datagrams, script):
    """The page's command shows what is encrypted as if it were not."""
    key, sender, folder = bytes(range(32)), bytes(range(50, 82)), installed.home
    with open(os.path.join(folder, "keys.log"), "w", encoding="utf-8") as file:
        file.write(f"padr-key {sender.hex()} {bytes(32).hex()} {key.hex()}\n")
    pcap.write(os.path.join(folder, "sealed.pcap"),
               [pcap.udp(sealed(key, ENCRYPT, sender, n, each)) for n, each in enumerate(datagrams, 1)])  # fmt: skip
    script = re.sub(r"\b(keys\.log|sealed\.pcap)", rf"{folder}/\1", script)
    assert "encrypted state" in installed.shell(re.sub(r"-o \S+ ", "", script))
    assert "encrypted" not in installed.shell(script)


def main(repository):
    with open(os.path.join(repository, "tools", "wireshark", "README.md"), encoding="utf-8") as file:
        text = file.read()
    install, _, with_keylog, without_lua = blocks(text)
    assert len(install.splitlines()) == 2
    with tempfile.TemporaryDirectory() as folder:
        homes = [os.path.join(folder, name) for name in ("with", "without")]
        for home in homes:
            os.mkdir(home)
        scripted, everything = os.path.join(folder, "scripted.pcap"), os.path.join(folder, "everything.pcap")
        pcap.write(scripted, history_test.all_packets())
        written = vectors(os.path.join(repository, "proto", "VECTORS.md"))
        pcap.write(everything, history_test.all_packets() + [pcap.udp(each) for each in written if each[:2] == b"Pd"])
        installed = Installed(homes[0], repository)
        installed.shell(install)
        check_fields(installed)
        check_protobuf(installed, scripted)
        check_filters(installed, everything, text)
        check_colours(installed, everything)
        check_keylog(installed, [each for each in pcap.read(scripted) if each and each[:3] == b"Pd\x90"], with_keylog)
        check_without_lua(homes[1], repository, scripted, without_lua)
    print("installed by two lines; filters, colours, protobuf and the way without Lua are as the page says")


if __name__ == "__main__":
    tshark.or_skip("editcap")
    main(os.path.abspath(sys.argv[1]))
