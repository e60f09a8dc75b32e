"""Twelve attacks on a server of Mercury Cloud, for its administrator: `attacks.sh LINK [NAME...]`.

They go to loopback addresses only, are bounded in number and time (the longest takes about a minute), make two users and remove them
with all that they have. The server holds if all attacks say so; the exit code is then 0. Standard library only.
"""

import contextlib
import hashlib
import http.client
import ipaddress
import json
import os
import socket
import sys
import threading
import time
from urllib.parse import urlsplit

PASSWORD = "correct horse battery"


class Fell(Exception):
    pass


def holds(condition, message):
    if not condition:
        raise Fell(message)


class Caller:
    """Requests with one cookie, from one address."""

    def __init__(self, target, cookie=None, address="127.0.0.1"):
        self.target, self.cookie, self.address = target, cookie, address

    def ask(self, method, path, body=None, headers=None):
        """Status and body. Bytes are sent as they are, all else as JSON."""
        connection = http.client.HTTPConnection(*self.target, timeout=60, source_address=(self.address, 0))
        head = {"Sec-Fetch-Site": "same-origin", "Content-Type": "application/json"}
        if self.cookie:
            head["Cookie"] = self.cookie
        data = body if isinstance(body, bytes) or body is None else json.dumps(body)
        connection.request(method, "/api/v1" + path, data, head | (headers or {}))
        answer = connection.getresponse()
        self.set_cookie = answer.headers.get("set-cookie", "").split(";")[0]
        content = answer.read()
        connection.close()
        return answer.status, content

    def get(self, method, path, body=None, status=(200, 201, 204)):
        got, content = self.ask(method, path, body)
        if got not in status:
            raise RuntimeError(f"{method} {path}: {got} {content[:300]!r}")
        return json.loads(content) if content[:1] in (b"{", b"[") else content

    def log_in(self, **body):
        """Another caller, with a session of its own."""
        new = Caller(self.target, None, self.address)
        new.get("POST", "/session", body)
        new.cookie = new.set_cookie
        return new

    def stalled(self, path, count):
        """Connections that send a request and read nothing."""
        made = []
        for _ in range(count):
            raw = socket.socket()
            raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            raw.connect(self.target)
            with contextlib.suppress(OSError):
                raw.sendall(f"GET /api/v1{path} HTTP/1.1\r\nHost: {self.target[0]}\r\nCookie: {self.cookie}\r\n\r\n".encode())
            made.append(raw)
        return made


class Site:
    """The server with two users: ada has a run, and eve attacks."""

    def __init__(self, link):
        url = urlsplit(link.strip())
        if not ipaddress.ip_address(socket.gethostbyname(url.hostname)).is_loopback:
            raise SystemExit(f"{url.hostname} is no loopback address: these attacks are for a server on this machine")
        self.target = (url.hostname, url.port or 80)
        self.admin = Caller(self.target).log_in(token=url.fragment.removeprefix("token="))
        mark = os.urandom(4).hex()
        self.names = {"ada": f"ada-{mark}", "eve": f"eve-{mark}"}
        self.project = None

    def __enter__(self):
        for name in self.names.values():
            self.admin.get("POST", "/users", {"name": name, "password": PASSWORD})
        self.ada, self.eve = (self.user(role) for role in ("ada", "eve"))
        template = self.ada.get("GET", "/templates")[0]
        self.scene = {"name": template["scene"], "text": template["text"], "files": template["files"],
                      "set": ["output.pictures=false", "time.end=1e-4"]}
        self.run = self.ada.get("POST", "/runs", {"scene": self.scene, "title": "of ada"})["id"]
        end = time.monotonic() + 120
        while self.ada.get("GET", f"/runs/{self.run}")["state"] not in ("finished", "failed") and time.monotonic() < end:
            time.sleep(0.3)
        return self

    def __exit__(self, *_):
        for name in self.names.values():
            end = time.monotonic() + 60
            # Live runs are ended first, and the answer is 409 until they are.
            while self.admin.ask("DELETE", f"/users/{name}")[0] == 409 and time.monotonic() < end:
                time.sleep(0.5)

    def user(self, role, address="127.0.0.1"):
        return Caller(self.target, None, address).log_in(name=self.names[role], password=PASSWORD)

    def share(self, run=None):
        token = self.ada.get("POST", f"/runs/{run or self.run}/share", {"days": 1})["token"]
        return Caller(self.target).log_in(token=token)

    def limit(self, **limits):
        self.admin.get("POST", "/users", {"name": self.names["eve"], **limits})

    def soon(self, seconds=3):
        """Ada is answered."""
        for path in ("/session", f"/runs/{self.run}", "/runs"):
            begin = time.monotonic()
            status, _ = self.ada.ask("GET", path)
            took = time.monotonic() - begin
            holds(status == 200 and took < seconds, f"{path}: {status} after {took:.1f} s")


