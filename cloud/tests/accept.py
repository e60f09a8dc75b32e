"""Acceptance of Mercury Cloud: whole programs, killed at random. Each check is a function named check_NAME.

Standard library only; moto's server (PyPI) and s3s-fs (crates.io) are used where they are on the path. Every check has a server on a free port, with data in a folder of its own, and leaves nothing.
The solver alone (`mercury-solve SCENE`) gives the bytes that runs through the cloud must have.
"""

import concurrent.futures
import contextlib
import csv
import fcntl
import hashlib
import hmac
import http.client
import http.server
import json
import os
import random
import re
import shutil
import signal
import socket
import sqlite3
import ssl
import subprocess
import sys
import tempfile
import threading
import time
import traceback
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SEED = int(os.environ.get("ACCEPT_SEED", random.randrange(10**6)))
RANDOM = random.Random(SEED)

# A drum that takes some seconds, with frames often enough to be cut anywhere.
SCENE = (ROOT / "scenes/drum.toml").read_text()
LONG = ["time.end=0.4", "output.interval=0.004", "output.pictures=false"]
SHORT = ["output.pictures=false"]
# The drum goes on from the state of a run.
FROM_RUN = re.sub(r"(?ms)^\[\[insertions\]\].*?(?=^\[|\Z)", "", SCENE) + "\n[[particles]]\nrun = \"RUN\"\n"


class Failed(Exception):
    pass


class Skipped(Exception):
    pass


def must(condition, message):
    if not condition:
        raise Failed(message)


def program(name):
    folders = os.environ.get("MERCURY_BIN", "").split(":") + [
        str(ROOT / place) for place in ("cloud/target/release", "cloud/target/debug", "target/release", "target/debug")
    ]
    for folder in filter(None, folders):
        if (path := Path(folder) / name).is_file():
            return str(path.resolve())
    raise SystemExit(f"{name} is not built")


CLOUD = program("mercury-cloud")
SOLVE = program("mercury-solve")
# Root has to say as which user it serves.
SERVE = [CLOUD, "serve", *(["--user", "root"] if os.geteuid() == 0 else [])]


def wait_for(what, seconds, message):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := what():
            return found
        time.sleep(0.1)
    raise Failed(f"{message} within {seconds} s")


def free_port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


class Line:
    """A line to a server that can be cut: connections end, and new ones are closed at once. Nothing is sent any more, and
    answers that are on their way are lost."""

    def __init__(self, to):
        self.to, self.cut, self.pairs = to, False, []
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                near, _ = self.listener.accept()
            except OSError:
                return
            if self.cut:
                near.close()
                continue
            far = socket.create_connection(("127.0.0.1", self.to))
            self.pairs.append((near, far))
            for a, b in ((near, far), (far, near)):
                threading.Thread(target=self.pump, args=(a, b), daemon=True).start()

    def pump(self, a, b):
        with contextlib.suppress(OSError):
            while (data := a.recv(1 << 16)) and not self.cut:
                b.sendall(data)
        for one in (a, b):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def down(self):
        self.cut = True
        for pair in self.pairs:
            for one in pair:
                with contextlib.suppress(OSError):
                    one.shutdown(socket.SHUT_RDWR)
        self.pairs.clear()

    def up(self):
        self.cut = False


class Bucket:
    """An S3 server with a bucket, behind a line."""

    def __init__(self, kind):
        program = {"moto": "moto_server", "s3s-fs": "s3s-fs"}[kind]
        if not shutil.which(program):
            raise Skipped(f"{program} is not on the path")
        self.folder = tempfile.mkdtemp(prefix="accept-s3-")
        self.port = free_port()
        command = [program, "-p", str(self.port)] if kind == "moto" else [
            program, "--host", "127.0.0.1", "--port", str(self.port), "--access-key", "test", "--secret-key", "test", self.folder]
        self.log = open(Path(self.folder).with_suffix(".log"), "w")
        self.kind = kind
        self.process = subprocess.Popen(command, stdout=self.log, stderr=self.log)
        wait_for(lambda: self.is_up(), 60, f"{program} does not start")
        self.line = Line(self.port)
        self.environment = {"AWS_ENDPOINT_URL": f"http://127.0.0.1:{self.line.port}", "AWS_ACCESS_KEY_ID": "test",
                            "AWS_SECRET_ACCESS_KEY": "test", "AWS_REGION": "us-east-1"}
        if kind == "moto":
            self.http("PUT", "/bucket")
        else:
            (Path(self.folder) / "bucket").mkdir()
        self.url = "s3://bucket/mercury"

    def is_up(self):
        with contextlib.suppress(OSError):
            return self.http("GET", "/") is not None

    def http(self, method, path):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        # moto does not look at signatures, but at whether there is one.
        signed = {"Authorization": "AWS4-HMAC-SHA256 Credential=test/20260101/us-east-1/s3/aws4_request, SignedHeaders=host, Signature=0"}
        connection.request(method, path, headers=signed)
        answer = connection.getresponse()
        return answer.read()

    def read(self, key):
        if self.kind == "moto":
            return self.http("GET", f"/bucket/{key}")
        return (Path(self.folder) / "bucket" / key).read_bytes()

    def keys(self, prefix):
        if self.kind == "moto":
            return re.findall("<Key>(.*?)</Key>", self.http("GET", f"/bucket?list-type=2&prefix={prefix}").decode())
        return [path for path in (Path(self.folder) / "bucket" / prefix).rglob("*") if path.is_file()]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.line.listener.close()
        shutil.rmtree(self.folder)
        os.unlink(self.log.name)


class Server:
    """`mercury-cloud serve` on a free port, and requests to it."""

    def __init__(self, folder, *options, environment=None, bucket=None, checkpoint="1s"):
        self.checkpoint = checkpoint
        self.folder, self.options, self.bucket = Path(folder), options, bucket
        self.environment = dict(os.environ) | (environment or {})
        if bucket:
            self.options += ("--store", bucket.url, "--beat", "1")
            self.environment |= bucket.environment
        self.port = free_port()
        self.process = None
        self.start()

    def start(self):
        self.log = open(self.folder / "server.log", "a")
        command = [*SERVE, "--data", str(self.folder / "data"), "--port", str(self.port), "--solver", SOLVE,
                   "--checkpoint-every", self.checkpoint, "--retry-wait", "0.2", *self.options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self.log, env=self.environment, text=True)
        link = self.process.stdout.readline()
        must(link, f"the server did not start:\n{(self.folder / 'server.log').read_text()}")
        # Standard output is no terminal, so the link that it shows has no secret; the command line has one of its own.
        must("#token=" not in link, f"a secret outside of a terminal: {link}")
        self.link = (self.folder / "data/link").read_text().strip()
        self.cookie = None
        answer = self.request("POST", "/session", {"token": self.link.split("#token=")[1]})
        self.admin = self.cookie = answer.headers["set-cookie"].split(";")[0]

    def kill(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def request(self, method, path, body=None, headers=None, expect=None, raw=False):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        head = {"Sec-Fetch-Site": "same-origin", "Content-Type": "application/json"}
        if self.cookie:
            head["Cookie"] = self.cookie
        head |= headers or {}
        data = body if raw or body is None else json.dumps(body)
        connection.request(method, ("" if path.startswith("/api/") or raw == "path" else "/api/v1") + path, data, head)
        answer = connection.getresponse()
        answer.body = answer.read()
        connection.close()
        if expect is not None:
            must(answer.status == expect, f"{method} {path}: {answer.status}, expected {expect}: {answer.body[:500]!r}")
        return answer

    def json(self, method, path, body=None, expect=200, headers=None):
        return json.loads(self.request(method, path, body, expect=expect, headers=headers).body or b"null")

    def submit(self, text=SCENE, sets=LONG, name="drum.toml", **more):
        body = {"scene": {"name": name, "text": text, "set": list(sets)}, **more}
        return self.json("POST", "/runs", body, expect=201)["id"]

    def run(self, run):
        return self.json("GET", f"/runs/{run}")

    def wait(self, run, state="finished", seconds=240):
        def over():
            found = self.run(run)
            if found["state"] == state:
                return found
            must(found["state"] in ("queued", "running", "stopping"),
                 f"the run is {found['state']}: {found['cause']} {found['message']} {found['notes']}")
        return wait_for(over, seconds, f"not {state}")

    def events(self, cookie):
        """Listens to all events of a user from now on; the function that comes back gives the lines so far."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        connection.request("GET", "/api/v1/events", headers={"Cookie": cookie})
        answer = connection.getresponse()
        must(answer.status == 200, f"GET /events: {answer.status}")
        lines = []

        def read():
            # The server ends before the listener does.
            with contextlib.suppress(OSError, http.client.HTTPException, AttributeError):
                while line := answer.readline():
                    lines.append(line.decode())

        threading.Thread(target=read, daemon=True).start()
        return lambda: list(lines)

    def attempts(self, run):
        return self.json("GET", f"/runs/{run}/attempts")

    def head(self, run):
        if self.bucket:
            return json.loads(self.bucket.read(f"mercury/runs/{run}/head.json"))
        return json.loads((self.folder / "data/store/runs" / run / "head.json").read_text())

    def fetch(self, run, to):
        subprocess.run([CLOUD, "get", "--link", self.link, run, "-o", str(to)], check=True)

    def same_as_alone(self, run, alone, but=()):
        """All files but these are those of the solver alone."""
        to = self.folder / f"got-{run}"
        self.fetch(run, to)
        diff = subprocess.run([CLOUD, "diff", str(alone), str(to)], capture_output=True, text=True)
        other = [line for line in diff.stdout.splitlines() if ": " in line and line.split(": ")[0] not in but]
        must(diff.returncode == 0 or but and not other, f"other bytes than the solver alone:\n{diff.stdout}\n{self.run(run)['notes']}")
        notes = [note for note in self.run(run)["notes"] if note["kind"] in ("not-reproduced", "damaged", "cut")]
        must(not notes, f"notes: {notes}")

    def worker(self, run):
        """Ids of the workers of a run, and of their solvers."""
        found = []
        for entry in Path("/proc").iterdir():
            if not entry.name.isdigit():
                continue
            try:
                words = (entry / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if words[1:2] == [b"worker"] and run.encode() in words:
                found.append(int(entry.name))
        return found


@contextlib.contextmanager
def server(*options, **more):
    folder = tempfile.mkdtemp(prefix="accept-")
    # A server of another user enters it.
    os.chmod(folder, 0o711)
    started = Server(folder, *options, **more)
    try:
        yield started
    except Exception:
        print((Path(folder) / "server.log").read_text()[-3000:])
        for log in sorted((Path(folder) / "data/log").glob("*")):
            print(log.name, log.read_text()[-1000:])
        raise
    finally:
        started.cookie = started.admin
        for run in started.json("GET", "/runs")["runs"] if started.process.poll() is None else []:
            for pid in started.worker(run["id"]):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
        started.kill()
        shutil.rmtree(folder, ignore_errors=True)


# Runs of the solver alone, for all checks of this call.
ALONE = "ACCEPT_ALONE"


def alone(sets=LONG, text=SCENE, name="drum"):
    """The folder of a run of the solver alone, made once."""
    key = hashlib.sha256(repr((tuple(sets), text, name)).encode()).hexdigest()
    folder = Path(os.environ[ALONE]) / key
    # Another check that runs beside this one may make it now.
    with open(folder.with_suffix(".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "made").exists():
            folder.mkdir()
            (folder / f"{name}.toml").write_text(text)
            options = [f"--set={one}" for one in sets]
            subprocess.run([SOLVE, f"{name}.toml", "--output", "out", "--quiet", "--threads", "1", *options], cwd=folder, check=True)
            (folder / "made").touch()
    return folder / "out"


def step_of(served, run):
    return served.run(run)["step"]


def committed(served, run):
    return served.head(run)["step"]


def check_server_killed():
    """The server is killed thrice at random: the worker goes on, one attempt, no event lost or twice, the same bytes."""
    reference = alone()
    with server() as served:
        run = served.submit()
        wait_for(lambda: served.worker(run), 30, "no worker")
        workers = served.worker(run)
        seen = []
        for _ in range(3):
            time.sleep(RANDOM.uniform(0.1, 1.5))
            seen += [event["id"] for event in served.json("GET", f"/runs/{run}/events?after={seen[-1] if seen else 0}")["events"]]
            served.kill()
            time.sleep(RANDOM.uniform(0, 1))
            still = served.worker(run)
            must(still in (workers, []), f"another worker: {still}, was {workers}")
            served.start()
        served.wait(run)
        seen += [event["id"] for event in served.json("GET", f"/runs/{run}/events?after={seen[-1] if seen else 0}")["events"]]
        everything = served.json("GET", f"/runs/{run}/events")["events"]
        must(seen == [event["id"] for event in everything], "events are lost or twice")
        states = [event["data"]["state"] for event in everything if event["kind"] == "state"]
        must(states == ["queued", "running", "finished"], f"states: {states}")
        must(len(served.attempts(run)) == 1, f"attempts: {served.attempts(run)}")
        served.same_as_alone(run, reference)


def check_submit_killed():
    """The server dies between the engine's yes and its record: the job is adopted, not started again."""
    reference = alone()
    with server(environment={"MERCURY_CLOUD_FAIL": "after-submit"}) as served:
        run = served.submit()
        wait_for(lambda: served.process.poll() is not None, 30, "the failpoint was not reached")
        workers = wait_for(lambda: served.worker(run), 10, "no worker")
        served.process.stdout.close()
        del served.environment["MERCURY_CLOUD_FAIL"]
        served.start()
        served.wait(run)
        must(len(workers) == 1, f"workers: {workers}")
        must(len(served.attempts(run)) == 1, f"attempts: {served.attempts(run)}")
        served.same_as_alone(run, reference)


def check_lost():
    """Worker and solver are killed at random, 20 times: never an older step than committed, and the same bytes."""
    reference = alone()
    with server() as served:
        run = served.submit()
        most = 0
        kills = 0
        while kills < 20:
            if served.run(run)["state"] == "finished":
                run = served.submit()
                most = 0
            workers = served.worker(run)
            if workers:
                time.sleep(RANDOM.uniform(0, 2.5))
                with contextlib.suppress(ProcessLookupError):
                    os.kill(workers[0], signal.SIGKILL)
                    kills += 1
            step = committed(served, run)
            must(step >= most, f"the committed step went back from {most} to {step}")
            most = step
            if served.run(run)["state"] == "failed":
                # Twenty losses in a row may use up the budget, which is right; the user resumes.
                served.json("POST", f"/runs/{run}/resume", {})
            time.sleep(0.2)
        wait_for(lambda: served.run(run)["state"] in ("finished", "failed"), 240, "no end")
        if served.run(run)["state"] == "failed":
            served.json("POST", f"/runs/{run}/resume", {})
        served.wait(run)
        causes = {attempt["cause"] for attempt in served.attempts(run)}
        must(causes <= {"lost", "finished", "engine"}, f"causes: {causes}")
        served.same_as_alone(run, reference)


def check_split():
    """A worker is frozen until a second one runs, then let go: it ends without a trace, and the bytes are the same."""
    reference = alone()
    with server() as served:
        run = served.submit()
        first = wait_for(lambda: served.worker(run), 30, "no worker")[0]
        wait_for(lambda: committed(served, run) > 0, 60, "no checkpoint")
        os.kill(first, signal.SIGSTOP)
        # Ten beats without a sign of life.
        wait_for(lambda: len(served.attempts(run)) == 2 and len(served.worker(run)) == 2, 60, "no second worker")
        time.sleep(1)
        os.kill(first, signal.SIGCONT)
        wait_for(lambda: first not in served.worker(run), 30, "the first worker did not end")
        served.wait(run)
        must([a["cause"] for a in served.attempts(run)] == ["lost", "finished"], f"{served.attempts(run)}")
        served.same_as_alone(run, reference)


def check_store_gone():
    """The store is away for a while in the middle: nothing fails, nothing runs twice, and it goes on. A folder that was
    moved; and moto, which hangs for 30 s and then is out of reach for 30 s."""
    reference = alone()
    with server("--store", tempfile.mkdtemp(prefix="accept-store-") + "/store") as served:
        store = Path(served.options[served.options.index("--store") + 1])
        run = served.submit()
        wait_for(lambda: served.worker(run), 30, "no worker")
        time.sleep(1)
        os.rename(store, store.with_name("away"))
        time.sleep(40)
        must(not store.exists(), "a store was made where there was none")
        must(len(served.attempts(run)) == 1, "something was run twice")
        os.rename(store.with_name("away"), store)
        served.wait(run)
        must(len(served.attempts(run)) == 1, f"attempts: {served.attempts(run)}")
        served.same_as_alone(run, reference)
        shutil.rmtree(store.parent)
    if not with_s3():
        print("    folder alone: no moto_server on the path, or built without --features s3")
        return
    with Bucket("moto") as bucket, server(bucket=bucket) as served:
        run = served.submit()
        wait_for(lambda: committed(served, run) > 0, 60, "no checkpoint")
        bucket.process.send_signal(signal.SIGSTOP)
        time.sleep(30)
        bucket.process.send_signal(signal.SIGCONT)
        bucket.line.down()
        time.sleep(30)
        bucket.line.up()
        served.wait(run)
        must(len(served.attempts(run)) == 1, f"attempts: {served.attempts(run)}")
        served.same_as_alone(run, reference)


def with_s3():
    """Whether the program can use buckets, and moto is there."""
    with tempfile.TemporaryDirectory() as folder:
        command = [*SERVE, "--data", folder, "--port", "0", "--solver", SOLVE, "--store", "s3://"]
        text = subprocess.run(command, capture_output=True, text=True).stderr
    return "built without" not in text and shutil.which("moto_server") is not None


def need_s3():
    if not with_s3():
        raise Skipped("no moto_server on the path, or built without --features s3")


def check_s3():
    """Object storage: runs with a worker killed, stopped and resumed, extended and deleted; the same bytes, on two servers
    that have nothing in common. A server without conditional writes is refused."""
    need_s3()
    class Plain(http.server.BaseHTTPRequestHandler):
        """Takes no notice of If-Match and If-None-Match."""
        protocol_version = "HTTP/1.1"
        contents = {}
        def answer(self, status, body=b""):
            self.send_response(status)
            self.send_header("ETag", f'"{hashlib.md5(body).hexdigest()}"')
            self.send_header("Last-Modified", "Mon, 01 Jan 2024 00:00:00 GMT")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)
        def do_PUT(self):
            Plain.contents[self.path] = self.rfile.read(int(self.headers["Content-Length"]))
            self.answer(200)
        def do_GET(self):
            self.answer(200, Plain.contents[self.path]) if self.path in Plain.contents else self.answer(404)
        def do_DELETE(self):
            Plain.contents.pop(self.path, None)
            self.answer(204)
        def log_message(self, *_):
            pass
    plain = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Plain)
    threading.Thread(target=plain.serve_forever, daemon=True).start()
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ) | {"AWS_ENDPOINT_URL": f"http://127.0.0.1:{plain.server_port}", "AWS_ACCESS_KEY_ID": "x",
                                          "AWS_SECRET_ACCESS_KEY": "x", "AWS_REGION": "us-east-1"}
        command = [*SERVE, "--data", folder, "--port", "0", "--solver", SOLVE, "--store", "s3://bucket/x"]
        refused = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=60)
        must(refused.returncode == 1 and "conditional writes" in refused.stderr, f"{refused}")
    plain.shutdown()
    reference = alone()
    for kind in ("moto", "s3s-fs"):
        try:
            bucket = Bucket(kind)
        except Skipped as reason:
            print(f"    {reason}")
            continue
        with bucket, server(bucket=bucket) as served:
            run = served.submit()
            wait_for(lambda: committed(served, run) > 0, 60, "no checkpoint")
            for pid in served.worker(run):
                os.kill(pid, signal.SIGKILL)
            wait_for(lambda: len(served.attempts(run)) == 2 and served.worker(run), 60, "no second attempt")
            time.sleep(1)
            served.kill()
            served.start()
            served.json("POST", f"/runs/{run}/stop", {})
            wait_for(lambda: served.run(run)["state"] in ("stopped", "finished"), 60, "not stopped")
            if served.run(run)["state"] == "stopped":
                served.json("POST", f"/runs/{run}/resume", {})
            served.wait(run)
            served.same_as_alone(run, reference)
            must(served.json("GET", f"/runs/{run}/frames")["frames"], "no frames")
            served.request("DELETE", f"/runs/{run}", expect=204)
            must(bucket.keys(f"mercury/runs/{run}/head.json") == [], "the head is still there")
            left = bucket.keys(f"mercury/runs/{run}/")
            must(left == [], f"left in the bucket: {left[:5]}")


