"""Every call gives the bits of the command line for the same request, or a closed form."""
import os
import struct
import subprocess

import grpc
import lucerna
import numpy as np
import pytest
from conftest import REFERENCE, WAIT_S, floats
from lucerna.v1 import render_pb2, render_pb2_grpc

UP = (0.0, 0.0, 1.0)


def joined(*columns):
    return np.concatenate([np.broadcast_to(c, columns[0].shape) for c in columns], axis=1)


def test_irradiance_has_the_bits_of_the_command_line(ask, many, points):
    wanted = ask("irradiance", many.id, "--points", "-", "--samples", 32, "--bounces", 1, "--per-light", "--seed", 3,
                 points=joined(points, UP))
    got = many.irradiance(points, UP, samples=32, bounces=1, per_light=True, seed=3)
    for name, field in (("illuminance", "illuminanceLx"), ("low", "lowerLx"), ("high", "upperLx"),
                        ("standard_error", "standardErrorLx"), ("zero_bound", "zeroBoundLx")):
        assert np.array_equal(getattr(got, name), floats(wanted[field], 40)), name
    assert np.array_equal(got.irradiance, floats(wanted["irradianceLx"], 40, 3))
    assert got.illuminance.max() > 0 and np.all(got.samples == 32)
    # A point lies in the box.
    names = [f"ITEM_STATUS_{lucerna.STATUS[s]}" for s in got.status]
    assert names == wanted["status"] and set(names) == {"ITEM_STATUS_OK", "ITEM_STATUS_INSIDE_SOLID"}
    assert [int(s["lightId"]) for s in wanted["shares"]] == got.shares.light_ids.tolist()
    for name, field in (("illuminance", "illuminanceLx"), ("low", "lowerLx"), ("high", "upperLx"),
                        ("standard_error", "standardErrorLx")):
        rows = floats([s[field] for s in wanted["shares"]], 400, 40)
        assert np.array_equal(getattr(got.shares, name), rows), name


def test_illuminance_of_a_point_light_equals_its_closed_form(server):
    """The light of 10 cd is at (1.2, -1.5, 3.2) and sees the whole floor before the box."""
    scene = server.load("point.pbrt")
    floor = lucerna.grid((-2, -4, 0), (4, 0, 0), (0, 2, 0), columns=7, rows=5)
    answer = scene.irradiance(floor, bounces=0)
    to_light = np.array([1.2, -1.5, 3.2]) - floor.points
    distance = np.linalg.norm(to_light, axis=-1)
    assert answer.illuminance.shape == (5, 7) and answer.irradiance.shape == (5, 7, 3)
    np.testing.assert_allclose(answer.illuminance, 10 * 3.2 / distance**3, rtol=1e-6)
    assert np.array_equal(answer.low, answer.illuminance) and np.array_equal(answer.high, answer.illuminance)


def test_irradiance_meets_a_target_error(ask, rectangle, points):
    accuracy = lucerna.Accuracy(error=0.05, floor=0.01, confidence=0.9, max_samples=4096, closed_forms="off")
    got = rectangle.irradiance(points, UP, accuracy=accuracy, bounces=0)
    wanted = ask("irradiance", rectangle.id, "--points", "-", "--error", 0.05, "--floor", 0.01, "--confidence", 0.9,
                 "--max-samples", 4096, "--closed-forms", "off", "--bounces", 0, points=joined(points, UP))
    assert np.array_equal(got.illuminance, floats(wanted["illuminanceLx"], 40))
    assert got.samples.tolist() == wanted["itemCosts"]["samples"] and len(set(got.samples.tolist())) > 1


def test_irradiance_at_wavelengths(ask, server, points):
    scene = server.load("blackbody.pbrt")
    got = scene.irradiance(points, UP, samples=16, bounces=0, wavelengths_nm=[450, 600])
    wanted = ask("irradiance", scene.id, "--points", "-", "--samples", 16, "--bounces", 0, "--wavelength", "450,600",
                 points=joined(points, UP))
    assert np.array_equal(got.spectral, floats(wanted["spectralIrradiance"], 40, 2)) and got.spectral.max() > 0
    assert np.array_equal(got.spectral_standard_error, floats(wanted["spectralStandardError"], 40, 2))


def test_irradiance_of_one_sample_has_no_interval(rectangle):
    answer = rectangle.irradiance([0, 0, 0.2], UP, samples=1, bounces=1)
    assert answer.illuminance.shape == () and answer.low is None and answer.standard_error is None


