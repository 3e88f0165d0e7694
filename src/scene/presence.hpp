// Which bodies of an entry are there when a run starts, and how the others come in.
#pragma once

#include "scene/generators.hpp"

namespace unibody {

// The columns of an inlet in report.csv begin with the name of its entry: fails where that is missing, or is another inlet's.
void check_inlet_name(const Value& entry, const Value& inlet, const Scene& scene);

// Reads the key `start` into the group, and takes over the generator's inlet.
void read_start(const KeyedMap& entry, const BodyTemplate& body, const Generated& generated, BodyGroup& group);

// Puts the group's inlet where the entry stands. put: places a body of the entry's frame in the world.
void put_inlet(const Vec3& position, const Quat& orientation, const std::function<Body(Id, Body)>& put, BodyGroup& group);

}  // namespace unibody
