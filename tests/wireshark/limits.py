"""Datagrams on both sides of every limit that one datagram alone can pass: WIRE.md, sections 3, 4, 7 and 9."""
import struct

from encoder import (MEMBERSHIP, MOST_STEPS, MOTION, PLACE, SESSION, STATE, block, column, datagram, fixed32, floats, in_steps,
                     number, values, varint)  # fmt: skip

BIG = 1 << 30
ADDRESS = bytes(10) + b"\xff\xff\x7f\0\0\1"
HERE = block(2, ADDRESS)


def fixed64(field, value):
    return varint(field << 3 | 1) + struct.pack("<q", value)


def state(*updates, seq=1, tick=100, count=9, more=b""):
    return datagram(STATE, column(1, (seq, tick, count)) + b"".join(block(9, u) for u in updates) + more)


def avatar(x=1.0, y=1.0, vx=0.0, vy=0.0, *control, flags=0x68):
    step = PLACE if flags >> 3 & 3 == 3 else MOTION
    return number(3, flags) + values((x, PLACE), (y, PLACE), (vx, MOTION), (vy, MOTION), *((v, step) for v in control))


def motion(*state):
    return values(*((v, PLACE) for v in state[:3]), *((v, MOTION) for v in state[3:]))


def body(gap=3, flags=0x50, claim=(1, 0), state=(1, 1, 0, 0, 0, 0)):
    return column(4, (128 * gap + flags, *claim)) + motion(*state)


def admission(slot=1, incarnation=5, first=0, address=ADDRESS, port=7000, have=(0, 0)):
    numbers = number(1, slot) + number(2, incarnation) + number(3, first)
    return block(11, numbers + block(4, address) + number(5, port) + column(6, have))


def removal(slot=1, incarnation=0, count=5):
    return block(12, number(1, slot) + number(2, incarnation) + number(3, count))


def passed_on(inner, slot=1, index=3, tick=50):
    return block(13, number(1, slot) + number(2, index) + number(3, tick) + block(4, inner))


def state_cases():
    for tick in (0, (1 << 31) - 2, (1 << 31) - 1):
        yield state(tick=tick)
    for seq in (0, 1, (1 << 32) - 1):
        yield state(seq=seq)
    for numbers in (1, 9, 10):
        yield datagram(STATE, column(1, [1] * numbers))
    yield datagram(STATE, b"")
    for loss in (100, 101):
        yield state(more=number(12, loss))
    for age in (100, 101):
        yield state(more=number(10, age) + fixed32(11, 1))
    for back in (8, 9):
        yield state(number(1, back))
    for back in (100, 101):
        yield state(number(2, back))
    for first, second in (((1, 1), (0, 0)), ((0, 1), (0, 0)), ((1, 0), (0, 0))):  # order, by number and by tick
        yield state(number(1, first[0]) + number(2, first[1]), number(1, second[0]) + number(2, second[1]))


def long_varints():
    """Keys and lengths may have five bytes, values ten; the shortest form is not asked for."""
    for pads in (3, 4):
        pad = b"\x80" * pads + b"\0"
        yield state(more=bytes([12 << 3 | 0x80]) + pad + b"\x05")
        yield state(more=bytes([9 << 3 | 2, 0x80]) + pad)
    for pads in (8, 9):
        yield state(more=bytes([12 << 3, 0x85]) + b"\x80" * pads + b"\0")
    yield state(more=bytes([12 << 3]) + b"\x85\x80\x80\x80\x70")  # more than 32 bits: the lower ones count


def avatar_cases():
    for flags in (0x3F, 0x40, 0x47, 0x7F, 0x80, 0xC0):
        yield state(avatar(flags=flags))
    for control in ((), (1,), (1, 2), (1, 2, 3)):
        for model in range(4):
            yield state(avatar(1, 1, 0, 0, *control, flags=0x60 | model << 3))
    for speed in (121, 121.00001, float("inf"), float("nan")):
        yield state(avatar(1, 1, speed, 0))
        yield state(avatar(1, 1, 0, 0, 0, speed * 10000 / 121, flags=0x78))
        yield state(avatar(speed))
    yield state(avatar(1, 1, 1, 0, flags=0x48))  # at rest, and moves
    yield state(floats(5, 1, 1, 0, -0.0))  # no flags, and a state
    yield state(in_steps((1, 1, 0, 0)))
    for steps in (MOST_STEPS, MOST_STEPS + 1, -MOST_STEPS, -MOST_STEPS - 1):
        yield state(number(3, 0x68) + in_steps((steps, 1, 0, 0)))
        yield state(number(3, 0x68) + floats(5, steps * PLACE, 1, 0, 0))
    for last in (0.0, -0.0, MOTION, MOTION / 2, PLACE):
        yield state(number(3, 0x68) + floats(5, 1, 1, 0, last))
    yield state(number(3, 0x68) + in_steps((1, 1)) + floats(5, 0, -0.0))
    yield state(number(3, 0x68) + in_steps((1, 1, 0, 0)) + floats(5))


