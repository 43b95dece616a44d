"""Seeds: scene files, and the files that set up lucernad."""
import hashlib
import pathlib

DATA = pathlib.Path(__file__).resolve().parent.parent / "data"


def joined(main, *names):
    """A scene of tests/data with the files that it names."""
    path = DATA / main
    text = path.read_bytes()
    for name in names:
        text += b"\n#FILE " + name.encode() + b"\n" + (path.parent / name).read_bytes()
    return text


def pbrt():
    ref = "reference/"
    yield "everything", joined("pbrt/everything.pbrt", "square.ply", "parts.pbrt")
    for name in ("moving_both", "moving_camera", "moving_point", "moving_sun", "moving_surfaces",
                 "twelve_samples"):
        yield name, joined(f"pbrt/{name}.pbrt")
    text = (DATA / "lights/every_light.pbrt").read_bytes().replace(b"../reference/", b"")
    for name in ("lights/downlight.ies", "lights/sconce.ldt", ref + "slide.exr", ref + "screen.exr",
                 ref + "sky.exr"):
        path = DATA / name
        text += b"\n#FILE " + path.name.encode() + b"\n" + path.read_bytes()
    yield "every_light", text
    for name, *files in (
            ("blackbody",), ("bounces",), ("colour",), ("cylinder",), ("disk",), ("infinite",),
            ("lens",), ("orthographic",), ("spherical",), ("mitchell",), ("gaussian",), ("portal",),
            ("point_power",), ("m_absorption",), ("m_coated",), ("m_coated_metal",),
            ("m_conductor",), ("m_conductor_aniso",), ("m_copper",), ("m_dielectric",), ("m_mix",),
            ("m_loop",), ("m_thin",), ("m_transmission",), ("m_texture_maths",),
            ("m_texture", "tiles.png"), ("m_normalmap", "bumps.png"), ("m_alpha", "holes.png"),
            ("textured", "screen.exr"), ("projection", "slide.exr")):
        text = joined(f"{ref}{name}.pbrt", *files)
        yield name, text
    yield "bom", b"\xef\xbb\xbfWorldBegin\n"
    yield "utf16", b"\xff\xfeW\0"
    yield "includes_itself", b'WorldBegin Include "scene.pbrt"'
    yield "leaves_the_root", b'WorldBegin Include "../scene.pbrt"'
    yield "unclosed", b'WorldBegin AttributeBegin ObjectBegin "a" Shape "sphere"'


def config():
    yield "all", b"""# every setting
listen = "127.0.0.1:0"
insecure = true
tls-cert = "cert.pem"
tls-key = "key.pem"
tls-client-ca = "ca.pem"
token-file = "tokens.toml"
max-connections = 100
max-peer-connections = 10
max-streams = 100
idle-seconds = 60
handshake-seconds = 20
ping-seconds = 60
min-ping-seconds = 5
scene-root = "scenes"
load = ["a.pbrt", "b.pbrt"]
threads = 2
isa = "avx2"
memory-budget = "8GiB"
texture-memory = 1048576
max-scene-primitives = 1000
max-scene-bytes = "1MiB"
max-picture-texels = 1000
max-include-depth = 3
max-tokens = 1000
max-lease = 60.5
asset-dir = "assets"
asset-budget = "16 GiB"
max-asset-bytes = "4k"
upload-timeout = 60
keep-partial-uploads = 60
max-batch-items = 2048
max-tile-pixels = 1024
max-samples = 64
max-message-bytes = "2MiB"
interactive-queue = 10
bulk-queue = 10
max-call-seconds = 1.5
metrics = "127.0.0.1:9090"
log-format = "json"
log-level = "warning"
log-lines = 0
drain-seconds = 5
"""
    yield "wrong_types", b'listen = 3\ninsecure = "yes"\nload = "a"\nload = [1]\n'
    yield "wrong_types_2", (b'load = [1]\nthreads = 1.5\nisa = "none"\nmemory-budget = true\n'
                            b'max-lease = "x"\nmax-call-seconds = nan\nmetrics = 1979-05-27\n')
    yield "out_of_range", (b'threads = 5000\nmemory-budget = "99999999999GiB"\n'
                           b'max-batch-items = 3\nmax-call-seconds = -1.0\nmax-samples = -1\n'
                           b'asset-budget = "12 parsecs"\nmax-scene-bytes = ""\n')
    yield "unknown", b"queue = 3\n[table]\nthreads = 2\n"
    yield "syntax", b"threads = \n"
    yield "twice", b"threads = 1\nthreads = 2\n"
    yield "strings", b'scene-root = """\nscenes"""\nasset-dir = \'C:\\x\'\nlisten = "\\u0041\\n"\n'
    yield "empty", b""


def token_file():
    digest = hashlib.sha256(b"a token of an example").hexdigest()
    yield "two", (f'[[token]]\nname = "render-farm"\nsha256 = "{digest}"\n'
                  'roles = ["query", "load"]\nmax-requests = 16\nmax-leases = 2\nmax-scenes = 3\n\n'
                  '[[token]]\nname = "admin.1_x"\ntoken = "0123456789abcdef"\n'
                  'roles = ["admin"]\n').encode()
    head = '[[token]]\nname = "a"\n'
    for name, text in (
            ("none", ""), ("no_name", f'[[token]]\nsha256 = "{digest}"\nroles = ["query"]\n'),
            ("no_secret", head + 'roles = ["query"]\n'),
            ("no_roles", head + f'sha256 = "{digest}"\n'),
            ("both", head + f'sha256 = "{digest}"\ntoken = "0123456789abcdef"\nroles = ["load"]\n'),
            ("short", head + 'token = "short"\nroles = ["load"]\n'),
            ("bad_digest", head + 'sha256 = "zz"\nroles = ["load"]\n'),
            ("odd_digest", head + f'sha256 = "{digest[:-1]}"\nroles = ["load"]\n'),
            ("bad_role", head + 'token = "0123456789abcdef"\nroles = ["root"]\n'),
            ("roles_text", head + 'token = "0123456789abcdef"\nroles = "query"\n'),
            ("bad_number", head + 'token = "0123456789abcdef"\nroles = ["load"]\nmax-leases = -1\n'),
            ("bad_name", '[[token]]\nname = "a b"\ntoken = "0123456789abcdef"\nroles = ["load"]\n'),
            ("unknown_key", head + 'colour = "red"\n'), ("other_table", "[token]\nname = 1\n"),
            ("list", "token = [1, 2]\n"), ("syntax", "[[token]\n"),
            ("twice", (head + 'token = "0123456789abcdef"\nroles = ["load"]\n') * 2)):
        yield name, text.encode()
