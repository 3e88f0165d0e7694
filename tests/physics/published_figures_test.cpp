// Elastic equilibria against published figures and closed forms, on three meshes, each twice as fine as the one before.
//
// Linear tetrahedra are too stiff, by a share that falls with the square of their size. Extrapolated from two meshes, the
// stiffness is off by terms of fourth order: about a sixteenth of what the coarse one is too stiff.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "solve/elastic_bench.hpp"
#include "solve/reference.hpp"

namespace unibody::small_worlds::published_figures_test {

namespace {

using Cells = std::array<Id, 3>;
using Map = std::function<Vec3(const Vec3& share)>;  // of the way along each axis, 0 to 1

// Cells of six tetrahedra. Their diagonals are each other's mirror images about the middles of the axes that `mirrored` names, so
// that a shape which is its own mirror image has a mesh that is so too.
ElasticMesh lattice(const Cells& cells, const std::array<bool, 3>& mirrored, const Map& place) {
  ElasticMesh mesh{{}, {}, {}};
  const Cells stride{1, cells[0] + 1, (cells[0] + 1) * (cells[1] + 1)};
  for (Id k = 0; k <= cells[2]; ++k)
    for (Id j = 0; j <= cells[1]; ++j)
      for (Id i = 0; i <= cells[0]; ++i) {
        const auto share = [&](Id n, std::size_t axis) { return static_cast<double>(n) / static_cast<double>(cells[axis]); };
        mesh.rest.push_back(place({share(i, 0), share(j, 1), share(k, 2)}));
      }
  std::array<std::size_t, 3> path{0, 1, 2};
  do {
    for (Id cell = 0; cell < cells[0] * cells[1] * cells[2]; ++cell) {
      const Cells at{cell % cells[0], cell / cells[0] % cells[1], cell / cells[0] / cells[1]};
      std::array<Id, 4> tet{};
      std::array<Id, 3> step{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool back = mirrored[axis] && 2 * at[axis] < cells[axis];
        tet[0] += (at[axis] + back) * stride[axis], step[axis] = back ? -stride[axis] : stride[axis];
      }
      for (std::size_t n = 0; n < 3; ++n) tet[n + 1] = tet[n] + step[path[n]];
      if (ElasticMesh::edges(tet, mesh.rest).determinant() < 0) std::swap(tet[2], tet[3]);
      mesh.cells.push_back(tet);
    }
  } while (std::next_permutation(path.begin(), path.end()));
  return mesh;
}

using Where = std::function<bool(const Vec3& rest)>;
struct Load {
  Where where;
  Vec3 force;  // N, spread over the nodes there
};

std::vector<Vec3> spread(const ElasticMesh& mesh, const std::vector<Load>& loads) {
  std::vector<Vec3> force(mesh.rest.size(), Vec3::Zero());
  for (const Load& load : loads) {
    const auto count = std::count_if(mesh.rest.begin(), mesh.rest.end(), load.where);
    for (std::size_t i = 0; i < force.size(); ++i)
      if (load.where(mesh.rest[i])) force[i] += load.force / static_cast<double>(count);
  }
  return force;
}

std::vector<Vec3> weight(const ElasticMesh& mesh, const Vec3& of_a_cubic_metre) {
  std::vector<Vec3> force(mesh.rest.size(), Vec3::Zero());
  for (const auto& cell : mesh.cells)
    for (const Id node : cell)
      force[static_cast<std::size_t>(node)] += ElasticMesh::edges(cell, mesh.rest).determinant() / 24 * of_a_cubic_metre;
  return force;
}

// What the nodes move (m) until a body of these materials rests under forces on its nodes (N), held where `held` says.
std::vector<Vec3> equilibrium(const ElasticMesh& mesh, double young, double poisson, const Where& held,
                              const std::vector<Vec3>& force) {
  constexpr double step = 1e4;  // s, far longer than any period
  std::vector<Body> bodies;
  for (std::size_t i = 0; i < mesh.rest.size(); ++i) {
    Body body = samples::body(static_cast<Id>(i), ShapeKind::particle, Vec3(1e-3, 0, 0), mesh.rest[i]);
    body.properties.mass = 1e-9 * young;
    body.properties.force = force[i];
    bodies.push_back(body);
  }
  World world = samples::world_of(bodies);
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (!held(mesh.rest[i])) continue;
    BodyProperties properties = world.properties[i];
    properties.motion = Motion::pinned;
    world.properties.set(i, properties);
  }
  const ReferenceStep found = reference_step(world, constraints_of(mesh, young, poisson), Vec3::Zero(), step);
  EXPECT_TRUE(found.converged) << found.reason;
  std::vector<Vec3> moved;
  for (const Vec3& v : found.velocity) moved.emplace_back(step * v);
  return moved;
}

Where across(Eigen::Index axis, double at) {
  return [=](const Vec3& x) { return std::abs(x[axis] - at) < 1e-9; };
}

Vec3 mean(const ElasticMesh& mesh, const std::vector<Vec3>& moved, const Where& where) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (std::size_t i = 0; i < moved.size(); ++i)
    if (where(mesh.rest[i])) sum += moved[i], ++count;
  return sum / count;
}

