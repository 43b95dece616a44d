"""Wrong input gives an exception that names the field, and the server keeps serving."""
import re
import socket

import grpc
import lucerna
import numpy as np
import pytest
from conftest import WAIT_S

UP = (0.0, 0.0, 1.0)
HERE = np.zeros((4, 3))


def fields(error):
    return [v.field for v in error.value.violations]


@pytest.mark.parametrize("field, call", [
    ("points", lambda s: s.irradiance(np.zeros((4, 2)), UP)),
    ("points", lambda s: s.irradiance(3.0, UP)),
    ("points", lambda s: s.irradiance([["a", "b", "c"]], UP)),
    ("normals", lambda s: s.irradiance(HERE)),
    ("normals", lambda s: s.irradiance(HERE, np.zeros((3, 3)))),
    ("wi", lambda s: s.pdf_li(HERE, np.zeros((5, 3)), light=1)),
    ("directions", lambda s: s.le(HERE, np.zeros((5, 3)))),
    ("directions", lambda s: s.pdf_le(HERE, light=1)),
    ("to and directions", lambda s: s.visible(HERE)),
    ("to and directions", lambda s: s.visible(HERE, UP, directions=UP)),
    ("lengths_m", lambda s: s.visible(HERE, UP, lengths_m=1)),
    ("lengths_m", lambda s: s.visible(HERE, directions=UP, lengths_m=[1, 2])),
    ("u", lambda s: s.sample_li(HERE, u=np.zeros((3, 2)))),
    ("u", lambda s: s.sample_li(HERE, u_light=np.zeros(4))),
    ("u_light", lambda s: s.sample_li(HERE, u=np.zeros((4, 2)), u_light=np.zeros(3))),
    ("places", lambda s: s.find_surfaces(HERE)),
    ("count", lambda s: s.sample_le(-1)),
    ("error", lambda s: s.irradiance(HERE, UP, samples=4, error=0.1)),
    ("error", lambda s: s.irradiance(HERE, UP, accuracy=lucerna.Accuracy(floor=1))),
    ("light_selection", lambda s: s.irradiance(HERE, UP, accuracy=lucerna.Accuracy(light_selection="best"))),
    ("method", lambda s: s.power(method="guess")),
    ("accuracy", lambda s: s.irradiance(HERE, UP, samples=-1)),
    ("accuracy", lambda s: s.irradiance(HERE, UP, samples=1.5)),
    ("seed", lambda s: s.irradiance(HERE, UP, seed=-1)),
    ("bounces", lambda s: s.irradiance(HERE, UP, bounces=-1)),
    ("tint", lambda s: s.edit(lucerna.edits.change(1, tint=[1, 2]))),
    ("timeout", lambda s: s.within(0)),
    ("across and up", lambda s: lucerna.grid(UP, UP, UP, columns=2, rows=2)),
    ("columns and rows", lambda s: lucerna.grid(UP, (1, 0, 0), (0, 1, 0), columns=0, rows=2)),
    ("corner", lambda s: lucerna.grid((1, 2), UP, UP, columns=2, rows=2)),
    # These reach the server.
    ("accuracy.samples", lambda s: s.irradiance(HERE, UP, samples=10**9)),
    ("bounces", lambda s: s.irradiance(HERE, UP, wavelengths_nm=[500])),
    ("wavelengths_nm", lambda s: s.irradiance(HERE, UP, wavelengths_nm=[5], bounces=0)),
    ("rect", lambda s: s.tile((0, 0, 10**6, 1))),
])
def test_violations_name_the_field(rectangle, field, call):
    with pytest.raises(lucerna.InvalidArgument) as error:
        call(rectangle)
    assert any(name.startswith(field) for name in fields(error)), error.value.violations
    assert error.value.code == grpc.StatusCode.INVALID_ARGUMENT and error.value.reason == "BAD_FIELD"
    assert field in str(error.value) and isinstance(error.value, ValueError)


def test_allowed_words_are_listed(rectangle):
    with pytest.raises(lucerna.InvalidArgument, match="is 'best', allowed: all, bvh, power, uniform"):
        rectangle.irradiance(HERE, UP, accuracy=lucerna.Accuracy(light_selection="best"))


def test_bad_points_have_a_status_and_do_not_fail_the_others(rectangle):
    points = np.array([[0, -2, 0.5], [np.nan, 0, 0.5], [np.inf, 0, 0.5], [0, -2, 0.5]])
    answer = rectangle.irradiance(points, [UP, UP, UP, (0, 0, 0)], samples=4, bounces=0)
    assert [lucerna.STATUS[s] for s in answer.status] == ["OK", "INVALID_INPUT", "INVALID_INPUT", "INVALID_INPUT"]
    assert answer.illuminance[0] > 0 and np.all(answer.illuminance[1:] == 0)
    huge = rectangle.irradiance([[1e300, 0, 0], [0, -2, 0.5]], UP, samples=4, bounces=0)
    assert huge.status[0] != 1 and huge.status[1] == 1


def test_errors_of_the_server_have_code_reason_and_request(server, rectangle):
    with pytest.raises(lucerna.NotFound) as error:
        server.load("missing.pbrt")
    assert error.value.reason == "NOT_FOUND" and error.value.code == grpc.StatusCode.NOT_FOUND
    assert error.value.request_id and error.value.request_id in server.log()
    with pytest.raises(lucerna.NotFound) as error:
        server.scene("0" * 64).irradiance(HERE, UP)
    assert error.value.reason == "SCENE_NOT_LOADED" and isinstance(error.value, LookupError)
    with pytest.raises(lucerna.NotFound) as error:
        rectangle.pdf_li(HERE, UP, light=99)
    assert error.value.reason == "NO_SUCH_LIGHT"
    with pytest.raises(lucerna.InvalidArgument, match=r"allowed: standard, unitless, raw"):
        server.load("point.pbrt", blender="watts")


