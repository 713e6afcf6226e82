"""The second implementation of section 14: known answers of its ciphers, the standard's vectors, and a real session's keys."""
import re
import sys

import sealed
from ciphers import chacha20, hchacha20, public_key, x25519, xchacha20

BLOCK = re.compile(r"```sealed\n([^`]*)```")


def check_ciphers():
    # RFC 7748, section 5.2: the first iteration.
    nine = (9).to_bytes(32, "little")
    assert x25519(nine, nine).hex() == "422c8e7a6227d7bca1350b3e2bb7279f7897b87bb6854b783c60e80311ae3079"
    # RFC 8439, section 2.3.2.
    stream = chacha20(bytes(range(32)), 1, bytes.fromhex("000000090000004a00000000"), 64)
    assert stream.hex().startswith("10f1e7e4d13b5915500fdd1fa32071c4"), stream.hex()
    # draft-irtf-cfrg-xchacha-03, section 2.2.1.
    inner = hchacha20(bytes(range(32)), bytes.fromhex("000000090000004a0000000031415927"))
    assert inner.hex() == "82413b4227b27bfed30e42508a877d73a0f9e4d58a74a853c12ec41326d3ecdc", inner.hex()
    text = b"Ladies and Gentlemen"
    assert xchacha20(inner, bytes(24), xchacha20(inner, bytes(24), text)) == text


def read(path):
    with open(path, encoding="utf-8") as file:
        (block,) = BLOCK.findall(file.read())
    found = {}
    for line in re.sub(r"#.*", "", block).splitlines():
        if "=" in line:
            name, _, digits = line.partition("=")
            name = name.strip()
            found[name] = b""
            line = digits
        if line.strip():
            found[name] += bytes.fromhex(line)
    return found


def main(path):
    check_ciphers()
    told, made = read(path), sealed.vectors()
    assert told == made, "\n".join(f"{n}: {told.get(n, b'').hex()} told, {made[n].hex()} made" for n in made if told.get(n) != made[n])
    number = (5 << 32) + 7
    for mode in ("auth", "encrypt"):
        assert sealed.unsealed(told["key_a_to_b"], number, told[mode]) == told["unsealed"]
        for bit in range(8 * len(told[mode])):
            damaged = bytearray(told[mode])
            damaged[bit // 8] ^= 1 << bit % 8
            assert sealed.unsealed(told["key_a_to_b"], number, bytes(damaged)) is None, (mode, bit)
    a, b = told["exchange_a"], told["exchange_b"]
    assert told["next_a_to_b"] == sealed.next_key(told["key_a_to_b"], told["exchange_secret_b"], a, a, b)
    assert public_key(told["secret_a"]) == told["public_a"]
    print(f"{len(told)} sealed vectors are as listed")


if __name__ == "__main__":
    main(*sys.argv[1:])
