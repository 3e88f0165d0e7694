#include "step/attach.hpp"

#include <algorithm>

namespace unibody {

namespace {

bool is_home(const World& world, Id id) {
  const auto end = world.id.begin() + static_cast<std::ptrdiff_t>(world.homes);
  return std::binary_search(world.id.begin(), end, id);
}

}  // namespace

std::vector<Id> holders(const Scene& scene, const World& world, double time) {
  std::vector<Id> holder;
  const auto note = [&](Id node, Id body, double release) {
    const Slot slot = body >= 0 && time < release ? world.find(node) : -1;
    if (slot < 0) return;
    if (holder.empty()) holder.assign(world.size(), -1);
    holder[static_cast<std::size_t>(slot)] = body;
  };
  for (const Pin& pin : scene.pins) note(pin.id, pin.body, pin.release);
  for (const Attachment& a : scene.attachments) note(a.node, a.body, a.release);
  return holder;
}

std::vector<AttachedNode> attached_nodes(const Scene& scene, const World& world, double time) {
  std::vector<AttachedNode> found;
  for (const Attachment& a : scene.attachments) {
    if (!(time < a.release)) continue;
    const Slot body = world.find(a.body), node = world.find(a.node);
    if (body < 0 || node < 0 || !(world.is_home(body) || world.is_home(node))) continue;
    const auto b = static_cast<std::size_t>(body), n = static_cast<std::size_t>(node);
    const Vec3 arm = world.position[n] - world.position[b];
    found.push_back({{a.node, a.body}, body, node, arm, world.orientation_of(b) * a.place - arm});
  }
  return found;
}

std::vector<std::array<Id, 2>> attachments_here(const World& world, const std::vector<Attachment>& attachments) {
  std::vector<std::array<Id, 2>> found;
  for (const Attachment& a : attachments)
    if (is_home(world, a.node) || is_home(world, a.body)) found.push_back({a.node, a.body});
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<Id> partners(const World& world, const std::vector<Attachment>& attachments) {
  std::vector<Id> found;
  for (const Attachment& a : attachments) {
    const bool node = is_home(world, a.node), body = is_home(world, a.body);
    if (node != body) found.push_back(node ? a.body : a.node);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

void leave_out_attached(const Scene& scene, const World& world, double time, Contacts& contacts) {
  const std::vector<Id> holder = holders(scene, world, time);
  if (holder.empty()) return;
  const auto holds = [&](Id body, Slot node) { return node >= 0 && holder[static_cast<std::size_t>(node)] == body; };
  leave_out(contacts, [&](const Manifold& m) { return holds(m.id_a, m.slot_b) || holds(m.id_b, m.slot_a); });
  std::erase_if(contacts.surface, [&](const SurfaceContact& c) {
    return std::any_of(c.slots.begin(), c.slots.end(), [&](Slot s) { return holds(c.ids[0], s); });
  });
}

}  // namespace unibody
