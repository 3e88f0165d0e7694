#!/usr/bin/python3
"""Turns scans, as packages hold them, into OBJ: in m, z up, standing on z = 0 above the origin.

  scans.py FILE OUT.obj [--height H]     FILE: .ply, .ply.gz, or a JavaScript module of positions and cells
"""
import argparse
import gzip
import json
import os
import re
import sys
import tempfile

import numpy as np

sys.dont_write_bytecode = True
import surface as surfaces  # noqa: E402


def from_script(path):
    """`exports.positions = [[x, y, z], ...]; exports.cells = [[i, j, k], ...]`"""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    positions, cells = (json.loads(re.search(rf"exports\.{name}\s*=\s*(\[\[.*?\]\])", text, re.S).group(1))
                        for name in ("positions", "cells"))
    return surfaces.Surface(np.array(positions, float), np.array(cells))


def from_ply(path):
    if not path.endswith(".gz"):
        return surfaces.read(path)
    with tempfile.TemporaryDirectory() as folder:
        plain = os.path.join(folder, "scan.ply")
        with gzip.open(path) as packed, open(plain, "wb") as file:
            file.write(packed.read())
        return surfaces.read(plain)


def upright(points, height):
    """From y up to z up."""
    points = np.column_stack([points[:, 0], -points[:, 2], points[:, 1]])
    low, high = points.min(0), points.max(0)
    points = points - [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]
    return points * (height / (high - low)[2] if height else 1.0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scan", metavar="FILE")
    parser.add_argument("out", metavar="OUT.obj")
    parser.add_argument("--height", type=float, help="in m (as scanned)")
    chosen = parser.parse_args()
    surface = from_script(chosen.scan) if chosen.scan.endswith(".js") else from_ply(chosen.scan)
    points = upright(surface.points, chosen.height)
    with open(chosen.out, "w", encoding="ascii") as file:
        file.writelines("v %.9g %.9g %.9g\n" % tuple(point) for point in points)
        file.writelines("f %d %d %d\n" % tuple(triangle) for triangle in surface.triangles + 1)


if __name__ == "__main__":
    main()
