"""tools/doc_commands.py finds what is wrong in a page: each sample breaks one promise, and the one beside it keeps it.

usage: can_fail_test.py DOCUMENTS.PY-COMMAND...
"""

import os
import subprocess
import sys
import tempfile
import unittest

DOCUMENTS = sys.argv[1:]
del sys.argv[1:]


def block(*lines):
    return "\n".join("    " + line for line in lines) + "\n"


def said_of(what, page):
    """Exit status and words of the runner."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "tutorial-sample.md")
        with open(path, "w", encoding="utf-8", errors="surrogateescape") as file:
            file.write(page)
        done = subprocess.run([*DOCUMENTS, "--patience", "5", what, path], capture_output=True, text=True, timeout=100, check=False)
        return done.returncode, done.stdout + done.stderr


class Run(unittest.TestCase):
    def holds(self, page):
        status, said = said_of("run", page)
        self.assertEqual(status, 0, said)

    def fails(self, page, because):
        status, said = said_of("run", page)
        self.assertEqual(status, 1, said)
        self.assertIn(because, said)

    def test_a_command_that_fails(self):
        self.holds(block("true"))
        self.fails(block("true", "false"), "line 2: 'false' exited with 1")
        self.holds("<!-- run: exit 1 -->\n\n" + block("false"))
        self.fails(block("padr-lab run --no-such-option"), "exited with 2")

    def test_what_is_shown_comes(self):
        self.holds(block("echo one two") + "\n<!-- output -->\n\n" + block("one  two"))
        self.fails(block("echo one two") + "\n<!-- output -->\n\n" + block("one three"), "'one three' did not come")
        self.fails(block("printf 'a\\nb\\n'") + "\n<!-- output -->\n\n" + block("a"), "more came than is shown: 'b'")
        self.holds(block("printf 'a\\nb\\n'") + "\n<!-- output -->\n\n" + block("a", "..."))
        self.fails(block("printf 'a\\nb\\n'") + "\n<!-- output -->\n\n" + block("...", "b", "a"), "'a' did not come")

    def test_numbers_have_a_tolerance(self):
        page = block("echo error 1.19 m") + "\n<!-- output{} -->\n\n" + block("error 1.00 m")
        self.holds(page.format(""))
        self.fails(page.format(": within 10 %"), "1.19 is too far from 1")
        self.holds(page.format(": within 10 % or 0.2"))
        self.holds(page.format(': within 10 %; any "error"'))
        self.fails(page.format(": exact"), "did not come")

    def test_times_hashes_and_ports_may_be_others(self):
        came = "echo 12:13:14.156 at 127.0.0.1:4711 hash ca1824d3@114"
        self.holds(block(came) + "\n<!-- output -->\n\n" + block("01:02:03.004 at 127.0.0.1:99 hash 0badcafe@114"))
        self.fails(block(came) + "\n<!-- output -->\n\n" + block("01:02:03.004 at 127.0.0.2:99 hash 0badcafe@114"), "did not come")

    def test_terminals_go_on_beside_the_page(self):
        page = "<!-- run: in terminal 1; until stopped -->\n\n" + block("echo ready; sleep 1000; echo over")
        page += "\n<!-- output of terminal 1 -->\n\n" + block("ready")
        self.holds(page)
        self.holds(page + "\n<!-- stop: terminal 1 -->\n\n" + block("true"))
        self.fails(page.replace("echo ready", "echo rea"), "'ready' did not come")

    def test_where_the_reader_is_stays(self):
        self.holds(block("mkdir a && cd a", "export B=c") + "\ntext\n\n" + block('[ "${PWD##*/}$B" = ac ]'))

    def test_single_commands_of_a_block(self):
        page = "<!-- run:\nno-such => not run, it is no program at all\n-->\n\n" + block("true", "no-such program")
        self.holds(page)
        self.fails(page.replace("no-such =>", "another =>"), "'another' is in 0 commands of the block")

    def test_comments_that_make_no_sense(self):
        self.fails("<!-- run: sometimes -->\n\n" + block("true"), "'sometimes' is none of")
        self.fails("<!-- not run: -->\n\n" + block("true"), "needs a reason")
        self.fails("<!-- output -->\n\ntext\n", "no block follows")

    def test_options_are_shortened(self):
        self.holds('<!-- run: shorter by --seeds 1 --quick -->\n\n' + block('echo --seeds 24 --x  # many') + "\n<!-- output -->\n\n" + block("--seeds 1 --x --quick"))


class Check(unittest.TestCase):
    def fails(self, page, because):
        status, said = said_of("check", page)
        self.assertEqual(status, 1, said)
        self.assertIn(because, said)

    def test_what_is_there(self):
        text = block("$ padr-lab run --seconds 5 --seed 2 | tee log   # ends soon", "build/release/bin/padr-lab sweep \\", "    --csv x")
        status, said = said_of("check", text + "\nSee `padr-report --json`.\n")
        self.assertEqual(status, 0, said)

    def test_what_is_not_there(self):
        self.fails(block("padr-nothing --help"), "there is no padr-nothing")
        self.fails(block("tools/nothing.sh"), "there is no tools/nothing.sh")
        self.fails(block("padr-lab walk"), "padr-lab has no subcommand 'walk'")
        self.fails(block("padr-lab run --csvv -"), "padr-lab run has no option --csvv")
        self.fails(block("true && build/release/bin/padr-lab run \\", "  --csvv -"), "padr-lab run has no option --csvv")
        self.fails(block("tools/test.sh --speed"), "tools/test.sh has no option --speed")
        self.fails("<!-- not run: too long for a test -->\n\n" + block("padr-lab merge --csvv x"), "padr-lab merge has no option --csvv")
        self.fails("Give `padr-peer --quick` a try.\n", "in `padr-peer --quick`: padr-peer has no option --quick")

    def test_a_page_that_is_no_text(self):
        self.fails("caf\udce9\n", "tutorial-sample.md: this is no UTF-8: ")
        status, said = said_of("run", "caf\udce9\n")
        self.assertEqual(status, 1, said)
        self.assertIn("tutorial-sample.md, this is no UTF-8: ", said)

    def test_wrong_arguments(self):
        status, said = said_of("walk", "")
        self.assertEqual(status, 2)
        self.assertRegex(said, r"^doc_commands\.py: .*'walk'.* \(see --help\)\n$")

    def test_tutorials_are_short_and_show_their_figures(self):
        self.fails("word " * 701, "701 words")
        self.fails("It was 0.541 m.\n", "the figure 0.541 is in no block")


unittest.main()