class Metadata(http.server.BaseHTTPRequestHandler):
    """The instance metadata service, version 2, with a notice once `taken` is set."""

    taken = False

    def answer(self, status, body=b""):
        self.send_response(status)
        self.end_headers()
        self.wfile.write(body)

    def do_PUT(self):
        self.answer(200, b"token") if self.path == "/latest/api/token" else self.answer(404)

    def do_GET(self):
        if self.headers.get("X-aws-ec2-metadata-token") != "token":
            self.answer(401)
        elif self.path == "/latest/meta-data/spot/instance-action" and Metadata.taken:
            # Given once: the next attempt, which would be on another machine, may begin at once and must not see it.
            Metadata.taken = False
            self.answer(200, b'{"action": "terminate", "time": "2026-01-01T00:00:00Z"}')
        else:
            self.answer(404)

    def log_message(self, *_):
        pass


def check_spot():
    """A notice of the provider: the attempt ends within 20 s with cause `spot`, and the next one, in another folder,
    goes on to the same bytes. The store is moto's S3 where it is there."""
    # Workers look for the notice every 5 s: what is left of the run then must take longer, wherever it runs.
    sets = LONG + ["time.end=2.4"]
    reference = alone(sets)
    service = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Metadata)
    threading.Thread(target=service.serve_forever, daemon=True).start()
    endpoint = {"AWS_EC2_METADATA_SERVICE_ENDPOINT": f"http://127.0.0.1:{service.server_port}"}
    Metadata.taken = False
    with contextlib.ExitStack() as stack:
        bucket = stack.enter_context(Bucket("moto")) if with_s3() else None
        served = stack.enter_context(server(environment=endpoint, bucket=bucket))
        run = served.submit(sets=sets)
        folder = lambda: [path.name for path in (served.folder / "data/scratch").glob(f"{run}.*")]
        wait_for(lambda: served.run(run)["step"] >= 0.4 * (served.run(run)["of_steps"] or 1e30), 120, "not at 40 %")
        first = folder()
        Metadata.taken = True
        begin = time.monotonic()
        wait_for(lambda: served.attempts(run)[0]["ended"], 20, "the attempt did not end")
        print(f"    {time.monotonic() - begin:.1f} s from the notice to the end of the attempt, with {'moto' if bucket else 'a folder'}")
        # A machine with other work starts a process late, and moto answers late.
        try:
            wait_for(lambda: folder() not in ([], first), 180, "no second folder")
        except Failed as failed:
            raise Failed(f"{failed}; {served.run(run)['state']}, {served.attempts(run)}") from None
        began = served.attempts(run)
        print(f"    {began[1]['started'] - began[0]['ended']:.1f} s to the next attempt, {time.time() - began[1]['started']:.1f} s to its folder")
        served.wait(run)
        must([one["cause"] for one in served.attempts(run)] == ["spot", "finished"], f"{served.attempts(run)}")
        served.same_as_alone(run, reference)
    service.shutdown()


def check_start_from_run():
    """A run that starts from the last state of another, by its id, gives the bytes of `run = FOLDER` by hand; a clone keeps that state; a run
    of another user, or without a state, is not taken."""
    with server() as served:
        sets = SHORT + ["time.end=0.1"]
        first = served.submit(sets=sets)
        body = {"scene": {"name": "next.toml", "text": FROM_RUN.replace("RUN", first), "set": sets}}
        early = json.loads(served.request("POST", "/runs", body, expect=400).body)
        must("no checkpoint yet" in early["detail"], f"{early}")
        served.wait(first)
        second = served.json("POST", "/runs", body, 201)["id"]
        served.wait(second)
        cloned = served.json("POST", f"/runs/{second}/clone", {})
        served.json("POST", f"/runs/{first}/extend", {"end": 0.15})
        served.wait(first)
        third = served.json("POST", "/runs", cloned, 201)["id"]
        served.wait(third)
        folder = Path(tempfile.mkdtemp(prefix="accept-from-"))
        (folder / "drum.toml").write_text(SCENE)
        (folder / "next.toml").write_text(FROM_RUN.replace("RUN", first))
        options = ["--quiet", "--threads", "1", *(f"--set={one}" for one in sets)]
        for words in (["drum.toml", "--output", first], ["next.toml", "--output", "out"]):
            subprocess.run([SOLVE, *words, *options], cwd=folder, check=True)
        served.same_as_alone(second, folder / "out")
        served.same_as_alone(third, folder / "out")
        shutil.rmtree(folder)
        served.request("POST", "/users", {"name": "ada", "password": "correct horse"}, expect=204)
        mine, served.cookie = served.cookie, None
        answer = served.request("POST", "/session", {"name": "ada", "password": "correct horse"}, expect=200)
        served.cookie = answer.headers["set-cookie"].split(";")[0]
        served.request("POST", "/runs", body, expect=422)
        served.cookie = mine


def check_extend():
    """A finished run to a later end gives the bytes of `mercury-solve --resume --set time.end`."""
    first, later = LONG, LONG + ["time.end=0.5"]
    with server() as served:
        run = served.submit(sets=first)
        served.wait(run)
        served.json("POST", f"/runs/{run}/extend", {"end": 0.3}, expect=400)
        served.json("POST", f"/runs/{run}/extend", {"end": 0.5})
        served.wait(run)
        folder = Path(tempfile.mkdtemp(prefix="accept-extend-"))
        (folder / "drum.toml").write_text(SCENE)
        for sets in (first, later):
            options = [f"--set={one}" for one in sets]
            command = [SOLVE, "drum.toml", "--output", "out", "--quiet", "--threads", "1", "--resume", *options]
            subprocess.run(command, cwd=folder, check=True)
        # The chain says how each of the two was called.
        served.same_as_alone(run, folder / "out", but=["drum.chain.jsonl"])
        shutil.rmtree(folder)
        # Several at once: one is accepted, and the run ends there.
        for _ in range(3):
            before, ends, accepted = served.run(run)["time"], [0.01, 0.02, 0.03, 0.04], []
            def extend(more):
                answer = served.request("POST", f"/runs/{run}/extend", {"end": before + more})
                accepted.extend([before + more] if answer.status == 200 else [])
                must(answer.status in (200, 409), f"{answer.status} {answer.body}")
            threads = [threading.Thread(target=extend, args=(more,)) for more in ends]
            [thread.start() for thread in threads]
            [thread.join() for thread in threads]
            must(len(accepted) == 1, f"{len(accepted)} of 4 extensions were accepted")
            time_of = served.wait(run)["time"]
            must(abs(time_of - accepted[0]) < 1e-4, f"the run ends at {time_of}, {accepted[0]} was accepted")


def check_verify():
    """A finished run with kept checkpoints, moved to another worker meanwhile, is verified in a cage: share and link; the kept checkpoints are
    those of the solver alone, also from an archive. Another byte in the store is named, by the page as well, and nothing stays behind."""
    sets = LONG + ["output.keep_checkpoints=4"]
    with server() as served:
        run = served.submit(sets=sets)
        served.request("POST", f"/runs/{run}/verification", {}, expect=409)
        wait_for(lambda: any(name.startswith("drum.checkpoints/") for name in served.head(run)["whole"]), 120, "no kept checkpoint")
        served.json("POST", f"/runs/{run}/stop", {})
        served.wait(run, "stopped")
        served.json("POST", f"/runs/{run}/resume", {})
        served.wait(run)
        must(served.json("GET", f"/runs/{run}/verification")["verdict"] == "never", "verified before")
        served.same_as_alone(run, alone(sets))
        kept = sorted(path.name for path in (served.folder / f"got-{run}/drum.checkpoints").iterdir())
        must(kept == sorted(path.name for path in (alone(sets) / "drum.checkpoints").iterdir()) and kept, f"kept checkpoints: {kept}")

        def verify(code):
            done = subprocess.run([CLOUD, "verify", "--link", served.link, run], capture_output=True, text=True)
            must(done.returncode == code, f"exit code {done.returncode}: {done.stdout}{done.stderr}")
            found = served.json("GET", f"/runs/{run}/verification")
            must(str(served.folder) not in json.dumps(found) and ".run" not in json.dumps(found), f"{found}")
            return found
        found = verify(0)
        summary = json.loads((served.folder / f"got-{run}/summary.json").read_text())
        must(found["verdict"] == "verified" and 0.01 <= found["share"] < 1 and found["link"] == summary["link"], f"{found}")
        segment = next(part for name, stream in served.head(run)["streams"].items() if name == "drum.ene" for part in stream["segments"])
        path = served.folder / "data/store/runs" / run / segment["key"]
        text = path.read_bytes()
        path.write_bytes(text[:-2] + bytes([text[-2] ^ 1]) + text[-1:])
        found = verify(1)
        must(found["verdict"] == "differs" and "drum.ene" in found["message"], f"{found}")
        path.write_bytes(text)
        if shutil.which("node"):
            browser("verify.mjs", served.link, run)
        must(not list((served.folder / "data/checks").iterdir()), "a folder was left")
        served.json("POST", f"/runs/{run}/extend", {"end": 0.41})
        served.wait(run)
        must(served.json("GET", f"/runs/{run}/verification")["verdict"] == "never", "a run that went on is another one")


def check_branch():
    """A branch of a run, stopped and resumed on the way, gives the bytes of `mercury-solve --from`, also from the page; what may not differ
    is named; the run goes on when the other one was deleted, and is verified."""
    sets = LONG + ["output.keep_checkpoints=4"]
    gravity = "gravity=[0, 0, -5]"
    with server() as served:
        run = served.submit(sets=sets)
        served.request("POST", f"/runs/{run}/branch", {"at": 0.1}, expect=409)
        served.wait(run)
        for at, code in ((0, 400), (9, 400), (0.2, 422)):
            served.request("POST", f"/runs/{run}/branch", {"at": at, "set": ["gravity=7"]}, expect=code)
        command = [CLOUD, "branch", "--link", served.link, run, "--at", "0.21", "--set", gravity, "--title", "Moon"]
        made = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
        wait_for(lambda: served.head(made)["checkpoint"], 120, "no checkpoint of its own")
        served.json("POST", f"/runs/{made}/stop", {})
        served.wait(made, "stopped")
        wrong = served.json("POST", f"/runs/{run}/branch", {"at": 0.2, "set": ["seed=7"]}, 422)["problems"][0]["message"]
        must("seed: 1 then, 7 now" in wrong and "--from" not in wrong and ".run" not in wrong, f"{wrong}")
        if shutil.which("node"):
            browser("branch.mjs", served.link, run)
        served.request("POST", "/users", {"name": "ada", "password": "correct horse"}, expect=204)
        mine, served.cookie = served.cookie, None
        answer = served.request("POST", "/session", {"name": "ada", "password": "correct horse"}, expect=200)
        served.cookie = answer.headers["set-cookie"].split(";")[0]
        served.request("POST", f"/runs/{run}/branch", {"at": 0.2}, expect=404)
        served.cookie = mine
        served.request("DELETE", f"/runs/{run}", expect=204)
        served.json("POST", f"/runs/{made}/resume", {})
        served.wait(made)
        folder = Path(tempfile.mkdtemp(prefix="accept-branch-"))
        command = [SOLVE, "--from", str(alone(sets)), "--at", "0.21", "--set", gravity, "--output", str(folder / "out"), "--quiet", "--threads", "1"]
        subprocess.run(command, check=True)
        served.same_as_alone(made, folder / "out")
        shutil.rmtree(folder)
        subprocess.run([CLOUD, "verify", "--link", served.link, made], check=True, capture_output=True)


def check_stop_resume():
    """Stop from the page, resume: stopped in between, the same bytes; stop and resume as often as one likes."""
    reference = alone()
    with server() as served:
        run = served.submit()
        for _ in range(3):
            wait_for(lambda: served.worker(run), 60, "no worker")
            time.sleep(RANDOM.uniform(0.5, 2))
            if served.run(run)["state"] != "running":
                break
            served.json("POST", f"/runs/{run}/stop", {})
            wait_for(lambda: served.run(run)["state"] in ("stopped", "finished"), 60, "not stopped")
            if served.run(run)["state"] == "finished":
                break
            served.json("POST", f"/runs/{run}/resume", {})
        served.wait(run)
        served.json("POST", f"/runs/{run}/stop", {}, expect=409)
        served.same_as_alone(run, reference)
        # Of a deletion and a resumption at once one is accepted: a run that goes on has its files.
        for _ in range(6):
            run = served.submit()
            wait_for(lambda: served.worker(run), 60, "no worker")
            served.json("POST", f"/runs/{run}/stop", {})
            wait_for(lambda: served.run(run)["state"] == "stopped", 60, "not stopped")
            answers = {}
            work = {"DELETE": f"/runs/{run}", "POST": f"/runs/{run}/resume"}
            def ask(method):
                answers[method] = served.request(method, work[method], None if method == "DELETE" else {}).status
            threads = [threading.Thread(target=ask, args=(method,)) for method in work]
            [thread.start() for thread in threads]
            [thread.join() for thread in threads]
            deleted = answers == {"DELETE": 204, "POST": 404}
            must(deleted or answers == {"DELETE": 409, "POST": 200}, f"{answers}")
            must(served.request("GET", f"/runs/{run}").status == (404 if deleted else 200), "neither there nor gone")
            if not deleted:
                must(served.head(run)["epoch"] >= 1, "a run without its head")
                served.json("POST", f"/runs/{run}/kill", {})


