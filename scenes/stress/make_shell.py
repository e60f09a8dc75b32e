#!/usr/bin/env python3
"""Writes size-ratio.csv: 200 spheres of 0.1 mm around one of 0.1 m at the origin, each flying at its centre with 1 m/s."""

import math
import pathlib

LARGE, SMALL, COUNT, SPEED = 0.1, 1e-4, 200, 1.0
GOLDEN = math.pi * (3.0 - math.sqrt(5.0))

rows = ["x,y,z,radius,vx,vy,vz"]
for k in range(COUNT):
    z = 1.0 - (2 * k + 1) / COUNT
    r = math.sqrt(1.0 - z * z)
    direction = (r * math.cos(GOLDEN * k), r * math.sin(GOLDEN * k), z)
    distance = LARGE + SMALL * (1.5 + 0.5 * k / COUNT)
    place = [repr(distance * c) for c in direction]
    velocity = [repr(-SPEED * c) for c in direction]
    rows.append(",".join([*place, repr(SMALL), *velocity]))
pathlib.Path(__file__).with_name("size-ratio.csv").write_text("\n".join(rows) + "\n")
