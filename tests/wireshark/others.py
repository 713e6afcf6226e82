"""Other traffic: real protocols' datagrams, made here, and bytes at random, some of which begin as ours do."""
import random
import struct

import pcap


def dns_query(rng):
    name = b"".join(bytes([len(part)]) + part for part in (b"www", b"example", b"org"))
    head = struct.pack(">HHHHHH", rng.randrange(65536), 0x0100, 1, 0, 0, 0)
    return head + name + b"\0" + struct.pack(">HH", rng.choice((1, 28)), 1)


def dns_answer(rng):
    query = bytearray(dns_query(rng))
    query[2:4], query[6:8] = b"\x81\x80", b"\0\1"
    return bytes(query) + b"\xc0\x0c" + struct.pack(">HHIH", 1, 1, 300, 4) + rng.randbytes(4)


def mdns(rng):
    name = b"\x05_http\x04_tcp\x05local\0"
    return struct.pack(">HHHHHH", 0, 0, 1, 0, 0, 0) + name + struct.pack(">HH", 12, 1 | rng.choice((0, 0x8000)))


def quic_initial(rng):
    """A long header of version 1; what follows is encrypted and so as good as random."""
    body = rng.randbytes(1162)
    return bytes([0xC0 | rng.randrange(4)]) + struct.pack(">I", 1) + b"\x08" + rng.randbytes(8) + b"\0\0\x44\x9e" + body


def quic_short(rng):
    return bytes([0x40 | rng.randrange(64)]) + rng.randbytes(rng.randrange(20, 1200))


def rtp(rng):
    return struct.pack(">BBHII", 0x80, 96, rng.randrange(65536), rng.randrange(1 << 32), 7) + rng.randbytes(160)


def anything(rng):
    return rng.randbytes(rng.randrange(0, 1300))


def begins_as_ours(rng):
    """Only the magic; of the header and the tag at least one thing is not as it would have to be."""
    data = bytearray(b"Pd" + rng.randbytes(rng.randrange(0, 200)))
    if len(data) > 3:
        data[2], data[3] = rng.choice(((0xA0, data[3]), (0x93, data[3]), (0x90, rng.randrange(64, 255)), (0x10, 0)))
    return bytes(data)


# And the ports they are seen on.
SORTS = {dns_query: (40000, 53), dns_answer: (53, 40000), mdns: (5353, 5353), quic_initial: (50001, 443),
         quic_short: (50001, 443), rtp: (5004, 5004), anything: (40001, 40002), begins_as_ours: (40001, 40002)}  # fmt: skip


def packets(count, seed):
    """So many packets of each sort."""
    rng = random.Random(seed)
    return [pcap.udp(sort(rng), *ports) for sort, ports in SORTS.items() for _ in range(count)]
