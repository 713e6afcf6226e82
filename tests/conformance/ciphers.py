"""X25519 (RFC 7748), Ed25519 (RFC 8032), ChaCha20 (RFC 8439) and XChaCha20 (draft-irtf-cfrg-xchacha-03), slow and plain."""
import struct
from hashlib import sha512

P25519 = (1 << 255) - 19
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


ORDER = (1 << 252) + 27742317777372353535851937790883648493
D = -121665 * pow(121666, P25519 - 2, P25519) % P25519
ROOT_OF_MINUS_ONE = pow(2, (P25519 - 1) // 4, P25519)


def inverse(number):
    return pow(number, P25519 - 2, P25519)


def add(p, q):
    """Of two points x, y, z, x*y/z of the twisted Edwards curve."""
    a, b = (p[1] - p[0]) * (q[1] - q[0]) % P25519, (p[1] + p[0]) * (q[1] + q[0]) % P25519
    c, d = 2 * p[3] * q[3] * D % P25519, 2 * p[2] * q[2] % P25519
    e, f, g, h = b - a, d - c, d + c, b + a
    return e * f % P25519, g * h % P25519, f * g % P25519, e * h % P25519


def times(number, point):
    sum = (0, 1, 1, 0)
    while number:
        if number & 1:
            sum = add(sum, point)
        point, number = add(point, point), number >> 1
    return sum


def x_of(y, odd):
    """Of the point with this y, or None if there is none."""
    square = (y * y - 1) * inverse(D * y * y + 1) % P25519
    x = pow(square, (P25519 + 3) // 8, P25519)
    if (x * x - square) % P25519:
        x = x * ROOT_OF_MINUS_ONE % P25519
    if (x * x - square) % P25519 or (x == 0 and odd):
        return None
    return P25519 - x if x & 1 != odd else x


def base_point():
    y = 4 * inverse(5) % P25519
    x = x_of(y, 0)
    return x, y, 1, x * y % P25519


def packed(point):
    z = inverse(point[2])
    x, y = point[0] * z % P25519, point[1] * z % P25519
    return (y | (x & 1) << 255).to_bytes(32, "little")


def unpacked(text):
    number = int.from_bytes(text, "little")
    y, odd = number & (1 << 255) - 1, number >> 255
    x = x_of(y, odd) if y < P25519 else None
    return None if x is None else (x, y, 1, x * y % P25519)


def halves(secret):
    digest = sha512(secret).digest()
    return (int.from_bytes(digest[:32], "little") & ~7 & (1 << 254) - 1) | 1 << 254, digest[32:]


def number_of(*texts):
    return int.from_bytes(sha512(b"".join(texts)).digest(), "little") % ORDER


def public_key(secret):
    return packed(times(halves(secret)[0], base_point()))


def sign(secret, text):
    scalar, prefix = halves(secret)
    public, r = public_key(secret), number_of(prefix, text)
    big_r = packed(times(r, base_point()))
    return big_r + ((r + number_of(big_r, public, text) * scalar) % ORDER).to_bytes(32, "little")


def signed_by(public, text, signature):
    s, key, r = int.from_bytes(signature[32:], "little"), unpacked(public), unpacked(signature[:32])
    if s >= ORDER or key is None or r is None:
        return False
    return packed(times(s, base_point())) == packed(add(r, times(number_of(signature[:32], public, text), key)))


def shared(secret, public):
    """X25519 of the scalar of one pair and the point of another."""
    y = int.from_bytes(public, "little") & (1 << 255) - 1
    return x25519(sha512(secret).digest()[:32], ((1 + y) * inverse(1 - y) % P25519).to_bytes(32, "little"))


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


def xor(a, b):
    return bytes(x ^ y for x, y in zip(a, b))


def xchacha20(key, nonce, text):
    """The text hidden, or shown again; the nonce has 24 bytes."""
    return xor(text, chacha20(hchacha20(key, nonce[:16]), 0, bytes(4) + nonce[16:], len(text)))
