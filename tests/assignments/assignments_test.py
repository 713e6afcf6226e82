"""The assignments: their starting points do not pass, reference solutions do, and near misses are told what is missing.

usage: assignments_test.py PROGRAMS ASSIGNMENTS
"""

import csv
import json
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import unittest

ASSIGNMENTS = os.path.abspath(sys.argv.pop(2))
PROGRAMS = os.path.abspath(sys.argv.pop(1))
ENVIRONMENT = {**os.environ, "PADR_BIN": PROGRAMS, "PATH": f"{PROGRAMS}:{os.environ['PATH']}"}

OWNERS = '''
import csv, sys
events = [row for row in csv.DictReader(open(sys.argv[1])) if row["entity"] and int(row["tick"] or 0) < int(sys.argv[2])]
owner, epoch = {}, {}
for row in sorted(events, key=lambda row: int(row["tick"])):
    body = row["entity"]
    if row["event"] == "claim":
        number = int(row["detail"].split()[1])
        if number > epoch.get(body, 0):
            owner[body], epoch[body] = row["peer"], number
    elif row["event"] == "release" and owner.get(body) == row["peer"]:
        del owner[body]
for body, peer in owner.items():
    print(body, peer)
'''
OWNERS_UNSORTED = OWNERS.replace('sorted(events, key=lambda row: int(row["tick"]))', "events")
OWNERS_WITHOUT_EPOCHS = OWNERS.replace("number > epoch.get(body, 0)", "True")

PREDICTOR = '''
def predict(updates, t):
    u = updates[-1]
    d = min(t - u["t"], 0.4)
    return u["x"] + u["vx"] * d + u["ax"] * d * d / 4, u["y"] + u["vy"] * d + u["ay"] * d * d / 4
'''
FIRST_ORDER = '''
def predict(updates, t):
    u = updates[-1]
    return u["x"] + u["vx"] * (t - u["t"]), u["y"] + u["vy"] * (t - u["t"])
'''

# Into the line of bodies from behind, and through what lies about.
PATH = """t,x,y
0,3,7.5
1,3,7.5
3.475,9.74,6.02
3.931,11.85,7.19
4.895,7.08,7.82
5.560,8,10.44
6.214,9.04,8.12
8.501,0.9,8.1
"""


class Assignment(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)

    def start(self, name):
        """A copy of what students start from."""
        self.name, self.folder = name, os.path.join(self.temporary.name, name)
        shutil.copytree(os.path.join(ASSIGNMENTS, name), self.folder)

    def hand_in(self, name, text):
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as file:
            file.write(text)

    def judged(self):
        check = os.path.join(ASSIGNMENTS, f"check_{self.name}.py")
        done = subprocess.run([sys.executable, "-B", check, self.folder], capture_output=True, text=True, env=ENVIRONMENT, check=False)
        return done.returncode, done.stdout + done.stderr

    def passes(self):
        status, said = self.judged()
        self.assertEqual(status, 0, said)
        self.assertTrue(said.startswith("pass: "), said)

    def not_yet(self, because):
        status, said = self.judged()
        self.assertEqual(status, 1, said)
        self.assertIn(because, said)


