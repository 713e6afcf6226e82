#!/usr/bin/env python3
"""The checks of the documents, tried on small trees that break one rule each, and on ones that break none."""

import os
import subprocess
import sys
import tempfile
import unittest

import data_page
import documents  # makes tools/docs known
import help_text
import pages


class Tree:
    """A small repository in a temporary folder."""

    def __init__(self, files):
        self.folder = tempfile.TemporaryDirectory()
        for path, text in files.items():
            full = os.path.join(self.folder.name, path)
            os.makedirs(os.path.dirname(full), exist_ok=True)
            with open(full, "w", encoding="utf-8") as file:
                file.write(text)

    def __enter__(self):
        return self.folder.name

    def __exit__(self, *_):
        self.folder.cleanup()


IDEA = "# The idea\n\n## `padr-lab run`: what, why?\n\n## Twice\n\n## Twice\n"

LINKS = [
    # a line of README.md, what the complaint must say (None: no complaint)
    ("[a](docs/idea.md) [b](docs/idea.md#the-idea) [c](#top) <https://example.org/x.md>", None),
    ("[a](docs/idea.md#padr-lab-run-what-why) [b](docs/idea.md#twice-1)", None),
    ("![a picture](docs/picture.svg)", None),
    ("`[a](docs/nowhere.md)`", None),
    ("    [a](docs/nowhere.md)", None),
    ("```\n[a](docs/nowhere.md)\n```", None),
    ("[a](docs/nowhere.md)", "README.md:3: docs/nowhere.md: there is no file docs/nowhere.md"),
    ("![a](docs/nowhere.svg)", "there is no file docs/nowhere.svg"),
    ('<img src="docs/nowhere.gif">', "there is no file docs/nowhere.gif"),
    ("[a]: docs/nowhere.md", "there is no file docs/nowhere.md"),
    ("[a](docs/idea.md#another)", "docs/idea.md has no heading 'another'; it has: padr-lab-run-what-why, the-idea, twice, twice-1"),
    ("[a](docs/idea.md#twice-2)", "docs/idea.md has no heading 'twice-2'"),
    ("[a](#bottom)", "README.md has no heading 'bottom'"),
    ("[a](docs)", "there is no file docs"),
    ("[a](../elsewhere.md)", "leads out of the repository"),
    ("[a](/docs/idea.md)", "leads out of the repository"),
]

NAMES = [
    # a file, its text, what the complaint must say
    ("tools/lab/run.cpp", '"docs/idea.md defines it"', None),
    ("tools/lab/run.cpp", '"/usr/share/docs/no.md, mydocs/no.md"', None),
    ("tools/lab/run.cpp", "writes docs/reference-NAME.md", None),
    ("tools/lab/run.cpp", '\n"docs/no-idea.md defines it"', "tools/lab/run.cpp:2: there is no file docs/no-idea.md"),
    ("docs/other.md", "see `docs/no-idea.md`.", "docs/other.md:1: there is no file docs/no-idea.md"),
    ("tools/run.sh", "# docs/no.svg", "there is no file docs/no.svg"),
]

NAVIGATION = [
    # lines of the navigation, what the complaint must say
    ("  - Home: README.md\n  - Why:\n      - 'The idea: why': docs/idea.md\n", None),
    ("  - Home: README.md\n", "docs/idea.md: not in the navigation"),
    ("  - Home: README.md\n  - A: docs/idea.md\n  - B: docs/idea.md\n", "the navigation names docs/idea.md 2 times"),
    ("  - Home: README.md\n  - A: docs/idea.md\n  - B: docs/no.md\n", "mkdocs.yml: there is no page docs/no.md"),
]


