"""What is to be drawn, from frames.h5, and the turns and extents of it."""
import numpy as np

SPHERE, BOX, PLANE, DISC, PARTICLE, CAPSULE, CYLINDER, HULL, COMPOUND, MESH = range(10)  # /bodies/shape
DYNAMIC, PINNED = 0, 3  # /bodies/motion; pinned nodes are held for a while


class Bodies:
    """What does not change from frame to frame."""

    def __init__(self, file):
        group = file['bodies']
        self.shape, self.size, self.motion = group['shape'][:], group['size'][:].astype(float), group['motion'][:]
        self.material = group['material'][:]
        self.count = len(self.shape)
        self.dynamic = (self.motion == DYNAMIC) | (self.motion == PINNED)
        # Of each cloth its triangles and of each thread its segments, between bodies; the nodes themselves are not drawn.
        surfaces = file['surfaces'] if 'surfaces' in file else {}
        self.surfaces = [surfaces[name]['cells'][:] for name in sorted(surfaces)]
        self.is_node = np.zeros(self.count, bool)
        for cells in self.surfaces:
            self.is_node[cells.ravel()] = True
        is_round = np.isin(self.shape, (SPHERE, DISC, PARTICLE))
        self.radius = np.where(is_round, self.size[:, 0], np.linalg.norm(self.size, axis=1))
        self.number = group['shape_number'][:] if 'shape_number' in group else np.zeros(self.count, int)
        self.library = file['shapes'] if 'shapes' in file else {}
        self.pieces = Pieces(self)

    def bounding_spheres(self, positions):
        """Centre and radius of all dynamic bodies (of all but planes if none is dynamic), in all frames that are to be seen."""
        chosen = self.dynamic if self.dynamic.any() else self.shape != PLANE
        rows = np.concatenate([np.column_stack([p[chosen], self.radius[chosen]]) for p in positions])
        rows = rows[np.isfinite(rows).all(1)]
        return rows if len(rows) else np.array([[0.0, 0, 0, 1]])

    def walls(self, orientation, height):
        """The fixed boxes that stand upright around a scene of that height: seen through, so that they don't hide what is in it."""
        result = np.zeros(self.count, bool)
        for k in np.flatnonzero(~self.dynamic & (self.shape == BOX)):
            axes = [np.abs(rotate(orientation[k:k + 1], np.eye(3)[a:a + 1]))[0] * self.size[k, a] for a in range(3)]
            extent = np.sum(axes, axis=0)
            result[k] = extent[2] > 2 * extent[:2].min() and extent[2] > 0.2 * height
        return result


class Pieces:
    """All that is drawn of bodies but cloths and threads: the bodies themselves, and of compounds their parts."""

    def __init__(self, bodies):
        rows = []
        for k in np.flatnonzero(~bodies.is_node):
            if bodies.shape[k] == COMPOUND:
                parts = bodies.library[f'compound_{bodies.number[k]}']['parts'][:]
                rows += [(k, int(p[0]), int(p[1]), p[2:5], p[5:8], p[8:12]) for p in parts]
            else:
                rows.append((k, int(bodies.shape[k]), int(bodies.number[k]), bodies.size[k], np.zeros(3), np.array([1.0, 0, 0, 0])))
        self.count = len(rows)
        columns = zip(*rows) if rows else [(), (), (), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 4))]
        body, kind, number, size, place, turn = columns
        self.body, self.kind, self.number = np.array(body, int), np.array(kind, int), np.array(number, int)
        self.size, self.place, self.turn = np.array(size), np.array(place), np.array(turn)  # place and turn in the body

    def states(self, position, orientation):
        """Where they are and how they are turned in the world, where their bodies are so."""
        turn = orientation[self.body]
        return position[self.body] + rotate(turn, self.place), product(turn, self.turn)


def rotate(q, v):
    """Vectors v turned by the quaternions q (w, x, y, z)."""
    w, u = q[:, :1], q[:, 1:]
    return v + 2 * np.cross(u, np.cross(u, v) + w * v)


def product(p, q):
    """The turn q and then p, row by row."""
    w = p[:, 0] * q[:, 0] - (p[:, 1:] * q[:, 1:]).sum(1)
    u = p[:, :1] * q[:, 1:] + q[:, :1] * p[:, 1:] + np.cross(p[:, 1:], q[:, 1:])
    return np.column_stack([w, u])
