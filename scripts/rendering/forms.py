"""Bodies, cloths and threads as data for VTK: sources of unit shapes, and mappers of what is drawn by them."""
import numpy as np
import vtk
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

from bodies import BOX, CAPSULE, CYLINDER, DISC, HULL, MESH, PARTICLE, SPHERE


def points_of(position):
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(position), deep=True))
    return points


def cells_of(corners):
    """Cells of rows of corners, all of one length."""
    lengths = np.full((len(corners), 1), corners.shape[1])
    cells = vtk.vtkCellArray()
    cells.SetCells(len(corners), numpy_to_vtkIdTypeArray(np.hstack([lengths, corners]).ravel().astype(np.int64), deep=True))
    return cells


def named_array(name, values):
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    return array


def bytes_of(rgb):
    return (255 * rgb).astype(np.uint8)


def mapper_of(source):
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    return mapper


def quad(origin, one, other):
    """A parallelogram by three corners."""
    source = vtk.vtkPlaneSource()
    source.SetOrigin(*origin)
    source.SetPoint1(*one)
    source.SetPoint2(*other)
    return mapper_of(source)


def sources(bodies):
    """By kind and number in the library (-1: any) the shape that is drawn, scaled, for each body."""
    fine = 40 if bodies.count < 5000 else 20
    sphere = vtk.vtkSphereSource()
    sphere.SetRadius(1)
    sphere.SetThetaResolution(fine)
    sphere.SetPhiResolution(fine)
    box = vtk.vtkCubeSource()
    box.SetXLength(2)
    box.SetYLength(2)
    box.SetZLength(2)
    disc = vtk.vtkCylinderSource()
    disc.SetRadius(1)
    disc.SetHeight(0.5)
    disc.SetResolution(48)
    rod = upright_rod()
    result = {(SPHERE, -1): sphere, (BOX, -1): box, (DISC, -1): disc, (PARTICLE, -1): sphere, (CYLINDER, -1): rod, (CAPSULE, -1): rod}
    for name in bodies.library:
        kind, number = name.split('_')
        if kind != 'compound':
            result[HULL if kind == 'hull' else MESH, int(number)] = library_source(bodies.library[name])
    return result


def upright_rod():
    """A cylinder of radius 1 and height 2 about z; VTK's own is about y."""
    rod = vtk.vtkCylinderSource()
    rod.SetRadius(1)
    rod.SetHeight(2)
    rod.SetResolution(32)
    turn = vtk.vtkTransform()
    turn.RotateX(90)
    upright = vtk.vtkTransformPolyDataFilter()
    upright.SetTransform(turn)
    upright.SetInputConnection(rod.GetOutputPort())
    return upright


def library_source(group):
    """A hull or mesh. Its `extent` is the size that the file gives its bodies along x."""
    nodes, triangles = group['nodes'][:], group['triangles'][:]
    data = vtk.vtkPolyData()
    data.SetPoints(points_of(nodes))
    data.SetPolys(cells_of(triangles))
    source = vtk.vtkPolyDataNormals()
    source.SetFeatureAngle(40)
    source.ConsistencyOff()
    source.SetInputData(data)
    source.extent = np.abs(nodes[:, 0]).max()
    return source


def glyphs(source, scale, position, orientation, rgb):
    """The same source for many bodies, each with its own row of scale, place, turn and colour."""
    data = vtk.vtkPolyData()
    data.SetPoints(points_of(position))
    for name, values in (('scale', scale), ('turn', orientation.astype(float)), ('colour', bytes_of(rgb))):
        data.GetPointData().AddArray(named_array(name, values))
    mapper = vtk.vtkGlyph3DMapper()
    mapper.SetInputData(data)
    mapper.SetSourceConnection(source.GetOutputPort())
    mapper.SetScaleArray('scale')
    mapper.SetScaleModeToScaleByVectorComponents()
    mapper.SetOrientationArray('turn')
    mapper.SetOrientationModeToQuaternion()
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray('colour')
    mapper.SetColorModeToDirectScalars()
    return mapper


def surface(cells, position, rgb, bodies):
    """A cloth as a smooth surface, a thread as a tube. rgb: of each body; None: uncoloured."""
    nodes, corners = np.unique(cells, return_inverse=True)
    corners = corners.reshape(cells.shape)
    data = vtk.vtkPolyData()
    data.SetPoints(points_of(position[nodes]))
    if rgb is not None:
        data.GetPointData().SetScalars(named_array('colour', bytes_of(rgb[nodes])))
    if cells.shape[1] == 2:
        data.SetLines(cells_of(np.concatenate([corners[:, 0], corners[-1:, 1]])[None, :]))
        shape = vtk.vtkTubeFilter()
        shape.SetRadius(bodies.size[nodes[0], 0])
        shape.SetNumberOfSides(16)
        shape.CappingOn()
    else:
        data.SetPolys(cells_of(corners))
        shape = vtk.vtkPolyDataNormals()
        shape.SplittingOff()
        shape.ConsistencyOff()
    shape.SetInputData(data)
    return mapper_of(shape)
