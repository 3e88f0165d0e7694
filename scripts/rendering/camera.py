"""Where a scene is seen from: as near as all of it fits into the picture."""
import numpy as np

VIEW_ANGLE = 24.0  # degrees, of the picture's height


class Camera:
    """Looks from azimuth and elevation (degrees) at bounding spheres (rows x, y, z, radius) around `centre`."""

    def __init__(self, spheres, centre, view, zoom, size):
        a, e = np.radians(view)
        self.toward = np.array([np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)])
        self.right = np.array([np.cos(a), np.sin(a), 0])
        up = np.cross(self.toward, self.right)
        tangent = np.tan(np.radians(VIEW_ANGLE) / 2) * np.array([1, size[0] / size[1]])
        self.centre = centre
        for _ in range(4):  # the distance from which each body just fits, then a shift that puts the picture in the middle
            offset, r = spheres[:, :3] - self.centre, spheres[:, 3]
            need = np.max([np.abs(offset @ axis) / t + r / np.sin(np.arctan(t)) for axis, t in zip((up, self.right), tangent)], axis=0)
            self.distance = 1.06 * np.max(need + offset @ self.toward) / zoom
            for axis in (up, self.right):
                seen, spread = (offset @ axis) / (self.distance - offset @ self.toward), r / self.distance
                self.centre = self.centre + axis * self.distance * ((seen + spread).max() + (seen - spread).min()) / 2

    def place(self, camera):
        """Puts VTK's camera there."""
        camera.SetViewAngle(VIEW_ANGLE)
        camera.SetFocalPoint(*self.centre)
        camera.SetPosition(*(self.centre + self.distance * self.toward))
        camera.SetViewUp(0, 0, 1)
