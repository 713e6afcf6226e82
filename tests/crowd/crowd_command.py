"""padr-lab crowd, as it is called: with --fill several crowds of a size are played, and told together."""
import json
import subprocess
import sys
import unittest

PADR_LAB = sys.argv.pop(1)


def crowds(*arguments):
    done = subprocess.run([PADR_LAB, "crowd", "--seconds", "2", "--warm-up", "2", "--json", "-", *arguments],
                          capture_output=True, text=True, timeout=240)
    if done.returncode != 0:
        raise AssertionError(f"exit code {done.returncode}: {done.stderr}")
    return json.loads(done.stdout)["crowds"]


class Fill(unittest.TestCase):
    def test_tells_the_mean_of_crowds_of_other_seeds_and_the_sum_of_what_is_counted(self):
        alone = [crowds("--peers", "2", "--seed", str(seed))[0] for seed in (5, 6, 7)]
        together, single = crowds("--peers", "2,6", "--fill", "6", "--seed", "5")
        self.assertEqual(together["crowds"], 3)
        self.assertEqual(single["crowds"], 1)
        self.assertGreater(min(c["kbit_per_s"] for c in alone), 0)
        self.assertGreater(len({c["kbit_per_s"] for c in alone}), 1)
        for name in ("kbit_per_s", "updates_per_s", "links_per_peer", "regions_per_peer", "neighbours"):
            self.assertAlmostEqual(together[name], sum(c[name] for c in alone) / 3, places=9, msg=name)
        for name in ("hashes_compared", "region_ticks", "bodies", "regions", "bodies_handed_over"):
            self.assertEqual(together[name], sum(c[name] for c in alone), name)
        near = sum(c["neighbours"] for c in alone)
        if near > 0:
            weighted = sum(c["per_avatar_m"] * c["neighbours"] for c in alone) / near
            self.assertAlmostEqual(together["per_avatar_m"], weighted, places=9)

    def test_is_refused_beyond_what_is_allowed(self):
        done = subprocess.run([PADR_LAB, "crowd", "--fill", "10001"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--fill", done.stderr)
        self.assertIn("10000", done.stderr)

    def test_sizes_are_numbers_with_commas_between(self):
        for sizes in ("4,", ",4", "4,,5", "x", "0", "10001", "4 5"):
            done = subprocess.run([PADR_LAB, "crowd", "--peers", sizes], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 2, sizes)
            self.assertIn(f"--peers: '{sizes}' is not allowed; give numbers from 1 to 10000 with commas", done.stderr)


if __name__ == "__main__":
    unittest.main()
