"""padr-monitor's web server: the files that it serves, and the requests that it refuses."""

import json
import os
import signal
import socket
import time

from monitors import MonitorCase, Refused, main, refused, wait_until


class Serving(MonitorCase):
    def test_the_page_and_all_it_needs_come_from_the_program(self):
        m = self.monitor()
        status, headers, body = m.get("/")
        self.assertEqual(status, 200)
        self.assertEqual(headers["Content-Type"], "text/html; charset=utf-8")
        self.assertIn("default-src 'none'", headers["Content-Security-Policy"])
        self.assertNotIn("unsafe", headers["Content-Security-Policy"])
        self.assertEqual(headers["X-Content-Type-Options"], "nosniff")
        self.assertEqual(m.get("/index.html")[2], body)
        self.assertIn(b"<html", body)
        for path, kind in [("/vendor/dygraph.min.js", "text/javascript"), ("/vendor/dygraph.css", "text/css")]:
            status, headers, body = m.get(path)
            self.assertEqual(status, 200, path)
            self.assertTrue(headers["Content-Type"].startswith(kind))
            self.assertGreater(len(body), 1000)
        self.assertEqual(m.get("/PROTOCOL.md")[0], 404)
        self.assertEqual(m.get("/../CMakeLists.txt")[0], 404)

    def test_what_has_not_changed_is_not_sent_again(self):
        m = self.monitor()
        tag = m.get("/")[1]["ETag"]
        status, headers, body = m.get("/", headers={"If-None-Match": tag})
        self.assertEqual((status, body), (304, b""))
        self.assertEqual(m.get("/", headers={"If-None-Match": '"old"'})[0], 200)
        status, headers, body = m.get("/", method="HEAD")
        self.assertEqual((status, body), (200, b""))
        self.assertGreater(int(headers["Content-Length"]), 100)

    def test_it_has_something_to_say_before_there_is_a_session(self):
        m = self.monitor()
        session = m.session()
        self.assertEqual(session["hello"]["mode"], "live")
        self.assertIsNone(session["scene"])
        self.assertEqual(m.metrics()["padr_monitor_viewers"], 0)
        self.assertEqual(m.get("/api/path?peer=0")[0], 404)
        self.assertEqual(m.get("/api/path?peer=99")[0], 400)
        self.assertEqual(m.get("/api/path")[0], 400)
        page = self.page(m)
        hello = page.wait("hello")
        self.assertTrue(hello["control"])
        self.assertIn("threshold", [k["name"] for k in hello["knobs"]])
        answer = page.ask(type="drive", peer=0, direction=[1, 0])
        self.assertEqual((answer["ok"], answer["text"]), (False, "there is no session"))


class Ending(MonitorCase):
    def test_signals_end_it_cleanly(self):
        for how in (signal.SIGINT, signal.SIGTERM):
            m = self.monitor()
            page = self.page(m)
            page.wait("hello")
            self.assertEqual(m.end(how), 0)
            self.assertEqual(page.wait_closed(), 1001, "going away")

    def test_it_ends_by_itself_if_told(self):
        m = self.monitor("--duration", 0.3)
        self.assertEqual(m.process.wait(20), 0)

    def test_a_port_in_use_is_one_clear_line(self):
        m = self.monitor()
        code, said = refused("--listen", f"127.0.0.1:{m.port}", "--peers-listen", "127.0.0.1:0")
        self.assertEqual(code, 1)
        self.assertEqual(said.splitlines()[-1], f"padr-monitor: cannot listen on 127.0.0.1:{m.port}: Address already in use; "
                         "give another port with --listen (0: any free port)")  # fmt: skip
        code, said = refused("--listen", "127.0.0.1:0", "--peers-listen", m.heard_at())
        self.assertEqual(code, 1)
        self.assertIn(f"cannot listen on {m.heard_at()}", said)
        self.assertIn("--peers-listen", said)

    def test_a_restart_gets_the_port_back_at_once(self):
        m = self.monitor()
        page = self.page(m)
        page.wait("hello")
        m.end()
        again = self.monitor(web=f"127.0.0.1:{m.port}")
        self.assertEqual(again.get("/api/session")[0], 200)

    def test_mistakes_of_users(self):
        for arguments, said in [
            (["--listen", "nonsense"], "--listen"),
            (["--listen", "0.0.0.0:0"], "--insecure"),
            (["--peers-listen", "0.0.0.0:0"], "--insecure"),
            (["--trace", "/nonexistent.trace"], "/nonexistent.trace"),
            (["--trace", "a", "--capture", "b"], "do not go together"),
            (["--capture", "/nonexistent.pcap"], "/nonexistent.pcap"),
            (["--control-token", "short"], "--control-token or PADR_CONTROL_TOKEN: 5 characters"),
            (["--allow-host", "http://padr.example"], "--allow-host: 'http://padr.example' is not a host name"),
            (["--allow-host", "padr.example:8080"], "without scheme, port and path"),
            (["--duration", "-1"], "--duration"),
        ]:
            code, text = refused("--duration", "1", *arguments) if arguments[0] != "--duration" else refused(*arguments)
            self.assertEqual(code, 2, (arguments, text))
            self.assertIn(said, text)
            self.assertEqual(len(text.strip().splitlines()), 1, text)


