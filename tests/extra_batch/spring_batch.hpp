// A kind of constraint that exists in this test alone: two springs from the centre of body 0 to the origin's planes, along x and
// along a slanted direction. Nothing else in the program knows of it but the list of batches.
#pragma once

#include "constraints/row_batch.hpp"
#include "world/world.hpp"

namespace unibody {

struct SpringBatch : RowBatch<SpringBatch, Row<1>> {
  static constexpr std::string_view name = "springs_to_the_origin";
  static constexpr double stiffness = 40000;  // N/m, of each
  static constexpr double directions[2][3] = {{1, 0, 0}, {0.6, 0.8, 0}};

  template <class F>
  static void for_each_element(const Elements& elements, F&& f) {
    const Slot body = elements.world.find(0);
    for (Id k = 0; k < 2 && body >= 0 && elements.world.is_home(body); ++k) f(Key{k}, std::array<Id, 1>{0});
  }
  static std::optional<Row<1>> row_of(const BuildContext& context, const Key& key, std::size_t) {
    const Vec3 along(directions[key[0]]), position = context.world.position[static_cast<std::size_t>(context.world.find(0))];
    const RowEnd<> end{row_side(context, context.world.find(0)), along, Vec3::Zero()};
    return Row<1>{.ends = {end}, .open = along.dot(position), .compliance = 1 / stiffness};
  }
};

static_assert(KeyedBatch<SpringBatch>);

}  // namespace unibody
