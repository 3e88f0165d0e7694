// ContactBatch: every row in use, wherever its block lies.
#pragma once

#include "constraints/contact_batch.hpp"

namespace unibody {

template <class F>
void ContactBatch::for_each_row(F&& f) const {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Manifold& m = contacts_->manifolds[i];
    const Rows& rows = rows_[places_[i] / lanes];
    for (std::uint32_t p = 0; p < m.count; ++p)
      f(i, places_[i] % lanes, rows.first_point + p,
        rows.first_tangent < 0 ? no_tangent : static_cast<std::size_t>(rows.first_tangent) + p, m.first + p);
  }
}

}  // namespace unibody
