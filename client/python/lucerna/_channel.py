"""Connections: TLS, tokens, retries, keep-alive.  client/library/channel.cpp does the same in C++."""
from __future__ import annotations

import dataclasses
import ipaddress
import os
import pathlib
import re
from collections.abc import Mapping
from typing import Any

import grpc
import numpy as np

from lucerna._errors import invalid

DEFAULT_TARGET = "127.0.0.1:50051"

# A server that starts or drains answers UNAVAILABLE.  Retries for half a second bridge a restart, and a wrong address
# still fails soon.  Uploads continue where they stopped, so they are not retried as a whole.
_SERVICE_CONFIG = """{
  "retryThrottling": {"maxTokens": 1000, "tokenRatio": 1},
  "methodConfig": [{
    "name": [{}],
    "retryPolicy": {
      "maxAttempts": 4,
      "initialBackoff": "0.05s",
      "maxBackoff": "0.3s",
      "backoffMultiplier": 2,
      "retryableStatusCodes": ["UNAVAILABLE"]
    }
  }, {
    "name": [{"service": "lucerna.v1.SceneService", "method": "UploadAsset"}]
  }]
}"""


@dataclasses.dataclass(frozen=True)
class Connection:
    """Where a server is, and how calls reach it.  `settings` makes one from arguments and the environment."""

    target: str
    token: str = ""
    tls: bool = False
    roots: bytes | None = None
    chain: bytes | None = None
    private_key: bytes | None = None
    name: str = ""

    @property
    def metadata(self) -> tuple[tuple[str, str], ...]:
        """What each call sends beside its message."""
        return (("authorization", f"Bearer {self.token}"),) if self.token else ()

    def credentials(self) -> Any:
        """Credentials of gRPC; None without TLS."""
        return grpc.ssl_channel_credentials(self.roots, self.private_key, self.chain) if self.tls else None

    def options(self) -> list[tuple[str, Any]]:
        """Channel options of gRPC."""
        options: list[tuple[str, Any]] = [
            # The server has its own limit for messages.
            ("grpc.max_receive_message_length", -1), ("grpc.max_send_message_length", -1),
            ("grpc.service_config", _SERVICE_CONFIG),
            # gRPC keeps no copy of a larger request for retries, and does not report that.
            ("grpc.per_rpc_retry_buffer_size", 64 << 20),
            # Otherwise each client looks up TXT records of the name for another configuration.
            ("grpc.service_config_disable_resolution", 1),
            # Otherwise a call to a server that hangs waits forever.  The server allows a ping every five seconds.
            ("grpc.keepalive_time_ms", 20_000), ("grpc.keepalive_timeout_ms", 20_000),
            ("grpc.http2.max_pings_without_data", 0),
            # Otherwise a client inherits the backoff of another client's failed attempts at the same address.
            ("grpc.use_local_subchannel_pool", 1),
        ]
        if _is_loopback(self.target):
            options.append(("grpc.enable_http_proxy", 0))  # gRPC would use a proxy even for this machine
        if self.tls and self.name:
            options.append(("grpc.ssl_target_name_override", self.name))
        return options


# Targets that gRPC finds without a host and a port.
_OTHER_SCHEMES = ("unix:", "unix-abstract:", "vsock:", "xds:")


def _is_ip(host: str, version: int) -> bool:
    try:
        return ipaddress.ip_address(host).version == version
    except ValueError:
        return False


def _servers(target: str) -> tuple[str, list[str]]:
    """What stands before the servers of a target of gRPC, and the servers."""
    if target.startswith(_OTHER_SCHEMES):
        return target, []
    if target.startswith(("ipv4:", "ipv6:")):
        return target[:5], target[5:].split(",")
    scheme = re.match("dns:(//[^/]*/)?", target)
    return (scheme[0], [target[scheme.end():]]) if scheme else ("", [target])


