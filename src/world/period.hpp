// Directions in which a scene repeats itself: a cell of space, beyond whose borders stand images of what is in it.
//
// A body's position is not taken back into the cell: it goes on counting, so that joints, energies and paths know nothing of
// borders. Code that compares the places of two bodies takes the image of the second that is nearest to the first.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/types.hpp"

namespace unibody {

using Image = std::array<std::int32_t, 3>;  // how many cells away, along each axis

struct Period {
  Vec3 lower = Vec3::Zero();   // m, the cell's corner of the least coordinates
  Vec3 length = Vec3::Zero();  // m, of the cell; 0 along axes without borders

  bool any() const { return !length.isZero(0); }
  bool along(int axis) const { return length[axis] > 0; }

  Vec3 shift(const Image& image) const { return {image[0] * length[0], image[1] * length[1], image[2] * length[2]}; }

  // The cell that a place is in, counted from the first one.
  Image image_of(const Vec3& place) const {
    return each([&](int k) { return std::floor((place[k] - lower[k]) / length[k]); });
  }
  // By how many cells `other` must be moved to be as near to `place` as it can be.
  Image nearest(const Vec3& place, const Vec3& other) const {
    return each([&](int k) { return std::round((place[k] - other[k]) / length[k]); });
  }
  // The image of a place that lies in the first cell.
  Vec3 wrapped(const Vec3& place) const { return wrapped(place, lower); }
  // The image of a place that lies in the cell which begins at `corner`, the corner of its least coordinates.
  Vec3 wrapped(const Vec3& place, const Vec3& corner) const {
    if (!any()) return place;
    return place - shift(each([&](int k) { return std::floor((place[k] - corner[k]) / length[k]); }));
  }

 private:
  template <class F>
  Image each(F&& number) const {
    constexpr double most = 1e9;
    Image image{};
    for (int k = 0; k < 3; ++k)
      if (along(k)) {
        const double cells = number(k);  // not a number where the place is none, which the run finds out
        image[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(cells > -most ? std::min(cells, most) : -most);
      }
    return image;
  }
};

}  // namespace unibody
