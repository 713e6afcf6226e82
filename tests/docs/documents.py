#!/usr/bin/env python3
"""Checks of the documents. Each prints one line per violation and exits 1 if there are any.

  documents.py links ROOT        links between pages, and to files, that lead nowhere
  documents.py names ROOT        files of the documents that programs and scripts name and that are not there
  documents.py navigation ROOT   pages that mkdocs.yml does not name, or not once, or that are not there
"""

import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tools", "docs"))
import pages  # noqa: E402

# Where messages and --help are written, and other text that people read beside the pages.
SPEAKING = ["common", "shell", "peer", "proto", "tools", "examples", "cmake", ".ci", "CMakeLists.txt", "CMakePresets.json", "Dockerfile",
            "docker-compose.yml"]  # fmt: skip
NAMED = re.compile(r"(?<![\w/.-])(?:docs|proto)/[\w./-]*\w\.(?:md|svg|png|gif|webp|csv|json|proto)\b")


def check_links(root):
    texts = {page: pages.read(page, root) for page in pages.pages(root)}
    anchors = {page: pages.anchors(text) for page, text in texts.items()}
    for page, text in texts.items():
        for line, link in pages.links(text):
            if pages.is_outside(link):
                continue
            target, anchor = pages.target_of(page, link)
            if target.startswith("..") or link.startswith("/"):
                yield f"{page}:{line}: {link} leads out of the repository"
            elif not os.path.isfile(os.path.join(root, target)):
                yield f"{page}:{line}: {link}: there is no file {target}"
            elif anchor and target in anchors and anchor not in anchors[target]:
                yield f"{page}:{line}: {link}: {target} has no heading '{anchor}'; it has: {', '.join(sorted(anchors[target]))}"


def texts_of(root, places):
    """(path, text) of the files in some places; what is no text is left out."""
    for place in places:
        top = os.path.join(root, place)
        files = [top] if os.path.isfile(top) else [os.path.join(d, n) for d, _, names in os.walk(top) for n in sorted(names)]
        for file in files:
            try:
                with open(file, encoding="utf-8") as opened:
                    yield os.path.relpath(file, root), opened.read()
            except UnicodeDecodeError:
                pass


def check_names(root):
    for path, text in texts_of(root, SPEAKING + pages.pages(root)):
        for number, line in enumerate(text.split("\n"), 1):
            for found in NAMED.finditer(line):
                if "NAME" not in found[0] and not os.path.isfile(os.path.join(root, found[0])):
                    yield f"{path}:{number}: there is no file {found[0]}"


def check_navigation(root):
    named, there = pages.navigation(root), pages.pages(root)
    for page in sorted(set(named) | set(there)):
        if page not in there:
            yield f"mkdocs.yml: there is no page {page}"
        elif page not in named:
            yield f"{page}: not in the navigation; give it a line under 'nav' in mkdocs.yml"
        elif named.count(page) > 1:
            yield f"mkdocs.yml: the navigation names {page} {named.count(page)} times"


CHECKS = {"links": check_links, "names": check_names, "navigation": check_navigation}


def main(arguments):
    if len(arguments) != 2 or arguments[0] not in CHECKS:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    complaints = list(CHECKS[arguments[0]](arguments[1]))
    print("\n".join(complaints) if complaints else f"{arguments[0]}: all well")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
