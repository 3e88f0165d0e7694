#include "shortest_turn.hpp"

namespace unibody {

Quat shortest_turn(const Vec3& from, const Vec3& to) { return Quat::FromTwoVectors(from, to); }

}  // namespace unibody