def check_idempotent():
    """A key sent again with its body gives one run, also at once; another body is refused."""
    with server() as served:
        body = {"scene": {"name": "drum.toml", "text": SCENE, "set": LONG}}
        key = {"Idempotency-Key": "one"}
        found = []
        threads = [threading.Thread(target=lambda: found.append(served.json("POST", "/runs", body, 201, key)["id"])) for _ in range(8)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        must(len(found) == 8 and len(set(found)) == 1, f"{found}")
        served.json("POST", "/runs", body | {"title": "another"}, expect=409, headers=key)
        must(len(served.json("GET", "/runs")["runs"]) == 1, "more than one run")


SPHERES = (ROOT / "scenes/two-spheres.toml").read_text()
PARTICLES = ROOT / "scenes/particles.csv"


def upload(served, path):
    content = path.read_bytes()
    digits = hashlib.sha256(content).hexdigest()
    served.request("PUT", f"/inputs/{digits}", content, {"Content-Type": "application/octet-stream"}, 201, raw=True)
    return digits


def check_thousand():
    """1,000 runs of one study, the server killed at 300: all finished once, lists under 100 ms, under 150 MB."""
    number = int(os.environ.get("ACCEPT_RUNS", 1000))
    with server() as served:
        files = {path.name: upload(served, path) for path in [PARTICLES] if f'"{path.name}"' in SPHERES}
        values = [repr(100.0 + k) for k in range(number)]
        base = {"scene": {"name": "two.toml", "text": SPHERES, "set": SHORT, "files": files}, "label": "thousand"}
        begin = time.monotonic()
        body = {"base": base, "sweep": ["materials.0.normal.dissipation=" + ",".join(values)]}
        ids = served.json("POST", "/studies", body, 201)["runs"]
        must(len(set(ids)) == number, f"{len(set(ids))} runs")
        submitted = time.monotonic() - begin
        finished = lambda: served.json("GET", "/runs")["states"].get("finished", 0)
        wait_for(lambda: finished() >= 0.3 * number, 600, "not 30 % finished")
        served.kill()
        served.start()
        slowest = 0
        def over():
            nonlocal slowest
            asked = time.monotonic()
            states = served.json("GET", "/runs?label=thousand")["states"]
            slowest = max(slowest, time.monotonic() - asked)
            time.sleep(1)
            return states.get("finished", 0) == number or set(states) - {"queued", "running", "finished"}
        wait_for(over, 1200, "not all finished")
        states = served.json("GET", "/runs")["states"]
        must(states == {"finished": number}, f"{states}")
        memory = [line for line in Path(f"/proc/{served.process.pid}/status").read_text().splitlines() if line.startswith("VmHWM")]
        attempts = [len(served.attempts(run)) for run in ids]
        must(set(attempts) == {1}, f"attempts: {[(ids[k], n) for k, n in enumerate(attempts) if n != 1][:5]}")
        print(f"    submitted in {submitted:.1f} s, all in {time.monotonic() - begin:.0f} s, slowest list {1000 * slowest:.0f} ms, {memory}")
        must(int(memory[0].split()[1]) < 150_000, f"{memory}")


def check_study():
    """A grid with a range, and a study file: the runs and the numbers of `mercury-solve` alone; the same key is the same
    study; the table survives deletion of a run; mistakes are reported in the solver's words."""
    folder = Path(tempfile.mkdtemp(prefix="accept-study-"))
    shutil.copy(ROOT / "scenes/two-spheres.toml", folder)
    for path in [PARTICLES] if f'"{PARTICLES.name}"' in SPHERES else []:
        shutil.copy(path, folder)
    (folder / "list.toml").write_text("""[study]
scene = "two-spheres.toml"
set = { "output.pictures" = false }
[study.results]
speed = "max(particles.vx)"
[[study.runs]]
name = "soft"
"materials.0.normal.dissipation" = 20.0
[[study.runs]]
name = "hard"
"materials.0.normal.dissipation" = 400.0
"gravity" = [0, 0, -1]
""")
    options = ["--sweep", "materials.0.normal.dissipation=10..500/3", "--sweep", "seed=1,2", "--result", "speed=max(particles.vx)",
               "--set", "output.pictures=false"]
    with server() as served:
        for name, more in [("two-spheres.toml", options), ("list.toml", [])]:
            subprocess.run([SOLVE, name, *more, "--quiet", "--output", "alone"], cwd=folder, check=True, capture_output=True)
            with open(folder / "alone/study.csv") as file:
                expected = list(csv.DictReader(file))
            shutil.rmtree(folder / "alone")
            made = subprocess.run([CLOUD, "submit", "--link", served.link, name, *more], cwd=folder, check=True, capture_output=True, text=True)
            study = made.stderr.split()[1]
            wait_for(lambda: served.json("GET", f"/studies/{study}")["states"].get("finished") == len(expected), 120, "not finished")
            text = subprocess.run([CLOUD, "table", "--link", served.link, study], check=True, capture_output=True, text=True).stdout
            got = list(csv.DictReader(text.splitlines()))
            must([row["run"] for row in got] == [row["run"] for row in expected], f"runs: {text}")
            of = lambda row: float(next(value for key, value in row.items() if key.split(" [")[0] == "speed"))
            must([of(row) for row in got] == [of(row) for row in expected], f"results: {text}\n{expected}")
        # Means over seeds, and differences seed by seed.
        (folder / "drum.toml").write_text(SCENE)
        (folder / "seeds.toml").write_text("""[study]
scene = "drum.toml"
seeds = 3
set = { "output.pictures" = false, "time.end" = 0.02 }
[study.results]
height = "max(particles.z)"
speed = "max(particles.vx)"
[study.sweep]
"materials.0.tangential.friction" = [0.1, 0.5]
""")
        subprocess.run([SOLVE, "seeds.toml", "--quiet", "--output", "alone"], cwd=folder, check=True, capture_output=True)
        def numbers(text):
            plain = lambda key: key.split(" [")[0]
            return [{plain(key): float(value) for key, value in row.items() if value} for row in csv.DictReader(text.splitlines())]
        means, differences = (numbers((folder / f"alone/study.{name}.csv").read_text()) for name in ("means", "differences"))
        made = subprocess.run([CLOUD, "submit", "--link", served.link, "seeds.toml"], cwd=folder, check=True, capture_output=True, text=True)
        seeds = made.stderr.split()[1]
        wait_for(lambda: served.json("GET", f"/studies/{seeds}")["states"].get("finished") == 6, 120, "not finished")
        must(numbers(served.request("GET", f"/studies/{seeds}/means.csv", expect=200).body.decode()) == means, f"other means: {means}")
        got = numbers(served.request("GET", f"/studies/{seeds}/differences.csv", expect=200).body.decode())
        must(got == differences, f"other differences: {got}, expected {differences}")
        points = served.json("GET", f"/studies/{seeds}")["means"]
        must([point["seeds"] for point in points] == [3, 3], f"{points}")
        for k, name in enumerate(("height", "speed")):
            one = points[1]["results"][k]
            got = [one["difference"], one["difference_error"], one["correlation"]]
            must(got == [differences[0].get(column) for column in (name, f"{name}_error", f"{name}_correlation")], f"{got}: {differences}")
        table = served.json("GET", f"/studies/{study}")
        served.request("DELETE", f"/runs/{table['rows'][0]['id']}", expect=204)
        must(len(served.json("GET", f"/studies/{study}")["rows"]) == 1, "the deleted run is in the table")
        files = {path.name: upload(served, path) for path in [PARTICLES] if f'"{path.name}"' in SPHERES}
        base = {"scene": {"name": "two.toml", "text": SPHERES, "files": files}}
        key = {"Idempotency-Key": "one"}
        first = served.json("POST", "/studies", {"base": base, "sweep": ["seed=1,2"]}, 201, key)
        must(served.json("POST", "/studies", {"base": base, "sweep": ["seed=1,2"]}, 201, key) == first, "another study")
        served.json("POST", "/studies", {"base": base, "sweep": ["seed=1,3"]}, 409, key)
        for more, part in [({"sweep": ["seed=1,,2"]}, "between two commas"), ({"sweep": ["materials.0.nothing=1,2"]}, "nothing"),
                           ({"sweep": ["materials.0.normal.stiffness=-1,2"]}, "must be > 0"), ({"sweep": ["seed=1,2"] * 2}, "seed"),
                           ({"file": "x = 1"}, "is no study"), ({"file": SPHERES}, "is no study"),
                           ({"file": '[study]\nscene = "other.toml"\n[study.sweep]\nseed = [1]'}, "other.toml")]:
            found = served.json("POST", "/studies/check", {"base": base} | more)
            must(found["problems"] and part in json.dumps(found), f"{more}: {found}")
            served.request("POST", "/studies", {"base": base} | more, expect=422)
        for more in [{}, {"sweep": ["seed=1"], "file": ""}, {"sweep": ["seed=1"] * 21}]:
            served.request("POST", "/studies", {"base": base} | more, expect=400)
    shutil.rmtree(folder)


def check_list():
    """10,000 runs: every page of the list in less than 100 ms."""
    number = int(os.environ.get("ACCEPT_RUNS", 10_000))
    with server() as served:
        run = served.submit(sets=SHORT + ["time.end=0.001"])
        served.wait(run)
        served.kill()
        with contextlib.closing(sqlite3.connect(served.folder / "data/db.sqlite")) as database, database:
            database.row_factory = sqlite3.Row
            row = dict(database.execute("SELECT * FROM runs").fetchone())
            names = list(row)
            for k in range(1, number):
                one = row | {"id": f"{RANDOM.getrandbits(128):032x}", "number": row["number"] + k, "title": f"run {k}", "label": f"label {k % 7}"}
                database.execute(f"INSERT INTO runs({','.join(names)}) VALUES ({','.join('?' * len(names))})", [one[name] for name in names])
        served.start()
        slowest, pages, seen, after = 0, 0, set(), ""
        while after is not None:
            begin = time.monotonic()
            page = served.json("GET", f"/runs?after={after}" if after else "/runs")
            slowest = max(slowest, time.monotonic() - begin)
            seen |= {one["id"] for one in page["runs"]}
            after, pages = page["after"], pages + 1
        must(len(seen) == number, f"{len(seen)} of {number} runs")
        for query in ["text=run+99", "state=finished", "label=label+3", "state=failed", "text=nothing"]:
            begin = time.monotonic()
            served.json("GET", f"/runs?{query}")
            slowest = max(slowest, time.monotonic() - begin)
        print(f"    {number} runs, {pages} pages and 5 searches, the slowest in {1000 * slowest:.0f} ms")
        must(slowest < 0.1, "slow")


def check_cost():
    """Extra processor time of a run through the cloud over a run at the shell, of all processes: less than 2 %."""
    sets = [f"time.end={os.environ.get('ACCEPT_END', '3')}", "output.pictures=false"]
    def spent(pid):
        # User and system time of a process's children that have ended, with theirs (proc(5), fields 16 and 17).
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[13]) + int(fields[14])) / os.sysconf("SC_CLK_TCK")
    least = {}
    with server(checkpoint="5m") as served:
        for _ in range(int(os.environ.get("ACCEPT_ROUNDS", 3))):
            folder = tempfile.mkdtemp(prefix="accept-cost-")
            (Path(folder) / "drum.toml").write_text(SCENE)
            before = os.times()
            command = [SOLVE, "drum.toml", "--output", "out", "--quiet", "--threads", "1", *[f"--set={one}" for one in sets]]
            subprocess.run(command, cwd=folder, check=True)
            after = os.times()
            shutil.rmtree(folder)
            shell = after.children_user + after.children_system - before.children_user - before.children_system
            before = spent(served.process.pid)
            run = served.submit(sets=sets)
            served.wait(run)
            wait_for(lambda: not served.worker(run), 30, "the worker stays")
            time.sleep(1.5)
            # The server itself works for its page, and is not counted.
            cloud = spent(served.process.pid) - before
            for name, seconds in [("shell", shell), ("cloud", cloud)]:
                least[name] = min(least.get(name, seconds), seconds)
    more = least["cloud"] / least["shell"] - 1
    print(f"    {least['shell']:.2f} s at the shell, {least['cloud']:.2f} s through the cloud: {100 * more:+.1f} %")
    must(least["shell"] > 10, "the run is too short for a comparison")
    must(more < 0.02, "dear")


def texts(served, *answers):
    """All that the server has said and written into logs."""
    logs = [path.read_bytes() for path in (served.folder / "data/log").glob("*")]
    return b"\n".join([*(answer.body for answer in answers), *logs, (served.folder / "server.log").read_bytes()])


def check_passwd():
    """No byte of a file of the machine gets into any answer or log."""
    passwd = Path("/etc/passwd").read_bytes()
    marks = [line for line in passwd.split(b"\n")[:5] if line] + [b"root:"]
    with server() as served:
        answers = []
        (served.folder / "secret.csv").write_text("root:secret-content")
        table = '\n[[particles]]\nfile = "{}"\nmaterial = "glass"\n'
        for name in ["/etc/passwd", "../../../../../etc/passwd", "../x", "../../../secret.csv", "x/../../etc/passwd", "/proc/self/environ", "/dev/stdin"]:
            for text, sets in [(SCENE + table.format(name), []), (SCENE, [f"insertions.0.psd.file={name}", "insertions.0.psd.kind=file"]),
                               (SCENE, [f'walls.0.file="{name}"', 'walls.0.shape="mesh"'])]:
                scene = {"name": "drum.toml", "text": text, "set": sets}
                answers.append(served.request("POST", "/check", {"scene": scene}, expect=200))
                problems = json.loads(answers[-1].body)["problems"]
                must(problems, f"{name} was taken")
                answers.append(served.request("POST", "/runs", {"scene": scene}, expect=422))
                body = {"base": {"scene": scene}, "sweep": ["time.end=0.1,0.2"]}
                answers.append(served.request("POST", "/studies", body, expect=422))
                body = {"base": {"scene": {"text": SCENE}}, "file": f'[study]\nscene = "{name}"\n[study.sweep]\nseed = [1, 2]\n'}
                answers.append(served.request("POST", "/studies", body, expect=422))
            answers.append(served.request("POST", "/check", {"scene": {"name": name, "text": SCENE}}, expect=400))
            answers.append(served.request("POST", "/check", {"scene": {"text": SCENE, "files": {name: "0" * 64}}}, expect=400))
        everything = texts(served, *answers)
        for mark in marks + [b"secret-content"]:
            must(mark not in everything, f"{mark!r} got out")
        data = str(served.folder).encode()
        for answer in answers:
            must(data not in answer.body, f"a path of the server got out: {answer.body!r}")


def check_hostile():
    """Names, bodies and scenes that mean harm: a 4xx with a reason, nothing outside, no growth of memory or disk."""
    with server() as served:
        def memory():
            text = Path(f"/proc/{served.process.pid}/status").read_text()
            return int([line for line in text.splitlines() if line.startswith("VmRSS")][0].split()[1])
        def disk():
            return sum(path.stat().st_size for path in served.folder.rglob("*") if path.is_file())
        served.json("POST", "/check", {"scene": {"text": SCENE}})
        memory_before, disk_before = memory(), disk()
        for name in ["../x.toml", "/etc/x.toml", "a\0b", "x" * 300, "ü.toml", "<img src=x onerror=alert(1)>.stl", ".hidden", "", "a/b"]:
            served.request("POST", "/check", {"scene": {"name": name, "text": SCENE}}, expect=400)
            served.request("POST", "/runs", {"scene": {"text": SCENE, "files": {name: "0" * 64}}}, expect=400)
        served.request("POST", "/check", b'{"scene": {"text": "\xff\xfe"}}', expect=400, raw=True)
        served.request("POST", "/check", b"{" * 100_000, expect=400, raw=True)
        served.request("POST", "/check", {"scene": {"text": "x" * (1 << 20) + "x"}}, expect=413)
        served.request("POST", "/check", b"x" * (5 << 20), expect=413, raw=True)
        for text in ["a = " + "[" * 100_000, "[" + "a." * 100_000 + "b]", SCENE.replace("number = 900", "number = 1e18"), "\0", "=" * 1000]:
            answer = served.json("POST", "/check", {"scene": {"text": text}})
            served.request("POST", "/runs", {"scene": {"text": text}})
            must(answer["problems"] or answer["plan"], f"no reason: {answer}")
        # A billion grains of dust, for which there is room in the drum.
        huge = SCENE.replace("number = 900", "number = 1000000000").replace("1.8e-3", "1.8e-6").replace("2.2e-3", "2.2e-6")
        answer = served.request("POST", "/runs", {"scene": {"text": huge}})
        must(answer.status in (400, 422), f"1e9 particles: {answer.status}")
        # An STL whose head promises 2^32 triangles.
        stl = b"\0" * 80 + b"\xff\xff\xff\xff" + b"\0" * 50
        path = served.folder / "huge.stl"
        path.write_bytes(stl)
        files = {"huge.stl": upload(served, path)}
        text = SCENE + '\n[[walls]]\nname = "<img src=x onerror=alert(1)>"\nshape = "mesh"\nfile = "huge.stl"\nmaterial = "glass"\n'
        must(served.json("POST", "/check", {"scene": {"text": text, "files": files}})["problems"], "the mesh was taken")
        # A body that is longer than it says, by length and by chunks; a digest that is another's.
        head = {"Content-Type": "application/octet-stream"}
        served.request("PUT", "/inputs/" + "0" * 64, b"x", head, 400, raw=True)
        served.request("PUT", "/inputs/../../x", b"x", head, 400 if False else None, raw=True)
        with socket.create_connection(("127.0.0.1", served.port)) as raw:
            raw.sendall(f"PUT /api/v1/inputs/{'0' * 64} HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\nCookie: {served.cookie}\r\n"
                        "Sec-Fetch-Site: same-origin\r\nContent-Length: 10000000000\r\n\r\n".encode())
            with contextlib.suppress(OSError):
                for _ in range(64):
                    raw.sendall(b"x" * (1 << 20))
        title = "<script>alert(1)</script>"
        run = served.submit(sets=SHORT + ["time.end=0.001"], title=title)
        must(served.run(run)["title"] == title, "the title is another")
        served.wait(run)
        for name in ["../head.json", "%2e%2e/head.json", "/etc/passwd", "x" * 300, "drum.ene%00"]:
            answer = served.request("GET", f"/runs/{run}/files/{name}")
            must(answer.status in (400, 404), f"{name}: {answer.status} {answer.body[:100]}")
        time.sleep(1)
        print(f"    {memory() - memory_before} kB of memory, {(disk() - disk_before) >> 10} kB of disk more")
        must(memory() - memory_before < 50_000, "memory grew")
        must(disk() - disk_before < 50 << 20, "the disk filled")


def paths(served):
    return json.loads(served.request("GET", "/openapi.json", expect=200).body)["paths"]


def check_others():
    """Another user gets 404 for all that is not hers; a token that expired or is foreign gets 401."""
    with server() as served:
        run = served.submit(sets=LONG)
        study = served.json("POST", "/studies", {"base": {"scene": {"text": SCENE}}, "sweep": ["time.end=1e-5,2e-5"]}, 201)["id"]
        project = served.json("POST", "/projects", {"name": "mine"}, 201)["id"]
        served.json("PATCH", f"/runs/{run}", {"project": project})
        served.request("POST", "/users", {"name": "ada", "password": "correct horse"}, expect=204)
        mine, served.cookie = served.cookie, None
        answer = served.request("POST", "/session", {"name": "ada", "password": "correct horse"}, expect=200)
        served.cookie = answer.headers["set-cookie"].split(";")[0]
        tried = 0
        for path, methods in paths(served).items():
            if not any(part in path for part in ("{run}", "{study}", "{project}")):
                continue
            path = path.replace("{project}", project).replace("/members/{name}", "/members/local")
            path = path.replace("{run}", run).replace("{study}", study).replace("{name}", "drum.ene").replace("{k}", "0").replace("{id}", "0")
            for method in methods:
                body = {"end": 9.0} if path.endswith("extend") else {"at": 0.01} if path.endswith("branch") else {"days": 1}
                query = "?file=drum.ene&column=elasticEnergy" if path.endswith("charts") else ""
                body = body if path.endswith(("extend", "branch", "share")) else {"role": "viewer"} if "/members/" in path else {}
                answer = served.request(method.upper(), path + query, body)
                must(answer.status == 404, f"{method} {path}: {answer.status} {answer.body[:200]!r}")
                tried += 1
        must(tried >= 15, f"{tried} paths")
        served.request("GET", f"/events?runs={run}", expect=404)
        served.request("GET", "/users", expect=403)
        must(served.json("GET", "/runs")["runs"] == [], "runs of others in the list")
        must(served.json("GET", "/projects") == [], "projects of others in the list")
        for path in (f"/runs?project={project}", f"/studies?project={project}"):
            served.request("GET", path, expect=404)
        served.request("POST", "/runs", {"scene": {"text": SCENE}, "project": project}, expect=404)
        served.cookie = None
        for token in ["mc_" + "0" * 64, "x", ""]:
            served.request("GET", f"/runs/{run}", headers={"Authorization": f"Bearer {token}"}, expect=401)
        served.request("GET", f"/runs/{run}", expect=401)
        # A share link shows one run, to look at.
        served.cookie = mine
        token = served.json("POST", f"/runs/{run}/share", {"days": 1})["token"]
        other = served.submit(sets=LONG, title="other")
        answer = served.request("POST", "/session", {"token": token}, expect=200)
        served.cookie = answer.headers["set-cookie"].split(";")[0]
        served.request("GET", f"/runs/{run}", expect=200)
        must(served.json("GET", "/projects") == [], "a share link shows projects")
        must(served.json("GET", f"/runs?project={project}")["runs"] == [], "a share link lists runs")
        served.request("GET", f"/runs/{other}", expect=404)
        served.request("GET", "/hook", expect=404)
        served.request("POST", f"/runs/{run}/stop", {}, expect=403)
        served.request("POST", "/tokens", {"name": "x"}, expect=403)