// Forces about an axis through the origin, on the nodes that `where` says, each by its distance from the axis. Where the nodes
// are even about it their sum is nothing but `torque` (N m).
std::vector<Vec3> couple(const ElasticMesh& mesh, Eigen::Index axis, const Where& where, double torque) {
  std::vector<Vec3> force(mesh.rest.size(), Vec3::Zero());
  double squares = 0;
  for (std::size_t i = 0; i < force.size(); ++i)
    if (where(mesh.rest[i])) force[i] = Vec3::Unit(axis).cross(mesh.rest[i]), squares += force[i].squaredNorm();
  for (Vec3& f : force) f *= torque / squares;
  return force;
}

// rad: by how much the section at `at` has turned about an axis through the origin.
double turned(const ElasticMesh& mesh, const std::vector<Vec3>& moved, Eigen::Index axis, double at) {
  const Eigen::Index one = (axis + 1) % 3, two = (axis + 2) % 3;
  double cross = 0, dot = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (!across(axis, at)(mesh.rest[i])) continue;
    const Vec3 &before = mesh.rest[i], after = before + moved[i];
    cross += before[one] * after[two] - before[two] * after[one], dot += before[one] * after[one] + before[two] * after[two];
  }
  return std::atan2(cross, dot);
}

// The order at which the stiffness, 1 over a displacement, falls to its limit on meshes of size 4 h, 2 h and h. Of a h^2 + b h^4
// it is 2 + log2((1 + 5 r) / (1 + 5/4 r)), r = 4 b h^2 / a the share of the second term on the mesh in the middle.
using Band = std::array<double, 2>;
constexpr Band second{1.75, 2.25};  // r is -4 to 5 %
void expect_order(double coarse, double medium, double fine, const Band& band, const std::string& what) {
  const double order = std::log2((1 / coarse - 1 / medium) / (1 / medium - 1 / fine));
  EXPECT_GT(order, band[0]) << what << ": " << coarse << ", " << medium << ", " << fine;
  EXPECT_LT(order, band[1]) << what << ": " << coarse << ", " << medium << ", " << fine;
}

// Displacements of a coarse mesh and one of half its size against the exact one.
// `other`: relative error of the exact one by itself.
void expect_limit(double coarse, double fine, double exact, const std::string& what, double other = 0) {
  const double excess = exact / coarse - 1, limit = 1 / (1 / fine - (1 / coarse - 1 / fine) / 3);
  EXPECT_LT(std::abs(exact / fine - 1), 0.5 * std::abs(excess)) << what << ": the fine mesh is no better";
  EXPECT_NEAR(exact / limit, 1, excess / 16 + other) << what << ": " << coarse << ", " << fine << ", limit " << limit;
}

// A bar from x = 0 along x, held there.
struct Bar {
  double length, width, height;  // m, along x, y and z

  ElasticMesh mesh(const Cells& cells) const {
    return lattice(cells, {},
                   [this](const Vec3& s) { return Vec3(length * s.x(), width * (s.y() - 0.5), height * (s.z() - 0.5)); });
  }
  Vec3 tip(const Cells& cells, double young, double poisson, const Vec3& force) const {
    const ElasticMesh m = mesh(cells);
    return mean(m, equilibrium(m, young, poisson, across(0, 0), spread(m, {{across(0, length), force}})), across(0, length));
  }
};

}  // namespace

