import lucerna
scene = lucerna.connect().load("demo.pbrt")
print(f"power {scene.power().total:g} lm")