def check_taken_back():
    """Tokens, links, passwords, users and sessions that are taken back are gone with all that they made, also streams; a link is good once."""
    with server() as served:
        def session(**body):
            served.cookie = None
            answer = served.request("POST", "/session", body, expect=200)
            return answer.headers["set-cookie"].split(";")[0]
        def status(cookie, path="/session"):
            served.cookie = cookie
            return served.request("GET", path).status
        def cli(*words, text=None):
            done = subprocess.run([CLOUD, *words[:1], "--link", served.link, *words[1:]], input=text, capture_output=True, text=True)
            must(done.returncode == 0, f"{words}: {done.stderr}")
            return done.stdout
        run = served.submit(sets=LONG)
        admin = served.admin
        # A token of one day makes a session of a day, which ends with it; so does its stream of events.
        token = served.json("POST", "/tokens", {"name": "day", "days": 1}, 201)
        made = session(token=token["secret"])
        served.cookie = made
        row = [row for row in served.json("GET", "/sessions") if row["current"]][0]
        must(row["token"] == "day" and row["expires"] <= token["expires"], f"{row}")
        longer = served.json("POST", "/tokens", {"name": "longer", "days": 300}, 201)
        must(longer["expires"] <= token["expires"], "a token makes one that lives longer")
        connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=30)
        connection.request("GET", "/api/v1/events", headers={"Cookie": made})
        stream = connection.getresponse()
        must(stream.status == 200, f"{stream.status}")
        served.cookie = admin
        served.request("DELETE", f"/tokens/{token['id']}", expect=204)
        must(status(made) == 401, "a session outlives its token")
        served.cookie = None
        served.request("GET", "/session", headers={"Authorization": f"Bearer {longer['secret']}"}, expect=401)
        begin = time.monotonic()
        while stream.readline():
            must(time.monotonic() - begin < 20, "a stream outlives its token")
        # A link to a run shows nothing of its owner, and ends with its sessions.
        served.cookie = admin
        share = served.json("POST", f"/runs/{run}/share", {"days": 1})["token"]
        shared = session(token=share)
        served.cookie = shared
        seen = served.json("GET", "/session")
        must((seen["user"], seen["cores"], seen["usage"]["disk"], seen["price"]) == ("", [0, 0], 0, None), f"{seen}")
        must(served.run(run)["owner"] == "", "the owner of a shared run")
        for path in ("/sessions", "/tokens", "/shares", f"/runs/{run}/shares"):
            served.request("GET", path, expect=404)
        served.cookie = admin
        [row] = served.json("GET", f"/runs/{run}/shares")
        must(row["run"] == run and served.json("GET", "/shares") == [row], f"{row}")
        cli("share", "rm", str(row["id"]))
        must(status(shared) == 401, "a session outlives its share")
        served.cookie = admin
        # Many sessions of links hide none of the user's own.
        share = served.json("POST", f"/runs/{run}/share", {"days": 1})["token"]
        for _ in range(210):
            served.request("POST", "/session", {"token": share}, expect=200)
        must([row["current"] for row in served.json("GET", "/sessions")].count(True) == 1, "the session itself is not listed")
        # A link to log in ends with the token that it was made with, and so does the session that it begins.
        token = served.json("POST", "/tokens", {"name": "links"}, 201)
        bearer = {"Authorization": f"Bearer {token['secret']}"}
        served.cookie = None
        link = served.json("POST", "/links", {"rotate": False}, 201, bearer)["secret"]
        made = session(token=link)
        served.cookie = admin
        served.request("DELETE", f"/tokens/{token['id']}", expect=204)
        must(status(made) == 401, "the session of a link outlives the token of the link")
        # So does a link to a run of another member of a project.
        served.cookie = admin
        cli("user", "bea", text="correct horse\n")
        project = served.json("POST", "/projects", {"name": "p"}, 201)["id"]
        served.request("PUT", f"/projects/{project}/members/bea", {"role": "member"}, expect=204)
        served.request("PATCH", f"/runs/{run}", {"project": project}, expect=200)
        served.cookie = member = session(name="bea", password="correct horse")
        token = served.json("POST", "/tokens", {"name": "member"}, 201)
        served.cookie = None
        bearer = {"Authorization": f"Bearer {token['secret']}"}
        shared = session(token=served.json("POST", f"/runs/{run}/share", {"days": 1}, headers=bearer)["token"])
        must(status(shared) == 200, "the session of a link")
        served.cookie = member
        served.request("DELETE", f"/tokens/{token['id']}", expect=204)
        must(status(shared) == 401, "a link to a run outlives the token that made it")
        served.cookie = admin
        # A password, and a user.
        cli("user", "ada", "--disk", "5", text="correct horse\n")
        first = session(name="ada", password="correct horse")
        served.cookie = first
        kept = served.json("POST", "/tokens", {"name": "kept"}, 201)["secret"]
        cli("user", "ada", "--password", text="another horse\n")
        must(status(first) == 401, "a session outlives its password")
        second = session(name="ada", password="another horse")
        served.cookie = second
        must(served.json("GET", "/session")["usage"]["most_disk"] == 5_000_000, "a new password changes limits")
        third = session(name="ada", password="another horse")
        served.cookie = second
        served.request("DELETE", "/sessions", expect=204)
        must(status(second) == status(third) == 401, "logged out everywhere, but not here")
        served.cookie = None
        served.request("GET", "/session", headers={"Authorization": f"Bearer {kept}"}, expect=200)
        must("ada" in cli("user", "ls"), "ada is not listed")
        cli("user", "rm", "ada")
        served.request("GET", "/session", headers={"Authorization": f"Bearer {kept}"}, expect=401)
        # The last administrator stays one; a link of the machine is good once, and rotation ends what was before.
        served.cookie = admin
        served.request("POST", "/users", {"name": "local", "admin": False}, expect=409)
        served.request("DELETE", "/users/local", expect=409)
        link = cli("link").strip().split("#token=")[1]
        once = session(token=link)
        served.cookie = None
        served.request("POST", "/session", {"token": link}, expect=401)
        must(status(once) == 200, "the session of the link")
        fresh = cli("link", "--rotate").strip().split("#token=")[1]
        must(status(once) == 401 and status(admin) == 401, "sessions outlive a rotation")
        served.link = (served.folder / "data/link").read_text().strip()
        served.admin = session(token=served.link.split("#token=")[1])
        must(status(session(token=fresh)) == 200, "the link of the rotation")


def check_private():
    """With any umask at its start, the data belongs to its owner alone; no answer has a path of the server; texts have no control characters."""
    before = os.umask(0)
    try:
        context = server()
        served = context.__enter__()
    finally:
        os.umask(before)
    try:
        run = served.submit(sets=[*SHORT, "time.end=0.01"])
        served.wait(run)
        for path in [served.folder / "data", *(served.folder / "data").rglob("*")]:
            must(path.stat().st_mode & 0o077 == 0, f"{path}: {path.stat().st_mode:o}")
        served.fetch(run, served.folder / "got")
        for path in (served.folder / "got").rglob("*"):
            for secret in (str(served.folder), SOLVE):
                must(not path.is_file() or secret.encode() not in path.read_bytes(), f"{path.name} has {secret}")
        for path in (f"/runs/{run}", f"/runs/{run}/log", f"/runs/{run}/attempts", f"/runs/{run}/events"):
            must(str(served.folder) not in served.request("GET", path, expect=200).body.decode(), path)
        for bad in ("a\nb", "\x1b[2J", "\x7f"):
            served.request("PATCH", f"/runs/{run}", {"title": bad}, expect=400)
            served.request("PATCH", f"/runs/{run}", {"label": bad}, expect=400)
            served.request("POST", "/runs", {"scene": {"text": SCENE}, "title": bad}, expect=400)
            served.request("POST", "/runs", {"scene": {"text": SCENE}, "label": bad}, expect=400)
            served.request("POST", "/studies", {"base": {"scene": {"text": SCENE}, "title": bad}, "sweep": ["seed=1,2"]}, expect=400)
            served.request("POST", "/tokens", {"name": bad}, expect=400)
            served.request("POST", "/projects", {"name": bad}, expect=400)
        # The right to change nothing holds for the route, not for the end of a path.
        project = served.json("POST", "/projects", {"name": "mine"}, 201)["id"]
        served.request("POST", "/users", {"name": "session", "password": "correct horse"}, expect=204)
        reads = served.json("POST", "/tokens", {"name": "reads", "read_only": True}, 201)["secret"]
        served.request("PUT", f"/projects/{project}/members/session", {"role": "viewer"}, {"Authorization": f"Bearer {reads}"}, 403)
    finally:
        context.__exit__(None, None, None)


def memory_of(served, line="VmHWM"):
    """Memory of a server in kB: the most so far, or another line of its status."""
    text = Path(f"/proc/{served.process.pid}/status").read_text()
    return int(re.search(rf"^{line}:\s+(\d+)", text, re.M)[1])


def stalled(served, path, cookie, count, address="127.0.0.1"):
    """Connections that send a request and read nothing of the answer."""
    made = []
    for _ in range(count):
        raw = socket.socket()
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        raw.bind((address, 0))
        raw.connect(("127.0.0.1", served.port))
        with contextlib.suppress(OSError):
            raw.sendall(f"GET /api/v1{path} HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: {cookie}\r\n\r\n".encode())
        made.append(raw)
    return made


def big_run(served, megabytes):
    """A finished run with an input of this length that its scene does not name, and a cookie of a link to it."""
    path = served.folder / "big.stl"
    path.write_bytes(os.urandom(1 << 20) * megabytes)
    run = served.json("POST", "/runs", {"scene": {"name": "drum.toml", "text": SCENE, "set": [*SHORT, "time.end=0.001"],
                                                  "files": {"big.stl": upload(served, path)}}}, 201)["id"]
    served.wait(run)
    token = served.json("POST", f"/runs/{run}/share", {"days": 1})["token"]
    shared = served.request("POST", "/session", {"token": token}, expect=200).headers["set-cookie"].split(";")[0]
    return run, shared


def check_unread():
    """610 downloads of a link that nothing reads: other requests take less than 2 s, and so do downloads of its owner."""
    with server() as served:
        run, shared = big_run(served, 16)
        before = memory_of(served, "VmRSS")
        unread = stalled(served, f"/runs/{run}/archive", shared, 610)
        time.sleep(2)
        for path in (f"/runs/{run}", "/runs", f"/runs/{run}/files/run.log"):
            begin = time.monotonic()
            served.request("GET", path, expect=200)
            seconds = time.monotonic() - begin
            must(seconds < 2, f"{path}: {seconds:.1f} s")
        more = memory_of(served) - before
        print(f"    {more} kB of memory more")
        must(more < 200_000, "memory grew")
        # Links to the runs of a user have 256 streams of events, and take none of the user's own. A name that comes twice counts once.
        events = f"/events?runs={run},{run}"
        unread += stalled(served, events, shared, 270)
        # A look in between would take the place of one of them.
        time.sleep(3)
        def status(cookie):
            connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=30)
            connection.request("GET", f"/api/v1{events}", headers={"Cookie": cookie})
            return connection.getresponse().status
        wait_for(lambda: status(shared) == 429, 30, "streams of events without a limit")
        must(status(served.cookie) == 200, "the owner gets no stream")
        # A head that never ends is cut.
        begin = time.monotonic()
        slow = socket.create_connection(("127.0.0.1", served.port))
        slow.sendall(b"GET /api/v1/runs HTTP/1.1\r\nHost: ")
        slow.settimeout(60)
        while slow.recv(1000):
            pass
        must(time.monotonic() - begin < 40, "a head without an end is waited for")
        [raw.close() for raw in [slow, *unread]]


def check_log_in():
    """120 names at once take less than 100 MB; wrong passwords delay their address alone; long names and passwords are refused."""
    with server() as served:
        served.request("POST", "/users", {"name": "ada", "password": "correct horse"}, expect=204)
        served.cookie = None
        before = memory_of(served, "VmRSS")
        def unknown(k):
            answer = served.request("POST", "/session", {"name": f"user{k}", "password": "correct horse"})
            answers.append(answer.status)
        def log_in(password, address="127.0.0.1"):
            connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=60, source_address=(address, 0))
            connection.request("POST", "/api/v1/session", json.dumps({"name": "ada", "password": password}),
                               {"Sec-Fetch-Site": "same-origin", "Content-Type": "application/json"})
            answer = connection.getresponse()
            return answer.status, answer.headers.get("retry-after"), answer.read()
        answers = []
        threads = [threading.Thread(target=unknown, args=(k,)) for k in range(120)]
        [thread.start() for thread in threads]
        # One address takes no turn of another one.
        begin = time.monotonic()
        must(log_in("correct horse", "127.0.0.3")[0] == 200, "a login of another address")
        seconds = time.monotonic() - begin
        must(seconds < 5, f"a login of another address takes {seconds:.1f} s")
        [thread.join() for thread in threads]
        must(set(answers) <= {401, 429} and len(answers) == 120, f"answers: {answers}")
        more = memory_of(served) - before
        print(f"    {more} kB of memory more")
        must(more < 100_000, "too much memory")
        begin = time.monotonic()
        wrong = [log_in("wrong")[0] for _ in range(8)]
        must(wrong[:3] == [401] * 3 and wrong.count(429) >= 2, f"wrong tries: {wrong}")
        must(time.monotonic() - begin < 20, "wrong tries are waited for")
        must(log_in("correct horse", "127.0.0.2")[0] == 200, "another address cannot log in")
        def waited():
            status, after, _ = log_in("correct horse")
            must(status == 200 or after is not None, f"{status} without Retry-After")
            return status == 200
        wait_for(waited, 30, "the user is locked out")
        must(log_in("x" * 2000)[0] == 401, "a long password")
        # Servers on other ports of this machine have other cookies.
        must(served.admin.startswith(f"mercury-{served.port}="), served.admin.split("=")[0])
        served.request("POST", "/session", {"name": "x" * 1000, "password": "correct horse"}, expect=401)
        served.request("POST", "/session", {"name": "ada", "password": "x" * 100_000}, expect=413)


def check_archives():
    """Six readers of an archive with an input of 200 MB: less than 100 MB of memory, and the right bytes; archives and files
    have a length and can be resumed at any byte, also by a browser that takes compressed answers."""
    with server() as served:
        run, shared = big_run(served, 200)
        before = memory_of(served, "VmRSS")
        digests = []
        def read():
            connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=120)
            connection.request("GET", f"/api/v1/runs/{run}/archive", headers={"Cookie": shared})
            answer = connection.getresponse()
            digest = hashlib.sha256()
            while piece := answer.read(1 << 20):
                digest.update(piece)
            digests.append(digest.hexdigest())
        threads = [threading.Thread(target=read) for _ in range(6)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        more = memory_of(served) - before
        print(f"    {more} kB of memory more")
        must(more < 100_000, "too much memory")
        must(len(digests) == 6 and len(set(digests)) == 1, f"other bytes: {digests}")
        path = served.folder / "got.zip"
        path.write_bytes(served.request("GET", f"/runs/{run}/archive", expect=200).body)
        with zipfile.ZipFile(path) as archive:
            must(archive.testzip() is None, "a damaged archive")
            content = archive.read("big.stl")
            must(content == (served.folder / "big.stl").read_bytes(), "the input has other bytes")
            must("drum/run.log" in archive.namelist(), f"files: {archive.namelist()}")
            # The last bytes of the input, and all behind it.
            behind = archive.getinfo("big.stl").header_offset + len(content) - 1000
        whole = path.read_bytes()
        text = served.request("GET", f"/runs/{run}/files/drum.ene", expect=200).body
        for where, content in [("archive", whole), ("files/drum.ene", text)]:
            firsts = [0, 1, 40, len(content) - 1] + [RANDOM.randrange(len(content)) for _ in range(3)] + [behind] * (where == "archive")
            browser = {"Accept-Encoding": "gzip, deflate, br"}
            answer = served.request("GET", f"/runs/{run}/{where}", headers=browser, expect=200)
            must(answer.headers["content-length"] == str(len(content)), f"{where}: no length: {answer.headers}")
            tag = answer.headers["etag"]
            for first in firsts:
                asked = browser | {"Range": f"bytes={first}-", "If-Range": tag}
                part = served.request("GET", f"/runs/{run}/{where}", headers=asked, expect=206)
                must(part.headers["content-range"] == f"bytes {first}-{len(content) - 1}/{len(content)}", f"{where}: {part.headers}")
                must(part.body == content[first:], f"{where}: other bytes from {first} on")
            middle = served.request("GET", f"/runs/{run}/{where}", headers={"Range": "bytes=30-89"}, expect=206)
            must(middle.body == content[30:90], f"{where}: other bytes in the middle")
            other = served.request("GET", f"/runs/{run}/{where}", headers={"Range": "bytes=5-", "If-Range": '"other"'}, expect=200)
            must(other.body == content, f"{where}: a part of other bytes")
        # An archive that is cut and resumed: each byte is read once.
        served.kill()
        served.start()
        reads = lambda: int(re.search(r"rchar: (\d+)", Path(f"/proc/{served.process.pid}/io").read_text())[1])
        before, cut = reads(), 100_000_000
        connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=120)
        connection.request("GET", f"/api/v1/runs/{run}/archive", headers={"Cookie": shared})
        first = connection.getresponse().read(cut)
        connection.close()
        rest = served.request("GET", f"/runs/{run}/archive", headers={"Range": f"bytes={cut}-"}, expect=206).body
        must(first + rest == whole, "a resumed archive has other bytes")
        read = reads() - before
        print(f"    {read / len(whole):.2f} of the archive read for one that was resumed")
        must(read < 1.15 * len(whole), f"{read} bytes read for {len(whole)}")


def check_large():
    """A scene whose check takes too long (1e7 particles of a table) says that it was not checked, and is submitted; a large one that is
    quick to check is checked."""
    with server("--memory", "200000", "--disk", "1000000") as served:
        table = served.folder / "grains.csv"
        with open(table, "w") as file:
            file.write("x,y,z,radius\n")
            for k in range(1000):
                file.write("".join(f"{(k * 10_000 + n) * 0.01 + 0.005:.3f},0.5,0.5,0.0025\n" for n in range(10_000)))
        text = SCENE.split("[[walls]]")[0].replace("min      = [-0.032, 0.0, -0.032]", "min = [0.0, 0.0, 0.0]").replace("max      = [0.032, 0.008, 0.032]", "max = [1e5, 1.0, 1.0]")
        scene = {"name": "large.toml", "text": text + '[[particles]]\nfile = "grains.csv"\nmaterial = "glass"\n[output]\ninterval = 0.05\n',
                 "files": {"grains.csv": upload(served, table)}}
        begin = time.monotonic()
        found = served.json("POST", "/check", {"scene": scene})
        print(f"    given up after {time.monotonic() - begin:.0f} s")
        must(not found["problems"] and "more than 10 s" in found["unchecked"], f"checked: {found}")
        run = served.json("POST", "/runs", {"scene": scene}, expect=201)["id"]
        must(served.run(run)["state"] in ("queued", "running"), f"the run is {served.run(run)['state']}")
        served.request("POST", f"/runs/{run}/stop", {}, expect=200)
        served.request("POST", f"/runs/{run}/kill", {})
        many = SCENE.replace("number = 900", "number = 10_000_000").replace("max      = [0.032, 0.008, 0.032]", "max      = [0.032, 90.0, 0.032]").replace("along = [0.0, 0.008]", "along = [0.0, 90.0]")
        found = served.json("POST", "/check", {"scene": {"name": "many.toml", "text": many}})
        must(not found["problems"] and "unchecked" not in found and found["plan"]["particles"]["expected"] > 9e6, f"not checked: {found}")