def test_time_budget_gives_the_number_of_samples(rectangle, points):
    answer = rectangle.irradiance(points, UP, budget_s=0.05, bounces=1)
    again = rectangle.irradiance(points, UP, samples=int(answer.samples.max()), bounces=1)
    assert np.array_equal(answer.illuminance, again.illuminance)


def test_sample_li_has_the_bits_of_the_command_line(ask, many, points):
    wanted = ask("sample", many.id, "--points", "-", "--samples", 4, "--visible", "--seed", 5, "--normal", "0,0,1",
                 points=points)
    got = many.sample_li(points, UP, samples=4, test_visibility=True, seed=5)
    assert np.array_equal(got.value, floats(wanted["value"], 40, 4, 3)) and got.value.max() > 0
    assert np.array_equal(got.wi, floats(wanted["wi"], 40, 4, 3))
    assert np.array_equal(got.distance, floats(wanted["distanceM"], 40, 4))
    assert np.array_equal(got.density, floats(wanted["pdfPerSr"], 40, 4))
    assert np.array_equal(got.light_ids, np.array(wanted["lightIds"], np.uint64).reshape(40, 4))
    assert np.array_equal(got.probability, np.array(wanted["selectionProbability"]).reshape(40, 4))
    assert got.delta.all() and got.receiver[7].tolist() == [7] * 4
    assert 0 < got.visible.mean() < 1


def test_samples_end_on_the_light(rectangle, points):
    points = points * (1, 1, 0) + (0, 0, 0.25)  # offsets then have an origin
    got = rectangle.sample_li(points, light=1)
    assert got.value.shape == (40, 3) and got.light_ids is None and got.probability is None
    corners = rectangle.lights().messages[0].bounds
    low, high = (np.array([c.x, c.y, c.z]) for c in (corners.lower_m, corners.upper_m))
    assert np.all(got.light_points >= low - 1e-5) and np.all(got.light_points <= high + 1e-5)
    reached = got.distance > 0
    np.testing.assert_allclose((points + got.distance[:, None] * got.wi)[reached], got.light_points[reached], atol=1e-5)


def test_own_sample_values_are_sent(ask, rectangle, points):
    u = np.random.default_rng(3).random((40, 2)).astype(np.float32)
    got = rectangle.sample_li(points, light=1, u=u)
    options = [x for pair in u for x in ("--u", f"{pair[0]!r},{pair[1]!r}")]
    wanted = ask("sample", rectangle.id, "--points", "-", "--light", 1, *options, points=points)
    assert np.array_equal(got.wi, floats(wanted["wi"], 40, 3))
    free = rectangle.sample_li(points, u=u, u_light=np.full(40, 0.5))
    assert np.array_equal(free.wi, got.wi) and np.all(free.light_ids == 1)


def test_sample_li_to_a_target_has_estimates(ask, many, points):
    got = many.sample_li(points, UP, accuracy=lucerna.Accuracy(max_samples=256, error=0.3), seed=2)
    wanted = ask("sample", many.id, "--points", "-", "--normal", "0,0,1", "--error", 0.3, "--max-samples", 256,
                 "--seed", 2, points=points)
    assert np.array_equal(got.estimates.illuminance, floats(wanted["estimates"]["illuminanceLx"], 40))
    assert got.estimates.samples.tolist() == wanted["estimates"]["samples"]
    assert np.array_equal(got.value, floats(wanted["value"], -1, 3))
    assert np.array_equal(np.bincount(got.receiver, minlength=40), got.estimates.samples)
    assert np.all(got.estimates.low <= got.estimates.high)


def test_sample_li_to_a_target_has_the_default_most_samples(ask, many, points):
    """The number follows from the limits of the server, and not from the number of points."""
    got = many.sample_li(points[:4], UP, error=0.03, seed=2)
    wanted = ask("sample", many.id, "--points", "-", "--normal", "0,0,1", "--error", 0.03, "--seed", 2,
                 points=points[:4])
    assert got.estimates.samples.tolist() == wanted["estimates"]["samples"] and got.estimates.samples.max() > 500


def test_pdf_li_is_the_density_of_the_samples(ask, rectangle, points):
    samples = rectangle.sample_li(points, light=1, seed=4)
    got = rectangle.pdf_li(points, samples.wi, light=1)
    wanted = ask("pdf", rectangle.id, "--points", "-", "--light", 1, points=joined(points, samples.wi.astype(float)))
    assert np.array_equal(got.density, floats(wanted["pdfPerSr"], 40))
    ok = samples.status == 1
    np.testing.assert_allclose(got.density[ok], samples.density[ok], rtol=1e-3)
    assert ok.sum() > 30


