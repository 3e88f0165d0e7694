#!/usr/bin/python3
"""Checks DIR/frames.h5 and DIR/frames.xdmf against the made-up bodies of report_worlds.hpp, the way a user would read them."""
import sys
import xml.etree.ElementTree as ElementTree

import h5py
import numpy as np

directory, count = sys.argv[1], int(sys.argv[2])
t = np.arange(count, dtype=float)

with h5py.File(f"{directory}/frames.h5", "r") as file:
    bodies, frames = file["bodies"], file["frames"]
    single = frames["000000/position"].dtype == np.float32
    close = dict(rtol=3e-7, atol=1e-7) if single else dict(rtol=1e-14, atol=1e-15)
    assert list(frames) == ["000000", "000005"], list(frames)
    assert bodies["shape"].dtype == np.int8 and bodies["material"].dtype == np.int32
    names = bodies.attrs["shape_names"].decode().split()
    assert names[:5] == ["sphere", "box", "plane", "disc", "particle"], names
    shape = bodies["shape"][:]
    assert [names[k] for k in shape[:4]] == ["plane", "box", "sphere", "box"]
    assert (bodies["id"][:] == np.arange(count)).all()
    assert (bodies["material"][:] == np.arange(count) % 3).all()
    dynamic = np.arange(count) % 7 != 0
    assert ((bodies["motion"][:] == 0) == dynamic).all()
    assert (bodies["size"][0] == 0).all()
    assert np.allclose(bodies["size"][1:, 0], 0.1 + 0.01 * np.sin(t[1:]), **close)
    assert np.allclose(bodies["mass"][:], np.where(dynamic, 1 + np.exp(np.sin(t)), 0), **close)
    assert np.allclose(bodies["inertia"][:, 2], np.where(dynamic, 3 + np.cos(t), 0), **close)
    for name, time, shift in (("000000", 0, 0), ("000005", 0.08, np.array([1, 2, 3]))):
        frame = frames[name]
        assert frame.attrs["time"] == time and frame.attrs["frame"] == int(name)
        position = np.stack([np.sin(t), np.cos(2 * t), t / 3], 1) + shift
        assert np.allclose(frame["position"][:], position, **close)
        q = np.stack([np.cos(t), np.sin(t), 0.1 * t, np.full(count, -0.3)], 1)
        assert np.allclose(frame["orientation"][:], q / np.linalg.norm(q, axis=1)[:, None], **close)
        assert np.allclose(frame["velocity"][:, 1], -t, **close)
        assert (frame["angular_velocity"][:, 2] == -1).all()

    # The XDMF is XML, and every heavy data item is there with the size and type it claims.
    root = ElementTree.parse(f"{directory}/frames.xdmf").getroot()
    grids = root.findall("./Domain/Grid/Grid")
    assert [float(g.find("Time").get("Value")) for g in grids] == [0, 0.08]
    kinds = {("Float", "8"): "f8", ("Float", "4"): "f4", ("Int", "8"): "i8", ("Char", "1"): "i1"}
    for grid in grids:
        assert grid.find("Topology").get("NumberOfElements") == str(count)
        names = [a.get("Name") for a in grid.findall("Attribute")]
        assert {"orientation", "velocity", "angular_velocity", "size", "shape", "id"} <= set(names), names
        for item in grid.iter("DataItem"):
            name, path = item.text.strip().split(":")
            assert name == "frames.h5"
            data = file[path]
            assert data.shape == tuple(map(int, item.get("Dimensions").split())), path
            assert data.dtype == kinds[item.get("NumberType"), item.get("Precision")], path

try:  # only some builds of VTK bring the reader
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
except ImportError:
    sys.exit(0)
reader = vtkXdmfReader()
reader.SetFileName(f"{directory}/frames.xdmf")
reader.UpdateTimeStep(0.08)
data = reader.GetOutputDataObject(0)
assert data.GetNumberOfPoints() == count, data
for name, components in (("orientation", 4), ("velocity", 3), ("size", 3), ("shape", 1), ("id", 1)):
    assert data.GetPointData().GetArray(name).GetNumberOfComponents() == components, name
