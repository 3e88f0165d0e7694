#include "report/frames_xdmf.hpp"

#include "core/hdf5.hpp"
#include "report/xdmf_file.hpp"

namespace unibody {

namespace {

std::string data_item(const std::string& path, Id rows, int columns, const char* type, int precision) {
  return xdmf_item("frames.h5", path, rows, columns, type, precision);
}

std::string attribute(const std::string& name, const char* kind, const std::string& item) {
  return xdmf_attribute(name, kind, "Node", item);
}

}  // namespace

// The bodies of the frame at this path in the file, as points.
std::string FramesXdmf::bodies(const std::string& at, Id rows) const {
  const int real = single ? 4 : 8;
  const std::string of_bodies = changes ? at : "/bodies/";
  // The points' numbers are their rows. Without them readers of version 3 make no cells, and nothing is drawn.
  std::string grid = "      <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"" + std::to_string(rows) +
                     "\" NodesPerElement=\"1\">" + data_item(changes ? at + "row" : "/bodies/id", rows, 1, "Int", 8) +
                     "</Topology>\n";
  grid += "      <Geometry GeometryType=\"XYZ\">" + data_item(at + "position", rows, 3, "Float", real) + "</Geometry>\n";
  grid += attribute("orientation", "Matrix", data_item(at + "orientation", rows, 4, "Float", real));
  grid += attribute("velocity", "Vector", data_item(at + "velocity", rows, 3, "Float", real));
  grid += attribute("angular_velocity", "Vector", data_item(at + "angular_velocity", rows, 3, "Float", real));
  grid += attribute("size", "Vector", data_item(of_bodies + "size", rows, 3, "Float", real));
  grid += attribute("shape", "Scalar", data_item(of_bodies + "shape", rows, 1, "Char", 1));
  grid += attribute("id", "Scalar", data_item(of_bodies + "id", rows, 1, "Int", 8));
  return grid;
}

// Cloths as triangles, threads as segments and solids as tetrahedra between the bodies of that frame.
std::string FramesXdmf::cells(const std::string& at, Id rows) const {
  const int real = single ? 4 : 8;
  const std::string node = changes ? "node_" : "";
  const Id points = changes ? nodes : rows;
  std::string grids;
  for (std::size_t n = 0; n < surfaces.size(); ++n) {
    const Surface& surface = surfaces[n];
    const bool solid = surface.tetrahedron_count > 0;
    const Id count = solid ? surface.tetrahedron_count : surface.count;
    const int corners = solid ? 4 : surface.corners;
    const std::string kind = solid ? "Tetrahedron" : corners == 3 ? "Triangle" : "Polyline\" NodesPerElement=\"2";
    const std::string corner_data =
        "/surfaces/" + h5::numbered(static_cast<std::int64_t>(n)) + "/" + node + (solid ? "tetrahedra" : "cells");
    grids += "    <Grid Name=\"surface " + std::to_string(n) + "\" GridType=\"Uniform\">\n";
    grids += "      <Topology TopologyType=\"" + kind + "\" NumberOfElements=\"" + std::to_string(count) + "\">" +
             data_item(corner_data, count, corners, "Int", 8) + "</Topology>\n";
    grids +=
        "      <Geometry GeometryType=\"XYZ\">" + data_item(at + node + "position", points, 3, "Float", real) + "</Geometry>\n";
    grids += attribute("velocity", "Vector", data_item(at + node + "velocity", points, 3, "Float", real));
    grids += "    </Grid>\n";
  }
  return grids;
}

std::string FramesXdmf::frame(std::int64_t number, double time, Id rows) const {
  const std::string at = "/frames/" + h5::numbered(number) + "/", clock = xdmf_time(time);
  const std::string grid = "    <Grid Name=\"bodies\" GridType=\"Uniform\">\n";
  if (surfaces.empty()) return grid + clock + bodies(at, rows) + "    </Grid>\n";
  return "    <Grid Name=\"scene\" GridType=\"Collection\" CollectionType=\"Spatial\">\n" + clock + grid + bodies(at, rows) +
         "    </Grid>\n" + cells(at, rows) + "    </Grid>\n";
}

}  // namespace unibody
