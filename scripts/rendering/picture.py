"""A window that frames of one run are drawn into: light, ground, shadows and bodies."""
import numpy as np
import vtk

import forms
from bodies import BOX, CAPSULE, CYLINDER, DISC, HULL, MESH, PLANE, SPHERE, rotate
from camera import Camera
from colours import BACKGROUND, of_surface

SEEN_THROUGH = 0.12  # opacity of walls


class Picture:
    def __init__(self, bodies, spheres, size, view=None, zoom=1.0):
        """spheres: what the camera is to see, x, y, z and radius (m) a row; size: pixels; view: azimuth and elevation (degrees)."""
        self.bodies, self.size = bodies, size
        self.planar = (bodies.shape == DISC).any()
        self.low, self.high = (spheres[:, :3] - spheres[:, 3:]).min(0), (spheres[:, :3] + spheres[:, 3:]).max(0)
        self.radius = max(1e-6, np.linalg.norm(self.high - self.low) / 2)
        self.sources = forms.sources(bodies)
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(2 * size[0], 2 * size[1])
        self.renderer = vtk.vtkRenderer()
        self.renderer.SetBackground(*BACKGROUND)
        self.window.AddRenderer(self.renderer)
        camera = Camera(spheres, (self.low + self.high) / 2, view or ((0, 0) if self.planar else (30, 20)), zoom, size)
        camera.place(self.renderer.GetActiveCamera())
        self.centre = camera.centre
        self.light(camera)

    def draw(self, position, orientation, rgb, path, tell=False):
        """Writes the picture of one frame; tell: the colours of cloths' nodes too are to be seen."""
        self.renderer.RemoveAllViewProps()
        floor = self.draw_planes(position, orientation)
        self.draw_pieces(position, orientation, rgb, floor)
        self.draw_surfaces(position, rgb, tell, floor)
        self.renderer.ResetCameraClippingRange()
        self.window.Render()
        self.write(path)

    def light(self, camera):
        """A high key light from the left, whose shadows fall on the ground, and a soft fill from the right."""
        self.sun = 0.35 * camera.toward - 0.6 * camera.right + np.array([0, 0, 1.1])
        fill = camera.toward + 0.7 * camera.right + np.array([0, 0, 0.4])
        for direction, colour, intensity in ((self.sun, (1.0, 0.97, 0.92), 0.80), (fill, (0.86, 0.92, 1.0), 0.40)):
            light = vtk.vtkLight()
            light.SetFocalPoint(*self.centre)
            light.SetPosition(*(self.centre + direction))
            light.SetColor(*colour)
            light.SetIntensity(intensity)
            self.renderer.AddLight(light)
        # Where bodies are close together less light gets in between.
        solids = self.bodies.dynamic & ~self.bodies.is_node
        body = np.median(self.bodies.radius[solids]) if solids.any() else self.radius / 10
        self.renderer.UseSSAOOn()
        self.renderer.SetSSAORadius(2.5 * body)
        self.renderer.SetSSAOBias(0.03 * body)
        self.renderer.SetSSAOKernelSize(96)
        self.renderer.SSAOBlurOn()

    def draw_planes(self, position, orientation):
        """Returns place and normal of the ground, on which shadows fall; None where there is none. Walls are not drawn."""
        floor = None
        finite = np.isfinite(position).all(1) & np.isfinite(orientation).all(1)
        for k in np.flatnonzero((self.bodies.shape == PLANE) & finite):
            normal = rotate(orientation[k:k + 1], np.array([[0.0, 0, 1]]))[0]
            if self.planar:
                self.strip(position[k], normal)
            elif normal[2] > 0.5:
                floor = floor or (position[k], normal)
                self.ground(position[k], normal)
        return floor

    def draw_pieces(self, position, orientation, rgb, floor):
        pieces = self.bodies.pieces
        if pieces.count == 0:
            return
        finite = np.isfinite(position).all(1) & np.isfinite(orientation).all(1)
        wall = self.bodies.walls(orientation, (self.high - self.low)[2])
        at, turned = pieces.states(position, orientation)
        colour = rgb[pieces.body]
        for (kind, number), source in self.sources.items():
            for see, opacity in ((~wall, 1.0), (wall, SEEN_THROUGH)):
                chosen = (see & finite)[pieces.body] & (pieces.kind == kind) & ((number < 0) | (pieces.number == number))
                if not chosen.any():
                    continue
                size = pieces.size[chosen]
                if kind == CAPSULE:
                    self.draw_capsules(size, at[chosen], turned[chosen], colour[chosen], opacity)
                    continue
                scale = size if kind in (BOX, CYLINDER) else np.repeat(size[:, :1], 3, axis=1)
                if kind in (HULL, MESH):
                    scale = scale / source.extent
                drawn, cast = [forms.glyphs(source, scale, at[chosen], turned[chosen], colour[chosen]) for _ in range(2)]
                # Of a mesh, the triangles whose pushing side is towards us: terrain from above, a drum's far walls.
                self.actor(drawn, opacity).GetProperty().SetBackfaceCulling(kind == MESH)
                if opacity == 1 and floor and kind != MESH:
                    self.shadow(cast, *floor)

    def draw_capsules(self, size, at, turned, rgb, opacity):
        """Two balls and what is between them."""
        half = size[:, 2] - size[:, 0]
        ends = rotate(turned, np.column_stack([0 * size[:, :2], half]))
        ball, tube = np.repeat(size[:, :1], 3, axis=1), np.column_stack([size[:, :2], half])
        for shift, form, scale in ((ends, SPHERE, ball), (-ends, SPHERE, ball), (0 * ends, CYLINDER, tube)):
            self.actor(forms.glyphs(self.sources[form, -1], scale, at + shift, turned, rgb), opacity)

    def draw_surfaces(self, position, rgb, tell, floor):
        for number, cells in enumerate(self.bodies.surfaces):
            if not np.isfinite(position[np.unique(cells)]).all():
                continue
            own = rgb if tell else np.broadcast_to(of_surface(number), rgb.shape)
            actor = self.actor(forms.surface(cells, position, own, self.bodies))
            back = vtk.vtkProperty()
            back.DeepCopy(actor.GetProperty())
            actor.SetBackfaceProperty(back)
            if floor:
                self.shadow(forms.surface(cells, position, None, self.bodies), *floor)

    def actor(self, mapper, opacity=1.0):
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        look = actor.GetProperty()
        look.SetInterpolationToPhong()
        look.SetAmbient(0.45 if self.planar else 0.22)
        look.SetDiffuse(0.85)
        look.SetSpecular(0.12)
        look.SetSpecularPower(25)
        look.SetOpacity(opacity)
        self.renderer.AddActor(actor)
        return actor

    def flat(self, mapper, colour):
        """The same colour everywhere, whatever the light."""
        actor = self.actor(mapper)
        look = actor.GetProperty()
        look.SetColor(*colour)
        look.LightingOff()
        look.SetAmbient(1)
        look.SetDiffuse(0)
        look.SetSpecular(0)
        return actor

    def strip(self, position, normal):
        """A plane of a planar scene, seen edge-on: a bar along its surface."""
        along, thick = np.array([normal[2], 0, -normal[0]]), 0.03 * self.radius
        middle = position + along * np.dot(self.centre - position, along) + np.array([0, self.high[1] - position[1] + thick, 0])
        end, below = 3 * self.radius * along, thick * normal
        self.flat(forms.quad(middle - end - below, middle + end - below, middle - end), 0.72 * BACKGROUND)

    def ground(self, position, normal):
        """A large quad of the colour of the sky, so that its edge is not seen."""
        middle = self.centre - normal * np.dot(self.centre - position, normal)
        across = np.cross(normal, [0, 1, 0] if abs(normal[1]) < 0.9 else [1, 0, 0])
        across /= np.linalg.norm(across)
        along, half = np.cross(normal, across), 8 * self.radius
        corners = [middle - half * (across + along), middle + half * (across - along), middle - half * (across - along)]
        self.flat(forms.quad(*corners), BACKGROUND)

    def shadow(self, mapper, position, normal):
        """The same bodies, pressed flat on the plane along the light's direction."""
        matrix = np.eye(4)
        matrix[:3, :3] -= np.outer(self.sun, normal) / np.dot(normal, self.sun)
        lift = 0.0005 * self.radius
        matrix[:3, 3] = self.sun * np.dot(normal, position) / np.dot(normal, self.sun) + lift * normal
        user = vtk.vtkMatrix4x4()
        user.DeepCopy(matrix.ravel())
        mapper.ScalarVisibilityOff()
        self.flat(mapper, 0.80 * BACKGROUND).SetUserMatrix(user)

    def write(self, path):
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(self.window)
        grab.ReadFrontBufferOff()
        halve = vtk.vtkImageResize()  # drawn twice as large: smooth edges
        halve.SetInputConnection(grab.GetOutputPort())
        halve.SetResizeMethodToOutputDimensions()
        halve.SetOutputDimensions(*self.size, 1)
        writer = vtk.vtkPNGWriter()
        writer.SetFileName(path)
        writer.SetInputConnection(halve.GetOutputPort())
        writer.Write()
