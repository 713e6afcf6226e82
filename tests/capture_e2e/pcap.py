"""A second reader of packet captures, for what padr-peer and tcpdump write: (time_ns, source, destination, payload)."""

import ipaddress
import struct


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    frames = pcapng(data) if data[:4] == b"\x0a\x0d\x0d\x0a" else pcap(data)
    return [(time, *datagram) for time, link, frame in frames for datagram in udp(link, frame)]


def pcap(data):
    order = "<" if data[:4] in (b"\xd4\xc3\xb2\xa1", b"\x4d\x3c\xb2\xa1") else ">"
    scale = 1000 if struct.unpack_from(order + "I", data)[0] == 0xA1B2C3D4 else 1
    link, at = struct.unpack_from(order + "I", data, 20)[0], 24
    while at + 16 <= len(data):
        seconds, fraction, size = struct.unpack_from(order + "III", data, at)
        if at + 16 + size > len(data):  # it is being written
            return
        yield seconds * 10**9 + fraction * scale, link, data[at + 16 : at + 16 + size]
        at += 16 + size


def pcapng(data):
    """Little endian with nanoseconds, as padr-peer writes it."""
    at, link = 0, None
    while at + 12 <= len(data):
        kind, size = struct.unpack_from("<II", data, at)
        if at + size > len(data):  # its writer was killed
            return
        body = data[at + 8 : at + size - 4]
        if kind == 1:
            link = struct.unpack_from("<H", body)[0]
        if kind == 6:
            _, high, low, captured, original = struct.unpack_from("<IIIII", body)
            assert captured == original
            yield high << 32 | low, link, body[20 : 20 + captured]
        at += size


def udp(link, frame):
    if link == 1:
        if frame[12:14] not in (b"\x08\x00", b"\x86\xdd"):
            return
        frame = frame[14:]
    if frame[0] >> 4 == 4:
        header, protocol, source, target = (frame[0] & 15) * 4, frame[9], frame[12:16], frame[16:20]
        assert link == 1 or checksum(frame[:header]) == 0xFFFF, "IPv4 header checksum"
    else:
        header, protocol, source, target = 40, frame[6], frame[8:24], frame[24:40]
    if protocol != 17:
        return
    packet = frame[header:]
    ports = struct.unpack_from(">HHHH", packet)
    packet = packet[: ports[2]]
    if link != 1:  # on the loopback device the system leaves the checksum to hardware that is not there
        assert checksum(source + target + struct.pack(">II", 17, ports[2]) + packet) == 0xFFFF, "UDP checksum"
    yield (str(ipaddress.ip_address(source)), ports[0]), (str(ipaddress.ip_address(target)), ports[1]), packet[8:]


def checksum(data):
    data += b"\0" * (len(data) % 2)
    total = sum(struct.unpack(f">{len(data) // 2}H", data))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return total


def write(path, datagrams):
    """Raw IPv4 with nanoseconds, big endian: what our reader must take as well. Checksums are left out."""
    with open(path, "wb") as file:
        file.write(struct.pack(">IHHIIII", 0xA1B23C4D, 2, 4, 0, 0, 65535, 101))
        for time, source, target, payload in datagrams:
            size = 28 + len(payload)
            addresses = ipaddress.ip_address(source[0]).packed + ipaddress.ip_address(target[0]).packed
            ip = struct.pack(">BBHHHBBH", 0x45, 0, size, 0, 0, 64, 17, 0) + addresses
            ports = struct.pack(">HHHH", source[1], target[1], 8 + len(payload), 0)
            file.write(struct.pack(">IIII", time // 10**9, time % 10**9, size, size) + ip + ports + payload)
