#include "chain.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace rivals {

std::vector<Anchor> chain_anchors(const Bodies& bodies, const Frame& start) {
  std::vector<long> order;
  for (std::size_t i = 0; i < bodies.count(); ++i)
    if (bodies.is_dynamic(i)) order.push_back(static_cast<long>(i));
  if (order.size() < 2) throw std::runtime_error("a chain has two links or more");
  const auto at = [&](std::size_t k) { return static_cast<std::size_t>(order[k]); };
  const double length = (start.position[at(1)] - start.position[at(0)]).norm();
  std::vector<Anchor> anchors;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool link = bodies.shape[at(k)] == Shape::box;
    const std::size_t along = link ? at(k) : at(k - 1);  // a body at the end hangs where the last link ends
    const Vec3 half = start.orientation[along] * Vec3(length / 2, 0, 0);
    const Vec3 place = start.position[along] + (link ? Vec3(-half) : half);
    Anchor anchor;
    anchor.a = k == 0 ? -1 : order[k - 1], anchor.b = order[k];
    anchor.in_a = k == 0 ? place : Vec3(start.orientation[at(k - 1)].conjugate() * (place - start.position[at(k - 1)]));
    anchor.in_b = start.orientation[at(k)].conjugate() * (place - start.position[at(k)]);
    anchors.push_back(anchor);
  }
  return anchors;
}

Drift chain_drift(const std::vector<Anchor>& anchors, const Frame& frame) {
  const auto place = [&](long body, const Vec3& local) -> Vec3 {
    if (body < 0) return local;
    const auto i = static_cast<std::size_t>(body);
    return frame.position[i] + frame.orientation[i] * local;
  };
  Drift drift;
  for (const Anchor& j : anchors) {
    const double open = (place(j.a, j.in_a) - place(j.b, j.in_b)).norm();
    drift.rms += open * open, drift.max = std::max(drift.max, open);
  }
  drift.rms = std::sqrt(drift.rms / static_cast<double>(anchors.size()));
  return drift;
}

}  // namespace rivals
