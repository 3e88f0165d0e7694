"""What LIGGGHTS and YADE are given of a process, and what they give back: the same spheres, triangles and planes for both.

A case is a .json file: young (Pa), poisson; materials, their names; friction and restitution, of each pair; spheres: radius (m), density
(kg/m^3), material, position (m), velocity (m/s); meshes: triangles [n][3][3] (m), material, spin (rad/s), about an axis through a point;
planes: axis, place (m), normal +1 or -1, material; gravity (m/s^2); step, end and every (s).

The result is a .npz file: time (s), position [times, spheres, 3], NaN of what has left the room; and seconds, that the steps took.
"""
import json


def read(path):
    with open(path, encoding='utf-8') as file:
        return json.load(file)


def whole_steps(case):
    """Steps between two samples, and samples."""
    return round(case['every'] / case['step']), round(case['end'] / case['every'])