def at_once(count, one):
    """Calls `one(k)` in so many threads; what they return. A connection that was cut is None."""
    answers = [None] * count

    def call(k):
        with contextlib.suppress(OSError, http.client.HTTPException):
            answers[k] = one(k)

    threads = [threading.Thread(target=call, args=(k,)) for k in range(count)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    return answers


def attack_unread(site):
    """400 downloads by a link that nothing reads: others are answered."""
    content = os.urandom(16 << 20)
    digits = hashlib.sha256(content).hexdigest()
    site.ada.get("PUT", f"/inputs/{digits}", content)
    scene = site.scene | {"files": site.scene["files"] | {"large.bin": digits}}
    run = site.ada.get("POST", "/runs", {"scene": scene})["id"]
    made = site.share(run).stalled(f"/runs/{run}/archive", 400)
    try:
        time.sleep(2)
        site.soon()
    finally:
        [raw.close() for raw in made]


def attack_heads(site):
    """100 heads that never end: others are answered, and the heads are cut."""
    made = []
    for _ in range(100):
        raw = socket.create_connection(site.target)
        raw.sendall(b"GET /api/v1/runs HTTP/1.1\r\nX-Slow: ")
        made.append(raw)
    begin = time.monotonic()
    site.soon()
    made[0].settimeout(60)
    with contextlib.suppress(ConnectionError):
        while made[0].recv(1000):
            holds(time.monotonic() - begin < 60, "a head without an end is waited for")
    holds(time.monotonic() - begin < 50, "a head without an end is waited for")
    [raw.close() for raw in made]


def attack_names(site):
    """100 names at once: each is a wrong password, and another address logs in meanwhile."""
    answers = []
    flood = threading.Thread(target=lambda: answers.extend(at_once(100, lambda k: Caller(site.target, None, "127.0.0.9").ask(
        "POST", "/session", {"name": f"unknown-{k}", "password": PASSWORD})[0])))
    flood.start()
    time.sleep(0.1)
    begin = time.monotonic()
    site.user("ada", "127.0.0.3")
    took = time.monotonic() - begin
    flood.join()
    holds(took < 6, f"a login takes {took:.1f} s")
    holds(set(answers) <= {401, 429, None}, f"{set(answers)}")


def attack_lock_out(site):
    """20 wrong passwords of a known name: the user still logs in."""
    wrong = Caller(site.target, None, "127.0.0.4")
    body = {"name": site.names["ada"], "password": "wrong horse battery"}
    statuses = [wrong.ask("POST", "/session", body)[0] for _ in range(20)]
    holds(statuses.count(401) <= 5 and 429 in statuses, f"tries without a delay: {statuses}")
    site.user("ada", "127.0.0.5")


def attack_uploads(site):
    """12 uploads at once take no more than the limit."""
    site.limit(disk=5_000_000)

    def put(k):
        content = bytes([k]) * 2_000_000
        return site.eve.ask("PUT", f"/inputs/{hashlib.sha256(content).hexdigest()}", content)[0]

    statuses = at_once(12, put)
    used = site.eve.get("GET", "/session")["usage"]["disk"]
    site.limit(disk=None)
    holds(used <= 5_000_000 and statuses.count(201) <= 2, f"{used} bytes, {statuses}")


def attack_runs(site):
    """8 runs, studies and clones at once take no more than the limit."""
    scene = site.scene | {"set": ["output.pictures=false"]}
    needs = site.eve.get("POST", "/check", {"scene": scene})["plan"]["disk"]["bytes"]
    used = site.eve.get("GET", "/session")["usage"]["disk"]
    site.limit(disk=used + int(2.5 * needs) + 20_000)
    statuses = at_once(8, lambda _: site.eve.ask("POST", "/runs", {"scene": scene})[0])
    for run in site.eve.get("GET", "/runs")["runs"]:
        site.eve.ask("POST", f"/runs/{run['id']}/kill", {})
    site.limit(disk=None)
    holds(statuses.count(201) <= 2, f"{statuses}")


def attack_kept(site):
    """A token that was taken back leaves no session, token or link that works."""
    token = site.ada.get("POST", "/tokens", {"name": "attack"})
    bearer = {"Authorization": f"Bearer {token['secret']}"}
    _, second = Caller(site.target).ask("POST", "/tokens", {"name": "second"}, bearer)
    _, share = Caller(site.target).ask("POST", f"/runs/{site.run}/share", {"days": 1}, bearer)
    sessions = [Caller(site.target).log_in(token=secret) for secret in
                (token["secret"], json.loads(second)["secret"], json.loads(share)["token"])]
    site.ada.get("DELETE", f"/tokens/{token['id']}")
    statuses = [session.ask("GET", "/session")[0] for session in sessions]
    holds(statuses == [401] * 3, f"{statuses}")


def attack_guest(site):
    """A link to a run sees this run alone, changes nothing, and learns nothing of its owner."""
    other = site.ada.get("POST", "/runs", {"scene": site.scene})["id"]
    guest = site.share()
    seen = guest.get("GET", f"/runs/{site.run}")
    holds(not seen["owner"] and site.names["ada"] not in json.dumps(guest.get("GET", "/session")), "the owner")
    for path in (f"/runs/{other}", f"/runs/{other}/files", "/tokens", "/sessions", "/shares", "/inputs", "/users", f"/runs/{site.run}/shares",
                 f"/events?runs={other}"):
        holds(guest.ask("GET", path)[0] in (403, 404), f"GET {path}")
    for method, path, body in (("DELETE", f"/runs/{site.run}", None), ("POST", f"/runs/{site.run}/extend", {"end": 9}),
                               ("POST", "/runs", {"scene": site.scene}), ("POST", f"/runs/{site.run}/share", {"days": 1}),
                               ("POST", "/tokens", {"name": "x"}), ("PATCH", f"/runs/{site.run}", {"title": "x"})):
        holds(guest.ask(method, path, body)[0] in (403, 404), f"{method} {path}")


def attack_files(site):
    """Scenes and paths that name files of the machine get none of them."""
    text = site.scene["text"]
    for name in ("/etc/passwd", "../../../../../../etc/passwd", "/proc/self/environ", "/proc/1/environ"):
        wall = f'\n[[walls]]\nname = "w"\nshape = "mesh"\nfile = "{name}"\nmaterial = "glass"\n'
        _, answer = site.eve.ask("POST", "/check", {"scene": site.scene | {"text": text + wall}})
        holds(b"root:" not in answer and b"PATH=" not in answer, f"{name} in the answer of a check")
        for path in (f"/runs/{site.run}/files/{name}", f"/runs/{site.run}/files/%2e%2e/%2e%2e/%2e%2e{name}"):
            status, answer = site.ada.ask("GET", path)
            holds(status in (400, 404) and b"root:" not in answer, f"GET {path}: {status}")
    for name in ("../x", "/tmp/x", "a/../../x", ".hidden", "a\0b"):
        scene = site.scene | {"name": name}
        holds(site.eve.ask("POST", "/runs", {"scene": scene})[0] == 400, f"a scene called {name!r}")


def attack_pages(site):
    """Requests of other pages and for other hosts are refused."""
    for headers in ({"Origin": "http://evil.example", "Sec-Fetch-Site": "cross-site"}, {"Sec-Fetch-Site": "same-site"}, {"Sec-Fetch-Site": "none"}):
        status, _ = site.ada.ask("DELETE", f"/runs/{site.run}", None, headers)
        holds(status == 403, f"{headers}: {status}")
    holds(site.ada.ask("GET", "/runs", None, {"Host": "evil.example"})[0] == 421, "another host")


def attack_texts(site):
    """Control characters and long texts are refused in names, titles and labels; markup stays text."""
    for text in ("a\nb", "\x1b[31mred", "a\x00b", "x" * 100_000):
        for body in ({"title": text}, {"label": text}):
            status, _ = site.ada.ask("PATCH", f"/runs/{site.run}", body)
            holds(status in (400, 413), f"{str(body)[:40]}: {status}")
        holds(site.ada.ask("POST", "/tokens", {"name": text})[0] in (400, 413), f"a token {text[:10]!r}")
        holds(site.admin.ask("POST", "/users", {"name": text, "password": PASSWORD})[0] in (400, 413), f"a user {text[:10]!r}")


def attack_others(site):
    """Another user finds nothing of a run, and a token for looking changes nothing."""
    for path in ("", "/files", "/log", "/archive", "/events", "/attempts", "/frames", "/tables"):
        holds(site.eve.ask("GET", f"/runs/{site.run}{path}")[0] == 404, f"GET {path}")
    for method, path, body in (("DELETE", "", None), ("POST", "/stop", {}), ("POST", "/clone", {}), ("POST", "/extend", {"end": 9}),
                               ("PATCH", "", {"title": "x"}), ("POST", "/share", {"days": 1})):
        holds(site.eve.ask(method, f"/runs/{site.run}{path}", body)[0] == 404, f"{method} {path}")
    holds(site.eve.ask("GET", f"/events?runs={site.run}")[0] == 404, "events")
    holds(site.eve.ask("GET", "/users")[0] == 403, "the list of users")
    secret = site.ada.get("POST", "/tokens", {"name": "looks", "read_only": True})["secret"]
    bearer = {"Authorization": f"Bearer {secret}"}
    for method, path, body in (("DELETE", f"/runs/{site.run}", None), ("POST", "/runs", {"scene": site.scene}),
                               ("PUT", "/projects/x/members/session", {"role": "viewer"})):
        status, _ = Caller(site.target).ask(method, path, body, bearer)
        holds(status == 403, f"{method} {path} by a token for looking: {status}")


ATTACKS = {name.removeprefix("attack_").replace("_", "-"): function for name, function in globals().items() if name.startswith("attack_")}


def main(arguments):
    if not arguments:
        for name, attack in ATTACKS.items():
            print(f"{name:10} {attack.__doc__}")
        return 0
    link, *names = arguments
    if unknown := set(names) - set(ATTACKS):
        print(f"no attacks of these names: {', '.join(sorted(unknown))}", file=sys.stderr)
        return 2
    fell = 0
    with Site(link) as site:
        for name in names or ATTACKS:
            begin = time.monotonic()
            try:
                ATTACKS[name](site)
                print(f"{name:10} holds ({time.monotonic() - begin:.1f} s)", flush=True)
            except Fell as why:
                fell += 1
                print(f"{name:10} FELL: {why}", flush=True)
    return min(fell, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
