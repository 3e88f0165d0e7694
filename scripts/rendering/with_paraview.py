"""Opens the surfaces that scripts/geometry made of a run in ParaView, without a screen, and draws the last frame.

  pvpython scripts/rendering/with_paraview.py DIR PICTURE.png [ARRAY]

ARRAY: what colours the cells (body). ParaView's animation takes its times from the series; what it found of each is printed.
"""
import sys

from paraview import simple

directory, picture, array = (sys.argv[1:] + ['body'])[:3]
surfaces = simple.OpenDataFile(f'{directory}/geometry.pvd')
surfaces.UpdatePipeline()
simple.GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
view = simple.GetActiveViewOrCreate('RenderView')
view.ViewSize = [1000, 640]
shown = simple.Show(surfaces, view)
simple.ColorBy(shown, ('CELLS', array))
shown.SetScalarBarVisibility(view, True)
for time in surfaces.TimestepValues:
    view.ViewTime = time
    surfaces.UpdatePipeline(time)
    print(f'{time:g} s: {surfaces.GetDataInformation().GetNumberOfCells()} cells, {", ".join(sorted(a.Name for a in surfaces.CellData))}')
shown.RescaleTransferFunctionToDataRange(False, True)
view.ResetActiveCameraToNegativeY()
simple.GetActiveCamera().Azimuth(30)
simple.GetActiveCamera().Elevation(25)
simple.ResetCamera()
simple.SaveScreenshot(picture, view)
