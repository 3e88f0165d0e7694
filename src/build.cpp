#include "build.hpp"

namespace unibody {

World build_world(MPI_Comm comm, const Scene& scene) {
  int rank = 0, size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  const Id count = scene.body_count();
  const Id begin = count * rank / size, end = count * (rank + 1) / size;

  std::vector<Body> homes, statics;
  for (const BodyGroup& group : scene.groups) {
    const Id first = group.is_static ? 0 : std::max<Id>(0, begin - group.first);
    const Id last = group.is_static ? group.count : std::min(group.count, end - group.first);
    for (Id k = first; k < last; ++k) {
      Body body = group.make(k);
      body.id = group.first + k;
      (group.is_static ? statics : homes).push_back(body);
    }
  }
  return make_world(homes, statics);
}

World make_world(const std::vector<Body>& homes, const std::vector<Body>& statics) {
  World world;
  world.homes = homes.size();
  world.resize(homes.size() + statics.size());
  for (std::size_t i = 0; i < homes.size(); ++i) world.set(i, homes[i]);
  for (std::size_t i = 0; i < statics.size(); ++i) world.set(homes.size() + i, statics[i]);
  return world;
}

}  // namespace unibody
