"""The second decoder reads what our encoders write as our decoders do: datagrams of every kind of state and membership
message, transfers of a session that was played, and damaged copies of all of them under tags that fit.

Usage: samples_test.py WIRE_SAMPLES
"""
import subprocess
import sys
from collections import Counter

from decoder import decode
from listing import listing
from protobuf import Malformed
from rules import Drop
from transfer import Scenario, decode_transfer, transfer_lines

# Reasons that come after decoding: what the samples' program lists is what it has decoded.
BELIEVED_LATER = ("order", "value")
COUNT = 600


def datagram_lines(words):
    return listing(decode(bytes.fromhex(words[0])))


def transfer_listing(words):
    numbers = [int(word) for word in words[:3]] + [float(word) for word in words[3:7]]
    return transfer_lines(decode_transfer(bytes.fromhex(words[7]), Scenario(*numbers)))


READERS = {"datagram": datagram_lines, "transfer": transfer_listing}


def read(name, words):
    """Our listing, and in a word what became of it."""
    try:
        return READERS[name](words), "read"
    except (Drop, Malformed) as error:
        reason = error.reason if isinstance(error, Drop) else "malformed"
        if name == "transfer":  # is refused, for whatever reason
            return ["drop = malformed"], "refused"
        return None if reason in BELIEVED_LATER else [f"drop = {reason}"], reason


def main(program):
    output = subprocess.run([program, str(COUNT)], stdout=subprocess.PIPE, check=True, text=True).stdout
    counts, kinds = Counter(), Counter()
    for block in output.rstrip("\n").split("\n\n"):
        head, *lines = block.split("\n")
        if head.startswith("seed"):
            print(head)
            continue
        name, *words = head.split(" ")
        ours, outcome = read(name, words)
        counts[name, outcome] += 1
        if ours is None:
            assert not lines[0].startswith("drop"), (head, lines[0], outcome)
            continue
        difference = next((pair for pair in zip(ours, lines) if pair[0] != pair[1]), (len(ours), len(lines)))
        assert ours == lines, f"{head}\nhere, and in C++: {difference}"
        if outcome == "read":
            kinds.update({line.split(".")[0].split("[")[0] for line in lines if "." in line.split(" = ")[0]})
            kinds.update(order for order in ("admission", "removal", "passed_on") if any(f".{order}" in line for line in lines))
    print(f"read alike: {dict(counts)}; of these with {dict(kinds)}")
    every = {"update", "pull", "piece", "enter", "poll", "answer", "fetch", "fetched", "probe", "reach", "newcomer",
             "transfer", "admission", "removal", "passed_on", "ask", "tell"}  # fmt: skip
    assert all(kinds[kind] >= 10 for kind in every), kinds
    assert counts["datagram", "malformed"] >= COUNT / 20 and counts["transfer", "refused"] >= COUNT / 20, counts


main(*sys.argv[1:])
