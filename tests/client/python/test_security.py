"""TLS, tokens and the variables of the command line."""
import hashlib
import os
import sys

import lucerna
import pytest
from conftest import REFERENCE, ROOT, WAIT_S

sys.path[:0] = [str(ROOT / "tests/e2e"), str(ROOT / "tests/server")]
from certificates import Authority  # noqa: E402
from lucernad import Lucernad  # noqa: E402

TOKENS = {"reader": "the-secret-of-the-reader", "loader": "the-secret-of-the-loader"}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("security")
    authority = Authority(folder, "authority")
    certificate, key = authority.issue("server")
    client_certificate, client_key = authority.issue("client")
    roles = {"reader": '["query"]', "loader": '["query", "load"]'}
    (folder / "tokens.toml").write_text("".join(
        f'[[token]]\nname = "{name}"\nsha256 = "{hashlib.sha256(secret.encode()).hexdigest()}"\nroles = {roles[name]}\n'
        for name, secret in TOKENS.items()))
    (folder / "reader.token").write_text(TOKENS["reader"] + "\n")
    return {"ca": authority.certificate, "stranger": Authority(folder, "stranger").certificate, "cert": certificate,
            "key": key, "client": (client_certificate, client_key), "tokens": folder / "tokens.toml",
            "token_file": folder / "reader.token"}


@pytest.fixture(scope="module")
def guarded(files):
    """The target of a server with TLS, client certificates and tokens."""
    with Lucernad(os.environ["LUCERNAD"], "--scene-root", REFERENCE, "--tls-cert", files["cert"], "--tls-key",
                  files["key"], "--tls-client-ca", files["ca"], "--token-file", files["tokens"]) as server:
        yield f"localhost:{server.port}"


def door(guarded, files, token, **more):
    options = {"ca": files["ca"], "certificate": files["client"][0], "key": files["client"][1], "token": token,
               "timeout": WAIT_S} | more
    return lucerna.connect(guarded, **options)


def test_a_token_opens_its_door(guarded, files):
    with door(guarded, files, TOKENS["loader"]) as server:
        assert server.load("point.pbrt").power().total > 0
    with door(guarded, files, TOKENS["reader"]) as server:
        with pytest.raises(lucerna.PermissionDenied, match="load") as error:
            server.load("sphere.pbrt")
    assert error.value.reason == "NOT_ALLOWED" and isinstance(error.value, PermissionError)


def test_strangers_do_not_enter(guarded, files):
    for token in ("", "wrong-token"):
        with door(guarded, files, token) as server, pytest.raises(lucerna.Unauthenticated):
            server.scenes()
    with door(guarded, files, TOKENS["loader"], ca=files["stranger"]) as server, pytest.raises(lucerna.Unavailable):
        server.info()
    with door(guarded, files, TOKENS["loader"], name="elsewhere") as server, pytest.raises(lucerna.Unavailable):
        server.info()
    with lucerna.connect(guarded, ca=files["ca"], timeout=WAIT_S) as server, pytest.raises(lucerna.Unavailable):
        server.info()  # no client certificate


def test_variables_of_the_command_line_count(guarded, files, monkeypatch):
    monkeypatch.setenv("LUCERNA_SERVER", guarded)
    monkeypatch.setenv("LUCERNA_TLS_CA", str(files["ca"]))
    monkeypatch.setenv("LUCERNA_TLS_CERT", str(files["client"][0]))
    monkeypatch.setenv("LUCERNA_TLS_KEY", str(files["client"][1]))
    monkeypatch.setenv("LUCERNA_TOKEN_FILE", str(files["token_file"]))
    with lucerna.connect(timeout=WAIT_S) as server:
        assert server.target == guarded and server.scenes() is not None
        with pytest.raises(lucerna.PermissionDenied):
            server.load("sphere.pbrt")
    monkeypatch.delenv("LUCERNA_TOKEN_FILE")
    monkeypatch.setenv("LUCERNA_TOKEN", TOKENS["loader"])
    with lucerna.connect(timeout=WAIT_S) as server:
        assert server.load("sphere.pbrt").id
    monkeypatch.setenv("LUCERNA_TLS_NAME", "elsewhere")
    with lucerna.connect(timeout=WAIT_S) as server, pytest.raises(lucerna.Unavailable):
        server.info()


def test_a_flag_alone_uses_the_authorities_of_this_machine(guarded, monkeypatch):
    monkeypatch.setenv("LUCERNA_TLS", "1")
    settings = lucerna._channel.settings(guarded)
    assert settings.tls and settings.roots is None