# What a program in a cage tries: each line prints what it reached.
ATTEMPTS = """
import os, socket, sys
server, worker = sys.argv[1:]
def attempt(what, action):
    try:
        action()
    except OSError:
        return
    print(what)
for pid in ("1", server, worker):
    for name in ("environ", "cmdline", "maps", "fd"):
        path = f"/proc/{pid}/{name}"
        attempt(path, lambda: os.listdir(path) if name == "fd" else open(path, "rb").read())
attempt("/proc", lambda: os.listdir("/proc"))
for family in ("AF_INET", "AF_INET6", "AF_UNIX", "AF_NETLINK", "AF_PACKET"):
    for kind in ("SOCK_STREAM", "SOCK_DGRAM", "SOCK_RAW"):
        attempt(f"{family} {kind}", lambda: socket.socket(getattr(socket, family), getattr(socket, kind)))
attempt("a signal", lambda: os.kill(int(server), 0))
attempt("a link", lambda: os.symlink("/etc/passwd", "link"))
attempt("/etc/passwd", lambda: open("/etc/passwd").read())
attempt("the data", lambda: os.listdir(".."))
with open("program", "w") as file:
    file.write("#!/bin/sh\\necho executed\\n")
os.chmod("program", 0o700)
attempt("a program of its own", lambda: os.execv("./program", ["program"]))
"""


def check_cage():
    """A program in a cage reads nothing of other processes, has no socket (a rank of MPI those of the network), sends no signal, and has
    no capabilities."""
    python = os.path.realpath("/usr/bin/python3")
    if not os.path.exists(python):
        raise Skipped("/usr/bin/python3 is missing")
    def caged(folder, *words, options=()):
        done = subprocess.run([CLOUD, "confine", "--folder", str(folder), *options, "--", *words], capture_output=True, text=True, cwd=folder,
                              env={"PATH": "/usr/bin:/bin"})
        must(done.returncode == 0, f"{words[0]}: {done.stderr}")
        return done.stdout
    with server(environment={"A_SECRET": "of the server"}) as served:
        run = served.submit()
        [worker, *_] = wait_for(lambda: served.worker(run), 60, "no worker")
        folder = served.folder / "data/caged"
        folder.mkdir()
        reached = caged(folder, python, "-c", ATTEMPTS, str(served.process.pid), str(worker))
        must(reached == "", f"reached from a cage: {reached}")
        # A rank of MPI has sockets of the network, and no other ones.
        (folder / "program").unlink()
        reached = caged(folder, python, "-c", ATTEMPTS, str(served.process.pid), str(worker), options=["--mpi"])
        network = {f"{family} {kind}" for family in ("AF_INET", "AF_INET6") for kind in ("SOCK_STREAM", "SOCK_DGRAM")}
        must(set(reached.splitlines()) == network | {"AF_NETLINK SOCK_DGRAM", "AF_NETLINK SOCK_RAW"}, f"reached by a rank: {reached}")
        status = caged(folder, "/bin/cat", "/proc/self/status")
        def field(name):
            return re.search(rf"^{name}:\s+(\S+)", status, re.M)[1]
        must(int(field("CapEff"), 16) == int(field("CapPrm"), 16) == int(field("CapBnd"), 16) == 0 or os.geteuid() != 0, status)
        must((field("NoNewPrivs"), field("Seccomp")) == ("1", "2"), status)
        # The solver of a run is in such a cage.
        def parent(entry):
            # Programs of other checks come and go meanwhile.
            with contextlib.suppress(OSError):
                return (entry / "stat").read_text().rsplit(")", 1)[1].split()[1]
        found = [entry for entry in Path("/proc").iterdir() if entry.name.isdigit() and parent(entry) == str(worker)]
        must(found, "the worker has no solver")
        must(re.search(r"^Seccomp:\s+2", (found[0] / "status").read_text(), re.M), "the solver has no filter")
        served.wait(run)


def check_root():
    """Root is refused unless it names a user; server, workers and solvers run as that user, without groups and capabilities."""
    if os.geteuid() != 0:
        raise Skipped("this is not root")
    user = "daemon"
    with tempfile.TemporaryDirectory() as base:
        os.chmod(base, 0o755)
        data = Path(base) / "data"
        command = [CLOUD, "serve", "--port", "0", "--solver", SOLVE]
        for words, word in [([], "--user"), (["--user", "no such user"], "no such user"), (["--user", user], "--data")]:
            refused = subprocess.run([*command, *words], capture_output=True, text=True, env={"PATH": os.environ["PATH"], "HOME": base})
            must(refused.returncode == 2 and word in refused.stderr, f"{words}: {refused.returncode} {refused.stderr}")
    real, SERVE[:] = list(SERVE), [CLOUD, "serve", "--user", user]
    try:
        with server() as served:
            run = served.submit()
            [worker, *_] = wait_for(lambda: served.worker(run), 60, "no worker")
            for pid in (served.process.pid, worker):
                status = Path(f"/proc/{pid}/status").read_text()
                ids = [re.search(rf"^{name}:\s*(.*)", status, re.M)[1].split() for name in ("Uid", "Gid", "Groups", "CapEff")]
                must("0" not in ids[0] + ids[1] + ids[2] and int(ids[3][0], 16) == 0, f"{ids}")
            must((served.folder / "data").stat().st_uid != 0, "root owns the data")
            served.wait(run)
    finally:
        SERVE[:] = real


def check_projects():
    """The members of a project see its runs, and do with them what their role allows; its events reach them; others see nothing of it."""
    with server() as served:
        cookies = {"local": served.cookie}
        for name in ("ada", "bob", "eve"):
            served.request("POST", "/users", {"name": name, "password": "correct horse"}, expect=204)
        for name in ("ada", "bob", "eve"):
            served.cookie = None
            answer = served.request("POST", "/session", {"name": name, "password": "correct horse"}, expect=200)
            cookies[name] = answer.headers["set-cookie"].split(";")[0]

        @contextlib.contextmanager
        def user(name):
            before, served.cookie = served.cookie, cookies[name]
            yield
            served.cookie = before

        served.cookie = cookies["local"]
        project = served.json("POST", "/projects", {"name": "Sieves"}, 201)["id"]
        member = f"/projects/{project}/members/"
        served.request("PUT", member + "ada", {"role": "member"}, expect=204)
        served.request("PUT", member + "bob", {"role": "viewer"}, expect=204)
        served.request("PUT", member + "bob", {"role": "owner"}, expect=400)
        served.request("PUT", member + "carl", {"role": "viewer"}, expect=404)
        for change in ({"role": "viewer"}, None):
            served.request("PUT" if change else "DELETE", member + "local", change, expect=409)
        run = served.submit(sets=LONG, project=project)
        alone = served.submit(sets=SHORT)
        study = served.json("POST", "/studies", {"base": {"scene": {"text": SCENE}, "project": project}, "sweep": ["time.end=1e-5,2e-5"]}, 201)["id"]
        news = served.events(cookies["bob"])
        for name in ("ada", "bob"):
            with user(name):
                listed = [one["id"] for one in served.json("GET", f"/runs?project={project}")["runs"]]
                must(run in listed and alone not in listed and len(listed) == 3, f"{name} sees {listed}")
                must(served.json("GET", "/runs")["runs"] == [], "the runs of the project are not one's own")
                must([one["id"] for one in served.json("GET", f"/studies?project={project}")["studies"]] == [study], "the study is not listed")
                must(len(served.json("GET", f"/studies/{study}")["rows"]) == 2, "the table of the study")
                served.request("GET", f"/runs/{alone}", expect=404)
                must(served.run(run)["writable"] == (name == "ada") and served.run(run)["owner"] == "local", f"{served.run(run)}")
                served.request("PATCH", f"/runs/{run}", {"project": ""}, expect=403)
                served.request("PUT", member + "eve", {"role": "viewer"}, expect=403)
                served.request("DELETE", f"/projects/{project}", expect=403)
                wait_for(lambda: served.run(run)["state"] == "running", 60, "not running")
        with user("eve"):
            served.request("GET", f"/runs/{run}", expect=404)
            served.request("GET", f"/runs?project={project}", expect=404)
            served.request("GET", f"/events?runs={run}", expect=404)
        with user("bob"):
            for path, body in (("stop", {}), ("kill", {}), ("extend", {"end": 9.0}), ("share", {"days": 1})):
                served.request("POST", f"/runs/{run}/{path}", body, expect=403)
            served.request("DELETE", f"/runs/{run}", expect=403)
            served.request("PATCH", f"/runs/{run}", {"title": "x"}, expect=403)
            served.request("POST", "/runs", {"scene": {"text": SCENE}, "project": project}, expect=403)
            must("project" not in served.json("POST", f"/runs/{run}/clone", {}), "a viewer clones into the project")
        with user("ada"):
            served.json("POST", f"/runs/{run}/stop", {})
            served.wait(run, "stopped")
            cloned = served.json("POST", f"/runs/{run}/clone", {})
            must(cloned["project"] == project, f"{cloned}")
            hers = served.json("POST", "/runs", cloned | {"scene": cloned["scene"] | {"set": SHORT + ["time.end=1e-4"]}}, 201)["id"]
            served.wait(hers)
        with user("bob"):
            must(served.run(hers)["owner"] == "ada", "bob does not see the run of ada")
        wait_for(lambda: any(run in line and "stopped" in line for line in news()), 30, "bob did not hear that the run was stopped")
        # A member that leaves sees nothing any more; a project that is removed leaves its runs with their owners.
        with user("bob"):
            served.request("DELETE", member + "bob", expect=204)
            served.request("GET", f"/runs/{run}", expect=404)
        served.request("DELETE", f"/projects/{project}", expect=204)
        with user("ada"):
            served.request("GET", f"/runs/{run}", expect=404)
            must(served.run(hers)["project"] is None, "the project is still named")
        must(served.run(run)["state"] == "stopped" and served.json("GET", "/projects") == [], "the owner's run")


