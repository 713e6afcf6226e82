#!/usr/bin/env python3
"""examples/ as a project of its own, outside of this one's build: it builds, and two of its games agree on their world.

Usage: own_game_test.py REPOSITORY BUILD_FOLDER
"""

import os
import socket
import subprocess
import sys
import time


def free_ports(count):
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [str(each.getsockname()[1]) for each in sockets]
    for each in sockets:
        each.close()
    return ports


def build(repository, folder):
    # Little is optimised, for a quick build; no float depends on it.
    options = ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_FLAGS_RELEASE=-O1", "-DPADR_UNITY=ON"]
    subprocess.run(["cmake", "-S", os.path.join(repository, "examples"), "-B", folder, *options], check=True)
    subprocess.run(["cmake", "--build", folder, "--parallel", os.environ.get("PADR_JOBS", "2")], check=True)
    for unwanted in ("bin/padr-peer", "padr/peer", "padr/tests", "padr/tools"):
        assert not os.path.exists(os.path.join(folder, unwanted)), f"{unwanted} was built, and nobody asked for it"


def play(program):
    first, second = free_ports(2)
    games = [subprocess.Popen([program, first], stdout=subprocess.PIPE, text=True)]
    time.sleep(0.5)  # also without it they would find each other, a little later
    games.append(subprocess.Popen([program, second, first], stdout=subprocess.PIPE, text=True))
    try:
        said = [game.communicate(timeout=60)[0] for game in games]
    finally:
        for game in games:
            game.kill()
    assert [game.returncode for game in games] == [0, 0], (said, [game.returncode for game in games])
    return [dict(line.split()[1:] for line in text.splitlines() if line.startswith("confirmed ")) for text in said], said


def main(repository, folder):
    build(repository, folder)
    (ours, theirs), said = play(os.path.join(folder, "own_game"))
    both = sorted(set(ours) & set(theirs), key=int)
    assert len(both) >= 10, said
    assert all(ours[tick] == theirs[tick] for tick in both), said
    assert len(set(ours.values())) > 5, "nothing moved"
    assert "tick 300: body 0 at " in said[0] and ", another avatar at " in said[0], said
    for wrong in (["abc"], ["0"], [free_ports(1)[0], "99999"]):
        done = subprocess.run([os.path.join(folder, "own_game"), *wrong], capture_output=True, text=True, timeout=20)
        assert done.returncode == 1 and done.stderr.startswith(f"own_game: PORT '{wrong[-1]}' is not allowed"), done
    taken = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    taken.bind(("127.0.0.1", 0))
    port = str(taken.getsockname()[1])
    done = subprocess.run([os.path.join(folder, "own_game"), port], capture_output=True, text=True, timeout=20)
    assert (done.returncode, done.stdout, done.stderr) == (1, "", f"own_game: 127.0.0.1:{port}: Address already in use\n"), done
    assert any(" owned by player " in text for text in said), "nobody touched body 0"
    print(f"two games agree on {len(both)} confirmed worlds, the last of tick {both[-1]}")


if __name__ == "__main__":
    main(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]))