class Stories(MonitorCase):
    # Once, nobody was answered meanwhile.
    def test_a_story_is_read_while_others_are_served(self):
        m = self.monitor()
        page = self.page(m, path="/ws?sample=bad-network-full")
        self.assertEqual(page.wait("hello")["sample"], "bad-network-full")
        self.assertIsNone(m.session()["scene"])
        self.assertIsNone(json.loads(m.get("/api/session?sample=bad-network-full")[2])["scene"])
        self.assertIn("still being read", page.ask(type="play")["text"])
        self.assertEqual(page.all("scene") + page.all("timeline"), [])
        page.wait("timeline", lambda t: t["playing"] and t["tick"] > 60)
        self.assertEqual((len(page.all("scene")), len(page.all("history"))), (1, 1))
        self.assertEqual(json.loads(m.get("/api/session?sample=bad-network-full")[2])["scene"]["name"], "arena")


class Hostile(MonitorCase):
    def request(self, m, *lines):
        return m.raw("\r\n".join(["GET / HTTP/1.1", *lines, "", ""]).encode("latin-1"))

    def test_bad_http_gets_an_error_or_nothing(self):
        m = self.monitor()
        host = f"Host: 127.0.0.1:{m.port}"
        for sent, status in [
            (b"\x00\x01\x02\x03 nonsense\r\n\r\n", b"400"),
            (b"GET / HTTP/9.9\r\n\r\n", b"400"),
            (b"GET  HTTP/1.1\r\n\r\n", b"400"),
            (b"GET / HTTP/1.1\r\n\r\n", b"421"),
            (f"GET /%2e%2e/etc/passwd HTTP/1.1\r\n{host}\r\n\r\n".encode(), b"400"),
            (f"GET http://evil.example/ HTTP/1.1\r\n{host}\r\n\r\n".encode(), b"400"),
            (f"POST / HTTP/1.1\r\n{host}\r\nContent-Length: 5\r\n\r\nhello".encode(), b"405"),
            (f"GET / HTTP/1.1\r\n{host}\r\nContent-Length: 5\r\n\r\nhello".encode(), b"413"),
            (f"DELETE / HTTP/1.1\r\n{host}\r\n\r\n".encode(), b"405"),
            (f"GET / HTTP/1.1\r\n{host}\r\nHost: 127.0.0.1\r\n\r\n".encode(), b"421"),
            (f"GET / HTTP/1.1\r\n{host}\r\nContent-Length: 99999999999999999999\r\n\r\n".encode(), b"400"),
            (f"GET / HTTP/1.1\r\n{host}\r\nX: {'y' * 10000}\r\n\r\n".encode(), b"431"),
            (b"GET /" + b"a" * 100000, b"431"),
            (f"GET /ws HTTP/1.1\r\n{host}\r\n\r\n".encode(), b"426"),
        ]:
            answer = m.raw(sent)
            self.assertTrue(answer.startswith(b"HTTP/1.1 " + status), (sent[:60], answer[:60]))
        self.assertTrue(m.alive())
        self.assertGreaterEqual(m.metrics()["padr_monitor_malformed_requests_total"], 6)

    def test_names_that_others_point_at_us_are_not_served(self):
        m = self.monitor("--allow-host", "monitor.example")
        for name, status in [("evil.example", 421), (f"evil.example:{m.port}", 421), ("localhost", 200), (f"[::1]:{m.port}", 200),
                             ("monitor.example:1234", 200), ("127.0.0.1.evil.example", 421)]:  # fmt: skip
            self.assertEqual(m.get("/", headers={"Host": name})[0], status, name)

    def test_pages_of_others_cannot_connect(self):
        m = self.monitor()
        self.page(m, origin=f"http://127.0.0.1:{m.port}").wait("hello")
        self.page(m, origin=f"http://localhost:{m.port}", host=f"localhost:{m.port}").wait("hello")
        for origin in ("http://evil.example", "null", f"http://127.0.0.1:{m.port + 1}", f"http://localhost:{m.port}"):
            with self.assertRaises(Refused) as caught:
                self.page(m, origin=origin)
            self.assertEqual(caught.exception.status, 403, origin)
        with self.assertRaises(Refused) as caught:
            self.page(m, host="evil.example", origin="http://evil.example")
        self.assertEqual(caught.exception.status, 421)

    def test_messages_that_are_wrong_are_answered(self):
        m = self.monitor()
        page = self.page(m)
        for sent in (b"", b"nonsense", b"[1,2]", b"{}", b'{"type":"drive","peer":-1}', b'{"type":' * 500):
            before = len(page.all("answer"))
            page.frame(1, sent)
            wait_until(lambda: len(page.all("answer")) > before, f"an answer to {sent[:20]}")
            self.assertFalse(page.all("answer")[-1]["ok"])
        self.assertIsNone(page.closed)

    def test_frames_that_are_wrong_end_the_connection(self):
        m = self.monitor()
        huge, binary, fragments, unmasked, invalid, endless = (self.page(m) for _ in range(6))
        huge.frame(1, b'"' + b"x" * 9000 + b'"')
        self.assertEqual(huge.wait_closed(), 1009, "message too big")
        binary.frame(2, b"\0\1\2")
        self.assertEqual(binary.wait_closed(), 1008)
        fragments.frame(1, b'{"type":', final=False)
        for _ in range(200):
            try:
                fragments.frame(0, b" " * 100, final=False)
            except OSError:
                break
        self.assertEqual(fragments.wait_closed(), 1009, "all fragments together")
        unmasked.frame(1, b"{}", masked=False)
        self.assertIn(unmasked.wait_closed(), (1002, 1006))
        invalid.frame(1, b"\xc3\x28")
        self.assertIn(invalid.wait_closed(), (1007, 1006))
        endless.socket.sendall(b"\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff\0\0\0\0")
        self.assertIn(endless.wait_closed(), (1009, 1002, 1006))
        self.page(m).wait("hello")

    def test_a_flood_of_messages_ends_the_connection(self):
        m = self.monitor()
        page = self.page(m)
        try:
            for _ in range(1000):
                page.say(type="subscribe")
        except OSError:
            pass
        self.assertIn(page.wait_closed(), (1008, 1006))

    def test_connections_are_bounded_and_come_back(self):
        m = self.monitor()
        crowd = []
        for _ in range(300):
            s = m.connect()
            crowd.append(s)
        wait_until(lambda: sum(self.is_closed(s) for s in crowd) >= 300 - 256, "those beyond the limit are turned away")
        for s in crowd:
            s.close()
        wait_until(lambda: self.answers(m), "an answer once they are gone")

    @staticmethod
    def is_closed(s):
        s.setblocking(False)
        try:
            return s.recv(1, socket.MSG_PEEK) == b""
        except BlockingIOError:
            return False
        except OSError:
            return True

    @staticmethod
    def answers(m):
        try:
            return m.get("/api/session")[0] == 200
        except OSError:
            return False

    def test_pages_are_bounded(self):
        m = self.monitor()
        pages = [self.page(m) for _ in range(64)]
        with self.assertRaises(Refused) as caught:
            self.page(m)
        self.assertEqual(caught.exception.status, 503)
        pages[0].close()
        wait_until(lambda: m.metrics()["padr_monitor_viewers"] < 64, "room again")
        self.page(m).wait("hello")

    def test_requests_that_drip_are_cut_off(self):
        m = self.monitor()
        with m.connect() as s:
            begun = time.monotonic()
            s.sendall(b"GET / HTTP/1.1\r\n")
            try:
                while time.monotonic() - begun < 30:
                    s.sendall(b"X")
                    s.settimeout(0.5)
                    try:
                        if s.recv(100) == b"":
                            break
                    except TimeoutError:
                        pass
            except OSError:
                pass
            self.assertLess(time.monotonic() - begun, 20, "ten seconds for a request, however its bytes come")
        self.assertGreaterEqual(m.metrics()["padr_monitor_timeouts_total"], 1)

    def test_datagrams_that_are_no_messages_are_counted(self):
        m = self.monitor()
        host, _, port = m.heard_at().rpartition(":")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
            for i in range(200):
                s.sendto(os.urandom(i % 100), (host, int(port)))
        wait_until(lambda: m.metrics()["padr_monitor_malformed_datagrams_total"] >= 190, "malformed datagrams")
        self.assertIsNone(m.session()["scene"])


