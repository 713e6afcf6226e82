"""Compares output that a page shows with output that came.

Lines come in order and have the same words. `...` on a line of its own stands for any lines, within a line for any text. A number
may be off by the page's tolerance. A clock time, a hash and a port are of no moment: any other will do.

The tolerance, a list with `;` between its parts:
  exact                every character counts
  within 30 %          of the number that is shown (default: 20 %)
  within 30 % or 5     or by no more than 5; what real peers did on a busy machine needs room: within 400 % or 300
  any "session" "at"   numbers that follow one of these words may be any
"""

import re
from dataclasses import dataclass

from pages import Wrong

TOKEN = re.compile(
    r"(?P<time>\b(?:\d{4}-\d\d-\d\dT)?\d\d:\d\d:\d\d(?:\.\d+)?)"
    r"|(?P<port>(?<=\d\.\d\.\d:)\d+)"
    r"|(?P<hash>(?<![\w.])(?=\d*[a-f])(?=[a-f]*\d)[0-9a-f]{8,16}(?![\w.]))"
    r"|(?P<number>(?<![\w])(?:(?<![\w.])-)?\d+(?:\.\d+)?(?![\w]))"
    r"|(?P<gap>\.\.\.)"
    r"|(?P<space>\s+)"
    r"|(?P<word>\w+|.)"
)


@dataclass
class Tolerance:
    exact: bool = False
    share: float = 0.2
    least: float = 0.0
    free: tuple = ()

    def allows(self, shown, came):
        return abs(shown - came) <= max(self.share * abs(shown), self.least) + 1e-9


def tolerance_of(words, line):
    tolerance = Tolerance()
    for item in filter(None, (w.strip() for w in words.split(";"))):
        within = re.fullmatch(r"within ([\d.]+) %(?: or ([\d.]+))?", item)
        if item == "exact":
            tolerance.exact = True
        elif within:
            tolerance.share = float(within[1]) / 100
            tolerance.least = float(within[2] or 0)
        elif re.fullmatch(r'any( "[^"]+")+', item):
            tolerance.free = tuple(re.findall(r'"([^"]+)"', item))
        else:
            raise Wrong(f"line {line}: '{item}' is none of: exact, within N % or M, any \"WORD\"...")
    return tolerance


def pattern_of(shown, tolerance):
    """A regular expression of what may come in place of a shown line, and the numbers that its groups stand for."""
    if tolerance.exact:
        return re.compile(".*?".join(re.escape(part) for part in shown.split("..."))), []
    pattern, numbers = "", []
    for token in TOKEN.finditer(shown.strip()):
        text = token.group()
        before = shown.strip()[: token.start()].rstrip()
        if token["time"]:
            pattern += r"(?:\d{4}-\d\d-\d\dT)?\d\d:\d\d:\d\d(?:\.\d+)?"
        elif token["port"]:
            pattern += r"\d+"
        elif token["hash"]:
            pattern += f"[0-9a-f]{{{len(text)}}}"
        elif token["number"]:
            pattern += r"(-?\d+(?:\.\d+)?)"
            numbers.append(None if any(before.endswith(word) for word in tolerance.free) else float(text))
        elif token["gap"]:
            pattern += ".*?"
        elif token["space"]:
            pattern += r"\s+"
        else:
            pattern += re.escape(text)
    return re.compile(pattern), numbers


def differs(shown, came, tolerance):
    """Nothing if the line that came is what was shown, else why not."""
    pattern, numbers = pattern_of(shown, tolerance)
    match = pattern.fullmatch(came if tolerance.exact else came.strip())
    if not match:
        return "other words"
    for number, group in zip(numbers, match.groups()):
        if number is not None and not tolerance.allows(number, float(group)):
            return f"{group} is too far from {number:g}"
    return ""


def compare(shown, came, tolerance):
    """Raises Wrong with the first shown line that did not come."""
    shown = [line.rstrip() for line in shown]
    came = [line.rstrip() for line in came]
    while came and not came[0]:
        came.pop(0)
    while came and not came[-1]:
        came.pop()
    reached = {0}  # how many lines of what came may have been used up by the lines shown so far
    for line in shown:
        if line == "...":
            reached = set(range(min(reached), len(came) + 1))
            continue
        after = {i + 1 for i in reached if i < len(came) and not differs(line, came[i], tolerance)}
        if not after:
            raise Wrong(explained(line, sorted(reached), came, tolerance))
        reached = after
    if len(came) not in reached:
        rest = came[min(reached)]
        raise Wrong(f"more came than is shown: '{rest.strip()}'")


def explained(line, places, came, tolerance):
    reasons = [(differs(line, came[i], tolerance), came[i]) for i in places if i < len(came)]
    near = [f"{why}: '{text.strip()}'" for why, text in reasons if why != "other words"]
    others = [f"in its place: '{text.strip()}'" for _, text in reasons[:1]] if len(places) == 1 else []
    return f"'{line.strip()}' did not come; " + "; ".join(near[:3] or others or ["nothing like it did"])
