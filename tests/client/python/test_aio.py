"""The methods for asyncio give the answers of the blocking ones."""
import asyncio
import inspect

import lucerna
import numpy as np
import pytest
from conftest import REFERENCE, WAIT_S

UP = (0.0, 0.0, 1.0)


def run(coroutine):
    async def bounded():
        return await asyncio.wait_for(coroutine, WAIT_S)
    return asyncio.run(bounded())


def test_every_method_has_its_coroutine():
    for blocking, other in ((lucerna.Server, lucerna.aio.Server), (lucerna.Scene, lucerna.aio.Scene)):
        names = [n for n in vars(blocking) if not n.startswith("_")]
        assert len(names) > 8
        for name in names:
            ours, theirs = inspect.getattr_static(blocking, name), inspect.getattr_static(other, name)
            if name in ("within", "scene", "target"):
                continue
            assert inspect.iscoroutinefunction(theirs) and not inspect.iscoroutinefunction(ours), name
            assert inspect.signature(ours).parameters.keys() == inspect.signature(theirs).parameters.keys(), name
            assert ours.__doc__ and theirs.__doc__, name


def test_answers_are_those_of_the_blocking_client(server, points):
    crowd = np.tile(points, (500, 1))  # several batches
    scene = server.load("rectangle.pbrt")

    async def ask():
        async with lucerna.aio.connect(server.target, timeout=WAIT_S) as client:
            other = await client.load("rectangle.pbrt")
            assert other.id == scene.id
            answers = await asyncio.gather(
                other.irradiance(crowd, UP, samples=2, bounces=0, seed=1), other.sample_li(crowd, seed=2),
                other.power(), other.tile((0, 0, 16, 16), samples=2), other.render(samples=1, tile_size=64),
                other.visible(points, points[::-1]), other.lights(), client.info(), client.scenes())
            dimmed = await other.edit(lucerna.edits.change(1, scale=0.5))
            return answers, await dimmed.power()

    (light, samples, power, tile, picture, visible, lights, info, scenes), dimmed = run(ask())
    assert np.array_equal(light.illuminance, scene.irradiance(crowd, UP, samples=2, bounces=0, seed=1).illuminance)
    assert np.array_equal(samples.wi, scene.sample_li(crowd, seed=2).wi)
    assert power.total == scene.power().total and dimmed.total == pytest.approx(power.total / 2)
    assert np.array_equal(tile.sum, scene.tile((0, 0, 16, 16), samples=2).sum)
    assert np.array_equal(picture.pixels, scene.render(samples=1, tile_size=64).pixels)
    assert np.array_equal(visible.visible, scene.visible(points, points[::-1]).visible)
    assert len(lights) == 1 and info.threads == 2 and scene.id in [s.scene_id for s in scenes]


def test_progress_and_errors(server, points):
    async def ask():
        async with lucerna.aio.connect(server.target, timeout=WAIT_S) as client:
            scene, seen = await client.load("rectangle.pbrt"), []
            await scene.irradiance(np.tile(points, (500, 1)), UP, samples=1, bounces=0,
                                   progress=lambda done, total: seen.append((done, total)))
            assert seen == [(8192, 20000), (16384, 20000), (20000, 20000)]
            with pytest.raises(lucerna.NotFound) as error:
                await client.load("missing.pbrt")
            assert error.value.reason == "NOT_FOUND" and error.value.request_id
            with pytest.raises(lucerna.InvalidArgument) as error:
                await scene.irradiance(points, UP, samples=10**9)
            assert error.value.violations[0].field == "accuracy.samples"
            with pytest.raises(lucerna.DeadlineExceeded):
                await scene.within(0.2).irradiance(np.tile(points, (200, 1)), UP, samples=1 << 20)
    run(ask())


def test_cancelling_a_task_cancels_its_calls(points):
    """Otherwise the server would compute for minutes."""
    with lucerna.local(REFERENCE, threads=2, patience=WAIT_S, timeout=WAIT_S) as server:
        async def ask():
            async with lucerna.aio.connect(server.target, timeout=WAIT_S) as client:
                scene = await client.load("rectangle.pbrt")
                task = asyncio.create_task(scene.irradiance(np.tile(points, (500, 1)), UP, samples=1 << 20))

                async def running():
                    calls = (await client.stats()).calls
                    return any(c.running for c in calls if c.method.endswith("EstimateIrradiance"))

                while not await running():
                    await asyncio.sleep(0.05)
                task.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await task
                while await running():
                    await asyncio.sleep(0.05)
        run(ask())


def test_upload(tmp_path):
    with lucerna.local(tmp_path, patience=WAIT_S, timeout=WAIT_S) as server:
        async def ask():
            async with lucerna.aio.connect(server.target, timeout=WAIT_S) as client:
                scene = await client.upload(REFERENCE / "textured.pbrt")
                return scene.id, (await scene.lights()).power[0], await scene.release()
        scene_id, power, still_loaded = run(ask())
    assert len(scene_id) == 64 and power > 0 and still_loaded is False
