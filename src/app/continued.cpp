#include "app/continued.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "checkpoint/checkpoint.hpp"
#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "step/build.hpp"

namespace unibody {

namespace {

using Entry = SceneOutline::Entry;

// Of the bodies of one group: how many go on, have left, or are another thing than in the checkpoint.
enum Count : std::size_t { going_on, gone, other_shape, other_mass, other_material, count_kinds };
using Counts = std::array<std::int64_t, count_kinds>;

// The checkpoint's entry of each group of the scene; null: it has none. The second group of a name goes with its second entry.
std::vector<const Entry*> matches_of(const Scene& scene, const SceneOutline& outline) {
  std::map<std::string, std::vector<const Entry*>> named;
  for (const Entry& entry : outline.entries)
    if (!entry.name.empty()) named[entry.name].push_back(&entry);
  std::map<std::string, std::size_t> used;
  std::vector<const Entry*> matches;
  for (const BodyGroup& group : scene.groups) {
    const auto found = named.find(group.name);
    const std::size_t number = used[group.name]++;
    matches.push_back(found != named.end() && number < found->second.size() ? found->second[number] : nullptr);
  }
  return matches;
}

// Where a body's state at the start comes from. A fixed body has no state of its own that could go on.
enum class Origin : std::uint8_t { fixed, checkpoint, scene };

class Origins {
 public:
  Origins(const Scene& scene, const std::vector<const Entry*>& matches) : scene_(scene), matches_(matches) {}

  Origin of(Id id) const {
    if (id < 0) return Origin::fixed;
    const BodyGroup& group = scene_.group_of(id);
    const Id k = id - group.first;
    if (group.is_static && group.make(k).properties.motion == Motion::fixed) return Origin::fixed;
    const Entry* entry = matches_[static_cast<std::size_t>(&group - scene_.groups.data())];
    return entry != nullptr && k < entry->count ? Origin::checkpoint : Origin::scene;
  }

  // Throws InputError where one of the two goes on and the other starts as the scene says. what: that holds them together.
  void expect_alike(Id a, Id b, const std::string& what) const {
    const Origin of_a = of(a), of_b = of(b);
    if (of_a == of_b || of_a == Origin::fixed || of_b == Origin::fixed) return;
    throw InputError(scene_.path + ": " + what + " holds " + scene_.body_name(a) + " and " + scene_.body_name(b) +
                     " together: found only " + scene_.body_name(of_a == Origin::checkpoint ? a : b) +
                     " in the checkpoint of -continue_from, expected both or neither");
  }

