// ContactBatch: which islands a solve is about.
//
// A row whose scales are 0 moves nothing and leaves no residual. Those of rows that are not selected are kept aside.

#include "constraints/contact_batch.hpp"
#include "constraints/contact_for_each.hpp"

namespace unibody {

std::pair<bool, bool> ContactBatch::set_islands(std::span<const std::int32_t> constrained) {
  constrained_.resize(contacts_->manifolds.size());
  std::pair<bool, bool> any{false, false};
  for (std::size_t i = 0; i < constrained_.size(); ++i) {
    const Manifold& m = contacts_->manifolds[i];
    constrained_[i] =
        constrained[static_cast<std::size_t>(m.slot_a)] != 0 || constrained[static_cast<std::size_t>(m.slot_b)] != 0;
    (constrained_[i] == 0 ? any.first : any.second) = true;
  }
  return any;
}

// Calls f with references to the four scales of each row that is not selected, always in the same order.
template <class F>
void ContactBatch::for_each_hidden(F&& f) {
  for_each_row([&](std::size_t m, std::size_t l, std::size_t p, std::size_t t, std::size_t) {
    if (is_selected(m)) return;
    double none = 0, no_other = 0, no_third = 0;
    const auto lane = [&](Vec4d& of) -> double& { return reinterpret_cast<double*>(&of)[l]; };
    const bool has_tangents = t != no_tangent;
    f(lane(points[p].inverse_scale), normal_scales.empty() ? none : lane(normal_scales[p]),
      has_tangents ? lane(tangents[t].inverse_scale) : no_other,
      has_tangents && !tangent_scales.empty() ? lane(tangent_scales[t]) : no_third);
  });
}

void ContactBatch::select_islands(Islands islands) {
  if (constrained_.empty() || islands == selected_) return;
  auto from = hidden_.begin();
  for_each_hidden([&](double& inverse, double& scale, double& tangential_inverse, double& tangential) {
    inverse = from->inverse, scale = from->scale, tangential_inverse = from->tangential_inverse, tangential = from->tangential;
    ++from;
  });
  hidden_.clear(), selected_ = islands, any_selected_ = false;
  for (std::size_t m = 0; m < constrained_.size() && !any_selected_; ++m) any_selected_ = is_selected(m);
  for_each_hidden([&](double& inverse, double& scale, double& tangential_inverse, double& tangential) {
    hidden_.push_back({inverse, scale, tangential_inverse, tangential});
    inverse = scale = tangential_inverse = tangential = 0;
  });
}

}  // namespace unibody
