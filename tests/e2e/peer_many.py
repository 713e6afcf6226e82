#!/usr/bin/env python3
"""As many peers as a session can have: they come together, play, believe the same and leave. Nothing here is about time."""
from peers import PLAYING, Case, main

MOST_PEERS = 64
SECONDS = 6


class Many(Case):
    def test_as_many_peers_as_there_can_be_agree(self):
        # A few of them move, so that there is something to agree on.
        own = [["--input", f"wander:{n}" if n % 16 == 0 else "rest"] for n in range(MOST_PEERS)]
        peers = self.session(MOST_PEERS, "--slots", MOST_PEERS, "--status-interval", 0, "--duration", SECONDS, own=own)
        for peer in peers:
            peer.wait_for(PLAYING)
        self.assertEqual([peer.end(60) for peer in peers], [0] * MOST_PEERS)
        summaries = [peer.summary() for peer in peers]
        self.assertEqual(sorted(s["peer"] for s in summaries), list(range(MOST_PEERS)))
        self.check_agreement(peers, SECONDS)
        for s in summaries:
            self.assertEqual(len(s["links"]), MOST_PEERS - 1)
            self.assertEqual(len(s["lives"]), 1, s["lives"])
        for s in summaries[::16]:
            self.assertGreater(s["sent"]["updates"], 0, "who moves has something to say")


if __name__ == "__main__":
    main()