def body_cases():
    for entity in (65534, 65535):
        yield state(body(gap=entity))
    for gaps in ((3, 0), (3, 65530), (3, 65531), ((1 << 25) - 1, 0)):
        yield state(column(4, [128 * gap for gap in gaps]))
    for count in (27, 28):
        yield state(column(4, [0] * count))
    for flags in (0x06, 0x07, 0x40, 0x7F):
        yield state(column(4, [128 * 3 + flags]))
    for epoch in (0, 1, BIG, BIG + 1):
        yield state(body(claim=(epoch, 0)))
    for age in (100, 101):
        yield state(body(claim=(1, age)))
    for told in ((1, 1, 0, 0, 0), (1, 1, 0, 0, 0, 0, 0), (1, 1, 100000, 0, 0, 95), (1, 1, 100001, 0, 0, 0),
                 (1, 1, 0, 0, 0, -95.1), (1, 1, 0, 90, 90, 0), (float("nan"), 1, 0, 0, 0, 0)):  # fmt: skip
        yield state(body(state=told))
    yield state(column(4, (128 * 3 + 0x50, 1, 0, 0x50, 1, 0)) + motion(0, 1, 2) + motion(3, 4, 5))
    for claim in ((), (1,), (1, 0, 0), (1, 0, 0, 0)):
        yield state(body(claim=claim))


def order_cases():
    for slot in (0, 1, 63, 64):  # 0 is the sender's own
        yield state(admission(slot=slot))
        yield state(removal(slot=slot))
        yield state(passed_on(b"", slot=slot))
    for value in (0, BIG - 1, BIG):
        yield state(admission(incarnation=value))
        yield state(admission(first=value))
        yield state(admission(have=(value,)))
        yield state(removal(incarnation=value))
        yield state(removal(count=value))
        yield state(passed_on(b"", index=value))
    for have in (64, 65):
        yield state(admission(have=[1] * have))
    for address, port in ((bytes(16), 1), (ADDRESS[:15], 1), (ADDRESS, 0), (ADDRESS, 65535), (ADDRESS, 65536),
                          (ADDRESS + bytes(range(32)), 1), (ADDRESS + bytes(32), 1), (ADDRESS + bytes(31), 1),
                          (bytes(16) + bytes(range(32)), 1)):  # fmt: skip
        yield state(admission(address=address, port=port))
    for tick in (100, 101, 1 << 31):
        yield state(passed_on(b"", tick=tick))
    yield state(passed_on(b"", index=(1 << 32) - 1))
    yield state(removal(1) + removal(2))
    yield state(removal(2) + removal(1))
    yield state(removal() + number(10, 1))  # of two sorts
    yield state(avatar() + admission())
    deep = avatar()
    for n in range(5):
        deep = passed_on(deep, slot=1 + n % 2)
        yield state(deep)


def session_cases():
    def session(kind, content):
        return datagram(SESSION, block(kind, content))

    nonce = fixed64(1, 5)
    for most in (128, 129):
        yield session(1, nonce + block(5, b"a" * most))
    yield session(1, fixed64(1, 0))
    for peer, slots, wanted, incarnation in (
            (0, 4, 2, 3), (3, 4, 2, 3), (4, 4, 2, 3), (1, 4, 2, 0), (1, 2, 3, 1), (1, 64, 64, 1), (1, 65, 64, 1), (0, 1, 1, 1),
            (1, 0, 0, 1)):  # fmt: skip
        for cookie in (0, 9):
            yield session(2, nonce + b"".join(number(field, value) for field, value in
                                              zip((2, 3, 4, 6), (peer, slots, wanted, incarnation))) + fixed64(7, cookie))
    for port in (0, 1, 65535, 65536):
        yield session(3, nonce + HERE + number(3, port))
    for most in (400, 401):
        yield session(4, nonce + block(2, b"\tr\xff" + b"r" * (most - 3)))
    for clock in (0, 1 << 53, (1 << 53) + 1, -(1 << 53), -(1 << 53) - 1):
        yield session(5, fixed64(1, clock) + block(2, bytes(18)))
        yield session(6, fixed64(1, clock) + fixed64(2, clock))
    for padding in (17, 18):
        yield session(5, block(2, bytes(padding)))
    yield datagram(SESSION, b"")
    yield datagram(SESSION, block(5, fixed64(1, 5)) + block(4, b"") + block(5, block(2, bytes(18))))  # the last one counts
    yield datagram(SESSION, block(5, fixed64(1, 5)) + block(5, block(2, bytes(18))))  # taken together


def membership_cases():
    def membership(kind, content):
        return datagram(MEMBERSHIP, block(kind, content))

    nonce, none = fixed64(1, 5), fixed64(1, 0)
    for start in (2047, 2048):
        yield membership(1, nonce + number(2, start))
    for kind in (1, 2, 3):
        yield membership(kind, none + (number(3, 1) + block(4, b"x") if kind == 2 else b""))
    for index, count, size in ((0, 1, 1), (0, 1, 0), (1, 1, 1), (2047, 2048, 1150), (0, 2049, 1), (0, 1, 1151)):
        yield membership(2, nonce + number(2, index) + number(3, count) + block(4, bytes(size)))
    for slots in ((), (0,), (63,), (64,), (1, 2), (2, 1), (1, 1)):
        yield membership(4, b"".join(block(1, number(1, slot) + number(3, 9)) for slot in slots))
        yield membership(8, b"".join(block(2, number(1, slot)) for slot in slots))
    for slot in (63, 64):
        yield membership(6, number(1, slot))
        yield membership(7, number(1, slot) + block(3, number(2, 9) + number(3, 9) + block(9, avatar())))
    for tick in ((1 << 31) - 2, (1 << 31) - 1):
        yield membership(7, block(3, number(2, tick) + number(3, 9) + block(9, b"")))
    yield membership(7, block(3, number(2, 9) + number(3, 9)))
    yield membership(7, block(3, number(2, 9) + number(3, 9) + block(9, b"") + block(9, b"")))


def cases():
    for group in (state_cases, long_varints, avatar_cases, body_cases, order_cases, session_cases, membership_cases):
        yield from group()