HELP = """Says what it is
for.
Usage: /build/bin/padr-it [OPTIONS]

Options:
  -h,--help                   Print this
  --count INT:in [1 - 9]=3
                              How many|s, with
                              --other
  --names A=B ...             As in docs/idea.md
  --input SPEC Excludes: --in --stretch
                              Instead

SPEC is one of these:
  limit N    loss P    rate R

Example:
  padr-it --count 4
Exit: 0 done.
"""
HELP_SHOWN = """Says what it is for.

```text
padr-it [OPTIONS]
```

## Options

| option | meaning | default; allowed |
|---|---|---|
| `-h, --help` | Print this |  |
| `--count N` | How many\\|s, with `--other` | `3`; 1 to 9 |
| `--names A=B ...` | As in [docs/idea.md](idea.md) |  |
| `--input SPEC` | Instead | not with `--in`, `--stretch` |

SPEC is one of these:

```text
limit N    loss P    rate R
```

Example:

```text
padr-it --count 4
```

Exit: 0 done.
"""


DATA = """
### Means

| field | unit | meaning |
|---|---|---|
| `mean_m` | m | of it |

### `it --json`

| field | unit | meaning |
|---|---|---|
| `n` | | how many |
| `by[].`[means](#means) | | of one |
| `by[].of.CAUSE` | | by cause |
| `list[].a` | | in a list, which may be empty |
| `extra` | | Only sometimes |
"""


class CanFail(unittest.TestCase):
    def expect(self, check, files, complaint):
        with Tree(files) as root:
            said = list(check(root))
        if complaint is None:
            self.assertEqual(said, [])
        else:
            self.assertEqual(len(said), 1, said)
            self.assertIn(complaint, said[0])

    def test_links(self):
        for line, complaint in LINKS:
            with self.subTest(line=line):
                files = {"README.md": f"# Top\n\n{line}\n", "docs/idea.md": IDEA, "docs/picture.svg": ""}
                self.expect(documents.check_links, files, complaint)

    def test_names(self):
        for file, text, complaint in NAMES:
            with self.subTest(file=file, text=text):
                self.expect(documents.check_names, {"docs/idea.md": IDEA, file: text + "\n"}, complaint)

    def test_navigation(self):
        for lines, complaint in NAVIGATION:
            with self.subTest(lines=lines):
                files = {"README.md": "", "docs/idea.md": IDEA, "mkdocs.yml": f"site_name: A\n\nnav:\n{lines}"}
                self.expect(documents.check_navigation, files, complaint)

    def test_what_help_says_is_shown(self):
        self.maxDiff = None
        self.assertEqual(help_text.markdown(HELP, 2, {}), HELP_SHOWN)

    def test_a_program_that_says_something_else_makes_its_page_stale(self):
        names = ["padr-peer", "padr-lab", "padr-report", "padr-capture", "padr-monitor", "padr-netem"]
        with Tree({name: "#!/bin/sh\necho 'Usage: it'\n" for name in names}) as root:
            for name in names:
                os.chmod(os.path.join(root, name), 0o755)
            reference = [sys.executable, "-B", os.path.join(pages.ROOT, "tools", "docs", "reference.py"), "--bin", root, "check"]
            done = subprocess.run(reference, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1, done)
        for name in names:
            self.assertIn(f"stale: docs/reference-{name}.md", done.stdout)

    def test_a_column_that_differs_is_named(self):
        tables = data_page.sections(DATA)
        rows, used = data_page.rows_of(tables, "it --json")
        self.assertEqual(used, {"Means"})
        right = ["n", "by[].mean_m", "by[].of.contact_end", "list[]"]
        self.assertEqual(list(data_page.differences(rows, right)), [])
        self.assertEqual(list(data_page.differences(rows, [*right, "list[].a", "extra"])), [])
        for wrong, said in [
            ([*right, "new"], "not on the page: new"),
            ([*right, "by[].peak_m"], "not on the page: by[].peak_m"),
            ([*right, "by[].of.hunger"], "not on the page: by[].of.hunger"),
            ([*right, "others[]"], "not on the page: others[]"),
            (right[1:], "on the page, and not written: n"),
            ([right[0], *right[2:]], "on the page, and not written: by[].mean_m"),
            (right[:3], "on the page, and not written: list[].a"),
        ]:
            self.assertEqual(list(data_page.differences(rows, wrong)), [said])


if __name__ == "__main__":
    unittest.main()
