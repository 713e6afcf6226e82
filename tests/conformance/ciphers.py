"""X25519 (RFC 7748), ChaCha20 and Poly1305 (RFC 8439) and XChaCha20-Poly1305 (draft-irtf-cfrg-xchacha-03), slow and plain."""
import struct

P25519 = (1 << 255) - 19
P1305 = (1 << 130) - 5
WORD = 0xFFFFFFFF


def x25519(scalar, point):
    k = (int.from_bytes(scalar, "little") & ~7 & (1 << 254) - 1) | 1 << 254
    x1 = int.from_bytes(point, "little") & (1 << 255) - 1
    x2, z2, x3, z3, swapped = 1, 0, x1, 1, 0
    for t in range(254, -1, -1):
        bit = k >> t & 1
        if swapped ^ bit:
            x2, z2, x3, z3 = x3, z3, x2, z2
        swapped = bit
        a, b, c, d = x2 + z2, x2 - z2, x3 + z3, x3 - z3
        aa, bb, da, cb = a * a % P25519, b * b % P25519, d * a % P25519, c * b % P25519
        e = aa - bb
        x3, z3 = (da + cb) ** 2 % P25519, x1 * (da - cb) ** 2 % P25519
        x2, z2 = aa * bb % P25519, e * (aa + 121665 * e) % P25519
    if swapped:
        x2, z2 = x3, z3
    return (x2 * pow(z2, P25519 - 2, P25519) % P25519).to_bytes(32, "little")


def public_key(secret):
    return x25519(secret, (9).to_bytes(32, "little"))


def quarter(s, a, b, c, d):
    for one, two, three, turn in ((a, b, d, 16), (c, d, b, 12), (a, b, d, 8), (c, d, b, 7)):
        s[one] = s[one] + s[two] & WORD
        mixed = s[three] ^ s[one]
        s[three] = (mixed << turn | mixed >> 32 - turn) & WORD


def rounds(state):
    s = list(state)
    for _ in range(10):
        for n in range(4):
            quarter(s, n, 4 + n, 8 + n, 12 + n)
        for n in range(4):
            quarter(s, n, 4 + (n + 1) % 4, 8 + (n + 2) % 4, 12 + (n + 3) % 4)
    return s


def start(key, last_four):
    return struct.unpack("<4I", b"expand 32-byte k") + struct.unpack("<8I", key) + last_four


def chacha20(key, counter, nonce, size):
    stream = b""
    while len(stream) < size:
        state = start(key, (counter,) + struct.unpack("<3I", nonce))
        stream += struct.pack("<16I", *(x + y & WORD for x, y in zip(state, rounds(state))))
        counter += 1
    return stream[:size]


def hchacha20(key, nonce):
    s = rounds(start(key, struct.unpack("<4I", nonce)))
    return struct.pack("<8I", *s[:4], *s[12:])


def poly1305(key, text):
    r = int.from_bytes(key[:16], "little") & 0x0FFFFFFC0FFFFFFC0FFFFFFC0FFFFFFF
    sum = 0
    for at in range(0, len(text), 16):
        sum = (sum + int.from_bytes(text[at:at + 16] + b"\1", "little")) * r % P1305
    return (sum + int.from_bytes(key[16:], "little") & (1 << 128) - 1).to_bytes(16, "little")


def xor(a, b):
    return bytes(x ^ y for x, y in zip(a, b))


def padded(text):
    return text + bytes(-len(text) % 16)


def seal(key, nonce, open, text):
    """(ciphertext, tag) by XChaCha20-Poly1305; the nonce has 24 bytes."""
    inner, short = hchacha20(key, nonce[:16]), bytes(4) + nonce[16:]
    cipher = xor(text, chacha20(inner, 1, short, len(text)))
    return cipher, tag_of(inner, short, open, cipher)


def tag_of(inner, short, open, cipher):
    lengths = struct.pack("<QQ", len(open), len(cipher))
    return poly1305(chacha20(inner, 0, short, 32), padded(open) + padded(cipher) + lengths)


def unseal(key, nonce, open, cipher, tag):
    """The text, or None if the tag is another."""
    inner, short = hchacha20(key, nonce[:16]), bytes(4) + nonce[16:]
    if tag_of(inner, short, open, cipher) != tag:
        return None
    return xor(cipher, chacha20(inner, 1, short, len(cipher)))
