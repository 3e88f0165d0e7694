#include "report/measure.hpp"

#include <algorithm>
#include <limits>

#include "report/report.hpp"
#include "report_worlds.hpp"

namespace unibody::measure_test {
namespace {

using namespace testing_worlds;

// Bodies 1..n in a row, cut over the ranks like cards, on a fixed body 0: every rank has all the others as guests. Contacts
// (0, k) with two points, the deeper 0.001 k; and (k, k + 1), open for even k, 0.01 k deep for odd k.
struct Row {
  World world;
  Contacts contacts;
};

Row row(MPI_Comm comm, Id n) {
  const int rank = rank_of(comm), ranks = size_of(comm);
  std::vector<Body> homes, guests;
  for (Id k = 1; k <= n; ++k) {
    Body b;
    b.id = k;
    b.properties.shape = {ShapeKind::sphere, Vec3(0.5, 0, 0)};
    b.properties.mass = 2;
    b.properties.inertia = Vec3(1, 2, 3);
    b.state.position = Vec3(static_cast<double>(k), 0, 1);
    b.state.velocity = Vec3(0, 3, 0);
    b.state.orientation = Quat(Eigen::AngleAxisd(std::acos(-1.0) / 2, Vec3::UnitZ()));  // body x is world y
    b.state.angular_velocity = Vec3(0, 5, 0);
    (k % ranks == rank ? homes : guests).push_back(b);
  }
  Row r;
  Body ground;
  ground.properties.motion = Motion::fixed;
  ground.properties.shape.kind = ShapeKind::plane;
  r.world.homes = homes.size(), r.world.guests = guests.size();
  r.world.resize(homes.size() + guests.size() + 1);
  std::size_t slot = 0;
  for (const auto& b : homes) r.world.set(slot++, b);
  for (const auto& b : guests) r.world.set(slot++, b);
  r.world.set(slot, ground);
  const auto slot_of = [&](Id id) {
    return static_cast<Slot>(std::find(r.world.id.begin(), r.world.id.end(), id) - r.world.id.begin());
  };
  const auto add = [&](Id a, Id b, std::initializer_list<double> gaps) {
    const Slot sa = slot_of(a), sb = slot_of(b);
    if (!r.world.is_home(sa) && !r.world.is_home(sb)) return;
    r.contacts.manifolds.push_back({a, b, sa, sb, Vec3::UnitZ(), 0.5, static_cast<std::uint32_t>(r.contacts.points.size()),
                                    static_cast<std::uint32_t>(gaps.size())});
    for (double gap : gaps) r.contacts.points.push_back({Vec3::Zero(), gap, 0});
  };
  for (Id k = 1; k <= n; ++k) add(0, k, {0.5, -0.001 * static_cast<double>(k)});
  add(0, n, {0.2, -0.0005});  // a second manifold of a pair
  for (Id k = 1; k < n; ++k) add(k, k + 1, {k % 2 == 0 ? 0.1 : -0.01 * static_cast<double>(k)});
  return r;
}

TEST(RanksMeasure, HandComputed) {
  const Row r = row(MPI_COMM_WORLD, 4);
  const Measures m = measure(MPI_COMM_WORLD, r.world, r.contacts, Vec3(0, 0, -10), 100.0 * static_cast<double>(r.world.homes));
  // Depths 1, 2, 3, 4 mm on the ground; 10 and 30 mm between neighbours.
  EXPECT_EQ(m.pairs, 7);
  EXPECT_EQ(m.contacts, 13);
  EXPECT_DOUBLE_EQ(m.penetration_max, 0.03);
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  EXPECT_EQ(m.bytes_per_body, 100);
  EXPECT_EQ(m.bytes_of_largest_rank, 100 * ((4 + ranks - 1) / ranks));
  EXPECT_DOUBLE_EQ(m.penetration_l2, std::sqrt(1030e-6));
  EXPECT_DOUBLE_EQ(m.penetration_rms, std::sqrt(1030e-6 / 6));
  // Each: m v^2 / 2 = 9; spin 5 about its own x axis, of moment 1: 12.5.
  EXPECT_NEAR(m.kinetic_energy, 4 * 21.5, 1e-12);
  EXPECT_DOUBLE_EQ(m.potential_energy, 4 * 20.0);
  EXPECT_EQ(m.linear_momentum, Vec3(0, 24, 0));
  // x cross m v: (k, 0, 1) x (0, 6, 0) = (-6, 0, 6 k); spin (0, 5, 0).
  EXPECT_NEAR((m.angular_momentum - Vec3(-24, 20, 60)).norm(), 0, 1e-12);
  EXPECT_DOUBLE_EQ(m.bytes_per_body, 100);
}

TEST(RanksMeasure, SameBitsAsOnOneRank) {
  const Row many = row(MPI_COMM_WORLD, 57), one = row(MPI_COMM_SELF, 57);
  const Vec3 gravity(0.1, 0.7, -9.81);
  FrameReport a, b;
  a.measures = measure(MPI_COMM_WORLD, many.world, many.contacts, gravity);
  b.measures = measure(MPI_COMM_SELF, one.world, one.contacts, gravity);
  EXPECT_EQ(report_row(a), report_row(b));
}

TEST(RanksMeasure, NamesTheFirstBadBody) {
  EXPECT_EQ(first_bad_body(MPI_COMM_WORLD, row(MPI_COMM_WORLD, 9).world), -1);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    Row r = row(MPI_COMM_WORLD, 9);
    for (std::size_t slot = 0; slot < r.world.homes; ++slot) {
      if (r.world.id[slot] == 5) r.world.velocity[slot][1] = bad;
      if (r.world.id[slot] == 8) r.world.orientation[slot].w() = bad;
    }
    EXPECT_EQ(first_bad_body(MPI_COMM_WORLD, r.world), 5);
  }
}

TEST(RanksMeasure, NothingAtAll) {
  World w;
  const Measures m = measure(MPI_COMM_WORLD, w, {}, Vec3(0, 0, -10));
  EXPECT_EQ(m.penetration_rms, 0);
  EXPECT_EQ(m.bytes_per_body, 0);
}

}  // namespace
}  // namespace unibody::measure_test
