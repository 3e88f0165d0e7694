"""Plays a cache of scripts/pointcache in Blender, without a screen, and compares where its points are with the run's frames.

  blender --background --factory-startup --python scripts/rendering/with_blender.py -- DIR NAME.pc2 [...]

Sample k of a cache is frame k of Blender's. The largest distance between the points and those of frames.h5 is printed for each cache;
more than 1e-6 of the largest coordinate ends the run with 1.
"""
import os
import sys

import bpy
import numpy as np

directory, *caches = sys.argv[sys.argv.index('--') + 1:]
scene = bpy.context.scene


def samples_of(path):
    """The file's own samples, to compare with: [samples, points, 3]."""
    with open(path, 'rb') as file:
        data = file.read()
    if path.endswith('.pc2'):
        points, samples = np.frombuffer(data, '<i4', 1, 16)[0], np.frombuffer(data, '<i4', 1, 28)[0]
        return np.frombuffer(data, '<f4', offset=32).reshape(samples, points, 3)
    samples, points = np.frombuffer(data, '>i4', 2)
    return np.frombuffer(data, '>f4', offset=8 + 4 * samples).reshape(samples, points, 3)


def played(cloth, frame):
    scene.frame_set(frame)
    mesh = cloth.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    places = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get('co', places)
    matrix = np.array(cloth.matrix_world)
    return places.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]


worst = 0
for name in caches:
    path = os.path.join(directory, 'caches', name)
    bpy.ops.wm.obj_import(filepath=path[:-4] + '.obj', forward_axis='Y', up_axis='Z')
    cloth = bpy.context.selected_objects[0]
    cache = cloth.modifiers.new('cache', 'MESH_CACHE')
    cache.cache_format, cache.filepath = path[-3:].upper(), path
    expected = samples_of(path)
    scene.frame_end = len(expected)
    misses = [np.abs(played(cloth, k) - places).max() for k, places in enumerate(expected)]
    moved = np.abs(expected[-1] - expected[0]).max()
    worst = max(worst, max(misses) / np.abs(expected).max())
    print(f'{name}: {len(expected)} samples of {expected.shape[1]} points, which move by up to {moved:.3g} m, are played to {max(misses):.2g} m')
sys.exit(worst > 1e-6)