 private:
  const Scene& scene_;
  const std::vector<const Entry*>& matches_;
};

void check_what_holds_together(const Scene& scene, const std::vector<const Entry*>& matches) {
  const Origins origins(scene, matches);
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    origins.expect_alike(scene.joints[j].ids[0], scene.joints[j].ids[1], "joint " + std::to_string(j));
  for (std::size_t k = 0; k < scene.couplings.size(); ++k) {
    const std::array<Id, 4>& ids = scene.couplings[k].ids;
    origins.expect_alike(ids[0], ids[2], "coupling " + std::to_string(k));
  }
  for (const Attachment& a : scene.attachments) origins.expect_alike(a.node, a.body, "a tie");
  for (const Pin& pin : scene.pins) origins.expect_alike(pin.id, pin.body, "a pin");
  for (const ConstraintGroup& nodes : scene.constraint_groups) {
    const BodyGroup& group = scene.group_of(nodes.first);
    const Entry* entry = matches[static_cast<std::size_t>(&group - scene.groups.data())];
    if (entry != nullptr && entry->count != group.count)
      throw InputError(scene.path + ": " + group.name + ": found " + std::to_string(group.count) + " nodes, expected " +
                       std::to_string(entry->count) + " as in the checkpoint of -continue_from");
  }
}

// Throws InputError where the checkpoint has nothing that the scene could go on with: it is not the one that is meant.
void expect_some(const std::string& path, const Scene& scene, const SceneOutline& outline, const std::vector<Counts>& all) {
  if (std::ranges::any_of(all, [](const Counts& of) { return of[going_on] > 0 || of[gone] > 0; })) return;
  std::string names;
  for (const Entry& entry : outline.entries)
    if (!entry.name.empty()) names += (names.empty() ? "" : ", ") + entry.name;
  throw InputError(scene.path + ": found no moving bodies of a name that '" + path + "' has, expected one of " +
                   (names.empty() ? "none, since no entry of its scene has a name" : names));
}

// Counts in what a body is another one than it was.
void compare(const BodyProperties& now, const BodyProperties& before, const std::vector<std::string>& materials,
             const Scene& scene, Counts& counts) {
  const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-9 * std::abs(a); };
  counts[other_shape] += now.shape.kind != before.shape.kind || !now.shape.size.isApprox(before.shape.size, 1e-9);
  counts[other_mass] += now.is_dynamic() && before.is_dynamic() && !near(now.mass, before.mass);
  const auto material = static_cast<std::size_t>(before.material);
  counts[other_material] +=
      material >= materials.size() || scene.materials[static_cast<std::size_t>(now.material)] != materials[material];
}

void take_state(Body& body, const BodyState& state) {
  body.state = state;
  if (body.properties.motion == Motion::pinned) body.state.velocity.setZero(), body.state.angular_velocity.setZero();
}

// Numbers [first, last) of the group, as they start; those that are absent are left out.
std::vector<Body> bodies_of(const Checkpoint& checkpoint, const Scene& scene, const BodyGroup& group, const Entry* entry,
                            const std::vector<std::string>& materials, Id first, Id last, Counts& counts) {
  const Id known = entry != nullptr ? std::clamp(entry->count, first, last) : first;
  std::vector<Body> before, bodies;
  if (known > first) before = checkpoint.read_bodies(entry->first + first, entry->first + known, false);
  auto next = before.begin();
  for (Id k = first; k < last; ++k) {
    Body body = group.make(k);
    body.id = group.first + k;
    if (k >= known) {
      if (group.start == Start::absent) continue;
    } else if (next == before.end() || next->id != entry->first + k) {
      ++counts[gone];
      continue;
    } else {
      compare(body.properties, next->properties, materials, scene, counts);
      const bool moves = body.properties.motion != Motion::fixed;
      if (moves) take_state(body, next->state);
      counts[going_on] += moves;
      ++next;
    }
    bodies.push_back(body);
  }
  return bodies;
}

std::string told_of(const BodyGroup& group, const Entry* entry, const Counts& counts) {
  const std::string name = group.name.empty() ? "the entry of line " + std::to_string(group.line) : group.name;
  const auto number = [](Id n, const std::string& what) { return std::to_string(n) + what; };
  const std::string bodies = group.count == 1 ? " body" : " bodies";
  if (entry == nullptr) return "  " + name + " is new: " + number(group.count, bodies) + " as the scene says";
  std::string text = "  " + name + ": " + number(counts[going_on], " of ") + number(group.count, bodies) + " go on";
  if (counts[going_on] == 0 && counts[gone] == 0) text = "  " + name + " stands as the scene says";
  if (counts[gone] > 0) text += ", " + number(counts[gone], " are absent there and here");
  if (group.count > entry->count) text += ", " + number(group.count - entry->count, " are new");
  if (group.count < entry->count) text += ", " + number(entry->count - group.count, " of the checkpoint's are left out");
  constexpr std::array<const char*, count_kinds> others{"", "", " with another shape", " with another mass",
                                                        " with another material"};
  for (std::size_t c = other_shape; c < counts.size(); ++c)
    if (counts[c] > 0) text += ", " + number(counts[c], others[c]);
  if (group.inlet) text += "; its inlet lets in no more";
  return text;
}

// Entries of the checkpoint that no group of the scene is matched with.
void tell_left_out(const SceneOutline& outline, const std::vector<const Entry*>& matches, std::vector<std::string>& told) {
  Id nameless = 0;
  for (const Entry& entry : outline.entries) {
    if (std::ranges::find(matches, &entry) != matches.end()) continue;
    if (entry.name.empty())
      nameless += entry.count;
    else
      told.push_back("  " + entry.name + " is left out: the scene has no such entry");
  }
  if (nameless > 0) told.push_back("  " + std::to_string(nameless) + " bodies of entries without a name are left out");
}

// start: of the first sentence, which tells how many bodies go on.
std::vector<std::string> told_of_all(const std::string& start, const Scene& scene, const SceneOutline& outline,
                                     const std::vector<const Entry*>& matches, const std::vector<Counts>& all) {
  std::int64_t bodies = 0;
  std::vector<std::string> told{""};
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const BodyGroup& group = scene.groups[g];
    const Counts& of = all[g];
    bodies += of[going_on];
    const bool stands = matches[g] != nullptr && matches[g]->count == group.count &&
                        std::accumulate(of.begin(), of.end(), std::int64_t{0}) == 0;  // fixed then and now
    const bool is_nothing_to_tell = matches[g] == nullptr && group.name.empty() && group.is_static;
    if (!stands && !is_nothing_to_tell) told.push_back(told_of(group, matches[g], of));
  }
  tell_left_out(outline, matches, told);
  told.front() = start + std::to_string(bodies) + (bodies == 1 ? " body goes on" : " bodies go on");
  return told;
}