class Loss(Assignment):
    def sweep(self, *words):
        subprocess.run(
            ["padr-lab", "sweep", "--technique", "fixed,full", "--peers", "4", "--delay", "50ms", "--seconds", "20", *words,
             "--csv", os.path.join(self.folder, "loss.csv")], env=ENVIRONMENT, check=True, stdout=subprocess.DEVNULL,
        )  # fmt: skip

    def factor(self, technique, column):
        with open(os.path.join(self.folder, "loss.csv"), encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if row["technique"] == technique]
        most = max(float(row["loss_percent"]) for row in rows)
        return statistics.mean(float(r[column]) for r in rows if float(r["loss_percent"]) == most) / statistics.mean(
            float(r[column]) for r in rows if float(r["loss_percent"]) == 0
        )

    def test_it(self):
        self.start("loss")
        self.not_yet("loss.csv is missing")
        done = subprocess.run([os.path.join(self.folder, "measure.sh")], env=ENVIRONMENT, stdout=subprocess.DEVNULL, check=False)
        self.assertEqual(done.returncode, 0)
        self.not_yet("it needs at least 4")
        os.remove(os.path.join(self.folder, "loss.csv"))
        self.sweep("--loss", "0,5,10,20%", "--seeds", "1-8")
        self.not_yet("fixed_factor in answers.json must be a number: mean inconsistency")
        self.hand_in("answers.json", "[]")
        self.not_yet("must be an object")
        answers = {
            "fixed_factor": round(self.factor("fixed", "mean_m"), 2),
            "full_factor": round(self.factor("full", "mean_m"), 2),
            "fixed_kbit_factor": round(self.factor("fixed", "wire_kbps"), 2),
            "full_kbit_factor": round(self.factor("full", "wire_kbps"), 2),
        }
        self.hand_in("answers.json", json.dumps({**answers, "why": "Because."}))
        self.not_yet("has 1 words")
        self.hand_in("answers.json", json.dumps({**answers, "full_factor": answers["full_factor"] * 1.2, "why": "word " * 50}))
        self.not_yet("full_factor in answers.json is")
        self.hand_in("answers.json", json.dumps({**answers, "why": "word " * 50}))
        self.passes()


class Owners(Assignment):
    def record(self):
        """Three peers on a bad network; the first one writes the capture."""
        netem = ["--netem", "delay 80ms 20ms loss 10%", "--duration", "14", "--status-interval", "0"]
        capture = os.path.join(self.folder, "game.pcapng")
        first = subprocess.Popen(
            ["padr-peer", "--listen", "127.0.0.1:0", "--wait-peers", "3", "--pcap", capture, *netem],
            env=ENVIRONMENT, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        address = re.search(r"listening on (\S+)", first.stderr.readline())[1]
        others = [subprocess.Popen(["padr-peer", "--join", address, *netem], env=ENVIRONMENT, stderr=subprocess.DEVNULL) for _ in range(2)]
        said = first.communicate(timeout=100)[1]
        self.assertEqual([first.returncode] + [other.wait(100) for other in others], [0, 0, 0], said)

    def test_it(self):
        self.start("owners")
        self.not_yet("game.pcapng is missing")
        self.record()
        self.not_yet("ticks of game.pcapng are wrong")
        self.hand_in("owners.py", "print('body 6 is mine')\n")
        self.not_yet("it must print lines of BODY PEER")
        self.hand_in("owners.py", OWNERS_UNSORTED)
        self.not_yet("are wrong; the first is tick")
        self.hand_in("owners.py", OWNERS_WITHOUT_EPOCHS)
        self.not_yet("are wrong; the first is tick")
        self.hand_in("owners.py", OWNERS)
        self.passes()


class Predictor(Assignment):
    def test_it(self):
        self.start("predictor")
        self.not_yet("first-order dead reckoning needs")
        self.hand_in("predictor.py", FIRST_ORDER)
        self.not_yet("save 10%")
        self.hand_in("predictor.py", "def predict(updates, t):\n    return updates[-1]['place']\n")
        self.not_yet("predict() fails: KeyError")
        self.hand_in("predictor.py", "import sys\nsys.exit(0)\n")
        self.not_yet("predictor.py cannot be used: SystemExit: 0")
        self.hand_in("predictor.py", "import sys\ndef predict(updates, t):\n    sys.exit(0)\n")
        self.not_yet("predict() fails: SystemExit: 0")
        self.hand_in("predictor.py", PREDICTOR)
        self.passes()


class Proxy(Assignment):
    def test_it(self):
        self.start("proxy")
        self.not_yet("reach 1.00")
        self.hand_in("path.csv", "t,x,y\n0,3,7.5\n1,19,7.5\n")
        self.not_yet("more than an avatar can do")
        self.hand_in("path.csv", "t,x,y\n0,3,7.5\n12 3 7.5\n")
        self.not_yet("must be t,x,y in numbers")
        self.hand_in("path.csv", PATH.replace("8.501,", "18.5,"))
        self.not_yet("may take 10 s")
        self.hand_in("path.csv", f"# behind the bodies\n{PATH}\n# and away\n")
        self.passes()


unittest.main()
