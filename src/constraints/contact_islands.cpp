// ContactBatch: which islands a solve is about.
//
// A row whose scales and multipliers are 0 moves nothing and leaves no residual. Those of rows that are not selected are kept
// aside. (The multipliers too, since projected once more on the cone they would change by a rounding.) All passes go over such
// rows as well, on every rank: what they add is 0, but that turns a velocity of -0 into 0, so a rank that left them out would end
// with other bits.

#include <array>
#include <tuple>
#include <utility>

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

// Calls f(the numbers of a row, as pointers; null: it has no such number) for each row that is not selected, always in the same
// order.
template <class F>
void ContactBatch::for_each_hidden(F&& f) {
  for_each_row([&](std::size_t m, std::size_t l, std::size_t p, std::size_t t, std::size_t) {
    if (is_selected(m)) return;
    const auto lane = [&](Vec4d& of) { return reinterpret_cast<double*>(&of) + l; };
    std::array<double*, std::tuple_size_v<HiddenRow>> at{};
    at[0] = lane(points[p].inverse_scale), at[1] = lane(normals[p].lambda);
    if (!normal_scales.empty()) at[2] = lane(normal_scales[p]);
    if (t != no_tangent) {
      at[3] = lane(tangents[t].inverse_scale);
      at[4] = lane(tangent_impulses[t].lambda_s), at[5] = lane(tangent_impulses[t].lambda_t);
      if (!tangent_scales.empty()) at[6] = lane(tangent_scales[t]);
    }
    f(at);
  });
}

void ContactBatch::select_islands(Islands islands) {
  if (constrained_.empty() || islands == selected_) return;
  auto from = hidden_.begin();
  for_each_hidden([&](const auto& at) {
    for (std::size_t k = 0; k < at.size(); ++k)
      if (at[k] != nullptr) *at[k] = (*from)[k];
    ++from;
  });
  hidden_.clear(), selected_ = islands, any_selected_ = false;
  for (std::size_t m = 0; m < constrained_.size() && !any_selected_; ++m) any_selected_ = is_selected(m);
  for_each_hidden([&](const auto& at) {
    HiddenRow& row = hidden_.emplace_back();
    for (std::size_t k = 0; k < at.size(); ++k)
      if (at[k] != nullptr) row[k] = std::exchange(*at[k], 0.0);
  });
  start_momenta();
}

}  // namespace unibody