def check_prices():
    """Costs are core hours times the price of the queue, attempt by attempt; savings are against the full price."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "prices.toml"
        file.write_text('currency = "EUR"\non_demand = 3600\n[core_hour]\nlocal = 900\n')
        with server("--prices", str(file)) as served:
            must(served.json("GET", "/session")["price"] == {"currency": "EUR", "core_hour": 900.0}, "the session has no price")
            run = served.submit(sets=SHORT + ["time.end=0.05"])
            row = served.wait(run)
            must(row["core_seconds"] > 0, f"{row}")
            must(abs(row["cost"] - 0.25 * row["core_seconds"]) < 1e-9 and abs(row["saved"] - 0.75 * row["core_seconds"]) < 1e-9, f"{row}")
            must(sum(one["cost"] for one in served.attempts(run)) == row["cost"], f"{served.attempts(run)}")
            must(served.json("GET", "/session")["usage"]["cost"] == row["cost"], "the usage of the user")
        file.write_text('currency = "EUR"\n[core_hour]\nlocal = -1\n')
        refused = subprocess.run([*SERVE, "--data", folder, "--prices", str(file)], capture_output=True, text=True)
        must(refused.returncode == 2 and "local: -1" in refused.stderr, f"{refused}")


def check_quota():
    """A user with limits: never more cores at once, no run, study or input beyond the disk; deletion makes room again."""
    with server("--cores", "4") as served:
        def limits(**more):
            mine, served.cookie = served.cookie, admin
            served.request("POST", "/users", {"name": "ada"} | more, expect=204)
            served.cookie = mine
        admin = served.cookie
        # A new password would end the session.
        limits(cores=1, password="correct horse")
        served.cookie = None
        answer = served.request("POST", "/session", {"name": "ada", "password": "correct horse"}, expect=200)
        served.cookie = answer.headers["set-cookie"].split(";")[0]
        served.request("POST", "/runs", {"scene": {"text": SCENE}, "threads": 2}, expect=403)
        runs = [served.submit(sets=SHORT + ["time.end=0.05"]) for _ in range(3)]
        most = 0
        def over():
            nonlocal most
            states = [served.run(run)["state"] for run in runs]
            most = max(most, sum(state in ("running", "stopping") for state in states))
            return set(states) == {"finished"}
        wait_for(over, 120, "not finished")
        must(most == 1, f"{most} runs at once")
        usage = served.json("GET", "/session")["usage"]
        must(usage["disk"] > 100_000 and usage["most_cores"] == 1 and usage["core_seconds"] > 0, f"{usage}")
        limits(disk=usage["disk"] + 1000)
        detail = json.loads(served.request("POST", "/runs", {"scene": {"text": SCENE}}, expect=403).body)["detail"]
        must("Delete runs" in detail, detail)
        served.request("POST", "/studies", {"base": {"scene": {"text": SCENE}}, "sweep": ["seed=1,2"]}, expect=403)
        content = b"x" * 10_000
        digits = hashlib.sha256(content).hexdigest()
        served.request("PUT", f"/inputs/{digits}", content, {"Content-Type": "application/octet-stream"}, 403, raw=True)
        for run in runs:
            served.request("DELETE", f"/runs/{run}", expect=204)
        must(served.json("GET", "/session")["usage"]["disk"] < 50_000, "deleted runs still count")
        served.request("PUT", f"/inputs/{digits}", content, {"Content-Type": "application/octet-stream"}, 201, raw=True)
        served.request("GET", "/users", expect=403)
        served.cookie = admin
        must([one["usage"]["most_disk"] for one in served.json("GET", "/users") if one["name"] == "ada"] == [usage["disk"] + 1000], "limits of ada")


def check_hook():
    """The web hook of a user: each end of a run once, also where the server is killed meanwhile, with a signature that its receiver checks;
    again where the receiver fails; by https only with a certificate that the machine trusts; never into the network of the server, by
    whatever name; bounded in time; removed it is gone. On the account page, in the API and at the command line."""
    got, answers, slow = [], [], threading.Event()
    class Receiver(http.server.BaseHTTPRequestHandler):
        def do_POST(self):
            body = self.rfile.read(int(self.headers["Content-Length"]))
            got.append((dict(self.headers.items()), body))
            if self.path == "/slow":
                slow.wait(60)
            self.send_response(answers.pop(0) if answers else 204)
            self.send_header("Location", "/other")
            self.end_headers()
        def log_message(self, *_):
            pass
    receiver = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Receiver)
    threading.Thread(target=receiver.serve_forever, daemon=True).start()
    def signed(one, secret):
        headers, body = one
        expected = hmac.new(secret.encode(), headers["mercury-time"].encode() + b"." + body, "sha256").hexdigest()
        must(headers["mercury-signature"] == f"sha256={expected}", f"another signature: {headers}")
        must(abs(time.time() - int(headers["mercury-time"])) < 30, f"another time: {headers}")
        message = json.loads(body)
        must(str(message["delivery"]) == headers["mercury-delivery"], f"{headers} {message}")
        return message
    # A certificate that the machine trusts, and one that it does not.
    folder = Path(tempfile.mkdtemp(prefix="accept-hook-"))
    for name in ("good", "bad"):
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj", f"/CN={name}",
                        "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1", "-addext", "basicConstraints=critical,CA:FALSE",
                        "-keyout", folder / f"{name}.key", "-out", folder / f"{name}.pem"], check=True, capture_output=True)
    def secure(name):
        https = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Receiver)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(folder / f"{name}.pem", folder / f"{name}.key")
        https.socket = context.wrap_socket(https.socket, server_side=True)
        threading.Thread(target=https.serve_forever, daemon=True).start()
        return f"https://localhost:{https.server_port}/"
    here = f"http://127.0.0.1:{receiver.server_port}"
    trust = {"SSL_CERT_FILE": str(folder / "good.pem")}
    title = 'a "title" of <b>mine</b>'
    with server("--hooks-to", "127.0.0.1", "--hooks-to", "localhost", environment=trust) as served:
        cloud = lambda *words: subprocess.run([CLOUD, "hook", *words, "--link", served.link], check=True, capture_output=True, text=True).stdout.strip()
        must("hook set URL" in cloud(), cloud())
        served.request("POST", "/hook/test", {}, expect=404)
        secret = cloud("set", f"{here}/x")
        must(re.fullmatch("[0-9a-f]{64}", secret) and secret not in json.dumps(served.json("GET", "/hook")), "a secret that is shown again")
        cloud("test")
        wait_for(lambda: len(got) == 1, 20, "no test")
        must(signed(got[0], secret)["state"] == "test", f"{got}")
        # Ends while the server is away: one message each.
        runs = [served.submit(sets=SHORT + ["time.end=0.02"], title=title) for _ in range(3)]
        wait_for(lambda: any(served.worker(run) for run in runs), 60, "no worker")
        served.kill()
        served.start()
        for run in runs:
            served.wait(run)
        wait_for(lambda: len(got) >= 4, 30, f"{len(got) - 1} messages of 3")
        served.kill()
        served.start()
        time.sleep(2)
        messages = [signed(one, secret) for one in got[1:]]
        must(sorted(one["run"] for one in messages) == sorted(runs), f"not one message for each run: {messages}")
        must(all(one["state"] == "finished" and one["title"] == title and one["owner"] == "local" for one in messages), f"{messages}")
        must(all(one["link"] == f"http://127.0.0.1:{served.port}/runs/{one['run']}" for one in messages), f"{messages}")
        log = served.json("GET", "/hook")["deliveries"]
        must([one["status"] for one in log] == [204] * 4 and all(one["next"] is None and one["tries"] == 1 for one in log), f"{log}")
        must("delivered" in cloud(), cloud())
        # A receiver that fails, and one that redirects: again, with the same number and a new time.
        answers += [500, 302]
        cloud("test")
        wait_for(lambda: len(got) == 7, 30, "not tried again")
        must(len({signed(one, secret)["delivery"] for one in got[4:]}) == 1, "another number")
        wait_for(lambda: served.json("GET", "/hook")["deliveries"][0]["next"] is None, 10, "not over")
        must(served.json("GET", "/hook")["deliveries"][0]["tries"] == 3, f"{served.json('GET', '/hook')['deliveries'][0]}")
        # One that does not answer holds nothing up.
        served.json("PUT", "/hook", {"url": f"{here}/slow"})
        served.json("POST", "/hook/test", {})
        served.request("POST", "/hook/test", {}, expect=409)
        wait_for(lambda: "10 s" in served.json("GET", "/hook")["deliveries"][0]["message"], 30, "no end of waiting")
        slow.set()
        # By https.
        count = len(got)
        secret = served.json("PUT", "/hook", {"url": secure("good")})["secret"]
        wait_for(lambda: len(got) > count, 60, "no message by https")
        signed(got[-1], secret)
        served.json("PUT", "/hook", {"url": secure("bad")})
        wait_for(lambda: served.json("GET", "/hook")["deliveries"][0]["next"] is None, 30, "not over")
        count = len(got)
        served.json("POST", "/hook/test", {})
        wait_for(lambda: "ertificate" in served.json("GET", "/hook")["deliveries"][0]["message"], 30, f"{served.json('GET', '/hook')['deliveries'][0]}")
        must(len(got) == count, "a message to a server that is not trusted")
        cloud("rm")
        must(served.json("GET", "/hook") == {"url": None, "deliveries": []}, "the hook is still there")
        # What looks only changes nothing; guests have none.
        token = served.json("POST", "/tokens", {"name": "looks", "read_only": True}, expect=201)["secret"]
        served.request("PUT", "/hook", {"url": f"{here}/x"}, {"Authorization": f"Bearer {token}"}, expect=403)
    # Without --hooks-to: nothing in this network, before and after names are resolved.
    count = len(got)
    with server(environment=trust) as served:
        for url in (here, "http://example.org/", "https://127.0.0.1/", "https://[::1]/", "https://169.254.169.254/latest", "https://10.0.0.1/", "https://a@b/", "file:///etc/passwd", "https://" + "x" * 2000):
            served.request("PUT", "/hook", {"url": url}, expect=400)
        for url in (secure("good"), secure("good").replace("localhost", "2130706433"), secure("good").replace("localhost", "0x7f.1")):
            served.json("PUT", "/hook", {"url": url})
            served.json("POST", "/hook/test", {})
            wait_for(lambda: "--hooks-to" in served.json("GET", "/hook")["deliveries"][0]["message"], 30, f"{url}: {served.json('GET', '/hook')}")
            served.request("DELETE", "/hook", expect=204)
        must(len(got) == count, "a message into the network of the server")
    receiver.shutdown()
    shutil.rmtree(folder)


def check_time():
    """Runs stop at the core hours of their user and at their own limit of time, say so, and go on when they may; deletion gives no core
    hours back; the command at the end of runs has each once, whatever their titles are."""
    folder = Path(tempfile.mkdtemp(prefix="accept-end-"))
    command = f'printf "%s|%s|%s|%s\\n" "$MERCURY_STATE" "$MERCURY_OWNER" "$MERCURY_TITLE" "$MERCURY_LINK" >> {folder}/ended; echo "$MERCURY_MESSAGE" >> {folder}/messages'
    with server("--cores", "2", "--at-end", command) as served:
        lines = lambda: (folder / "ended").read_text().splitlines() if (folder / "ended").exists() else []
        admin = served.cookie
        def limit(**more):
            mine, served.cookie = served.cookie, admin
            served.request("POST", "/users", {"name": "ada"} | more, expect=204)
            served.cookie = mine
        # The limit of a run: it stops, goes on for as long again, and stops again.
        title = f"$(touch {folder}/broken) `touch {folder}/broken`; 'x"
        endless = ["time.end=500", "output.interval=0.05", "output.pictures=false"]
        run = served.submit(sets=endless, title=title, time_limit=4)
        found = served.wait(run, "stopped", 90)
        must("limit" in found["message"] and found["step"] > 0 and found["time_limit"] == 4, f"{found}")
        served.json("POST", f"/runs/{run}/resume", {})
        again = served.wait(run, "stopped", 90)
        must(again["step"] > found["step"] and "limit" in again["message"], f"not as long again: {again}")
        must(again["core_seconds"] < 40, f"{again['core_seconds']} core seconds of 8")
        must(served.json("POST", f"/runs/{run}/clone", {})["time_limit"] == 4, "the clone has no limit")
        wait_for(lambda: len(lines()) == 2, 10, f"not two ends: {lines()}")
        must(all(line == f"stopped|local|{title}|http://127.0.0.1:{served.port}/runs/{run}" for line in lines()), f"{lines()}")
        must(not (folder / "broken").exists(), "a title was executed")
        must("limit" in (folder / "messages").read_text(), "no message")
        served.request("POST", "/runs", {"scene": {"text": SCENE}, "time_limit": 0}, expect=400)
        # The core hours of a user, of all runs together.
        limit(password="correct horse", core_seconds=6)
        served.cookie = None
        answer = served.request("POST", "/session", {"name": "ada", "password": "correct horse"}, expect=200)
        served.cookie = answer.headers["set-cookie"].split(";")[0]
        runs = [served.submit(sets=endless) for _ in range(2)] + [served.submit(sets=endless)]
        for run in runs:
            wait_for(lambda: served.run(run)["state"] in ("stopped", "cancelled"), 90, f"not stopped: {served.run(run)}")
            must("core hours" in served.run(run)["message"], f"{served.run(run)}")
        usage = served.json("GET", "/session")["usage"]
        must(usage["most_core_seconds"] == 6 and 6 <= usage["core_seconds"] < 40, f"{usage}")
        for path, body in ((f"/runs/{runs[0]}/resume", {}), ("/runs", {"scene": {"text": SCENE}}), ("/studies", {"base": {"scene": {"text": SCENE}}, "sweep": ["seed=1,2"]})):
            must("core hours" in served.request("POST", path, body, expect=403).body.decode(), path)
        served.request("DELETE", f"/runs/{runs[0]}", expect=204)
        must(served.json("GET", "/session")["usage"]["core_seconds"] >= usage["core_seconds"] - 0.01, "deletion gives core hours back")
        limit(core_seconds=None)
        served.json("POST", f"/runs/{runs[1]}/resume", {})
        served.wait(runs[1], "running", 30)
        served.request("POST", f"/runs/{runs[1]}/stop", {}, expect=200)
        served.wait(runs[1], "stopped", 60)
        must("core hours" not in served.run(runs[1])["message"], "an old message stays")
    shutil.rmtree(folder)


def mesh_of(path, n):
    """A binary STL of a wavy surface in 2 * n^2 triangles, within the drum."""
    import struct
    def at(i, j):
        return (0.004 * i / n, 0.004 * j / n, 0.001 + 0.0001 * ((i + j) % 7) / 7)
    with open(path, "wb") as file:
        file.write(b"\0" * 80 + struct.pack("<I", 2 * n * n))
        for i in range(n):
            for j in range(n):
                for three in ((at(i, j), at(i + 1, j), at(i, j + 1)), (at(i + 1, j), at(i + 1, j + 1), at(i, j + 1))):
                    file.write(struct.pack("<12fH", 0, 0, 0, *(c for corner in three for c in corner), 0))


def check_previews():
    """A preview and the walls of a mesh of 204,800 triangles: less than 150 MB in the server, at most 200,000 triangles."""
    with server() as served:
        path = served.folder / "large.stl"
        mesh_of(path, 320)
        text = SCENE + '\n[[walls]]\nname = "plate"\nshape = "mesh"\nfile = "large.stl"\nmaterial = "glass"\n'
        scene = {"text": text, "files": {"large.stl": upload(served, path)}, "set": [*SHORT, "time.end=1e-5"]}
        before = memory_of(served, "VmRSS")
        seen = served.json("POST", "/preview", {"scene": scene})
        shown, of = seen["walls"]["triangles"]
        must(of > 204_800 and 50_000 < shown <= 200_000, f"{shown} of {of} triangles")
        must(sum(len(wall["corners"]) for wall in seen["walls"]["walls"]) == 9 * shown, "other triangles than it says")
        must(len(seen["grains"]) == 4 and seen["domain"], f"{str(seen)[:200]}")
        # On a busy machine a check of so many triangles may take longer than it may.
        def submitted():
            answer = served.request("POST", "/runs", {"scene": scene})
            return answer.status == 201 and json.loads(answer.body)["id"]
        run = wait_for(submitted, 120, "the run is not taken")
        served.wait(run)
        walls = served.json("GET", f"/runs/{run}/frames/0/walls")
        must(walls["triangles"] == [shown, of], f"{walls['triangles']}")
        served.request("GET", f"/runs/{run}/frames/999/walls", expect=404)
        more = memory_of(served) - before
        print(f"    {more} kB of memory more, {shown} of {of} triangles")
        must(more < 150_000, "too much memory")


def check_limits():
    """Parallel uploads, parallel runs and extensions never exceed a limit of disk; a run beyond it stops, says why, and can be resumed."""
    with server("--cores", "2") as served:
        def limit(disk, **more):
            mine, served.cookie = served.cookie, served.admin
            served.request("POST", "/users", {"name": "ada", "disk": disk} | more, expect=204)
            served.cookie = mine
        # A new password would end the session.
        limit(20_000_000, password="correct horse")
        answer = served.request("POST", "/session", {"name": "ada", "password": "correct horse"}, expect=200)
        served.cookie = ada = answer.headers["set-cookie"].split(";")[0]
        def at_once(one, count):
            answers = []
            def answer(k):
                try:
                    answers.append(one(k).status)
                except OSError:
                    # Refused and cut before all of the body was sent.
                    answers.append(403)
            threads = [threading.Thread(target=answer, args=(k,)) for k in range(count)]
            [thread.start() for thread in threads]
            [thread.join() for thread in threads]
            return answers
        def put(k):
            content = bytes([k]) * 5_000_000
            return served.request("PUT", f"/inputs/{hashlib.sha256(content).hexdigest()}", content, {"Content-Type": "application/octet-stream"}, raw=True)
        statuses = at_once(put, 10)
        used = served.json("GET", "/session")["usage"]["disk"]
        must(set(statuses) == {201, 403} and statuses.count(201) in (3, 4) and used <= 20_000_000, f"uploads: {statuses}, {used} bytes")
        # Each of these runs is expected to take a third of what is left.
        needs = served.json("POST", "/check", {"scene": {"text": SCENE, "set": LONG}})["plan"]["disk"]["bytes"]
        limit(used + int(3.5 * needs) + 10_000)
        statuses = at_once(lambda k: served.request("POST", "/runs", {"scene": {"text": SCENE, "set": LONG}}), 6)
        runs = [run["id"] for run in served.json("GET", "/runs")["runs"]]
        must(statuses.count(201) == len(runs) == 3 and statuses.count(403) == 3, f"runs: {statuses}")
        run, *others = runs
        for other in others:
            served.request("POST", f"/runs/{other}/kill", {}, expect=200)
        wait_for(lambda: committed(served, run) > 0, 60, "no checkpoint")
        limit(used)
        wait_for(lambda: served.run(run)["state"] == "failed", 60, "not stopped")
        found = served.run(run)
        must(found["cause"] == "disk" and "make room" in found["message"], f"{found['cause']}: {found['message']}")
        served.request("POST", f"/runs/{run}/resume", {}, expect=403)
        limit(10**9)
        served.json("POST", f"/runs/{run}/resume", {})
        served.wait(run)
        usage = served.json("GET", "/session")["usage"]["disk"]
        limit(usage + 100_000)
        answer = served.request("POST", f"/runs/{run}/extend", {"end": 1000.0}, expect=403)
        must("live runs" in json.loads(answer.body)["detail"], f"{answer.body}")
        must(served.run(run)["spec"]["revision"] == 1, "the extension was made")
        # Of extensions at once one is accepted, and the run ends where that one says.
        limit(10**9)
        ends = {}
        def extend(k):
            answer = served.request("POST", f"/runs/{run}/extend", {"end": 0.41 + 0.01 * k})
            ends[answer.status] = ends.get(answer.status, []) + [0.41 + 0.01 * k]
            return answer
        statuses = at_once(extend, 4)
        must(statuses.count(200) == 1 and statuses.count(409) == 3, f"extensions: {statuses}")
        served.wait(run)
        must(abs(served.run(run)["time"] - ends[200][0]) < 1e-3, f"ends at {served.run(run)['time']}, accepted {ends[200]}")
        # Files of a run of another user, the state that a run starts from, and texts of scenes count, too.
        project = served.json("POST", "/projects", {"name": "p"}, 201)["id"]
        served.request("PATCH", f"/runs/{run}", {"project": project}, expect=200)
        served.cookie = served.admin
        served.request("POST", "/users", {"name": "bea", "disk": 100, "password": "correct horse"}, expect=204)
        served.cookie = ada
        served.request("PUT", f"/projects/{project}/members/bea", {"role": "member"}, expect=204)
        answer = served.request("POST", "/session", {"name": "bea", "password": "correct horse"}, expect=200)
        served.cookie = answer.headers["set-cookie"].split(";")[0]
        served.request("POST", f"/runs/{run}/clone", {}, expect=403)
        from_run = {"scene": {"name": "from.toml", "text": FROM_RUN.replace("RUN", run)}}
        served.request("POST", "/check", from_run, expect=403)
        limit = {"name": "bea", "disk": int(needs) + 100}
        bea, served.cookie = served.cookie, served.admin
        served.request("POST", "/users", limit, expect=204)
        served.cookie = bea
        served.request("POST", "/runs", {"scene": {"text": SCENE, "set": LONG}}, expect=403)
        must(served.json("GET", "/session")["usage"]["disk"] == 0, "what was refused counts")
        must(served.json("GET", "/inputs") == [], "what was refused is an input")


def check_inputs():
    """Inputs are listed and deleted, unless a run names them, and go with the last run that does."""
    with server() as served:
        path = served.folder / "spare.stl"
        path.write_bytes(os.urandom(100_000))
        digits = upload(served, path)
        kept = served.folder / "data/store/inputs" / digits
        def rows():
            return {row["sha256"]: row["runs"] for row in served.json("GET", "/inputs")}
        must(rows() == {digits: 0} and kept.exists(), f"{rows()}")
        served.request("DELETE", f"/inputs/{digits}", expect=204)
        must(rows() == {} and not kept.exists(), "a deleted input is still there")
        served.request("DELETE", f"/inputs/{digits}", expect=404)
        upload(served, path)
        scene = {"name": "drum.toml", "text": SCENE, "set": [*SHORT, "time.end=0.001"], "files": {"spare.stl": digits}}
        runs = [served.json("POST", "/runs", {"scene": scene}, 201)["id"] for _ in range(2)]
        [served.wait(run) for run in runs]
        served.request("DELETE", f"/inputs/{digits}", expect=409)
        clone = served.json("POST", f"/runs/{runs[0]}/clone", {})
        must(clone["scene"] == scene, f"the clone has another scene: {clone['scene']['set']}")
        served.request("DELETE", f"/runs/{runs[0]}", expect=204)
        must(rows()[digits] == 1 and kept.exists(), "an input goes before its last run")
        served.request("DELETE", f"/runs/{runs[1]}", expect=204)
        must(rows() == {} and not kept.exists(), f"an input outlives its runs: {rows()}")
        must(served.json("GET", "/session")["usage"]["disk"] == 0, "disk that is not given back")
        # Of requests at once that send and remove one content none leaves a row without it, or it without a row.
        for _ in range(20):
            work = [lambda: upload(served, path), lambda: served.request("DELETE", f"/inputs/{digits}")] * 3
            threads = [threading.Thread(target=one) for one in work]
            [thread.start() for thread in threads]
            [thread.join() for thread in threads]
            must((digits in rows()) == kept.exists(), f"listed: {rows()}, in the store: {kept.exists()}")


def check_csrf():
    """Unsafe requests from another page get 403, requests for another host 421."""
    with server() as served:
        tried = 0
        for path, methods in paths(served).items():
            for method in set(methods) - {"get"}:
                path = path.replace("{run}", "0" * 32).replace("{sha256}", "0" * 64).replace("{id}", "1")
                for headers in [{"Origin": "http://evil.example", "Sec-Fetch-Site": "cross-site"}, {"Sec-Fetch-Site": "cross-site"},
                                {"Sec-Fetch-Site": "same-site"}, {"Sec-Fetch-Site": "none"}]:
                    answer = served.request(method.upper(), path, {}, headers)
                    must(answer.status == 403, f"{method} {path} {headers}: {answer.status}")
                answer = served.request(method.upper(), path, {}, {"Host": "evil.example"})
                must(answer.status == 421, f"{method} {path}: {answer.status}")
                tried += 1
        must(tried >= 10, f"{tried} paths")
        served.request("GET", "/runs", headers={"Host": f"evil.example:{served.port}"}, expect=421)


def check_watchers():
    """200 listeners for 60 s on a run, 20 of which read nothing: p99 of the delay under 250 ms, under 100 MB."""
    seconds = float(os.environ.get("ACCEPT_SECONDS", 60))
    with server() as served:
        run = served.submit(sets=["time.end=4", "output.interval=0.01", "output.pictures=false"])
        wait_for(lambda: served.worker(run), 30, "no worker")
        delays, stop = [], time.monotonic() + seconds
        def listen(reads):
            with socket.create_connection(("127.0.0.1", served.port)) as raw:
                raw.sendall(f"GET /api/v1/events?runs={run} HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: {served.cookie}\r\n\r\n".encode())
                raw.settimeout(1)
                rest = b""
                while time.monotonic() < stop:
                    if not reads:
                        time.sleep(0.5)
                        continue
                    try:
                        rest += raw.recv(1 << 16)
                    except TimeoutError:
                        continue
                    *lines, rest = rest.split(b"\n")
                    for line in lines:
                        if line.startswith(b"data: {") and b'"progress"' in line:
                            delays.append(time.time() - json.loads(line[6:])["time"])
        threads = [threading.Thread(target=listen, args=(k >= 20,)) for k in range(200)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        memory = [line for line in Path(f"/proc/{served.process.pid}/status").read_text().splitlines() if line.startswith("VmHWM")]
        must(len(delays) > 180 * seconds / 5, f"{len(delays)} messages")
        p99 = sorted(delays)[int(0.99 * len(delays))]
        print(f"    {len(delays)} messages, p99 {1000 * p99:.0f} ms, {memory}")
        must(p99 < 0.25, "too slow")
        must(int(memory[0].split()[1]) < 100_000, "too large")


def check_start():
    """The server is up in less than 1 s and takes less than 40 MB."""
    with server() as served:
        served.kill()
        begin = time.monotonic()
        served.start()
        seconds = time.monotonic() - begin
        memory = [line for line in Path(f"/proc/{served.process.pid}/status").read_text().splitlines() if line.startswith("VmRSS")]
        print(f"    {seconds:.2f} s, {memory}")
        must(seconds < 1, "slow")
        must(int(memory[0].split()[1]) < 40_000, "large")


def check_second_server():
    """A second server on the same data is refused; servers of one machine on other ports share no cookie."""
    with server() as served:
        command = [*SERVE, "--data", str(served.folder / "data"), "--port", "0", "--solver", SOLVE]
        second = subprocess.run(command, capture_output=True, text=True, timeout=20)
        must(second.returncode == 1 and "another server" in second.stderr, f"{second}")
        with server() as other:
            # A browser sends the cookies of a host to all of its ports.
            both = {"Cookie": f"{served.cookie}; {other.cookie}"}
            names = {one.cookie.split("=")[0] for one in (served, other)}
            must(len(names) == 2, f"one cookie of two servers: {names}")
            [one.request("GET", "/session", headers=both, expect=200) for one in (served, other)]


@contextlib.contextmanager
def cluster():
    """Slurm with two nodes of one core on this machine: a folder, and the environment with which programs of Slurm find it."""
    if not all(map(shutil.which, ["slurmctld", "slurmd", "squeue", "munged"])):
        raise Skipped("Slurm is not installed")
    folder, here = Path(tempfile.mkdtemp(prefix="accept-slurm-")), Path(__file__).parent
    folder.chmod(0o755)
    try:
        subprocess.run([here / "slurm-up.sh", folder / "slurm"], check=True)
        yield folder, {"SLURM_CONF": str(folder / "slurm/etc/slurm.conf"), "PATH": f"{folder}/bin:{os.environ['PATH']}"}
    finally:
        subprocess.run([here / "slurm-down.sh", folder / "slurm"])
        time.sleep(1)
        shutil.rmtree(folder, ignore_errors=True)


def check_slurm():
    """Slurm: drained with SIGTERM, a worker killed, the controller restarted, stopped and resumed, a node killed, a limit of
    time, a study; the same bytes, and at most one squeue in 10 s."""
    with cluster() as (folder, environment):
        reference = alone()
        (folder / "bin").mkdir()
        def counted(name):
            """A file that gets a line for each call of a program."""
            count, wrapper = folder / f"bin/{name}.count", folder / f"bin/{name}"
            wrapper.write_text(f'#!/bin/sh\necho x >> {count}\nexec {shutil.which(name)} "$@"\n')
            wrapper.chmod(0o755)
            return count
        count, submissions = counted("squeue"), counted("sbatch")
        # Longer than the minute that a job has below, less its grace.
        longer = ["time.end=6", "output.interval=0.02", "output.pictures=false"]
        def stepd(entry, folder):
            with contextlib.suppress(OSError):
                return b"slurmstepd" in (entry / "cmdline").read_bytes() and str(folder).encode() in (entry / "environ").read_bytes()
        site = folder / "site.toml"
        site.write_text("grace = 60\npoll = 10.0\n")
        slurm = lambda *words: subprocess.run(words, env=dict(os.environ) | environment, check=True, capture_output=True, text=True).stdout
        begin = time.monotonic()
        with server("--slurm", str(site), environment=environment) as served:
            run = served.submit(sets=LONG)
            wait_for(lambda: committed(served, run) > 0, 120, "no checkpoint")
            job, node = slurm(shutil.which("squeue"), "-h", "-t", "R", "-o", "%i %N").split()
            slurm("scontrol", "update", f"nodename={node}", "state=drain", "reason=test")
            slurm("scancel", "--signal=TERM", "--batch", job)
            wait_for(lambda: served.attempts(run)[0]["ended"], 60, "the attempt did not end")
            must(served.attempts(run)[0]["cause"] in ("preempted", "finished"), f"{served.attempts(run)}")
            os.kill(int((folder / "slurm/run/ctld.pid").read_text()), signal.SIGTERM)
            time.sleep(2)
            slurm("slurmctld")
            served.wait(run, seconds=240)
            slurm("scontrol", "update", f"nodename={node}", "state=resume")
            served.same_as_alone(run, reference)
            second = served.submit(sets=LONG)
            worker = wait_for(lambda: served.worker(second), 120, "no worker")[0]
            time.sleep(1)
            os.kill(worker, signal.SIGKILL)
            wait_for(lambda: served.attempts(second)[0]["ended"], 120, "the lost attempt was not seen")
            must(served.attempts(second)[0]["cause"] in ("lost", "engine"), f"{served.attempts(second)}")
            wait_for(lambda: served.worker(second), 120, "no second worker")
            served.json("POST", f"/runs/{second}/stop", {})
            wait_for(lambda: served.run(second)["state"] in ("stopped", "finished"), 90, "not stopped")
            if served.run(second)["state"] == "stopped":
                served.json("POST", f"/runs/{second}/resume", {})
            served.wait(second, seconds=240)
            served.same_as_alone(second, reference)
            seconds = time.monotonic() - begin
            calls = len(count.read_text().splitlines())
            print(f"    {calls} calls of squeue in {seconds:.0f} s")
            must(calls <= seconds / 10 + 3, "too many calls of squeue")
            # A node that dies: its daemon and all that it has started.
            third = served.submit(sets=longer)
            wait_for(lambda: committed(served, third) > 0, 120, "no checkpoint")
            node = slurm(shutil.which("squeue"), "-h", "-t", "R", "-o", "%N").split()[0]
            daemon = int((folder / f"slurm/run/{node}.pid").read_text())
            steps = [int(entry.name) for entry in Path("/proc").iterdir() if entry.name.isdigit() and stepd(entry, folder)]
            for pid in [daemon, *steps, *served.worker(third)]:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            wait_for(lambda: len(served.attempts(third)) == 2, 180, "no second attempt")
            must(served.attempts(third)[0]["cause"] in ("lost", "engine"), f"{served.attempts(third)}")
            slurm("slurmd", "-N", node)
            # Many small runs of a study.
            begin, before = time.monotonic(), len(count.read_text().splitlines())
            arrays = len(submissions.read_text().splitlines())
            number = int(os.environ.get("ACCEPT_RUNS", 40))
            files = {path.name: upload(served, path) for path in [PARTICLES] if f'"{path.name}"' in SPHERES}
            values = ",".join(repr(100.0 + k) for k in range(number))
            base = {"scene": {"name": "two.toml", "text": SPHERES, "set": SHORT, "files": files}}
            study = served.json("POST", "/studies", {"base": base, "sweep": [f"materials.0.normal.dissipation={values}"]}, 201)["id"]
            wait_for(lambda: served.json("GET", f"/studies/{study}")["states"].get("finished") == number, 900, "the study is not finished")
            served.wait(third, seconds=240)
            served.same_as_alone(third, alone(longer))
            seconds, calls = time.monotonic() - begin, len(count.read_text().splitlines()) - before
            arrays = len(submissions.read_text().splitlines()) - arrays
            print(f"    {number} runs of a study in {seconds:.0f} s, {calls} calls of squeue, {arrays} of sbatch")
            must(arrays <= 5, "a study is no array")
            must(calls <= seconds / 10 + 3, "too many calls of squeue")
        # A limit of one minute: SIGTERM 30 s before it, and another job.
        site.write_text('grace = 30\npoll = 10.0\ntime = "1"\n')
        with server("--slurm", str(site), environment=environment) as served:
            run = served.submit(sets=longer)
            served.wait(run, seconds=400)
            causes = [attempt["cause"] for attempt in served.attempts(run)]
            print(f"    with a limit of one minute: {', '.join(causes)}")
            must(causes[0] == "preempted" and causes[-1] == "finished", f"causes: {causes}")
            served.same_as_alone(run, alone(longer))


def check_slurm_ranks():
    """Ranks of MPI under Slurm, on two nodes, each in its cage: too many are refused, and a solver without MPI; a run is stopped and resumed
    on one rank; a rank is killed; the same bytes as the solver alone."""
    if "with MPI" not in subprocess.run([SOLVE, "--version"], capture_output=True, text=True).stdout:
        raise Skipped("mercury-solve was built without MPI")
    with cluster() as (folder, environment):
        reference = alone()
        site = folder / "site.toml"
        site.write_text("grace = 60\npoll = 2.0\n[ranks]\nmost = 2\n")
        without = folder / "mercury-solve"
        without.write_text("#!/bin/sh\necho mercury-solve 1.0\n")
        without.chmod(0o755)
        refused = subprocess.run([*SERVE, "--data", str(folder / "data"), "--port", "0", "--slurm", str(site), "--solver", str(without)],
                                 capture_output=True, text=True, timeout=60)
        must(refused.returncode == 1 and "without MPI" in refused.stderr, f"{refused}")
        with server("--slurm", str(site), environment=environment | {"A_SECRET": "of the server"}) as served:
            def ranks(run):
                """The solvers of a run."""
                found = []
                for entry in Path("/proc").iterdir():
                    with contextlib.suppress(OSError):
                        if run in os.readlink(entry / "cwd") and (entry / "cmdline").read_bytes().startswith(b"mercury-solve\0"):
                            found.append(entry)
                return found
            def begin():
                run = served.submit(sets=LONG, ranks=2)
                wait_for(lambda: committed(served, run) > 0, 180, "no checkpoint")
                found = ranks(run)
                must(len(found) == 2, f"{len(found)} ranks")
                return run, found
            must(served.json("GET", "/session")["ranks"] == 2, "ranks are not offered")
            more = served.request("POST", "/runs", {"scene": {"text": SCENE}, "ranks": 3}, expect=400).body
            must(b"1 to 2 ranks" in more, f"{more}")
            run, found = begin()
            for entry in found:
                must(re.search(r"^Seccomp:\s+2", (entry / "status").read_text(), re.M), "a rank has no filter of system calls")
                must(b"A_SECRET" not in (entry / "environ").read_bytes(), "the environment of the server")
            served.json("POST", f"/runs/{run}/stop", {})
            found = served.wait(run, "stopped", seconds=120)
            must(found["cause"] == "user" and found["core_seconds"] > 1 and found["time"] < 0.4, f"{found}")
            found = served.json("POST", f"/runs/{run}/resume?ranks=1", {})
            must(found["ranks"] == 1, f"{found}")
            served.wait(run)
            served.same_as_alone(run, reference)
            # A rank that is lost.
            run, found = begin()
            os.kill(int(found[-1].name), signal.SIGKILL)
            wait_for(lambda: served.attempts(run)[0]["ended"], 120, "the attempt did not end")
            must(served.attempts(run)[0]["cause"] == "lost", f"{served.attempts(run)}")
            served.wait(run)
            must(served.run(run)["ranks"] == 2, "it went on with other ranks")
            served.same_as_alone(run, reference)
            with contextlib.suppress(Skipped):
                browser("ranks.mjs", served.link)
            # At once.
            run, found = begin()
            served.json("POST", f"/runs/{run}/kill", {})
            served.wait(run, "stopped", seconds=60)
            wait_for(lambda: not ranks(run), 30, "ranks that go on")


# Stands for `sbatch`, `squeue` and `scancel`: jobs wait while there is a file `hold`, and then run.
SLURM = """
import json, os, pathlib, signal, subprocess, sys
folder, (name, *words) = pathlib.Path(sys.argv[0]).parent, [pathlib.Path(sys.argv[0]).name, *sys.argv[1:]]
def jobs():
    return sorted((json.loads(path.read_text()) for path in folder.glob("job.*")), key=lambda job: job["id"])
