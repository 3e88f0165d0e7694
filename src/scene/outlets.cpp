#include "scene/outlets.hpp"

#include "scene/probes.hpp"

namespace unibody {

const Keys& corners_keys() {
  static const Keys table{"box",
                          "A box whose edges are along the axes.",
                          {keys::vector("low", "m", needed, "corner of the least coordinates"),
                           keys::vector("high", "m", needed, "corner of the greatest coordinates")}};
  return table;
}

std::pair<Vec3, Vec3> read_corners(const Value& box, bool planar) {
  const KeyedMap map(box, corners_keys());
  const Vec3 low = map.vector("low"), high = map.vector("high");
  const Value& other = map.need("high");
  if (!(low.array() <= high.array()).all() || low.x() == high.x() || low.z() == high.z() || (low.y() == high.y() && !planar))
    other.fail_expected("a corner that is above the other one along each axis (m)");
  return {low, high};
}

const Keys& outlet_keys() {
  static const Keys table =
      Keys{"outlet",
           "A box in which bodies leave the scene.",
           {keys::text("name", "a name", needed, "name of its columns of report.csv"),
            keys::map("box", corners_keys, "a map with low and high", needed, "bodies whose centres are in it leave")}}
          .with(probed_keys());
  return table;
}

void read_outlets(const Value& list, Scene& scene) {
  std::vector<std::string> names;
  for (const Value& entry : list.list("outlets")) {
    const KeyedMap map(entry, outlet_keys());
    Outlet outlet;
    outlet.name = read_column_name(map.need("name"), names, "outlet");
    names.push_back(outlet.name);
    outlet.bodies = read_probed(map, scene);
    std::tie(outlet.low, outlet.high) = read_corners(map.need("box"));
    scene.outlets.push_back(std::move(outlet));
  }
}

}  // namespace unibody