def _host_port(server: str) -> tuple[str, int]:
    """Splits HOST:PORT or [IPV6]:PORT."""
    match = re.fullmatch(r"(?:\[([^][]+)\]|([^][:/, ]+)):([^]:]*)", server)
    if not match or not (match[2] or _is_ip(match[1], 6)):
        raise invalid("target", f'"{server}", allowed: HOST:PORT, with an IPv6 address in brackets')
    if not re.fullmatch("0*[0-9]{1,5}", match[3]) or not 1 <= int(match[3]) <= 65535:
        raise invalid("target", f'"{server}": port "{match[3]}", allowed: 1 to 65535')
    return match[1] or match[2], int(match[3])


def _is_loopback(target: str) -> bool:
    hosts = [_host_port(server)[0] for server in _servers(target)[1]]
    return all(host in ("localhost", "::1") or host.startswith("127.") and _is_ip(host, 4) for host in hosts) if hosts \
        else target.startswith("unix:")


def _with_port(target: str) -> str:
    """Adds the default port to a bare host, as the command line does.  gRPC would take port 65537 for port 1, so other
    ports than 1 to 65535 are an error."""
    scheme, servers = _servers(target)
    if len(servers) == 1:
        server = servers[0]
        server = f"[{server}]" if _is_ip(server, 6) else server
        if server.endswith("]") or server and ":" not in server:
            server += ":50051"
        servers = [server]
    for server in servers:
        _host_port(server)
    return scheme + ",".join(servers)


def _read(field: str, path: str | os.PathLike[str] | None) -> bytes | None:
    if not path:
        return None
    try:
        return pathlib.Path(path).read_bytes()
    except OSError as error:
        raise invalid(field, f"{os.fspath(path)} cannot be read: {error.strerror}") from None


def _token(token: str | None, token_file: str | os.PathLike[str] | None, environment: Mapping[str, str]) -> str:
    if token is None:
        path = token_file or environment.get("LUCERNA_TOKEN_FILE")
        if path:
            content = _read("token_file", path) or b""
            token = content.decode("ascii", "replace").partition("\n")[0].rstrip("\r")
            if not token:
                raise invalid("token_file", f"{os.fspath(path)} has no token in its first line")
        else:
            token = environment.get("LUCERNA_TOKEN", "")
    if not all("!" <= c <= "~" for c in token):
        raise invalid("token", "has a character that is not allowed: only visible ASCII")
    return token


def keep_memory() -> None:
    """Lets the C library keep the memory of answers for the next call.

    glibc returns freed blocks of more than 128 kB to the system, and the next call then pays for new pages: a third of
    the time of a batch of 8192 samples.  Once a block of almost 32 MB was freed, glibc keeps blocks below that size.
    """
    np.empty(31 << 20, np.uint8)  # its pages are never touched


def settings(target: str | None = None, *, token: str | None = None, token_file: str | os.PathLike[str] | None = None,
             tls: bool | None = None, ca: str | os.PathLike[str] | None = None,
             certificate: str | os.PathLike[str] | None = None, key: str | os.PathLike[str] | None = None,
             name: str | None = None, environment: Mapping[str, str] = os.environ) -> Connection:
    """The connection of these arguments.  The environment sets those that are None."""
    target = environment.get("LUCERNA_SERVER", DEFAULT_TARGET) if target is None else target
    if not target:
        raise invalid("target", "is empty, allowed: HOST:PORT")
    target = _with_port(target)
    ca = environment.get("LUCERNA_TLS_CA") if ca is None else ca
    certificate = environment.get("LUCERNA_TLS_CERT") if certificate is None else certificate
    key = environment.get("LUCERNA_TLS_KEY") if key is None else key
    name = environment.get("LUCERNA_TLS_NAME") if name is None else name
    if tls is None:
        tls = environment.get("LUCERNA_TLS", "").lower() in ("1", "true", "on", "yes")
        tls = tls or any((ca, certificate, key, name))
    if bool(certificate) != bool(key):
        raise invalid("certificate and key", "allowed: both or neither")
    keep_memory()
    connection = Connection(target, _token(token, token_file, environment), tls, _read("ca", ca),
                            _read("certificate", certificate), _read("key", key), name or "")
    if connection.token and not tls and not _is_loopback(target):
        raise invalid("token", f"would leave this machine without encryption; use TLS for {target}")
    return connection
