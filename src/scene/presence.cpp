#include "scene/presence.hpp"

#include "scene/probes.hpp"

namespace unibody {

void check_inlet_name(const Value& entry, const Value& inlet, const Scene& scene) {
  const Value* name = entry.find("name");
  if (!name) inlet.fail("an inlet without a name", "the key `name` beside it");
  std::vector<std::string> taken;
  for (const BodyGroup& group : scene.groups)
    if (group.inlet) taken.push_back(group.name);
  read_column_name(*name, taken, "inlet");
}

void read_start(const KeyedMap& entry, const BodyTemplate& body, const Generated& generated, BodyGroup& group) {
  group.inlet = generated.inlet;
  if (group.inlet) group.start = Start::absent;
  const Value* start = entry.find("start");
  if (!start) return;
  if (group.inlet) start->fail_expected("no such key beside an inlet, whose bodies come in by themselves");
  group.start = static_cast<Start>(entry.choice("start"));
  if (group.start == Start::held && !body.properties.is_dynamic())
    start->fail("held of bodies that are not dynamic", "present or absent");
  if (group.start == Start::absent && !generated.joints.empty()) start->fail("absent of bodies with joints", "present or held");
  if (group.start == Start::held && !(body.velocity.isZero(0) && body.angular_velocity.isZero(0)))
    start->fail("held beside a velocity", "no velocity: bodies that are held start from rest");
}

void put_inlet(const Vec3& position, const Quat& orientation, const std::function<Body(Id, Body)>& put, BodyGroup& group) {
  auto inlet = std::make_shared<Inlet>(*group.inlet);
  inlet->place = [place = inlet->place, put](Id k, std::uint64_t draw) { return put(k, place(k, draw)); };
  const Vec3 middle = position + orientation * Vec3(0.5 * (inlet->low + inlet->high)),
             half = orientation.toRotationMatrix().cwiseAbs() * Vec3(0.5 * (inlet->high - inlet->low));
  inlet->low = middle - half, inlet->high = middle + half;
  group.inlet = std::move(inlet);
}

}  // namespace unibody
