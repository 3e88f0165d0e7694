#include "step/pressed_areas.hpp"

#include <algorithm>

#include "core/checked.hpp"
#include "joints/joint_set.hpp"

namespace unibody {

void measure_pressed_areas(RankState& state) {
  if (state.ties.pressed_areas.empty()) return;
  const std::vector<Joint>& joints = state.scene.joints;
  std::vector<std::int64_t> sliders;  // on whose offsets areas depend
  for (const Joint& joint : joints)
    if (joint.area)
      for (const PressedArea::Length& length : joint.area->lengths) sliders.push_back(length.slider);
  std::ranges::sort(sliders);
  sliders.erase(std::unique(sliders.begin(), sliders.end()), sliders.end());

  // One rank counts each joint, and the others add zero: the sum is that rank's value to the last bit.
  std::vector<double> offsets(sliders.size(), 0);
  const auto place_of = [&](std::int64_t slider) { return std::ranges::lower_bound(sliders, slider) - sliders.begin(); };
  for (std::size_t i = 0; i < state.ties.joints.size(); ++i) {
    if (!state.ties.joint_slots[i].counted || !std::ranges::binary_search(sliders, state.ties.joints[i])) continue;
    const Joint& joint = joints[static_cast<std::size_t>(state.ties.joints[i])];
    offsets[static_cast<std::size_t>(place_of(state.ties.joints[i]))] =
        joint_state(joint, state.ties.joint_slots[i], state.world, {}, state.step()).coordinate;
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, offsets.data(), static_cast<int>(offsets.size()), MPI_DOUBLE, MPI_SUM, state.comm()));

  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (!joints[j].area) continue;
    double area = 1;
    for (const PressedArea::Length& length : joints[j].area->lengths)
      area *= std::max(0.0, length.at_start + offsets[static_cast<std::size_t>(place_of(length.slider))]);
    state.ties.pressed_areas[j] = area;
  }
}

}  // namespace unibody