// A joint that has broken stays broken, if there is one of its kind between the same bodies. Returns how many do.
std::size_t break_again(const Scene& scene, const SceneOutline& outline, const std::vector<const Entry*>& matches, Past& past) {
  using Key = std::tuple<Id, Id, int>;
  const auto id_before = [&](Id id) -> Id {
    if (id < 0) return -1;
    const BodyGroup& group = scene.group_of(id);
    const Entry* entry = matches[static_cast<std::size_t>(&group - scene.groups.data())];
    return entry == nullptr || id - group.first >= entry->count ? -2 : entry->first + (id - group.first);
  };
  const auto key_of = [](Id a, Id b, int kind) { return Key(std::min(a, b), std::max(a, b), kind); };
  std::set<Key> broken;
  for (const auto& joint : outline.broken) broken.insert(key_of(joint.ids[0], joint.ids[1], joint.kind));
  for (std::size_t j = 0; j < scene.joints.size() && !broken.empty(); ++j) {
    const Joint& joint = scene.joints[j];
    if (broken.contains(key_of(id_before(joint.ids[0]), id_before(joint.ids[1]), static_cast<int>(joint.kind))))
      past.breaks.push_back({static_cast<std::int64_t>(j)});
  }
  return past.breaks.size();
}

// The inlets of entries that go on have done their work.
void close_inlets(const Scene& scene, const std::vector<const Entry*>& matches, Past& past) {
  std::size_t number = 0;
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    if (!scene.groups[g].inlet) continue;
    InletPast& inlet = past.inlets[number++];
    if (matches[g] != nullptr) inlet.drawn = scene.groups[g].count;
  }
}

}  // namespace

SceneOutline outline_of(const Scene& scene) {
  SceneOutline outline{scene.planar, scene.lacks_bodies, scene.materials, {}, {}};
  for (const BodyGroup& group : scene.groups) outline.entries.push_back({group.first, group.count, group.name});
  return outline;
}

std::vector<std::string> continue_from(MPI_Comm comm, const std::string& path, Scene& scene, Simulation& simulation) {
  const Checkpoint checkpoint(comm, path, "");
  int rank = 0, size = 1;
  check_mpi(MPI_Comm_rank(comm, &rank));
  check_mpi(MPI_Comm_size(comm, &size));
  const Id count = scene.body_count(), begin = count * rank / size, end = count * (rank + 1) / size;
  SceneOutline outline;
  std::vector<const Entry*> matches;
  std::vector<Counts> all(scene.groups.size(), Counts{});
  std::vector<Body> homes, statics;
  agree<InputError>(comm, "", [&] {
    outline = checkpoint.outline();
    matches = matches_of(scene, outline);
    if (scene.planar && !outline.planar)
      throw InputError(scene.path + ": key 'planar': found true, expected false as in the run that wrote '" + path + "'");
    check_what_holds_together(scene, matches);
    for (std::size_t g = 0; g < scene.groups.size(); ++g) {
      const BodyGroup& group = scene.groups[g];
      const Id first = group.is_static ? 0 : std::clamp<Id>(begin - group.first, 0, group.count);
      const Id last = group.is_static ? group.count : std::clamp<Id>(end - group.first, 0, group.count);
      const auto bodies = bodies_of(checkpoint, scene, group, matches[g], outline.materials, first, last, all[g]);
      if (group.is_static && rank != 0) all[g] = {};
      auto& to = group.is_static ? statics : homes;
      to.insert(to.end(), bodies.begin(), bodies.end());
    }
  });
  if (!all.empty())
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size() * count_kinds), MPI_INT64_T, MPI_SUM, comm));
  expect_some(path, scene, outline, all);
  simulation.world = make_world(homes, statics, scene.has_rotations(), scene.period);
  close_inlets(scene, matches, simulation.history.past);
  const std::size_t broken = break_again(scene, outline, matches, simulation.history.past);

  for (const Counts& of : all) scene.lacks_bodies = scene.lacks_bodies || of[gone] > 0;
  auto told = told_of_all("starts from frame " + std::to_string(checkpoint.frame()) + " of " + path + ", at time 0: ", scene,
                          outline, matches, all);
  if (broken > 0) told.push_back("  " + std::to_string(broken) + " of the scene's joints have broken there, and are so here");
  return told;
}

}  // namespace unibody
