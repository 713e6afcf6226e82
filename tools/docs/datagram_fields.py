"""The page of every field of a datagram: the filters of the Wireshark plugin and the columns of padr-capture export."""

import re

import pages

PLUGIN = "tools/wireshark/padr/fields.lua"
EXPORT = "tools/capture/field_names.cpp"
HEAD = """# Fields of datagrams

What `padr-capture export` writes of a datagram, and what Wireshark and tshark can filter by with [the plugin](../tools/wireshark/README.md).
Both give a field the same name. [The wire](../proto/WIRE.md) says what the fields are for.

In `export`, *yes* is a field that comes once at most, and *list* one that can come several times in a datagram: in JSON a list, in CSV
joined by `;`. An empty cell is a field of the plugin alone. Besides there are tshark's `frame.number`, `frame.time_epoch` (s, Unix time),
`ip.src`, `ip.dst`, `ipv6.src`, `ipv6.dst`, `udp.srcport` and `udp.dstport`.

| field | type | in `export` | meaning |
|---|---|---|---|
"""


def page():
    shown = re.findall(r'^  \{ "(padr[\w.]+)", "(\w+)", "([^"]*)"(?:, "([^"]*)")?', pages.read(PLUGIN), re.M)
    exported = dict(re.findall(r'^ +\{"([\w.]+)", (true|false)\},$', pages.read(EXPORT), re.M))
    lines = []
    for name, kind, label, more in shown:
        within = {"true": "list", "false": "yes"}.get(exported.pop(name, ""), "")
        lines.append(f"| `{name}` | {kind} | {within} | {label}{': ' + more if more else ''} |\n")
    unknown = [name for name in exported if name.startswith("padr.")]
    if unknown:
        raise ValueError(f"{EXPORT} has fields that {PLUGIN} does not explain: {', '.join(unknown)}")
    return HEAD + "".join(lines)
