#!/usr/bin/env python3
"""The pages of the documents: which there are, where they link to, and what anchors they have.

usage: tools/docs/pages.py assemble FOLDER   put links to all pages, and to the files they link to, into FOLDER
       tools/docs/pages.py list              name the pages

FOLDER gets the repository's own folders, so that relative links between pages work there as they do in the repository. Needs
nothing but Python: the tests of the documents use it where no site is built.
"""

import os
import re
import shutil
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOLDERS = ["docs", "proto", "tools", "examples"]  # besides the top level
MARK = ".made-by-tools-docs"  # only a folder with this file is emptied
EXTRA = ["tools/docs/site.css"]  # what mkdocs.yml names besides pages


def pages(root=ROOT):
    """All pages, as paths from the top of the repository, sorted."""
    found = [name for name in os.listdir(root) if name.endswith(".md")]
    for folder in FOLDERS:
        for place, _, names in os.walk(os.path.join(root, folder)):
            found += [os.path.relpath(os.path.join(place, name), root) for name in names if name.endswith(".md")]
    return sorted(found)


def read(page, root=ROOT):
    with open(os.path.join(root, page), encoding="utf-8") as file:
        return file.read()


def prose(text):
    """The lines of a page with their numbers, without fenced and indented code and without comments."""
    fence, before, comment = None, "", False
    for number, line in enumerate(text.split("\n"), 1):
        mark = re.match(r" {0,3}(```+|~~~+)", line)
        if fence or mark:
            if not fence:
                fence = mark[1]
            elif line.strip().startswith(fence):
                fence = None
            before = ""
            continue
        if line.lstrip().startswith("<!--") or comment:
            comment = "-->" not in line
            before = ""
            continue
        indented = line.startswith("    ") and not before.strip()
        if not indented:
            before = line
            yield number, line


def without_code(line):
    return re.sub(r"(`+).+?\1", "", line)


def links(text):
    """(line, target) of every link and picture of a page, as they are written."""
    for number, line in prose(text):
        line = without_code(line)
        for found in re.finditer(r"\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)", line):
            yield number, found[1]
        for found in re.finditer(r"(?:src|href)=\"([^\"]+)\"", line):
            yield number, found[1]
        found = re.match(r" {0,3}\[[^\]]+\]:\s+(\S+)", line)
        if found:
            yield number, found[1]


def is_outside(target):
    return re.match(r"[a-z][a-z0-9+.-]*:", target) is not None


def anchor_of(heading, separator="-"):
    """The anchor that forges make from a heading's text: lower case, spaces as hyphens, other signs left out."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", separator)


def headings(text):
    """The text of each heading of a page, as it is shown, in order."""
    for _, line in prose(text):
        found = re.match(r" {0,3}#{1,6}\s+(.*?)\s*#*$", line)
        if found:
            shown = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", found[1])
            yield re.sub(r"[`*]|(?<!\w)_|_(?!\w)", "", shown)


def anchors(text):
    """What links to places in a page may name. Two headings of the same text get '-1', '-2', ... as on forges."""
    seen, found = {}, set()
    for heading in headings(text):
        name = anchor_of(heading)
        count = seen.get(name, 0)
        seen[name] = count + 1
        found.add(name if count == 0 else f"{name}-{count}")
    found.update(re.findall(r"<a (?:id|name)=\"([^\"]+)\"", text))
    return found


def target_of(page, link):
    """The file from the top of the repository, and the anchor or "", that a relative link of a page means."""
    path, _, anchor = link.partition("#")
    return (os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page), anchor


def navigation(root=ROOT):
    """The pages that mkdocs.yml names in its navigation, in order."""
    text = read("mkdocs.yml", root).split("\nnav:\n")[1]
    return re.findall(r"^\s*- .*?([\w./-]+\.md)\s*$", text, re.M)


def wanted(root=ROOT):
    """All files of the site: the pages, and what they link to or show."""
    found = set(pages(root)) | set(EXTRA)
    for page in pages(root):
        for _, link in links(read(page, root)):
            target, _ = target_of(page, link)
            if not is_outside(link) and os.path.isfile(os.path.join(root, target)):
                found.add(target)
    return sorted(found)


def assemble(folder, root=ROOT):
    if os.path.isdir(folder) and os.listdir(folder) and not os.path.exists(os.path.join(folder, MARK)):
        sys.exit(f"pages.py: {folder} has files that this program did not put there; name another folder")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    with open(os.path.join(folder, MARK), "w", encoding="utf-8"):
        pass
    for path in wanted(root):
        link = os.path.join(folder, path)
        os.makedirs(os.path.dirname(link), exist_ok=True)
        os.symlink(os.path.join(root, path), link)


def main(arguments):
    if arguments and arguments[0] in ("--help", "-h"):
        print(__doc__.strip())
    elif arguments == ["list"]:
        print("\n".join(pages()))
    elif len(arguments) == 2 and arguments[0] == "assemble":
        assemble(arguments[1])
    else:
        print("pages.py: wrong arguments; wanted: assemble FOLDER, or list; see --help", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main(sys.argv[1:])
