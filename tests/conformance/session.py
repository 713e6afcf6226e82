"""What must hold of the state datagrams of a whole session, in the order in which they were sent."""
from decoder import STATE, decode


def check(condition, *what):
    assert condition, " ".join(str(part) for part in what)


class Link:
    """What one peer has sent to one other so far."""

    def __init__(self):
        self.seq = self.mark_tick = self.mark_count = self.have = 0
        self.updates = set()
        self.given = 0  # numbers below this are in the transfer that the receiver began with
        self.datagrams = 0
        self.told = 0  # tick of the last datagram that told of the link and the hash
        self.check_tick = -1  # of that hash


class Session:
    def __init__(self, peers):
        self.links = {(a, b): Link() for a in range(peers) for b in range(peers) if a != b}
        self.updates = [{} for _ in range(peers)]  # of each sender: number -> what it said
        self.messages = {}
        self.marks = self.longest = 0

    @property
    def bodies(self):
        return sum(len(update["bodies"]) for updates in self.updates for update in updates.values())

    def datagram(self, sender, receiver, raw):
        """Decodes and checks one datagram; gives what is in it."""
        decoded = decode(raw)
        self.longest = max(self.longest, len(raw))
        if decoded["kind"] == STATE:
            check(decoded["sender"] == sender, "peer", sender, "says it is", decoded["sender"])
            self.state(sender, receiver, decoded)
        else:
            name = decoded["message"][0]
            self.messages[name] = self.messages.get(name, 0) + 1
            check(name != "join" or len(raw) == 1200, "a join is padded to the largest datagram")
        return decoded

    def state(self, sender, receiver, decoded):
        link, back = self.links[sender, receiver], self.links[receiver, sender]
        link.datagrams += 1
        check(decoded["seq"] == link.seq + 1, "seq", decoded["seq"], "after", link.seq)
        check(decoded["mark_tick"] > link.mark_tick or link.seq == 0, "two datagrams in a tick, or back in time")
        check(decoded["mark_count"] >= link.mark_count, "the mark went back")
        check(decoded["have"] >= link.have, "an acknowledgement was taken back")
        check(decoded["seen_seq"] <= back.seq, "seen what was not sent")
        link.seq, link.mark_tick, link.mark_count, link.have = (
            decoded[name] for name in ("seq", "mark_tick", "mark_count", "have"))
        self.acknowledged(decoded, back)
        self.marks += not decoded["updates"]
        if decoded["transit"] or decoded["check_hash"] or decoded["updates"] and decoded["loss"]:
            newer = not decoded["updates"] and decoded["check_tick"] > link.check_tick
            check(newer or decoded["mark_tick"] - link.told >= 60, "told too soon")
            link.told, link.check_tick = decoded["mark_tick"], decoded["check_tick"] if decoded["check_hash"] else -1
        for update in decoded["updates"]:
            link.updates.add(update["index"])
            if update["admission"]:
                newcomer = update["admission"]["slot"]
                for slot, have in enumerate(update["admission"]["have"][: len(self.updates)]):
                    if slot != newcomer:
                        self.links[slot, newcomer].given = have
            known = self.updates[sender].setdefault(update["index"], update)
            check(repr(known) == repr(update), "an update that was something else before:", update)

    def acknowledged(self, decoded, back):
        """What is said to have arrived must have been sent on that link, or before that in the transfer."""
        bits = decoded["have_beyond"]
        said = set(range(back.given, decoded["have"])) | {decoded["have"] + 1 + i for i in range(32) if bits >> i & 1}
        check(said <= back.updates, "acknowledged, but never sent:", said - back.updates)

    def finish(self):
        """Once all has been sent: a sender's numbers have no gaps, its ticks ascend, and its marks told the truth."""
        for updates in self.updates:
            check(sorted(updates) == list(range(len(updates))), "gaps in the numbers", sorted(updates))
            ticks = [updates[n]["tick"] for n in range(len(updates))]
            check(all(a < b for a, b in zip(ticks, ticks[1:])), "ticks do not ascend", ticks)
            leaves = [updates[n]["leave"] for n in range(len(updates))]
            check(leaves == [False] * (len(leaves) - 1) + [True], "the leave is not the last", leaves)
        for (sender, receiver), link in self.links.items():
            # Whoever has left is told no more, and who came in has by its transfer what was before.
            told = {n for n, update in self.updates[sender].items() if update["tick"] < self.last_tick(receiver)}
            told -= set(range(link.given))
            check(told <= link.updates, "not all was sent from", sender, "to", receiver, told - link.updates)
            check(link.mark_count <= len(self.updates[sender]), "a mark above all that there is")

    def last_tick(self, peer):
        return max(update["tick"] for update in self.updates[peer].values())
