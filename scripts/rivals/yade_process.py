"""Runs a case (spheres_case.py) by YADE: Hertz and Mindlin.    yade -n -x -j1 yade_process.py CASE.json RESULT.npz"""
# pylint: disable=undefined-variable
import math
import os
import sys
import time

import numpy as np

sys.path.insert(0, os.environ['UNIBODY_RIVALS'])
from spheres_case import read, whole_steps  # noqa: E402

case = read(sys.argv[1])
samples, count = whole_steps(case)
materials = [O.materials.append(FrictMat(young=case['young'], poisson=case['poisson'], density=2000, frictionAngle=0.3, label=name))  # noqa: F821
             for name in case['materials']]
own = {}  # a material for each density; friction and restitution go by pairs of them
spheres = []
for given in case['spheres']:
    key = (given['material'], given['density'])
    if key not in own:
        own[key] = O.materials.append(FrictMat(young=case['young'], poisson=case['poisson'], density=given['density'], frictionAngle=0.3))  # noqa: F821
    spheres.append(O.bodies.append(sphere(given['position'], given['radius'], material=own[key])))  # noqa: F821
    O.bodies[spheres[-1]].state.vel = given['velocity']  # noqa: F821
turning = []
for mesh in case['meshes']:
    ids = O.bodies.append([facet(triangle, material=materials[mesh['material']]) for triangle in mesh['triangles']])  # noqa: F821
    if mesh['spin']:
        turning.append(RotationEngine(ids=ids, rotationAxis=mesh['axis'], angularVelocity=mesh['spin'], rotateAroundZero=True, zeroPoint=mesh['point']))  # noqa: F821
for plane in case['planes']:
    place = [0, 0, 0]
    place[plane['axis']] = plane['place']
    O.bodies.append(wall(place, plane['axis'], sense=plane['normal'], material=materials[plane['material']]))  # noqa: F821
numbers = [(material, k) for k, material in enumerate(materials)] + [(k, key[0]) for key, k in own.items()]
pairs = [(a, b, i, j) for a, i in numbers for b, j in numbers if a <= b]
friction = MatchMaker(matches=[(a, b, math.atan(case['friction'][i][j])) for a, b, i, j in pairs])  # noqa: F821
restitution = MatchMaker(matches=[(a, b, case['restitution'][i][j]) for a, b, i, j in pairs])  # noqa: F821
O.engines = [  # noqa: F821
    ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb(), Bo1_Wall_Aabb()]),  # noqa: F821
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],  # noqa: F821
                    [Ip2_FrictMat_FrictMat_MindlinPhys(frictAngle=friction, en=restitution)], [Law2_ScGeom_MindlinPhys_Mindlin()]),  # noqa: F821
    *turning, NewtonIntegrator(gravity=(0, 0, -case['gravity']), damping=0)]  # noqa: F821
O.dt = case['step']  # noqa: F821
places = np.full((count + 1, len(spheres), 3), np.nan)
seconds = 0
for sample in range(count + 1):
    if sample > 0:
        start = time.perf_counter()
        O.run(samples, True)  # noqa: F821
        seconds += time.perf_counter() - start
    places[sample] = [O.bodies[k].state.pos for k in spheres]  # noqa: F821
np.savez(sys.argv[2], time=case['every'] * np.arange(count + 1), position=places, seconds=seconds)