def test_emitted_rays_and_their_densities(ask, server):
    scene = server.load("rectangle.pbrt")
    got = scene.sample_le(50, light=1, seed=6)
    wanted = ask("emit", scene.id, "--light", 1, "--count", 50, "--seed", 6)
    assert np.array_equal(got.offsets, floats(wanted["points"]["offsetsM"], 50, 3))
    assert np.array_equal(got.directions, floats(wanted["directions"], 50, 3))
    assert np.array_equal(got.value, floats(wanted["value"], 50, 3))
    # The power is the mean of value |n.direction| / (densities).
    cosine = np.abs(np.sum(got.light_normals * got.directions, axis=1))
    density = got.density_position * got.density_direction
    flux = np.mean(got.value[:, 1] * cosine / density)
    np.testing.assert_allclose(flux, scene.power().rgb[0, 1], rtol=1e-4)
    again = scene.pdf_le(got, light=1)
    assert np.array_equal(again.density_position, got.density_position)
    assert np.array_equal(again.density_direction, got.density_direction)
    typed = scene.pdf_le(got.points, got.directions, light=1)
    np.testing.assert_allclose(typed.density_direction, got.density_direction, rtol=1e-5)


def test_le_of_rays_that_meet_the_light(ask, rectangle, points):
    towards = rectangle.sample_li(points, light=1).wi.astype(float)
    towards[::2] = (0, 0, -1)
    got = rectangle.le(points, towards)
    wanted = ask("le", rectangle.id, "--points", "-", points=joined(points, towards))
    assert np.array_equal(got.radiance, floats(wanted["radianceCdM2"], 40, 3))
    assert got.light_ids.tolist() == [int(i) for i in wanted["lightIds"]] and set(got.light_ids.tolist()) == {0, 1}


def test_visibility_of_segments_and_rays(server, ask):
    scene = server.load("point.pbrt")
    # The box about (0.8, 0.2) is 1.2 m high; the floor is at z = 0.
    starts, ends = np.array([[0.8, -1.5, 0.5], [0.8, -1.5, 2]]), np.array([[0.8, 1.5, 0.5], [0.8, 1.5, 2]])
    assert scene.visible(starts, ends).visible.tolist() == [False, True]
    assert scene.visible(starts, directions=(0, 0, -1)).visible.tolist() == [False, False]
    assert scene.visible(starts, directions=(0, 0, -1), lengths_m=[0.4, 3]).visible.tolist() == [True, False]
    wanted = ask("visible", scene.id, "--points", "-", points=joined(starts, ends))
    assert wanted["count"] == 2 and scene.visible(starts, ends).visible.dtype == np.bool_


def test_surfaces_of_the_picture_are_receivers(server):
    """The floor before the box is at z = 0; the light of 10 cd is at (1.2, -1.5, 3.2)."""
    scene = server.load("point.pbrt")
    x, y = np.meshgrid(np.arange(160) + 0.5, np.arange(120) + 0.5)
    places = np.stack([x, y], axis=-1)  # more than one batch
    places[0, 0] = (-1, 0)
    surfaces = scene.find_surfaces(places)
    request = render_pb2.FindSurfacesRequest(scene_id=scene.id, places=places.ravel().tolist())
    with grpc.insecure_channel(server.target) as channel:
        raw = render_pb2_grpc.RenderServiceStub(channel).FindSurfaces(request, timeout=WAIT_S)
    offsets = np.array(raw.points.offsets_m).reshape(120, 160, 3)
    origin = (raw.points.origin_m.x, raw.points.origin_m.y, raw.points.origin_m.z)
    assert np.array_equal(surfaces.points, offsets + origin)
    assert np.array_equal(surfaces.normals.ravel(), raw.normals)
    assert surfaces.status.ravel().tolist() == list(raw.status) and surfaces.status[0, 0] == 7
    assert surfaces.found[1:].all() and not surfaces.found[0, 0] and surfaces.light_ids.shape == (120, 160)
    row = scene.irradiance(surfaces, bounces=0).illuminance[-1]
    to_light = np.array([1.2, -1.5, 3.2]) - surfaces.points[-1]
    assert np.allclose(surfaces.normals[-1], UP) and np.abs(surfaces.points[-1, :, 2]).max() < 1e-6
    np.testing.assert_allclose(row, 32 / np.linalg.norm(to_light, axis=1) ** 3, rtol=1e-5)