class Control(MonitorCase):
    def test_view_only_is_for_everybody(self):
        page = self.page(self.monitor("--view-only"))
        self.assertFalse(page.wait("hello")["control"])
        self.assertIn("--view-only", page.ask(type="pause", peer="all", on=True)["text"])

    def elsewhere(self, m):
        """A page that does not come from a loopback address, if this machine has another one."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
            try:
                s.connect(("192.0.2.1", 9))
            except OSError:
                self.skipTest("this machine has no other address")
            m.host = s.getsockname()[0]
        if m.host.startswith("127."):
            self.skipTest("this machine has no other address")
        return self.page(m)

    def test_from_elsewhere_only_with_the_token(self):
        env = {**os.environ, "PADR_CONTROL_TOKEN": "a secret of the tests"}
        m = self.monitor("--insecure", web="0.0.0.0:0", env=env)
        page = self.elsewhere(m)
        hello = page.wait("hello")
        self.assertEqual((hello["control"], hello["needs_token"]), (False, True))
        self.assertIn("token", page.ask(type="pause", peer="all", on=True)["text"])
        self.assertFalse(page.ask(type="token", token="a secret of the test!")["ok"])
        self.assertTrue(page.ask(type="token", token="a secret of the tests")["ok"])
        self.assertTrue(page.wait("hello", lambda h: h["control"]))
        self.assertEqual(page.ask(type="pause", peer="all", on=True)["text"], "there is no session")
        guesser = self.page(m)
        self.assertFalse(guesser.wait("hello")["control"], "here, too, where somebody's proxy may run")
        for i in range(5):
            guesser.say(type="token", token=f"guess {i}")
        self.assertEqual(guesser.wait_closed(), 1008)

    def test_what_a_proxy_passes_on_comes_from_elsewhere(self):
        m = self.monitor()
        self.assertTrue(self.page(m).wait("hello")["control"])
        for header in ("Forwarded: for=192.0.2.1", "X-Forwarded-For: 192.0.2.1", "x-real-ip: 192.0.2.1", "Via: 1.1 proxy"):
            page = self.page(m, headers=[header])
            self.assertFalse(page.wait("hello")["control"], header)
            self.assertIn("own machine", page.ask(type="pause", peer="all", on=True)["text"])

    def test_without_a_token_nobody_elsewhere_controls(self):
        m = self.monitor("--insecure", web="0.0.0.0:0")
        page = self.elsewhere(m)
        hello = page.wait("hello")
        self.assertEqual((hello["control"], hello["needs_token"]), (False, False))
        self.assertFalse(page.ask(type="token", token="")["ok"])


if __name__ == "__main__":
    main()