def test_a_broken_scene_names_its_place(tmp_path):
    (tmp_path / "broken.pbrt").write_text('WorldBegin\nShape "sphere" "float radius" [oops]\n')
    with lucerna.local(tmp_path, patience=WAIT_S, timeout=WAIT_S) as server:
        with pytest.raises(lucerna.InvalidArgument, match=r"broken\.pbrt:2:\d+: ") as error:
            server.load("broken.pbrt")
        assert error.value.reason == "INVALID_INPUT" and server.scenes() == ()


def test_a_full_memory_says_when_to_retry(tmp_path):
    (tmp_path / "a.pbrt").write_text('WorldBegin\nShape "sphere"\n')
    (tmp_path / "b.pbrt").write_text('WorldBegin\nShape "sphere" "float radius" 2\n')
    with lucerna.local(tmp_path, patience=WAIT_S, timeout=WAIT_S) as probe:
        size = probe.load("a.pbrt").description().summary.bytes
    with lucerna.local(tmp_path, patience=WAIT_S, timeout=WAIT_S,
                       arguments=["--memory-budget", str(size + size // 2)]) as server:
        server.load("a.pbrt", lease_s=600)
        with pytest.raises(lucerna.ResourceExhausted) as error:
            server.load("b.pbrt")
        assert error.value.reason == "MEMORY_LEASED" and 1 < error.value.retry_after_s <= 600


def test_no_server_is_unavailable():
    with socket.socket() as taken:  # bound and not listening, so that nobody else takes the port
        taken.bind(("127.0.0.1", 0))
        with lucerna.connect(f"127.0.0.1:{taken.getsockname()[1]}", timeout=WAIT_S) as server:
            with pytest.raises(lucerna.Unavailable) as error:
                server.info()
    assert isinstance(error.value, ConnectionError) and error.value.request_id == ""


def test_the_deadline_ends_a_call(rectangle):
    with pytest.raises(lucerna.DeadlineExceeded) as error:
        rectangle.within(0.2).irradiance(np.tile([0, 0, 0.5], (8192, 1)), UP, samples=1 << 20)
    assert isinstance(error.value, TimeoutError)
    assert rectangle.within(WAIT_S).power().total > 0


def test_files_of_the_connection_are_checked(tmp_path):
    with pytest.raises(lucerna.InvalidArgument, match="ca: .*cannot be read: No such file"):
        lucerna.connect(ca=tmp_path / "missing.pem")
    with pytest.raises(lucerna.InvalidArgument, match="both or neither"):
        lucerna.connect(certificate=tmp_path / "missing.pem")
    with pytest.raises(lucerna.InvalidArgument, match="without encryption"):
        lucerna.connect("lights.example:50051", token="secret")
    with pytest.raises(lucerna.InvalidArgument, match="only visible ASCII"):
        lucerna.connect(token="two words")
    (tmp_path / "empty").write_text("\n")
    with pytest.raises(lucerna.InvalidArgument, match="no token in its first line"):
        lucerna.connect(token_file=tmp_path / "empty")
    with pytest.raises(lucerna.InvalidArgument, match="in_flight"):
        lucerna.connect(in_flight=0)
    with pytest.raises(lucerna.InvalidArgument, match="target: is empty"):
        lucerna.connect("")


def test_a_bare_host_has_the_default_port():
    for given, wanted in (("localhost", "localhost:50051"), ("[::1]", "[::1]:50051"), ("a:1", "a:1"),
                          ("unix:/run/x", "unix:/run/x"), ("dns:///a:1", "dns:///a:1"), ("::1", "[::1]:50051"),
                          ("dns:///a", "dns:///a:50051"), ("ipv4:127.0.0.1:1,127.0.0.2:65535",) * 2):
        with lucerna.connect(given) as server:
            assert server.target == wanted


# gRPC takes ports modulo 65536: 119537 is 54001.
@pytest.mark.parametrize("port", ["119537", "65536", "0", "-1", "99999999999999999999", "0x50", "http", "+80", ""])
def test_ports_of_no_server_are_refused(port):
    for start, host in (("", "127.0.0.1:"), ("", "[::1]:"), ("dns:///", "a:"), ("dns:", "a:"),
                        ("ipv4:10.0.0.1:1,", "127.0.0.1:")):
        wanted = re.escape(f'target: "{host}{port}": port "{port}", allowed: 1 to 65535')
        with pytest.raises(lucerna.InvalidArgument, match=wanted):
            lucerna.connect(f"{start}{host}{port}")
        with pytest.raises(lucerna.InvalidArgument, match=wanted):
            lucerna.aio.connect(f"{start}{host}{port}")


@pytest.mark.parametrize("target", [":50051", "::1:119537", "[::1:119537]", "http://a:1", "a:1,b:2", "[a]:1", "a b:1"])
def test_hosts_that_are_none_are_refused(target):
    with pytest.raises(lucerna.InvalidArgument, match="target: .*allowed: HOST:PORT"):
        lucerna.connect(target)


def test_only_loopback_takes_a_token_without_encryption():
    with lucerna.connect("127.0.0.1", token="secret"), lucerna.connect("[::1]:1", token="secret"):
        pass
    for target in ("127.example.org", "dns:///lights.example:1", "ipv4:127.0.0.1:1,10.0.0.7:1"):
        with pytest.raises(lucerna.InvalidArgument, match="without encryption"):
            lucerna.connect(target, token="secret")