def test_surfaces_far_from_zero(tmp_path):
    """The offsets of the answer then have an origin."""
    (tmp_path / "far.pbrt").write_text(
        'Film "rgb" "integer xresolution" 8 "integer yresolution" 8\n'
        "LookAt 1000 2000 5  1000 2000 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\n"
        'Shape "bilinearmesh" "point3 P" [990 1990 3  1010 1990 3  990 2010 3  1010 2010 3]\n')
    with lucerna.local(tmp_path, patience=WAIT_S, timeout=WAIT_S) as server:
        surfaces = server.load("far.pbrt").find_surfaces((4, 4))
        assert surfaces.found and np.allclose(surfaces.normals, UP)
        np.testing.assert_allclose(surfaces.points, (1000, 2000, 3), atol=1e-4)


def test_power_is_exact_sampled_and_approximate(ask, rectangle, many):
    wanted = ask("power", rectangle.id)
    got = rectangle.power()
    assert got.total == wanted["total"]["powerLm"] and got.error[0] == 0 and np.isnan(got.low[0])
    sampled = rectangle.power([1], method="sampled", samples=64, seed=9)
    other = ask("power", rectangle.id, "--method", "sampled", "--samples", 64, "--seed", 9)["lights"][0]
    assert sampled.flux[0] == other["powerLm"] and sampled.low[0] == other["lowerLm"] and sampled.samples[0] == 64
    assert rectangle.power(method="approximate").flux[0] == ask("power", rectangle.id, "--method", "approximate")[
        "lights"][0]["powerLm"]
    assert many.power([3, 1]).light_ids.tolist() == [3, 1] and len(many.power().flux) == 400


def test_lights_are_described(many, rectangle):
    lights = many.lights()
    assert len(lights) == 400 and set(lights.kinds) == {"point"} and lights.delta.all() and np.isnan(lights.area).all()
    np.testing.assert_allclose(lights.power[0], 4 * np.pi * 0.08286, rtol=1e-6)
    assert rectangle.lights().area[0] > 0 and rectangle.lights().kinds == ("diffuse_area",)


def read_pfm(path):
    data = path.read_bytes()
    head, size, scale, rows = data.split(b"\n", 3)
    width, height = map(int, size.split())
    assert head == b"PF" and float(scale) < 0
    return np.array(struct.unpack(f"<{3 * width * height}f", rows)).reshape(height, width, 3)[::-1]


def test_picture_equals_that_of_the_command_line(server, tmp_path):
    scene = server.load("point.pbrt")
    subprocess.run([os.environ["LUCERNA_CLI"], "--server", server.target, "render", scene.id, "--samples", "2", "-o",
                    tmp_path / "picture.pfm"], check=True, capture_output=True, timeout=WAIT_S)
    tiles = []
    got = scene.render(samples=2, one_sequence=True, on_tile=tiles.append)
    assert np.array_equal(got.pixels.astype(np.float32), read_pfm(tmp_path / "picture.pfm").astype(np.float32))
    assert got.pixels.shape == (120, 160, 3) and got.pixels.max() > 0 and np.all(got.samples == 2) and len(tiles) > 6
    assert got.srgb().dtype == np.uint8 and got.srgb().max() == 255 and not got.may_miss_light


def test_tile_is_a_part_of_the_picture(server):
    scene = server.load("point.pbrt")
    whole = scene.tile(samples=2, samples_per_block=1)
    part = scene.tile((32, 16, 48, 24), samples=2, samples_per_block=1)
    assert whole.pixels.shape == (120, 160, 3) and part.pixels.shape == (8, 16, 3) and (part.x0, part.y0) == (32, 16)
    assert np.array_equal(part.sum, whole.sum[16:24, 32:48]) and part.blocks == 2
    np.testing.assert_array_equal(part.standard_error, np.sqrt(part.deviation / 2))


def test_tile_to_a_target_has_intervals(server):
    part = server.load("rectangle.pbrt").tile((80, 60, 84, 64), error=0.2, bounces=0)
    assert part.low.shape == (4, 4) and np.all(part.low <= part.high) and part.samples.min() >= 1


