"""Captures as files: reads those of tcpdump, and writes made-up ones."""
import struct

ETHERNET = 1
MAGIC = 0xA1B2C3D4
IPV4, UDP, ICMP = 0x0800, 17, 1


def ipv4(payload, protocol, source, target):
    """An IPv4 packet; Wireshark does not check its header's checksum unless told to."""
    return struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(payload), 0, 0, 64, protocol, 0, bytes(source), bytes(target)) + payload


def udp(payload, source_port=40001, target_port=40002, source=(127, 0, 0, 1), target=(127, 0, 0, 1)):
    """Without a checksum: 0 says that there is none."""
    return ipv4(struct.pack(">HHHH", source_port, target_port, 8 + len(payload), 0) + payload, UDP, source, target)


def icmp_unreachable(packet):
    """What the sender of a packet is told if nobody listens: the packet is in it."""
    return ipv4(struct.pack(">BBHI", 3, 3, 0, 0) + packet, ICMP, (127, 0, 0, 1), (127, 0, 0, 1))


def frame(packet):
    return bytes(12) + struct.pack(">H", IPV4) + packet


def write(path, packets, snaplen=65535):
    """Packets (IPv4), a millisecond apart, each cut off after so many bytes of its frame."""
    with open(path, "wb") as file:
        file.write(struct.pack("<IHHiIII", MAGIC, 2, 4, 0, 0, snaplen, ETHERNET))
        for n, packet in enumerate(packets):
            whole = frame(packet)
            part = whole[:snaplen]
            file.write(struct.pack("<IIII", n // 1000, n % 1000 * 1000, len(part), len(whole)) + part)


def read(path):
    """The UDP payloads of a capture of Ethernet by tcpdump on this machine, None for frames that are something else."""
    with open(path, "rb") as file:
        magic, _, _, _, _, _, link = struct.unpack("<IHHiIII", file.read(24))
        assert magic == MAGIC and link == ETHERNET, (hex(magic), link)
        while header := file.read(16):
            _, _, captured, size = struct.unpack("<IIII", header)
            assert captured == size, "cut off"
            yield udp_payload(file.read(captured))


def udp_payload(data):
    (kind,) = struct.unpack_from(">H", data, 12)
    if kind != IPV4 or data[23] != UDP:
        return None
    at = 14 + 4 * (data[14] & 15)
    (length,) = struct.unpack_from(">H", data, at + 4)
    return data[at + 8:at + length]
