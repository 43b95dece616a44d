"""Sends a lucernad four queries about a scene file.  Usage: ask.py HOST:PORT SCENE

The stubs: mkdir -p stubs; protoc -I proto --python_out=stubs --grpc_out=stubs \
  --plugin=protoc-gen-grpc=/usr/bin/grpc_python_plugin proto/lucerna/v1/*.proto; PYTHONPATH=stubs
"""
import sys

import grpc
from lucerna.v1 import accuracy_pb2, lighting_pb2, lighting_pb2_grpc
from lucerna.v1 import render_pb2, render_pb2_grpc, scene_pb2, scene_pb2_grpc

channel = grpc.insecure_channel(sys.argv[1])
scenes = scene_pb2_grpc.SceneServiceStub(channel)
light = lighting_pb2_grpc.LightingServiceStub(channel)
scene = scenes.LoadScene(scene_pb2.LoadSceneRequest(path=sys.argv[2])).scene_id
here = accuracy_pb2.Points(offsets_m=[1.2, -1.5, 0])
there = accuracy_pb2.Points(offsets_m=[1.2, -1.5, 3.2])

li = light.SampleLi(lighting_pb2.SampleLiRequest(
    scene_id=scene, receivers=here, seed=lighting_pb2.Seed(seed=1)))
print(f"sample {li.value[0]:g} at {li.distance_m[0]:g} m")

power = light.EstimatePower(lighting_pb2.EstimatePowerRequest(scene_id=scene))
print(f"power {power.total.power_lm:g} lm")

visibility = light.TestVisibility(lighting_pb2.TestVisibilityRequest(
    scene_id=scene, segments=lighting_pb2.Segments(**{"from": here, "to": there})))
print(f"visible {visibility.visible[0] & 1}")

tile = render_pb2_grpc.RenderServiceStub(channel).RenderTile(render_pb2.RenderTileRequest(
    scene_id=scene, accuracy=accuracy_pb2.Accuracy(samples=4))).tile
print(f"tile {tile.image_width} x {tile.image_height}")