def test_edits_make_a_revision(server, rectangle):
    dimmed = rectangle.edit(lucerna.edits.change(1, scale=0.5, tint=(1, 1, 1)))
    assert dimmed.id != rectangle.id
    np.testing.assert_allclose(dimmed.power().total, rectangle.power().total / 2, rtol=1e-12)
    dark = rectangle.edit(lucerna.edits.change(1, on=False))
    assert dark.power().total == 0
    moved = server.load("point.pbrt").edit(lucerna.edits.change(1, shift=(0, 0, 1)))
    assert moved.lights().messages[0].point.position_m.z == pytest.approx(4.2)
    light = moved.lights().messages[0]
    light.id = 0
    more = moved.edit(lucerna.edits.put(light), lucerna.edits.remove(1))
    assert len(more.new_lights) == 1 and more.lights().ids.tolist() == list(more.new_lights)
    loaded = server.load("rectangle.pbrt", edits=[lucerna.edits.change(1, scale=0.5, tint=(1, 1, 1))])
    assert loaded.id == dimmed.id


def test_edits_find_lights_by_name(tmp_path):
    (tmp_path / "two.pbrt").write_text(
        'WorldBegin\nLightSource "point" "string name" "lamp" "rgb I" [1 1 1]\n'
        'LightSource "point" "string name" "lamp" "rgb I" [2 2 2]\n'
        'LightSource "point" "string name" "other" "rgb I" [4 4 4]\n')
    with lucerna.local(tmp_path, patience=WAIT_S, timeout=WAIT_S) as server:
        scene = server.load("two.pbrt")
        np.testing.assert_allclose(scene.edit(lucerna.edits.change("lamp", scale=0)).power().total, 16 * np.pi)
        assert scene.edit(lucerna.edits.remove("other")).lights().names == ("lamp", "lamp")
        assert scene.power(["other"]).light_ids.tolist() == [3]
        assert scene.sample_li([0, 0, 1], light="other").value[0] == pytest.approx(4)
        with pytest.raises(lucerna.NotFound, match='no light named "desk"'):
            scene.edit(lucerna.edits.change("desk", scale=2))


def test_server_describes_itself(server, rectangle):
    info = server.info()
    assert info.threads == 2 and info.limits.max_batch_items == 65536
    assert any(call.method.endswith("GetServerInfo") for call in server.stats().calls)
    assert rectangle.id in [s.scene_id for s in server.scenes()] and "point.pbrt" in server.available()
    assert rectangle.description().summary.lights == 1


def test_leases_keep_scenes(server):
    scene = server.load("sphere.pbrt", lease_s=600)
    assert scene.lease_id in [lease.lease_id for lease in server.leases()]
    with pytest.raises(lucerna.FailedPrecondition, match="leased"):
        server.scene(scene.id).release()
    assert scene.renew(60, scene.lease_id) == scene.lease_id
    assert scene.release() is False
    with pytest.raises(lucerna.NotFound):
        scene.power()


def test_upload_sends_a_scene_with_its_files(tmp_path, rectangle):
    sent = []
    with lucerna.local(tmp_path, patience=WAIT_S, timeout=WAIT_S) as server:
        scene = server.upload(REFERENCE / "textured.pbrt", progress=lambda *step: sent.append(step))
        assert {name for name, _, _ in sent} >= {"textured.pbrt", "screen.exr"}
        assert all(done == size for name, done, size in sent if size < 1 << 20)
        assert scene.lights().power[0] > 0
        sent.clear()
        assert server.upload(REFERENCE / "textured.pbrt", progress=lambda *step: sent.append(step)).id == scene.id
        assert sent == []
        with pytest.raises(lucerna.NotFound, match="no such file"):
            server.upload(tmp_path / "missing.pbrt")
        with pytest.raises(lucerna.InvalidArgument, match="is not inside"):
            server.upload(REFERENCE / "textured.pbrt", root=tmp_path)
        (tmp_path / "inner").mkdir()
        (tmp_path / "inner/scene.pbrt").write_text('WorldBegin\nInclude "../outer.pbrt"\n')
        (tmp_path / "outer.pbrt").write_text('LightSource "point"\n')
        with pytest.raises(lucerna.InvalidArgument):
            server.upload(tmp_path / "inner/scene.pbrt")
        assert len(server.upload(tmp_path / "inner/scene.pbrt", root=tmp_path).lights()) == 1
        (tmp_path / "inner/link.pbrt").symlink_to("../outer.pbrt")
        (tmp_path / "inner/linked.pbrt").write_text('WorldBegin\nInclude "link.pbrt"\n')
        with pytest.raises(lucerna.InvalidArgument, match="link.pbrt is outside .*; only files inside it are sent"):
            server.upload(tmp_path / "inner/linked.pbrt")
