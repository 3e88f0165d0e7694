// Crowds: more bodies at one place than can be there. N bodies at one place are N (N - 1) / 2 pairs that all overlap, which
// nobody means, and which would take hours for some ten thousands; so each of them meets a few of the others only, until they are
// apart.
//
// Centres of convex bodies of about one size are in one cell of half their smallest size; five in a cell or more are a crowd.
// (Bodies that touch have at most one there.) Its members are ranked by id. Two members of one crowd meet where their ranks
// differ by two at most, members of two crowds where their ranks are equal, and all else as ever: so many pairs as bodies, times
// a number that does not depend on how many there are.
#pragma once

#include <span>
#include <vector>

#include "collide/broadphase.hpp"
#include "world/world.hpp"

namespace unibody {

inline constexpr std::size_t most_of_no_crowd = 4;  // bodies in a cell
inline constexpr std::int32_t reach_in_crowd = 2;   // ranks

// The place of a body as crowds see it: a cell of half its size, of bodies of this size within a quarter.
struct CrowdCell {
  std::int64_t size, x, y, z;
  auto operator<=>(const CrowdCell&) const = default;
};

// By slot, each home body's rank in the crowd that it belongs to; -1: in none, or not home here. Empty where no home body is in a
// crowd. All members of a home body's crowd must be here: they overlap it, so that they are its guests.
std::vector<std::int32_t> crowd_ranks(const World& world);

// Members of crowds, one crowd after the other, in order of their ranks. A crowd stands in the broad phase as one body, which its
// first member here lends its index to.
class Crowds {
 public:
  struct Member {
    CrowdCell cell;
    std::int32_t rank, index;  // in the crowd; in the lists of the broad phase
  };

  explicit Crowds(std::vector<Member> members);  // in any order

  // Puts one member, with bounds that hold them all, in place of each crowd's members.
  void stand_for(std::span<Bounds> bounds, std::span<Role> roles, std::span<Filter> filters) const;

  // Puts the pairs of members that meet in place of the pairs with crowds. bounds, roles, filters: those from before
  // stand_for().
  void expand(Pairs& pairs, std::span<const Bounds> bounds, std::span<const Role> roles, std::span<const Filter> filters,
              const Period& period = {}) const;

 private:
  std::span<const Member> members(std::size_t crowd) const {
    return {members_.data() + first_[crowd], first_[crowd + 1] - first_[crowd]};
  }
  std::size_t count() const { return first_.size() - 1; }

  std::vector<Member> members_;
  std::vector<std::size_t> first_;  // of each crowd, its first member; and their end
};

// The cell of a body that may be in a crowd: dynamic, convex and solid, and no node of a cloth, thread or solid.
bool may_crowd(const BodyProperties& body);
CrowdCell crowd_cell(const BodyProperties& body, const Vec3& position);

}  // namespace unibody
