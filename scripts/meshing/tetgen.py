"""TetGen, the distribution's, for surfaces whose triangles must stay as they are."""
import os
import shutil
import subprocess
import tempfile

import numpy as np


class Failed(Exception):
    pass


def tetrahedralized(surface, quality, size):
    """Nodes and tets inside a closed surface. `quality` bounds the radius of a tet's sphere over its shortest edge; `size`, if
    not None, is about the length of the longest edges."""
    switches = f"-pYQq{quality}" + (f"a{size ** 3 / (6 * 2 ** 0.5):.12f}" if size else "")
    with tempfile.TemporaryDirectory() as folder:
        write_off(os.path.join(folder, "surface.off"), surface)
        words = [shutil.which("tetgen"), switches, "surface.off"]
        done = subprocess.run(words, cwd=folder, text=True, capture_output=True, check=False)
        base = os.path.join(folder, "surface.1")
        if done.returncode != 0 or not os.path.exists(base + ".ele"):
            lines = [line.strip() for line in (done.stdout + done.stderr).splitlines() if line.strip()]
            raise Failed("; ".join(lines[-3:]) or f"exit code {done.returncode}")
        return table(base + ".node", 4)[:, 1:], table(base + ".ele", 5)[:, 1:].astype(np.int64)


def write_off(path, surface):
    with open(path, "w", encoding="ascii") as file:
        file.write(f"OFF\n{len(surface.points)} {len(surface.triangles)} 0\n")
        file.writelines("%.17g %.17g %.17g\n" % tuple(point) for point in surface.points)
        file.writelines("3 %d %d %d\n" % tuple(triangle) for triangle in surface.triangles)


def table(path, columns):
    """The rows of a TetGen file behind its head."""
    with open(path, encoding="ascii") as file:
        rows = [line.split()[:columns] for line in file if line.strip() and not line.startswith("#")]
    return np.array(rows[1:], float)