def keep(job):
    (folder / f"job.{job['id']}").write_text(json.dumps(job))
def look(job):
    if job["state"] == "PENDING" and not (folder / "hold").exists():
        script = folder / f"script.{job['id']}"
        script.write_text(job["script"])
        out = open(folder / "out", "a")
        job |= {"state": "RUNNING", "pid": subprocess.Popen(["sh", script], stdout=out, stderr=out, start_new_session=True).pid}
    if job["state"] == "RUNNING":
        try:
            state = pathlib.Path(f"/proc/{job['pid']}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except OSError:
            state = "Z"
        job["state"] = "COMPLETED" if state == "Z" else "RUNNING"
    keep(job)
    return job
if name == "sbatch":
    job = {"id": len(jobs()) + 1, "name": [word[11:] for word in words if word.startswith("--job-name=")][0], "state": "PENDING"}
    keep(job | {"script": sys.stdin.read()})
    print(job["id"])
elif name == "squeue":
    for job in map(look, jobs()):
        print(f"{job['id']}|{job['name']}|{job['state']}|Resources|n1|0:00")
else:
    [job] = [job for job in jobs() if str(job["id"]) == words[-1]]
    if job["state"] == "PENDING" and len(words) == 1:
        keep(job | {"state": "CANCELLED"})
    elif job["state"] == "RUNNING" and len(words) == 1:
        os.killpg(job["pid"], signal.SIGKILL)
    elif job["state"] == "RUNNING":
        os.kill(job["pid"], signal.SIGTERM)
"""


def check_slurm_stop():
    """A job of Slurm that waits shows the reason; Stop and End of one that waits or runs take effect within 10 s, by the user."""
    folder = Path(tempfile.mkdtemp(prefix="accept-slurm-"))
    try:
        for name in ("sbatch", "squeue", "scancel"):
            (folder / name).write_text(f"#!{sys.executable}\n{SLURM}")
            (folder / name).chmod(0o755)
        site = folder / "site.toml"
        site.write_text("poll = 1.0\n")
        with server("--slurm", str(site), environment={"PATH": f"{folder}:{os.environ['PATH']}"}) as served:
            def over(run, what):
                begin = time.monotonic()
                served.json("POST", f"/runs/{run}/{what}", {})
                wait_for(lambda: served.run(run)["state"] == "stopped", 20, f"not over after {what}")
                seconds = time.monotonic() - begin
                print(f"    {what}: {seconds:.1f} s")
                must(seconds < 10, f"{what} takes {seconds:.1f} s")
                must(served.run(run)["cause"] == "user", f"{served.run(run)['cause']}: {served.run(run)['message']}")
            for what in ("stop", "kill"):
                (folder / "hold").touch()
                run = served.submit(sets=LONG)
                wait_for(lambda: served.run(run)["waits"] == "Resources", 30, "no reason")
                over(run, what)
                (folder / "hold").unlink()
                time.sleep(5)
                must(not served.worker(run) and served.run(run)["state"] == "stopped", "what was stopped starts")
                served.json("POST", f"/runs/{run}/resume", {})
                wait_for(lambda: served.worker(run) and committed(served, run) > 0, 60, "no worker")
                must(served.run(run)["waits"] is None, "a job that runs waits")
                over(run, what)
                served.json("POST", f"/runs/{run}/resume", {})
                served.wait(run)
                served.same_as_alone(run, alone())
    finally:
        shutil.rmtree(folder, ignore_errors=True)


class BatchJobs:
    """ListJobs, SubmitJob and TerminateJob of AWS Batch, with its pages of lists. Jobs begin after a second, get SIGTERM and
    30 s later SIGKILL, and their ends are known: a process stands for a container."""

    def __init__(self, environment):
        self.jobs, self.calls, self.lock = {}, [], threading.Lock()
        self.environment = dict(os.environ) | environment
        outer = self
        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            def do(self):
                body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
                if self.headers.get("Transfer-Encoding") == "chunked":
                    while size := int(self.rfile.readline(), 16):
                        body += self.rfile.read(size)
                        self.rfile.readline()
                    self.rfile.readline()
                with outer.lock:
                    status, answer = outer.answer(self.command, self.path, json.loads(body) if body else None, self.headers)
                text = json.dumps(answer).encode()
                self.send_response(status)
                self.send_header("Content-Type", "application/json")
                self.send_header("Content-Length", str(len(text)))
                self.end_headers()
                self.wfile.write(text)
            do_POST = do
            def log_message(self, *_):
                pass
        self.service = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.service.serve_forever, daemon=True).start()
        self.url = f"http://127.0.0.1:{self.service.server_port}"

    def begin(self, name, command):
        job = {"name": name, "id": f"id-{len(self.jobs)}", "at": time.monotonic(), "process": None, "command": command, "ended": False}
        self.jobs[job["id"]] = job
        return job

    def state(self, job):
        if job["ended"]:
            return "FAILED"
        if job["process"] is None:
            if time.monotonic() < job["at"] + 1:
                return "RUNNABLE"
            job["process"] = subprocess.Popen(job["command"], env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        code = job["process"].poll()
        return "RUNNING" if code is None else "SUCCEEDED" if code == 0 else "FAILED"

    def end(self, job):
        if job["process"] is None:
            job["ended"] = True
        else:
            job["process"].terminate()
            threading.Timer(30, job["process"].kill).start()

    def names(self):
        return sorted(job["name"] for job in self.jobs.values())

    def live(self):
        return [job for job in self.jobs.values() if job["process"] and job["process"].poll() is None]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.service.shutdown()
        for job in self.live():
            job["process"].kill()

    def answer(self, method, path, body, headers):
        name = path.split("/")[-1]
        self.calls.append(name)
        if "/batch/aws4_request" not in headers.get("Authorization", ""):
            return 403, {"message": "Missing Authentication Token"}
        if body.get("jobQueue", "spot") not in ("spot", "demand"):
            return 400, {"message": f"{body['jobQueue']} does not exist"}
        if name == "submitjob":
            must(body["retryStrategy"] == {"attempts": 1}, f"{body}")
            job = self.begin(body["jobName"], body["containerOverrides"]["command"])
            job["queue"] = body["jobQueue"]
            return 200, {"jobId": job["id"], "jobName": job["name"]}
        if name == "terminatejob":
            self.end(self.jobs[body["jobId"]])
            return 200, {}
        names = [value for one in body.get("filters", []) for value in one["values"]]
        fits = lambda job: job["name"] in names if names else self.state(job) == body["jobStatus"]
        jobs = [job for job in self.jobs.values() if job["queue"] == body["jobQueue"] and fits(job)]
        # Pages of one job.
        at = int(body.get("nextToken", 0))
        page = [{"jobName": job["name"], "jobId": job["id"], "status": self.state(job)} for job in jobs[at:at + 1]]
        return 200, {"jobSummaryList": page} | ({"nextToken": str(at + 1)} if at + 1 < len(jobs) else {})


def through_batch(jobs, bucket):
    """A run through AWS Batch: submitted and adopted by a second server, its machine lost, terminated by the
    engine, stopped and resumed by the user; the same bytes."""
    reference = alone()
    folder = Path(tempfile.mkdtemp(prefix="accept-jobs-"))
    file = folder / "engine.toml"
    (folder / "scratch").mkdir()
    file.write_text('queues = ["spot", "demand"]\ndefinition = "worker"\n'
                    f'poll = 0.5\nprogram = "{CLOUD}"\nsolver = "{SOLVE}"\nscratch = "{folder}/scratch"\n')
    environment = bucket.environment | {"AWS_ENDPOINT_URL_BATCH": jobs.url}
    with server("--aws", str(file), environment=environment | {"MERCURY_CLOUD_FAIL": "after-submit"}, bucket=bucket) as served:
        run = served.submit()
        wait_for(lambda: served.process.poll() is not None, 60, "the failpoint was not reached")
        served.process.stdout.close()
        del served.environment["MERCURY_CLOUD_FAIL"]
        served.start()
        wait_for(lambda: jobs.live() and committed(served, run) > 0, 120, "no checkpoint")
        must(jobs.names() == [f"mc-{run}-1"], f"the job was not adopted: {jobs.names()}")
        jobs.live()[0]["process"].kill()
        wait_for(lambda: len(served.attempts(run)) == 2 and jobs.live() or served.run(run)["state"] == "finished", 120, "no second attempt")
        for job in jobs.live():
            jobs.end(job)
        wait_for(lambda: len(served.attempts(run)) == 3 and jobs.live() or served.run(run)["state"] == "finished", 120, "no third attempt")
        if served.run(run)["state"] == "running":
            served.json("POST", f"/runs/{run}/stop", {})
            wait_for(lambda: served.run(run)["state"] in ("stopped", "finished"), 60, "not stopped")
            if served.run(run)["state"] == "stopped":
                served.json("POST", f"/runs/{run}/resume", {})
        served.wait(run)
        causes = [attempt["cause"] for attempt in served.attempts(run)]
        must(causes[0] in ("lost", "engine") and causes[-1] == "finished", f"causes: {causes}")
        must(len(jobs.names()) == len(set(jobs.names())) == len(causes), f"jobs: {jobs.names()}, attempts: {causes}")
        served.same_as_alone(run, reference)
        print(f"    {', '.join(causes)}; {len(jobs.calls)} calls")
        # Ended hard: the job goes, too.
        second = served.submit(sets=["time.end=20", "output.pictures=false"])
        wait_for(jobs.live, 60, "no second run")
        served.json("POST", f"/runs/{second}/kill", {})
        wait_for(lambda: served.run(second)["state"] in ("stopped", "cancelled") and not jobs.live(), 90, "not ended")
    shutil.rmtree(folder)


def has(option):
    text = subprocess.run([CLOUD, "serve", "--help"], capture_output=True, text=True).stdout
    if option not in text:
        raise Skipped(f"built without {option}")


def check_batch():
    """AWS Batch: a stand-in that runs jobs (submitted and adopted, lost, terminated, stopped); and moto's, which runs none, with
    a server killed between submission and its record: one job of each name."""
    has("--aws")
    need_s3()
    with Bucket("moto") as bucket:
        with BatchJobs(bucket.environment) as jobs:
            through_batch(jobs, bucket)
        def moto(path, body):
            connection = http.client.HTTPConnection("127.0.0.1", bucket.port, timeout=30)
            signed = {"Authorization": "AWS4-HMAC-SHA256 Credential=test/20260101/us-east-1/batch/aws4_request, SignedHeaders=host, Signature=0"}
            connection.request("POST", path, json.dumps(body), signed | {"Content-Type": "application/json"})
            answer = connection.getresponse()
            text = answer.read()
            must(answer.status in (200, 201), f"{path}: {answer.status} {text[:500]}")
            return json.loads(text)
        moto("/moto-api/config", {"batch": {"use_docker": False}})
        script = """if True:
            import boto3, sys
            client = lambda name: boto3.client(name, endpoint_url=sys.argv[1], region_name="us-east-1", aws_access_key_id="test", aws_secret_access_key="test")
            role = client("iam").create_role(RoleName="batch", AssumeRolePolicyDocument="{}")["Role"]["Arn"]
            batch = client("batch")
            batch.create_compute_environment(computeEnvironmentName="machines", type="UNMANAGED", state="ENABLED", serviceRole=role)
            batch.create_job_queue(jobQueueName="spot", state="ENABLED", priority=1, computeEnvironmentOrder=[{"order": 1, "computeEnvironment": "machines"}])
            resources = [{"type": "VCPU", "value": "1"}, {"type": "MEMORY", "value": "2048"}]
            batch.register_job_definition(jobDefinitionName="worker", type="container", containerProperties={"image": "x", "resourceRequirements": resources})
        """
        subprocess.run([beside_moto(), "-c", script, f"http://127.0.0.1:{bucket.port}"], check=True)
        file = Path(bucket.folder) / "batch.toml"
        file.write_text('queues = ["spot"]\ndefinition = "worker"\npoll = 0.5\n')
        with server("--aws", str(file), environment={"MERCURY_CLOUD_FAIL": "after-submit"}, bucket=bucket) as served:
            run = served.submit()
            wait_for(lambda: served.process.poll() is not None, 60, "the failpoint was not reached")
            served.process.stdout.close()
            del served.environment["MERCURY_CLOUD_FAIL"]
            served.start()
            # Its jobs end at once and have run nothing: each attempt is lost, and another one is made.
            wait_for(lambda: len(served.attempts(run)) >= 2, 60, "the lost job was not seen")
            jobs = moto("/v1/listjobs", {"jobQueue": "spot", "filters": [{"name": "JOB_NAME", "values": [f"mc-{run}-1"]}]})["jobSummaryList"]
            must(len(jobs) == 1, f"jobs: {jobs}")
            must(served.attempts(run)[0]["cause"] in ("lost", "engine"), f"{served.attempts(run)}")
            served.json("POST", f"/runs/{run}/stop", {})


def beside_moto():
    """The python that has moto."""
    return Path(shutil.which("moto_server")).parent / "python"


def check_cloudformation():
    """cfn-lint finds nothing in the template of deploy/aws; moto creates, updates and deletes a stack of it."""
    if not shutil.which("moto_server") or not shutil.which("cfn-lint"):
        raise Skipped("moto_server or cfn-lint is not on the path")
    with Bucket("moto") as bucket:
        checked = subprocess.run([beside_moto(), Path(__file__).with_name("cloudformation.py"), str(bucket.port)], text=True, capture_output=True)
        must(checked.returncode == 0, checked.stdout + checked.stderr[-2000:])
        print(checked.stdout.rstrip())


def browser(script, *options, environment=None):
    if not shutil.which("node") or not shutil.which(os.environ.get("CHROMIUM", "chromium")):
        raise Skipped("node or chromium is not installed")
    done = subprocess.run(["node", ROOT / "cloud/web/tests" / script, *options], text=True, capture_output=True, env=dict(os.environ) | (environment or {}))
    must(done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:])
    print("".join(f"    {line}\n" for line in done.stdout.splitlines()), end="")


def check_newcomer():
    """A newcomer in Chromium: template, mistake, Submit, particles, chart, log, stop, resume, download; no complaint."""
    with server() as served:
        browser("newcomer.mjs", served.link)


def check_account_page():
    """The account page in Chromium: a web hook is refused, set, tested and removed."""
    class Receiver(http.server.BaseHTTPRequestHandler):
        def do_POST(self):
            self.rfile.read(int(self.headers["Content-Length"]))
            self.send_response(204)
            self.end_headers()
        def log_message(self, *_):
            pass
    receiver = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Receiver)
    threading.Thread(target=receiver.serve_forever, daemon=True).start()
    with server("--hooks-to", "localhost") as served:
        browser("account.mjs", served.link, f"http://localhost:{receiver.server_port}/")
    receiver.shutdown()


def check_draft():
    """A draft in Chromium: kept over reload, dark and templates; a lost answer makes no second run; account; a link asks."""
    with server() as served:
        browser("draft.mjs", served.link)


def check_states():
    """Chromium: unknown addresses, a server that is away, a session that is over, buttons that stay, values of charts, a dropped scene."""
    with server() as served:
        run = served.submit(sets=["time.end=20", "output.interval=0.01", "output.pictures=false"])
        wait_for(lambda: committed(served, run) > 0, 60, "no checkpoint")
        try:
            browser("states.mjs", served.link, run)
        finally:
            # The page has ended all sessions.
            served.cookie = None
            answer = served.request("POST", "/session", {"token": served.link.split("#token=")[1]}, expect=200)
            served.admin = served.cookie = answer.headers["set-cookie"].split(";")[0]
            served.json("POST", f"/runs/{run}/kill", {})


def check_compare_page():
    """Chromium: Compare has the differences of the scenes, one slider and one range of colours; without WebGL a picture comes."""
    with server() as served:
        sets = ["time.end=0.02", "output.interval=0.002"]
        runs = [served.submit(text=text, sets=sets) for text in (SCENE, SCENE.rstrip() + "\n# another line\n")]
        [served.wait(run) for run in runs]
        browser("compare.mjs", served.link, *runs)


def check_view():
    """Chromium: problems in view at 1366 x 768, completion; results with errors, several charts with logarithmic axes, Reset view,
    picture, film, full screen, previews of files."""
    with server() as served:
        results = ["torque=mean(walls.drum.ty, 0.2..)", "tilt=tilt(walls.drum, steady..)", "top=max(particles.z)"]
        run = served.submit(sets=["time.end=0.6", "output.interval=0.005", "output.pictures=false"], result=results)
        served.wait(run)
        browser("view.mjs", served.link, run)


def check_known():
    """A run that ends when its result is known, in Chromium: value and error at each look, what is missing, the time left until then."""
    with server() as served:
        until = re.sub(r"(?m)^end *=.*$", 'end = 60\nuntil = { result = "torque", error = "1 %", at_least = 0.3 }', SCENE, count=1) + '\n[results]\ntorque = "mean(walls.drum.ty, 0.2..)"\n'
        run = served.submit(until, sets=["output.interval=0.002", "output.pictures=false"])
        wait_for(lambda: any(one["file"].endswith(".results.csv") for one in served.json("GET", f"/runs/{run}/tables")), 120, "no look at the result")
        browser("known.mjs", served.link, run)


def check_study_page():
    """A study from the page in Chromium: a grid, a study file, table, plot, charts over each other, two runs side by side."""
    with server() as served:
        browser("study.mjs", served.link)


def check_viewer():
    """1e5 and 1e6 spheres in Chromium's software rendering."""
    with server() as served:
        browser("viewer.mjs", served.link)


def check_page():
    """The page by axe-core and by keyboard alone, its functions by node --test, its types by tsc where it is there (ACCEPT_NPM: a
    folder with node_modules)."""
    modules = Path(os.environ.get("ACCEPT_NPM", ROOT / "cloud/web")) / "node_modules"
    if not shutil.which("node"):
        raise Skipped("node is not installed")
    tested = subprocess.run(["node", "--test", ROOT / "cloud/web/tests/"], text=True, capture_output=True)
    must(tested.returncode == 0, tested.stdout)
    if (modules / ".bin/tsc").exists():
        typed = subprocess.run([modules / ".bin/tsc", "-p", ROOT / "cloud/web/tests/tsconfig.json"], text=True, capture_output=True)
        must(typed.returncode == 0, typed.stdout)
    else:
        print("    types not checked: typescript is not installed")
    if not (modules / "axe-core").exists():
        print("    accessibility not checked: axe-core is not installed")
        return
    with server() as served:
        study = {"base": {"scene": {"name": "drum.toml", "text": SCENE, "set": SHORT + ["time.end=0.01"]}, "result": ["height=max(particles.z)"]}, "sweep": ["seed=1,2"]}
        study = served.json("POST", "/studies", study, 201)["id"]
        wait_for(lambda: served.json("GET", f"/studies/{study}")["states"] == {"finished": 2}, 120, "not finished")
        browser("axe.mjs", served.link, modules / "axe-core/axe.min.js")


def check_attacks():
    """The twelve attacks of attacks.sh: the server holds, and nothing of them is left."""
    with server() as served:
        here = Path(__file__).parent
        done = subprocess.run([here / "attacks.sh", served.link], capture_output=True, text=True)
        print("".join(f"    {line}\n" for line in done.stdout.splitlines()), end="")
        must(done.returncode == 0, f"{done.stdout}{done.stderr}")
        must([user["name"] for user in served.json("GET", "/users")] == ["local"], "users that are left")
        must(served.json("GET", "/runs")["runs"] == [], "runs that are left")


def check_audit():
    """The audit log has changes and logins with user, address and status, but no look, no secret and no body; it is for administrators."""
    with server() as served:
        admin = served.cookie
        served.request("POST", "/users", {"name": "ada", "password": "correct horse"}, expect=204)
        served.cookie = None
        served.request("POST", "/session", {"name": "ada", "password": "wrong horse!"}, expect=401)
        answer = served.request("POST", "/session", {"name": "ada", "password": "correct horse"}, expect=200)
        served.cookie = answer.headers["set-cookie"].split(";")[0]
        run = served.submit(sets=[*SHORT, "time.end=0.001"])
        served.wait(run)
        secret = served.json("POST", "/tokens", {"name": "t"}, 201)["secret"]
        served.request("POST", "/check", {"scene": {"text": SCENE}}, expect=200)
        served.request("GET", "/audit", expect=403)
        served.request("POST", "/links", {}, expect=403)
        served.request("DELETE", f"/runs/{run}", expect=204)
        served.request("DELETE", f"/runs/{run}", None, {"Sec-Fetch-Site": "cross-site"}, 403)
        served.cookie = admin
        rows = served.json("GET", "/audit")
        found = [(row["user"], row["method"], row["path"], row["status"]) for row in reversed(rows)][1:]
        must(found == [("local", "POST", "/users", 204), ("", "POST", "/session", 401), ("ada", "POST", "/session", 200), ("ada", "POST", "/runs", 201),
                       ("ada", "POST", "/tokens", 201), ("ada", "POST", "/links", 403), ("ada", "DELETE", f"/runs/{run}", 204)], f"{found}")
        must(rows[0]["address"] == "127.0.0.1" and time.time() - rows[0]["time"] < 60, f"{rows[0]}")
        must(secret not in json.dumps(rows) and "horse" not in json.dumps(rows), "secrets in the log")
        must(served.json("GET", f"/audit?before={rows[0]['id']}") == rows[1:], "pages")
        done = subprocess.run([CLOUD, "audit", "--link", served.link, "--most", "1"], capture_output=True, text=True)
        must(f"DELETE /runs/{run}" in done.stdout and len(done.stdout.splitlines()) == 1, done.stdout + done.stderr)


def check_log():
    """The lines of the solver come while it runs, for each attempt, without paths of the server; clone and log at the command line."""
    with server() as served:
        sets = ["time.end=4", "output.interval=0.05", "output.pictures=false"]
        run = served.submit(sets=sets)
        def lines(attempt):
            return served.json("GET", f"/runs/{run}/log?attempt={attempt}")["text"]
        wait_for(lambda: "particle-steps/s" in lines(1), 60, "no lines of a run that runs")
        must(served.run(run)["state"] == "running", "not live")
        os.kill(served.worker(run)[0], signal.SIGKILL)
        wait_for(lambda: "particle-steps/s" in lines(2), 90, "no lines of the second attempt")
        must("particle-steps/s" in lines(1), "the lines of the first attempt are gone")
        served.json("POST", f"/runs/{run}/stop", {})
        served.wait(run, "stopped")
        text = lines(1) + lines(2)
        must(str(served.folder) not in text and "/" not in text.replace("particle-steps/s", ""), f"paths: {text}")
        def cli(*words):
            done = subprocess.run([CLOUD, *words[:1], "--link", served.link, *words[1:]], capture_output=True, text=True)
            must(done.returncode == 0, f"{words}: {done.stderr}")
            return done.stdout
        must(cli("log", run, "--attempt", "2") == lines(2).rstrip("\n") + "\n", "other lines at the command line")
        found = cli("log", run, "--attempt", "1", "--search", "particle-steps/s").splitlines()
        must(found and all("particle-steps/s" in line for line in found), f"{found}")
        clone = json.loads(cli("clone", run, "--json", "--set", "time.end=0.001", "--title", "short"))
        must(clone["title"] == "short" and clone["set"] == [*sets, "time.end=0.001"], f"{clone['title']}: {clone['set']}")
        must(served.wait(clone["id"])["time"] < 0.01, "the clone has another end")
        for words in (["session"], ["share"], ["token"], ["user"], ["project"], ["ls"]):
            must(isinstance(json.loads(cli(*words, "--json")), list), f"{words} --json is no list")


def check_contract():
    """The OpenAPI document is valid; schemathesis against it, with a run to look at: no 5xx, no status that it does not name, and answers
    fit their schemas."""
    if validator := shutil.which("openapi-spec-validator"):
        document = subprocess.run([CLOUD, "openapi"], capture_output=True, text=True, check=True).stdout
        valid = subprocess.run([validator, "-"], input=document, capture_output=True, text=True)
        must(valid.returncode == 0, valid.stdout[-2000:])
    else:
        print("    the document is not checked: openapi-spec-validator is not on the path")
    if not (program := shutil.which("schemathesis")):
        raise Skipped("schemathesis is not on the path")
    seconds = os.environ.get("ACCEPT_SECONDS", "300")
    with server() as served:
        run = served.submit(sets=SHORT + ["time.end=0.001"])
        served.wait(run)
        token = served.json("POST", "/tokens", {"name": "contract"}, 201)["secret"]
        command = [program, "run", f"http://127.0.0.1:{served.port}/api/v1/openapi.json", "--header", f"Authorization: Bearer {token}",
                   "--checks", "not_a_server_error,status_code_conformance,response_schema_conformance,content_type_conformance", "--phases", "examples,coverage,fuzzing",
                   # Streams of events never end, and a token that is taken back lets nothing in.
                   "--exclude-path", "/api/v1/events", "--exclude-path", "/api/v1/tokens/{id}", "--exclude-path", "/api/v1/session",
                   # These end the sessions of this check.
                   "--exclude-path", "/api/v1/sessions", "--exclude-path", "/api/v1/links",
                   "--max-examples", "40", "--request-timeout", "30", "--generation-deterministic", "--continue-on-failure"]
        try:
            # It keeps what it finds in the folder where it runs.
            done = subprocess.run(command, text=True, capture_output=True, timeout=float(seconds), cwd=served.folder)
            must(done.returncode == 0, done.stdout[-4000:] + done.stderr[-1000:])
            print(f"    {[line for line in done.stdout.splitlines() if line.strip()][-1]}")
        except subprocess.TimeoutExpired as over:
            text = (over.stdout or b"").decode()
            must("FAILURES" not in text and "Server error" not in text, text[-4000:])
            print(f"    nothing found in {seconds} s")


CHECKS = {name.removeprefix("check_").replace("_", "-"): check for name, check in list(globals().items()) if name.startswith("check_")}

# These measure short times or memory of a machine that does nothing else, or take ports that are always the same.
UNDISTURBED = {"attacks", "cost", "list", "log-in", "slurm", "slurm-ranks", "start", "thousand", "unread", "viewer", "watchers"}

RESULTS = ["passed", "FAILED", "skipped"]


def attempt(name):
    """Makes a check, prints and returns its result."""
    begin = time.monotonic()
    try:
        CHECKS[name]()
        result, why = "passed", f"  {time.monotonic() - begin:.0f} s"
    except Skipped as reason:
        result, why = "skipped", f": {reason}"
    except Exception as error:
        if not isinstance(error, Failed):
            traceback.print_exc()
        result, why = "FAILED", f": {error}"
    print(f"{result:7} {name}{why}", flush=True)
    return result


def attempt_apart(name):
    """Makes a check in a process of its own, and prints all of its output at its end."""
    done = subprocess.run([sys.executable, __file__, "--apart", name], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(done.stdout, end="", flush=True)
    return RESULTS[done.returncode]


def attempt_all(names, jobs):
    """Makes checks, `jobs` of them at a time; their results in order. One that fails beside others is made once more alone: their limits of time
    are those of a machine that does nothing else."""
    if jobs == 1:
        return [attempt(name) for name in names]
    results = {name: attempt_apart(name) for name in names if name in UNDISTURBED}
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        others = [name for name in names if name not in UNDISTURBED]
        results |= zip(others, pool.map(attempt_apart, others))
    for name in others:
        if results[name] == "FAILED":
            print(f"once more alone: {name}", flush=True)
            results[name] = attempt_apart(name)
    return [results[name] for name in names]


def main(names):
    if names[:1] == ["--apart"]:
        return RESULTS.index(attempt(names[1]))
    jobs = max(1, int(os.environ.get("ACCEPT_JOBS", 1)))
    if not names or any(name not in CHECKS and name != "all" for name in names):
        for name, check in CHECKS.items():
            print(f"{name:15} {' '.join(check.__doc__.split())}")
        return 2
    names = list(CHECKS) if "all" in names else names
    print(f"seed {SEED} (ACCEPT_SEED repeats it)")
    with tempfile.TemporaryDirectory(prefix="accept-alone-") as folder:
        os.environ |= {"ACCEPT_SEED": str(SEED), ALONE: folder}
        results = attempt_all(names, jobs)
    failed = [name for name, result in zip(names, results) if result == "FAILED"]
    print(", ".join(f"{results.count(result)} {result.lower()}" for result in RESULTS) + (f": {', '.join(failed)}" if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
