#!/usr/bin/env python3
"""Follows every link of a built site, and finds what a browser would ask other machines for.

usage: tools/docs/built.py SITE

Prints one line per violation. Exit status: 0 when there is none, 1 when there are, 2 for wrong arguments.
"""

import html.parser
import os
import re
import sys
import urllib.parse

# What a browser fetches without being asked to: attributes by tag. A link in a page's text is followed only by its reader.
FETCHED = {"img": "src", "script": "src", "link": "href", "iframe": "src", "source": "src", "video": "src"}


class Page(html.parser.HTMLParser):
    """The anchors of a page, what it links to, and what it fetches."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.fetched = {"", "__search"}, set(), set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.anchors |= {attributes[name] for name in ("id", "name") if attributes.get(name)}
        if tag == "a" and attributes.get("href"):
            self.links.add(attributes["href"])
        if attributes.get(FETCHED.get(tag)):
            self.fetched.add(attributes[FETCHED[tag]])


def of_kind(site, ending):
    for folder, _, names in os.walk(site):
        for name in sorted(names):
            if name.endswith(ending):
                path = os.path.join(folder, name)
                with open(path, encoding="utf-8") as file:
                    yield os.path.relpath(path, site), file.read()


def is_elsewhere(link):
    return re.match(r"//|[a-z]+:", link) is not None and not link.startswith("data:")


def violations(site):
    read = {path: Page(text) for path, text in of_kind(site, ".html") if path != "404.html"}  # its links begin at '/'
    for path, page in read.items():
        for link in sorted(page.links | page.fetched):
            if is_elsewhere(link):
                if link in page.fetched:
                    yield f"{path}: would ask another machine for {link}"
                continue
            where, _, anchor = urllib.parse.unquote(link).partition("#")
            target = os.path.normpath(os.path.join(os.path.dirname(path), where)) if where else path
            if os.path.isdir(os.path.join(site, target)):
                target = os.path.normpath(os.path.join(target, "index.html"))
            if not os.path.isfile(os.path.join(site, target)):
                yield f"{path}: {link} leads nowhere"
            elif target in read and anchor not in read[target].anchors:
                yield f"{path}: {link}: there is no such place in {target}"
    for path, text in of_kind(site, ".css"):
        for link in re.findall(r"(?:url\(|@import\s*)[\"']?((?:https?:)?//[^\"')]+)", text):
            yield f"{path}: would ask another machine for {link}"


def main(arguments):
    if arguments in (["--help"], ["-h"]):
        print(__doc__.strip())
        return 0
    if len(arguments) != 1 or not os.path.isfile(os.path.join(arguments[0], "index.html")):
        print("built.py: wanted: the folder of a built site; see --help", file=sys.stderr)
        return 2
    found = list(violations(arguments[0]))
    print("\n".join(found) if found else "built.py: every link leads somewhere, nothing is asked of other machines")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
