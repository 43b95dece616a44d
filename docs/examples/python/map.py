import lucerna
scene = lucerna.connect().load("room/scene.pbrt")
plane = lucerna.grid((0.5, 0.5, 0.8), (8, 0, 0), (0, 5.5, 0), columns=32, rows=22)
answer = scene.irradiance(plane, samples=64, bounces=1)
answer.plot("build/map.png")
