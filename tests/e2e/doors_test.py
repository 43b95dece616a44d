#!/usr/bin/python3
"""Checks who may connect to lucernad, what callers may do, and what the client reports.

    tests/e2e/doors_test.py BUILD_DIR
"""
import hashlib
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "server"))
from certificates import Authority  # noqa: E402
from lucernad import Lucernad, expect  # noqa: E402

COMMAND_S = 300  # ends tests that hang
SCENES = pathlib.Path(__file__).resolve().parents[1] / "data/reference"
BUILD = pathlib.Path(sys.argv[1])
LUCERNAD = BUILD / "bin/lucernad"
TOKENS = {name: f"a long secret of {name}".replace(" ", "-") for name in ("viewer", "loader", "other", "porter", "root")}


def lucerna(server, *arguments, token=None, **environment):
    """Runs the command line.  `server` may be an address."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith("LUCERNA")}
    if token:
        clean["LUCERNA_TOKEN"] = token
    address = server if isinstance(server, str) else server.address
    return subprocess.run([BUILD / "bin/lucerna", "--server", address, *map(str, arguments)], capture_output=True,
                          text=True, timeout=COMMAND_S, env=clean | environment, check=False)


def succeeds(outcome):
    expect(outcome.returncode == 0, f"{outcome.args}: {outcome.stderr}")
    return outcome.stdout


def fails(outcome, text):
    expect(outcome.returncode == 1 and text in outcome.stderr,
           f"{outcome.args}: status {outcome.returncode}, {text!r} is not in: {outcome.stderr}")


def refuses_to_start(text, *options):
    run = subprocess.run([LUCERNAD, *map(str, options)], capture_output=True, text=True, timeout=COMMAND_S, check=False)
    expect(run.returncode == 1 and text in run.stderr, f"{options}: {run.returncode}, {text!r} is not in: {run.stderr}")


def write_tokens(path, names, quotas=""):
    roles = {"viewer": '["query"]', "loader": '["query", "load"]', "other": '["query", "load"]',
             "porter": '["load"]', "root": '["admin", "load", "query"]'}
    path.write_text("".join(
        f'[[token]]\nname = "{n}"\nsha256 = "{hashlib.sha256(TOKENS[n].encode()).hexdigest()}"\nroles = {roles[n]}\n'
        f"{quotas}\n" for n in names))


def only_loopback_is_open(files):
    certificate, key = files.issue("open-server")
    refuses_to_start("listen = 0.0.0.0:0, which other machines can reach", "--listen", "0.0.0.0:0")
    refuses_to_start("listen = [::]:0, which other machines can reach", "--listen", "[::]:0")
    for address in ("127.0.0.1:119537", "[::1]:65536", "127.0.0.1:-1", "localhost:http"):
        wrong = f'"{address}": port "{address.rpartition(":")[2]}", allowed: 0 to 65535'
        refuses_to_start(f"listen = {wrong}", "--listen", address)
        refuses_to_start(f"metrics = {wrong}", "--listen", "127.0.0.1:0", "--metrics", address)
    for options in (["--insecure"], ["--tls-cert", certificate, "--tls-key", key]):
        with Lucernad(LUCERNAD, "--listen", "0.0.0.0:0", *options):
            pass


def wrong_files_are_refused(files, directory):
    certificate, key = files.issue("wrong-files")
    _, other_key = files.issue("wrong-files-2")
    garbage = directory / "garbage.pem"
    garbage.write_text("no certificate\n")
    for text, options in (
            ("tls-cert and tls-key, allowed: both or neither", ["--tls-cert", certificate]),
            ("cannot be read: No such file or directory", ["--tls-cert", "/no/such.pem", "--tls-key", key]),
            ("has no certificate in PEM", ["--tls-cert", garbage, "--tls-key", key]),
            ("has no private key in PEM", ["--tls-cert", certificate, "--tls-key", garbage]),
            ("is not the key of the certificate", ["--tls-cert", certificate, "--tls-key", other_key]),
            ("garbage.pem has no certificate in PEM",
             ["--tls-cert", certificate, "--tls-key", key, "--tls-client-ca", garbage])):
        refuses_to_start(text, "--listen", "127.0.0.1:0", *options)


def pipes_are_refused(files, directory):
    certificate, key = files.issue("pipe")
    pipe = directory / "pipe"
    os.mkfifo(pipe)
    text = f"{pipe} cannot be read: it is a pipe or a device, allowed: files"
    for options in (["--tls-cert", pipe, "--tls-key", key], ["--tls-cert", certificate, "--tls-key", pipe],
                    ["--tls-cert", certificate, "--tls-key", key, "--tls-client-ca", pipe]):
        refuses_to_start(text, "--listen", "127.0.0.1:0", *options)
    refuses_to_start(text.replace(" cannot", ": cannot"), "--listen", "127.0.0.1:0", "--token-file", pipe)
    # The thread of signals must not wait for a pipe that replaces a file.
    tokens = directory / "replaced.toml"
    write_tokens(tokens, ["viewer"])
    with Lucernad(LUCERNAD, "--token-file", tokens) as server:
        tokens.unlink()
        os.mkfifo(tokens)
        server.process.send_signal(signal.SIGHUP)
        server.wait_for_log("not reloaded", COMMAND_S)
        server.process.send_signal(signal.SIGTERM)
        expect(server.process.wait(COMMAND_S) == 0, "SIGTERM does not end the server")


def expired_certificates_are_reported(files):
    old, old_key = files.issue("old", days=-1)
    new, new_key = files.issue("new")
    text = f"tls-cert: a certificate of {old} expired on 20"
    for options, warns in ((["--tls-cert", old, "--tls-key", old_key], True),
                           (["--tls-cert", new, "--tls-key", new_key], False)):
        run = subprocess.run([LUCERNAD, "--check-config", *options], capture_output=True, text=True,
                             timeout=COMMAND_S, check=False)
        expect(run.returncode == 0 and (f"lucernad: warning: {text}" in run.stderr) == warns, f"{run}")
    with Lucernad(LUCERNAD, "--tls-cert", old, "--tls-key", old_key) as server:
        server.wait_for_log(f"[warning] {text}", COMMAND_S)
        server.process.send_signal(signal.SIGHUP)
        server.wait_for_log("reloaded certificates", COMMAND_S)
        server.wait_for_log(f"[warning] {text}", COMMAND_S, count=2)


def doctor_finds(check, text, server, *arguments, token=None):
    """The doctor names the check that failed, and its reason.  Else all is well."""
    outcome = lucerna(server, "doctor", "--json", *arguments, token=token)
    failed = {c["name"]: c["text"] for c in json.loads(outcome.stdout)["checks"] if not c["ok"]}
    if check is None:
        expect(outcome.returncode == 0 and failed == {}, f"{outcome.args}: {outcome.returncode}, {failed}")
    else:
        expect(outcome.returncode == 1 and list(failed) == [check] and text in failed[check],
               f"{outcome.args}: {outcome.returncode}, {failed}, expected {check}: {text}")


def refuses(check, text, server, *arguments, token=None):
    """Both a command and the doctor state why."""
    fails(lucerna(server, "info", *arguments, token=token), text)
    doctor_finds(check, text, server, *arguments, token=token)


def client_reports_why_tls_fails(files, strangers):
    certificate, key = files.issue("server")
    ca = ("--tls-ca", files.certificate)
    with Lucernad(LUCERNAD, "--tls-cert", certificate, "--tls-key", key) as server:
        succeeds(lucerna(server, "info", *ca))
        doctor_finds(None, "", server, *ca)
        # The names of the certificate, and one that it does not have.
        succeeds(lucerna(f"localhost:{server.port}", "info", *ca))
        succeeds(lucerna(server, "info", *ca, "--tls-name", "localhost"))
        refuses("TLS", "the server's certificate is not for the name lamps.example", server, *ca, "--tls-name", "lamps.example")
        refuses("TLS", "the server's certificate is not signed by an authority of ", server, "--tls-ca", strangers.certificate)
        refuses("TLS", "the server's certificate is not signed by an authority of ", server, "--tls")
        refuses("TLS", "the server uses TLS, and the client does not", server)
    with Lucernad(LUCERNAD) as server:
        refuses("TLS", "the server does not use TLS on this port", server, *ca)
    certificate, key = files.issue("expired-server", days=-1)
    with Lucernad(LUCERNAD, "--tls-cert", certificate, "--tls-key", key) as server:
        refuses("TLS", "the server's certificate has expired", server, *ca)
    certificate, key = files.issue("other-name", alternatives="DNS:lamps.example")
    with Lucernad(LUCERNAD, "--tls-cert", certificate, "--tls-key", key) as server:
        refuses("TLS", "the server's certificate is not for the name 127.0.0.1", server, *ca)
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        refuses("connection", "no server listens there", f"127.0.0.1:{unused.getsockname()[1]}", *ca)


def client_reports_why_mutual_tls_fails(files, strangers):
    certificate, key = files.issue("mutual")
    ca = ("--tls-ca", files.certificate)
    with Lucernad(LUCERNAD, "--tls-cert", certificate, "--tls-key", key, "--tls-client-ca",
                  files.certificate) as server:
        def of(own):
            return (*ca, "--tls-cert", own[0], "--tls-key", own[1])

        doctor_finds(None, "", server, *of(files.issue("client")))
        refuses("TLS", "the server needs a client certificate", server, *ca)
        refuses("TLS", "the server does not accept the client certificate", server, *of(strangers.issue("stranger")))
        refuses("TLS", "the client certificate has expired", server, *of(files.issue("expired-client", days=-1)))
        # The log has the name of the certificate.
        succeeds(lucerna(server, "info", *of(files.issue("named", alternatives="DNS:*.desk.example"))))
        server.wait_for_log(" caller=*.desk.example ")


def certificates_are_reloaded(files, strangers, directory):
    certificate, key = directory / "live.pem", directory / "live.key"

    def install(pair):
        certificate.write_bytes(pair[0].read_bytes())
        key.write_bytes(pair[1].read_bytes())

    install(files.issue("first"))
    with Lucernad(LUCERNAD, "--tls-cert", certificate, "--tls-key", key) as server:
        succeeds(lucerna(server, "info", "--tls-ca", files.certificate))
        install(strangers.issue("second"))
        server.process.send_signal(signal.SIGHUP)
        server.wait_for_log("reloaded certificates")
        succeeds(lucerna(server, "info", "--tls-ca", strangers.certificate))
        fails(lucerna(server, "info", "--tls-ca", files.certificate), "is not signed by an authority")
        # A wrong file changes nothing.
        certificate.write_text("half a certificate\n")
        server.process.send_signal(signal.SIGHUP)
        server.wait_for_log("not reloaded: tls-cert: ")
        succeeds(lucerna(server, "info", "--tls-ca", strangers.certificate))


def tokens_have_roles(directory):
    tokens = directory / "tokens.toml"
    write_tokens(tokens, ("viewer", "loader", "porter"))
    with Lucernad(LUCERNAD, "--token-file", tokens, "--scene-root", SCENES, "--load", "point.pbrt") as server:
        scene = json.loads(succeeds(lucerna(server, "scenes", "--json", token=TOKENS["viewer"])))["scenes"][0]["sceneId"]
        power = ("power", scene)
        succeeds(lucerna(server, *power, token=TOKENS["viewer"]))
        doctor_finds(None, "", server, token=TOKENS["viewer"])
        fails(lucerna(server, *power), "the call has no token")
        refuses("token", "the call has no token", server)
        refuses("token", "the server does not know this token", server, token="a-wrong-token-of-nobody")
        refuses("token", 'GetServerInfo needs the role query, and the token of "porter" has only: load', server,
                token=TOKENS["porter"])
        fails(lucerna(server, "load", "point.pbrt", token=TOKENS["viewer"]),
              'permission_denied: LoadScene needs the role load, and the token of "viewer" has only: query')
        succeeds(lucerna(server, "load", "point.pbrt", token=TOKENS["loader"]))
        fails(lucerna(server, "release", scene, "--break-leases", token=TOKENS["loader"]),
              "break_leases needs the role admin")
        # A token in a file.
        file = directory / "token"
        file.write_text(TOKENS["viewer"] + "\n")
        succeeds(lucerna(server, *power, "--token-file", file))
        # Revoked and new tokens hold after SIGHUP.
        write_tokens(tokens, ("loader", "other"))
        server.process.send_signal(signal.SIGHUP)
        server.wait_for_log("reloaded certificates, tokens and limits")
        fails(lucerna(server, *power, token=TOKENS["viewer"]), "it is wrong or was revoked")
        doctor_finds("token", "it is wrong or was revoked", server, token=TOKENS["viewer"])
        succeeds(lucerna(server, *power, token=TOKENS["other"]))
        # A wrong file changes nothing.
        tokens.write_text('[[token]]\nname = "other"\nroles = ["queries"]\n')
        server.process.send_signal(signal.SIGHUP)
        server.wait_for_log(f"{tokens}:3:1: roles, allowed: a list of query, load, admin")
        succeeds(lucerna(server, *power, token=TOKENS["other"]))
        # The log has the names of callers, also of calls that were refused, and no token.
        for line in ("call EstimatePower code=OK id=", "call LoadScene code=PERMISSION_DENIED id="):
            expect(any(line in one and " caller=viewer " in one for one in server.log().splitlines()), server.log())
        for token in TOKENS.values():
            expect(token not in server.log(), f"a token is in the log:\n{server.log()}")


def token_stays_on_this_machine():
    outcome = lucerna("192.0.2.1:50051", "info", token="some-secret-token")
    expect(outcome.returncode == 2 and "the token would leave this machine without encryption" in outcome.stderr,
           f"{outcome.returncode}: {outcome.stderr}")


def leases_belong_to_tokens(directory):
    tokens = directory / "lease-tokens.toml"
    write_tokens(tokens, ("viewer", "loader", "other", "root"), "max-leases = 2")
    with Lucernad(LUCERNAD, "--token-file", tokens, "--scene-root", SCENES) as server:
        def run(name, *arguments):
            return lucerna(server, *arguments, token=TOKENS[name])

        def listed(name):
            return {lease["leaseId"]: lease["owner"]
                    for lease in json.loads(succeeds(run(name, "leases", "--json")))["leases"]}

        loaded = json.loads(succeeds(run("loader", "load", "point.pbrt", "--lease", "3600", "--json")))
        lease, scene = loaded["leaseId"], loaded["sceneId"]
        expect(listed("loader") == {lease: "loader"}, f"{listed('loader')}")
        expect(listed("other") == {}, f"{listed('other')}")
        expect(listed("root") == {lease: "loader"}, f"{listed('root')}")
        # Another caller can neither renew nor end the lease, even if it knows the id.
        fails(run("other", "lease", scene, "--for", "60", "--id", lease), "no such lease")
        fails(run("other", "release", scene, "--lease", lease), "no such lease")
        expect(listed("loader") == {lease: "loader"}, "the lease is gone")
        # The quota of leases.
        succeeds(run("loader", "lease", scene, "--for", "60"))
        fails(run("loader", "lease", scene, "--for", "60"), '"loader" has 2 leases, allowed: 2')
        succeeds(run("loader", "lease", scene, "--for", "60", "--id", lease))
        succeeds(run("other", "lease", scene, "--for", "60"))
        # An admin ends one lease of another, then all.
        succeeds(run("root", "release", scene, "--lease", lease))
        expect(set(listed("root").values()) == {"loader", "other"}, f"{listed('root')}")
        succeeds(run("root", "release", scene, "--break-leases"))
        expect(listed("root") == {}, f"{listed('root')}")
        fails(run("viewer", "power", scene), "not loaded")


def scenes_have_a_quota(directory):
    tokens = directory / "scene-tokens.toml"
    write_tokens(tokens, ("loader",), "max-scenes = 1")
    with Lucernad(LUCERNAD, "--token-file", tokens, "--scene-root", SCENES) as server:
        succeeds(lucerna(server, "load", "point.pbrt", token=TOKENS["loader"]))
        succeeds(lucerna(server, "load", "point.pbrt", token=TOKENS["loader"]))
        fails(lucerna(server, "load", "spot.pbrt", token=TOKENS["loader"]),
              '"loader" has loaded 1 scenes, allowed: 1; release one')
        succeeds(lucerna(server, "release", "point.pbrt", token=TOKENS["loader"]))
        succeeds(lucerna(server, "load", "spot.pbrt", token=TOKENS["loader"]))


def limits_are_reloaded(directory):
    file = directory / "lucernad.toml"
    file.write_text("max-samples = 1000\nthreads = 2\n")
    with Lucernad(LUCERNAD, "--config", file) as server:
        def samples():
            return json.loads(succeeds(lucerna(server, "info", "--json")))["limits"]["maxSamples"]

        expect(samples() == 1000, f"{samples()}")
        file.write_text("max-samples = 2000\nbulk-queue = 3\n")
        server.process.send_signal(signal.SIGHUP)
        server.wait_for_log("max-samples is now 2000")
        server.wait_for_log("bulk-queue stays 64 until a restart")
        expect(samples() == 2000, f"{samples()}")
        file.write_text("max-samples = 0\n")
        server.process.send_signal(signal.SIGHUP)
        server.wait_for_log(f"{file}:1:1: max-samples = 0, allowed: 1 to")
        expect(samples() == 2000, f"{samples()}")


def main():
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        files, strangers = Authority(directory, "authority"), Authority(directory, "strangers")
        only_loopback_is_open(files)
        wrong_files_are_refused(files, directory)
        pipes_are_refused(files, directory)
        expired_certificates_are_reported(files)
        client_reports_why_tls_fails(files, strangers)
        client_reports_why_mutual_tls_fails(files, strangers)
        certificates_are_reloaded(files, strangers, directory)
        tokens_have_roles(directory)
        token_stays_on_this_machine()
        leases_belong_to_tokens(directory)
        scenes_have_a_quota(directory)
        limits_are_reloaded(directory)


main()
