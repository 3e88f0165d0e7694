// The few types that every room uses. SI units, right-handed axes, z up.
#pragma once

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace unibody {

using Id = std::int64_t;    // a body's global number: its place in the scene file, statics included
using Slot = std::int32_t;  // a body's place in this rank's arrays
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;  // body frame -> world frame; written to files as (w, x, y, z)

}  // namespace unibody
