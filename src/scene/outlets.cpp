#include "scene/outlets.hpp"

#include "scene/probes.hpp"

namespace unibody {

std::pair<Vec3, Vec3> read_corners(const Value& box, bool planar) {
  box.map({"low", "high"});
  const Vec3 low = box.need("low", "a corner (m)").vector(any_number, "m");
  const Value& other = box.need("high", "the other corner (m)");
  const Vec3 high = other.vector(any_number, "m");
  if (!(low.array() <= high.array()).all() || low.x() == high.x() || low.z() == high.z() || (low.y() == high.y() && !planar))
    other.fail_expected("a corner that is above the other one along each axis (m)");
  return {low, high};
}

std::vector<std::string> outlet_keys() { return {"name", "of", "material", "box"}; }

void read_outlets(const Value& list, Scene& scene) {
  std::vector<std::string> names;
  for (const Value& entry : list.list("outlets")) {
    entry.map(outlet_keys());
    Outlet outlet;
    outlet.name = read_column_name(entry.need("name", "a name"), names, "outlet");
    names.push_back(outlet.name);
    outlet.bodies = read_probed(entry, scene);
    const Value& box = entry.need("box", "a map with low and high");
    std::tie(outlet.low, outlet.high) = read_corners(box);
    scene.outlets.push_back(std::move(outlet));
  }
}

}  // namespace unibody
