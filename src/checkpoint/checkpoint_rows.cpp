#include "checkpoint/checkpoint_rows.hpp"

#include <algorithm>

namespace unibody {

namespace {

constexpr std::uint64_t kinds = 256;  // a shape is one number: its kind and, times this, its place in the library

}  // namespace

BodyRow to_row(const BodyProperties& p, const BodyState& s) {
  BodyRow row;
  auto at = row.begin();
  const auto put = [&](const Vec3& v) { at = std::copy(v.data(), v.data() + 3, at); };
  put(s.position);
  for (double q : {s.orientation.w(), s.orientation.x(), s.orientation.y(), s.orientation.z()}) *at++ = q;
  put(s.velocity), put(s.angular_velocity);
  put(p.shape.size), put(p.inertia), put(p.force), put(p.torque);
  *at++ = p.mass;
  *at++ = static_cast<double>(static_cast<std::uint64_t>(p.shape.kind) + kinds * std::uint64_t{p.shape.data});
  *at++ = static_cast<double>(p.motion);
  *at++ = p.material;
  *at++ = p.group;
  return row;
}

Body from_row(Id id, const BodyRow& row) {
  Body b;
  b.id = id;
  auto at = row.begin();
  const auto take = [&](Vec3& v) { std::copy(at, at + 3, v.data()), at += 3; };
  take(b.state.position);
  b.state.orientation = Quat(at[0], at[1], at[2], at[3]), at += 4;
  take(b.state.velocity), take(b.state.angular_velocity);
  take(b.properties.shape.size), take(b.properties.inertia), take(b.properties.force), take(b.properties.torque);
  b.properties.mass = *at++;
  const auto shape = static_cast<std::uint64_t>(*at++);
  b.properties.shape.kind = static_cast<ShapeKind>(shape % kinds);
  b.properties.shape.data = static_cast<std::uint32_t>(shape / kinds);
  b.properties.motion = static_cast<Motion>(*at++);
  b.properties.material = static_cast<std::int32_t>(*at++);
  b.properties.group = static_cast<std::int32_t>(*at++);
  return b;
}

PointRow to_row(Id owner, const Multipliers& all, std::size_t m, std::size_t k) {
  const RememberedPoint& p = all.points_of(m)[k];
  const auto places = all.places_of(m);
  const auto [slip, turn] = k > 0 ? Creep{} : all.creep_of(m);
  const Vec3 place = places.empty() ? Vec3(Vec3::Zero()) : places[k];
  return {owner,
          all.manifolds[m].id_a,
          all.manifolds[m].id_b,
          static_cast<std::int64_t>(k),
          !places.empty(),
          {place[0], place[1], place[2], p.normal, p.tangential[0], p.tangential[1], p.tangential[2]},
          {slip[0], slip[1], slip[2], turn[0], turn[1], turn[2]}};
}

void append(Multipliers& to, const PointRow& row) {
  const auto& r = row.reals;
  to.points.push_back({r[3], Vec3(r[4], r[5], r[6])});
  if (row.placed != 0) to.places.emplace_back(r[0], r[1], r[2]);
}

}  // namespace unibody
