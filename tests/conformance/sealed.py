"""Section 14 of proto/WIRE.md, from its text alone: keys, sealed datagrams, the handshake."""
import struct
import zlib
from hashlib import blake2b

from decoder import VERSION
from ciphers import public_key, shared, sign, x25519, xchacha20

AUTH, ENCRYPT = 1, 2
HEADER, TAG, LARGEST, HANDSHAKE = 14, 16, 1220, 76


def blake(key, text, size):
    return blake2b(text, key=key, digest_size=size).digest()


def pair_key(session, secret, theirs, sender, receiver):
    """What goes from `sender` to `receiver`, by the secret of either and the public key of the other."""
    return blake(session, b"padr pair" + shared(secret, theirs) + sender + receiver, 32)


def handshake_key(session):
    return blake(session, b"padr handshake", 32)


def next_key(former, exchange, theirs, sender, receiver):
    """What follows `former` from a sender to a receiver with these new public keys, by the new secret of either."""
    return blake(former, b"padr rekey" + x25519(exchange, theirs) + sender + receiver, 32)


def tag_of(key, number, open, text=b""):
    return blake(key, open + text + struct.pack("<Q", number), TAG)


def mixed(key, tag, number, text):
    """The text hidden, or shown again."""
    return xchacha20(blake(key, b"padr cipher", 32), tag + struct.pack("<Q", number), text)


def sealed(key, mode, sender, number, unsealed):
    """An unsealed datagram, sealed by whoever has the public key `sender`."""
    head = unsealed[:2] + bytes([unsealed[2] | mode << 2]) + unsealed[3:6] + sender[:4] + struct.pack("<I", number & 0xFFFFFFFF)
    payload = unsealed[6:-4]
    open, text = (head + payload, b"") if mode == AUTH else (head, payload)
    tag = tag_of(key, number, open, text)
    return open + mixed(key, tag, number, text) + tag


def unsealed(key, number, datagram):
    """The unsealed datagram in a sealed one, or None."""
    if not HEADER + TAG <= len(datagram) <= LARGEST or datagram[:2] != b"Pd" or datagram[2] >> 4 != VERSION:
        return None
    mode = datagram[2] >> 2 & 3
    if mode not in (AUTH, ENCRYPT) or datagram[2] & 3 == 3:
        return None
    at, tag = len(datagram) - TAG if mode == AUTH else HEADER, datagram[-TAG:]
    text = mixed(key, tag, number, datagram[at:-TAG])
    if tag_of(key, number, datagram[:at], text) != tag:
        return None
    head = datagram[:2] + bytes([datagram[2] & 0xF3]) + datagram[3:6]
    plain = head + (datagram[HEADER:-TAG] if mode == AUTH else text)
    return plain + struct.pack("<I", zlib.crc32(plain))


def handshake(type, public, number, cookie):
    return b"Pd" + bytes([VERSION << 4 | 3, type]) + public + struct.pack("<Q", number) + cookie


def hello(session, public, number, type=1, cookie=bytes(16)):
    """Also a Cookie, by type 2."""
    text = handshake(type, public, number, cookie)
    return text + blake(handshake_key(session), text, 16)


def introduction(key, public, number, cookie, type=3):
    """Also an Acceptance, by type 4."""
    text = handshake(type, public, number, cookie)
    return text + tag_of(key, number, text)


def rekey(key, exchange, number, id, generation, has):
    """`has` is the beginning of the receiver's new public key, or zeros."""
    return introduction(key, exchange, number, id + struct.pack("<I", generation) + has, 5)


def signed_text(session, incarnation, passed_on):
    """What the signature of an update is over; `passed_on` is what would pass it on, without its signature."""
    return b"padr update" + session + struct.pack("<I", incarnation) + passed_on


def vectors():
    """Those of the standard, by name; they are made of these secrets."""
    session, a, b = (bytes(range(n, n + 32)) for n in (0, 32, 64))
    pa, pb = public_key(a), public_key(b)
    ab, ba = pair_key(session, a, pb, pa, pb), pair_key(session, b, pa, pb, pa)
    plain = b"Pd" + bytes([VERSION << 4]) + bytes.fromhex("0234120a03016405")
    plain += struct.pack("<I", zlib.crc32(plain))
    number = (5 << 32) + 7
    cookie = bytes(range(160, 176))
    ea, eb = bytes(range(96, 128)), bytes(range(128, 160))
    nine = bytes([9]) + bytes(31)
    xa, xb = x25519(ea, nine), x25519(eb, nine)
    text = signed_text(bytes(range(176, 192)), 130, bytes.fromhex("08021009185a22025001"))
    return {
        "session_key": session, "secret_a": a, "public_a": pa, "secret_b": b, "public_b": pb, "key_a_to_b": ab,
        "key_b_to_a": ba, "unsealed": plain, "auth": sealed(ab, AUTH, pa, number, plain),
        "encrypt": sealed(ab, ENCRYPT, pa, number, plain), "hello": hello(session, pa, 0x1122334455667788),
        "cookie": hello(session, pb, 0x1122334455667788, 2, cookie), "introduction": introduction(ab, pa, 1, cookie),
        "acceptance": introduction(ba, pb, 1, bytes(16), 4), "exchange_secret_a": ea, "exchange_a": xa,
        "exchange_secret_b": eb, "exchange_b": xb, "rekey_a": rekey(ab, xa, 2, pa[:4], 1, bytes(8)),
        "rekey_b": rekey(ba, xb, 2, pb[:4], 1, xa[:8]), "next_a_to_b": next_key(ab, ea, xb, xa, xb),
        "next_b_to_a": next_key(ba, eb, xa, xb, xa), "signed_text": text, "signature": sign(a, text),
    }  # fmt: skip
