"""Writes a state of ParaView for a run: its bodies as glyphs, where it has them its surfaces, joints and the forces of contacts.

  pvpython scripts/rendering/paraview_state.py DIR [PICTURE.png]

DIR/scene.pvsm, which ParaView opens by File > Load State, has spheres and boxes of frames.xdmf as glyphs of their sizes and turns,
coloured by speed: they cost little where there are many. All else is of the files that scripts/geometry makes: in a run that has
DIR/geometry.pvd other bodies, cloths and solids are its surfaces, and joints its lines; contacts.xdmf is drawn as tubes as thick as
the force that goes along them, which wait to be shown. PICTURE.png: the last frame as the state draws it.
"""
import math
import os
import sys

from paraview import simple

SPHERE, BOX = 0, 1  # of the array 'shape'
CIRCLE, WIDTH, HEIGHT = 24, 1000, 640


def glyphs(points, shape, form, scale, view):
    """Bodies of one shape, as glyphs of one form times their sizes, turned as they are."""
    chosen = simple.Threshold(registrationName=f'{form} bodies', Input=points)
    chosen.Scalars = ['POINTS', 'shape']
    chosen.LowerThreshold = chosen.UpperThreshold = shape
    chosen.UpdatePipeline()
    if chosen.GetDataInformation().GetNumberOfPoints() == 0:
        simple.Delete(chosen)
        return False
    shown = simple.Show(chosen, view, 'UnstructuredGridRepresentation')
    shown.SetRepresentationType('3D Glyphs')
    shown.GlyphType = form
    if form == 'Sphere':
        shown.GlyphType.Radius, shown.GlyphType.ThetaResolution, shown.GlyphType.PhiResolution = 1, CIRCLE, CIRCLE // 2
    else:
        shown.GlyphType.XLength = shown.GlyphType.YLength = shown.GlyphType.ZLength = 2  # sizes are half edges
    shown.Scaling, shown.ScaleMode, shown.SelectScaleArray, shown.ScaleFactor = True, scale, 'size', 1
    shown.Orient, shown.OrientationMode, shown.SelectOrientationVectors = True, 'Quaternion', 'orientation'
    simple.ColorBy(shown, ('POINTS', 'velocity', 'Magnitude'))
    shown.RescaleTransferFunctionToDataRange(True, False)
    return True


def tubes(data, view, name, array, widest):
    """Lines as tubes, as thick as their cells' values of the array."""
    at_points = simple.CellDatatoPointData(registrationName=f'{name} at points', Input=data)
    at_points.UpdatePipeline()
    size = at_points.PointData.GetArray(array)
    if size is None:
        simple.Delete(at_points)
        return
    lines = simple.ExtractSurface(registrationName=f'{name} as lines', Input=at_points)  # of which alone Tube makes tubes
    tube = simple.Tube(registrationName=name, Input=lines)
    most = max(size.GetRange(-1 if size.GetNumberOfComponents() > 1 else 0)[1], 1e-300)
    tube.Scalars, tube.VaryRadius, tube.Radius, tube.RadiusFactor = ['POINTS', array], 'By Scalar', widest / 100, 100
    shown = simple.Show(tube, view)
    simple.ColorBy(shown, ('POINTS', array))
    print(f'{name}: up to {most:.4g} of {array}')


def main():
    directory, picture = (sys.argv[1:] + [''])[:2]
    files = {name: os.path.join(os.path.abspath(directory), name) for name in ('frames.xdmf', 'geometry.pvd', 'joints.pvd', 'contacts.xdmf')}
    if not os.path.exists(files['frames.xdmf']):
        sys.exit(f"paraview_state: no '{files['frames.xdmf']}': expected the output folder of a run")
    view = simple.GetActiveViewOrCreate('RenderView')
    view.ViewSize = [WIDTH, HEIGHT]
    points = simple.XDMFReader(registrationName='frames', FileNames=[files['frames.xdmf']])
    simple.GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
    simple.GetAnimationScene().GoToLast()
    drawn = [form for shape, form, scale in ((SPHERE, 'Sphere', 'Magnitude'), (BOX, 'Box', 'Vector Components'))
             if glyphs(points, shape, form, scale, view)]
    print('glyphs: ' + (', '.join(drawn) or 'none'))
    bounds = points.GetDataInformation().GetBounds()
    extent = math.dist(bounds[::2], bounds[1::2])
    if os.path.exists(files['geometry.pvd']):
        surfaces = simple.PVDReader(registrationName='surfaces', FileName=files['geometry.pvd'])
        shown = simple.Show(surfaces, view)
        if drawn:
            simple.Hide(surfaces, view)  # it has the bodies that are glyphs too
        simple.ColorBy(shown, ('CELLS', 'material'))
    if os.path.exists(files['joints.pvd']):
        simple.Show(simple.PVDReader(registrationName='joints', FileName=files['joints.pvd']), view).LineWidth = 3
    if os.path.exists(files['contacts.xdmf']):
        contacts = simple.XDMFReader(registrationName='contacts', FileNames=[files['contacts.xdmf']])
        tubes(contacts, view, 'forces', 'normal_force', 0.02 * extent)
    view.ResetActiveCameraToNegativeY()
    simple.GetActiveCamera().Azimuth(30)
    simple.GetActiveCamera().Elevation(25)
    simple.ResetCamera()
    simple.SaveState(os.path.join(directory, 'scene.pvsm'))
    print(os.path.join(directory, 'scene.pvsm'))
    if picture:
        simple.SaveScreenshot(picture, view)


if __name__ == '__main__':
    main()