// F6, MacNeal & Harder 1985: a bar of 6 x .2 x .1, E = 1e7, nu = .3, unit loads; scaled from loads so small that strains are.
TEST(PublishedFigures, MacNealsStraightBeam) {
  const Bar bar{6, 0.2, 0.1};
  constexpr double load = 0.05;
  const std::array<double, 3> published{3.0e-5, 0.1081, 0.4321};
  const auto tip = [&](Id n, Eigen::Index axis) {
    return bar.tip({30 * n, n, n}, 1e7, 0.3, load * Vec3::Unit(axis))[axis] / load;
  };
  EXPECT_NEAR(tip(2, 0) / published[0], 1, 0.005);
  for (const Eigen::Index axis : {1, 2}) {
    const double coarse = tip(2, axis), fine = tip(4, axis);
    const std::string what = "axis " + std::to_string(axis);
    expect_limit(coarse, fine, published[static_cast<std::size_t>(axis)], what);
    expect_order(tip(1, axis), coarse, fine, second, what);
  }
}

// The same section under a couple T, by Saint-Venant: a piece of it, away from its ends, turns by T / G J a metre, where J =
// w h^3 (1/3 - 64 / pi^5 h / w (tanh(pi w / 2 h) + ...)). Over 6 m that is .0341; MacNeal & Harder's .03208 is 6 % less.
TEST(PublishedFigures, TwistOfMacNealsBeam) {
  const Bar bar{1, 0.2, 0.1};
  constexpr double young = 1e7, poisson = 0.3, torque = 0.1;
  double series = 0;
  for (int n = 1; n < 20; n += 2) series += std::tanh(n * std::numbers::pi * bar.width / (2 * bar.height)) / std::pow(n, 5);
  const double J =
      bar.width * std::pow(bar.height, 3) * (1.0 / 3 - 64 / std::pow(std::numbers::pi, 5) * bar.height / bar.width * series);
  const auto twist = [&](Id n) {
    const ElasticMesh mesh = bar.mesh({10 * n, 2 * n, n});
    const auto moved = equilibrium(mesh, young, poisson, across(0, 0), couple(mesh, 0, across(0, bar.length), torque));
    return (turned(mesh, moved, 0, 0.8) - turned(mesh, moved, 0, 0.4)) / 0.4;
  };
  const double coarse = twist(4), fine = twist(8);
  expect_limit(coarse, fine, torque * 2 * (1 + poisson) / (young * J), "twist a metre");
  expect_order(twist(2), coarse, fine, second, "twist a metre");
}

// F7: w = P L^3 / 3 E I + P L / k G A under a load at the end, and q L^4 / 8 E I + q L^2 / 2 k G A under its own weight; k = 5/6.
TEST(PublishedFigures, Cantilever) {
  const Bar bar{1, 0.05, 0.2};  // so short that shear is 2.4 % of the one and 3.2 % of the other
  constexpr double young = 1e6, poisson = 0;
  const double area = bar.width * bar.height, bending = young * area * bar.height * bar.height / 12;
  const double shear = 5.0 / 6 * young / 2 * area, load = 1e-3 * bending;
  const auto sag = [&](Id n) {
    const ElasticMesh mesh = bar.mesh({5 * n, 1, n});
    const Vec3 of_a_cubic_metre(0, 0, -load / area);
    return -mean(mesh, equilibrium(mesh, young, poisson, across(0, 0), weight(mesh, of_a_cubic_metre)), across(0, 1)).z();
  };
  const auto drop = [&](Id n) { return -bar.tip({5 * n, 1, n}, young, poisson, {0, 0, -load}).z(); };
  const double dropped[] = {drop(4), drop(8), drop(16)}, sagged[] = {sag(4), sag(8), sag(16)};
  expect_limit(dropped[1], dropped[2], load / (3 * bending) + load / shear, "a load at the end");
  expect_limit(sagged[1], sagged[2], load / (8 * bending) + load / (2 * shear), "its own weight");
  expect_order(dropped[0], dropped[1], dropped[2], second, "a load at the end");
  expect_order(sagged[0], sagged[1], sagged[2], second, "its own weight");
}

// F8: the elastica, a slender cantilever under a dead load P; a = P L^2 / EI, where its end is: down and back over L.
TEST(PublishedFigures, TheElastica) {
  constexpr double thick = 1.0 / 32, young = 1e6;
  const Bar bar{1, thick, thick};
  for (const auto& [a, down, back] :
       {std::tuple(1.0, 0.30172, 0.05643), {3.0, 0.60325, 0.25442}, {5.0, 0.71379, 0.38763}, {10.0, 0.81061, 0.55500}}) {
    const Vec3 force(0, 0, a * young * std::pow(thick, 4) / 12);
    const auto tip = [&](Id n) { return bar.tip({32 * n, 1, n}, young, 0, force); };
    const Vec3 coarsest = tip(2), coarse = tip(4), fine = tip(8);
    const std::string at = " at " + std::to_string(a);
    EXPECT_GT(coarse.z() / down, 0.8) << at;
    // The elastica neither stretches nor shears; this bar does, by no more than P / E A + P / k G A.
    const double other = a * thick * thick / 12 * (1 + 2.4);
    expect_limit(coarse.z(), fine.z(), down, "down" + at, other);
    expect_limit(-coarse.x(), -fine.x(), back, "back" + at, other);
    expect_order(coarsest.z(), coarse.z(), fine.z(), second, "down" + at);
    // What a slope takes off the length is as its square: of that a root is over the stiffness.
    expect_order(std::sqrt(-coarsest.x()), std::sqrt(-coarse.x()), std::sqrt(-fine.x()), second, "back" + at);
  }
}

