// The generators `urdf` and `mjcf`: the bodies and joints of a robot's file.
#pragma once

#include "scene/generators.hpp"

namespace unibody {

const Keys& urdf_keys();
const Keys& mjcf_keys();

// {file: ROBOT.urdf, base: fixed, joints: [{name: shoulder, at: 30, motor: {...}}]}. The entry's `position` and `orientation`
// place the frame of the robot's root link.
Generated read_urdf_robot(const Value& value, const BodyTemplate& body, const Scene& scene);
// {file: ROBOT.xml, joints: [...]}, whose root is the file's world.
Generated read_mjcf_robot(const Value& value, const BodyTemplate& body, const Scene& scene);

}  // namespace unibody
