#include "joints/strength.hpp"

#include <algorithm>

namespace unibody {

double load_share(const Strength& strength, const Vec3& force, const Vec3& torque) {
  const double along = force.z(), about = torque.z(), across = force.head<2>().norm(), bent = torque.head<2>().norm();
  return std::max({force.norm() / strength.force, torque.norm() / strength.torque,
                   along / strength.tension + bent / strength.bending,
                   across / strength.shear + std::abs(about) / strength.twisting});
}

}  // namespace unibody