// F10: Cook's membrane, plane stress, E = 1, nu = 1/3, unit load up the right side, whose middle rises by 23.96.
TEST(PublishedFigures, CooksMembrane) {
  constexpr double load = 1e-4;
  const auto rise = [&](Id n, double poisson) {
    const ElasticMesh mesh = lattice({n, n, 2}, {false, false, true}, [](const Vec3& s) {
      const double x = 48 * s.x();
      return Vec3(x, (1 - s.y()) * 44 * x / 48 + s.y() * (44 + 16 * x / 48), s.z());
    });
    const auto moved = equilibrium(mesh, 1, poisson, across(0, 0), spread(mesh, {{across(0, 48), Vec3(0, load, 0)}}));
    const auto middle = [](const Vec3& x) { return (x.head<2>() - Eigen::Vector2d(48, 52)).norm() < 1e-9; };
    return mean(mesh, moved, middle).y() / load;
  };
  const double coarse = rise(16, 1.0 / 3), fine = rise(32, 1.0 / 3);
  expect_limit(coarse, fine, 23.96, "rise");
  // Where the held side meets the upper one, at 108 degrees, stress is infinite, if of finite energy: the order is below 2.
  expect_order(rise(8, 1.0 / 3), coarse, fine, {1, 2}, "rise");
  // In plane stress a body of this E is no stiffer for Poisson's ratio; tetrahedra lock, the less the finer they are.
  double share = 0;
  for (const Id n : {8, 16, 32}) {
    const double now = rise(n, 0.49) / 23.96;
    EXPECT_GT(now, share) << n;
    share = now;
  }
  EXPECT_LT(share, 0.9 * fine / 23.96);
  EXPECT_LT(rise(32, 0.4999), 0.5 * 23.96);
}

// F12: a round bar under a couple T turns by T L / G J; held against no end, one of St. Venant-Kirchhoff's law becomes shorter.
TEST(PublishedFigures, TorsionOfARoundBar) {
  constexpr double radius = 1, length = 6, young = 1e6, poisson = 0.3, strain = 0.01;
  struct Found {
    double twist, longer;
  };
  const auto turn = [&](Id n) {
    const ElasticMesh mesh = lattice({n, n, 2 * n}, {true, true, false}, [](const Vec3& s) {
      const double a = 2 * s.x() - 1, b = 2 * s.y() - 1, norm = std::hypot(a, b);
      const double grow = norm > 0 ? radius * std::max(std::abs(a), std::abs(b)) / norm : 0;
      return Vec3(grow * a, grow * b, length * s.z());
    });
    const double torque = young / (2 * (1 + poisson)) * std::numbers::pi / 2 * std::pow(radius, 3) * strain;
    const auto rim = [&](const Vec3& x) { return std::abs(x.z() - length) < 1e-9 && x.head<2>().norm() > radius - 1e-9; };
    const auto moved = equilibrium(mesh, young, poisson, across(2, 0), couple(mesh, 2, rim, torque));
    const double low = length / 4, high = 3 * length / 4;
    return Found{(turned(mesh, moved, 2, high) - turned(mesh, moved, 2, low)) / (high - low) * radius / strain,
                 (mean(mesh, moved, across(2, high)) - mean(mesh, moved, across(2, low))).z() / (high - low)};
  };
  const Found coarse = turn(4), fine = turn(8);
  expect_limit(coarse.twist, fine.twist, 1, "twist");
  expect_order(turn(2).twist, coarse.twist, fine.twist, second, "twist");
  const double shorter = (1 - poisson) / (4 * (1 + poisson)) * std::pow(fine.twist * strain, 2);
  EXPECT_LT(fine.longer, -0.5 * shorter);
  EXPECT_GT(fine.longer, -1.5 * shorter);
}

}  // namespace unibody::small_worlds::published_figures_test
