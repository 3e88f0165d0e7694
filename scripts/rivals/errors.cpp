#include "errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace rivals {

namespace {

double reach(Shape shape, const Vec3& size) { return shape == Shape::box ? size.norm() : size.x(); }

bool is_round(Shape shape) { return shape == Shape::sphere || shape == Shape::disc; }

double plane_depth(const Placed& plane, const Placed& body) {
  const Vec3 normal = plane.axes.col(2);
  const double extent = is_round(body.shape) ? body.size.x() : body.size.dot((body.axes.transpose() * normal).cwiseAbs());
  return std::max(0.0, extent - normal.dot(body.position - plane.position));
}

double round_box_depth(const Placed& ball, const Placed& box) {
  const Vec3 local = box.axes.transpose() * (ball.position - box.position);
  const Vec3 outside = (local.cwiseAbs() - box.size).cwiseMax(0.0);
  const double distance = outside.norm();
  if (distance > 0) return std::max(0.0, ball.size.x() - distance);
  return ball.size.x() + (box.size - local.cwiseAbs()).minCoeff();
}

double box_box_depth(const Placed& a, const Placed& b) {
  const Eigen::Matrix3d turn = a.axes.transpose() * b.axes;  // b's axes in a's frame
  const Eigen::Matrix3d absolute = turn.cwiseAbs();
  const Vec3 offset = a.axes.transpose() * (b.position - a.position);
  const Vec3 offset_b = turn.transpose() * offset;

  const Vec3 faces_a = a.size + absolute * b.size - offset.cwiseAbs();
  const Vec3 faces_b = b.size + absolute.transpose() * a.size - offset_b.cwiseAbs();
  double best = std::min(faces_a.minCoeff(), faces_b.minCoeff());
  if (best <= 0) return 0;

  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double length = std::sqrt(std::max(0.0, 1 - turn(i, j) * turn(i, j)));
      if (length < 1e-6) continue;  // parallel edges: the faces say it all
      const double extent = a.size[i1] * absolute(i2, j) + a.size[i2] * absolute(i1, j) + b.size[j1] * absolute(i, j2) +
                            b.size[j2] * absolute(i, j1);
      const double distance = std::abs(offset[i2] * turn(i1, j) - offset[i1] * turn(i2, j));
      best = std::min(best, (extent - distance) / length);
      if (best <= 0) return 0;
    }
  }
  return best;
}

// Finds the pairs whose bounding spheres overlap. Bodies of ordinary size go into a grid of cells no smaller than the
// largest of them, sorted by cell; the few much larger ones are tried against all.
template <typename Visit>
void for_each_near_pair(const std::vector<Vec3>& centre, const std::vector<double>& radius, Visit&& visit) {
  const std::size_t n = centre.size();
  if (n == 0) return;
  std::vector<double> sorted = radius;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n / 2), sorted.end());
  const double limit = 4 * sorted[n / 2];

  const auto try_pair = [&](std::size_t i, std::size_t j) {
    const double sum = radius[i] + radius[j];
    if ((centre[i] - centre[j]).squaredNorm() < sum * sum) visit(i, j);
  };
  std::vector<std::size_t> ordinary;
  Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity());
  double cell = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (radius[i] <= limit) {
      ordinary.push_back(i);
      lower = lower.cwiseMin(centre[i]);
      cell = std::max(cell, 2 * radius[i]);
    } else {
      for (std::size_t j = 0; j < n; ++j)
        if (radius[j] <= limit || j < i) try_pair(i, j);
    }
  }
  if (cell <= 0) return;

  // 20 bits an axis; what flew farther shares the last cell, which keeps neighbours neighbours.
  struct Entry {
    std::int64_t key;
    std::size_t body;
  };
  constexpr std::int64_t last = (1 << 20) - 2;
  const auto key_of = [](std::int64_t x, std::int64_t y, std::int64_t z) { return (z << 42) + (y << 21) + x; };
  std::vector<Entry> entries;
  std::vector<std::array<std::int64_t, 3>> cells(n);
  for (const auto i : ordinary) {
    for (int k = 0; k < 3; ++k)
      cells[i][static_cast<std::size_t>(k)] =
          1 + static_cast<std::int64_t>(std::min((centre[i][k] - lower[k]) / cell, static_cast<double>(last)));
    entries.push_back({key_of(cells[i][0], cells[i][1], cells[i][2]), i});
  }
  const auto before = [](const Entry& a, const Entry& b) { return a.key < b.key || (a.key == b.key && a.body < b.body); };
  std::sort(entries.begin(), entries.end(), before);

  // Half of the neighbours: those later in the order. Rows of three cells in x are contiguous.
  constexpr int rows[4][2] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}};  // (dy, dz)
  std::size_t cursor[4] = {0, 0, 0, 0};
  for (std::size_t e = 0; e < entries.size(); ++e) {
    const auto i = entries[e].body;
    const auto [x, y, z] = cells[i];
    for (std::size_t f = e + 1; f < entries.size() && entries[f].key <= key_of(x + 1, y, z); ++f) try_pair(i, entries[f].body);
    for (int row = 0; row < 4; ++row) {
      const std::int64_t first = key_of(x - 1, y + rows[row][0], z + rows[row][1]), final = first + 2;
      auto& at = cursor[row];
      while (at < entries.size() && entries[at].key < first) ++at;
      for (std::size_t f = at; f < entries.size() && entries[f].key <= final; ++f) try_pair(i, entries[f].body);
    }
  }
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

}  // namespace

Placed place(const Bodies& bodies, const Frame& frame, std::size_t i) {
  return {bodies.shape[i], bodies.size[i], frame.position[i], frame.orientation[i].toRotationMatrix()};
}

double depth(const Placed& a, const Placed& b) {
  if (a.shape == Shape::plane) return b.shape == Shape::plane ? 0 : plane_depth(a, b);
  if (b.shape == Shape::plane) return plane_depth(b, a);
  if (is_round(a.shape) && is_round(b.shape)) return std::max(0.0, a.size.x() + b.size.x() - (a.position - b.position).norm());
  if (is_round(a.shape)) return round_box_depth(a, b);
  if (is_round(b.shape)) return round_box_depth(b, a);
  return box_box_depth(a, b);
}

FrameErrors measure(const Bodies& bodies, const Frame& frame) {
  FrameErrors result;
  std::vector<Placed> placed, planes;
  std::vector<bool> dynamic;
  std::vector<Vec3> centre;
  std::vector<double> radius;
  double squares = 0, kinetic = 0, height = 0, spread = 0;
  long dynamics = 0;
  for (std::size_t i = 0; i < bodies.count(); ++i)
    if (bodies.shape[i] == Shape::plane) planes.push_back(place(bodies, frame, i));

  const auto add = [&](double d) {
    if (d <= 0) return;
    squares += d * d;
    result.max = std::max(result.max, d);
    ++result.count;
  };
  for (std::size_t i = 0; i < bodies.count(); ++i) {
    if (bodies.shape[i] == Shape::plane) continue;
    const bool moves = bodies.is_dynamic(i);
    if (moves) ++dynamics;
    if (!frame.position[i].allFinite() || !frame.orientation[i].coeffs().allFinite()) {
      if (moves) ++result.lost;
      continue;
    }
    const Placed body = place(bodies, frame, i);
    placed.push_back(body);
    dynamic.push_back(moves);
    centre.push_back(body.position);
    radius.push_back(reach(body.shape, body.size));
    if (!moves) continue;
    const Vec3 spin = body.axes.transpose() * frame.angular_velocity[i];
    kinetic += 0.5 * (bodies.mass[i] * frame.velocity[i].squaredNorm() + spin.dot(bodies.inertia[i].cwiseProduct(spin)));
    height += body.position.z();
    spread += body.position.head<2>().squaredNorm();
    bool behind = false;
    for (const auto& plane : planes) {
      add(plane_depth(plane, body));
      behind = behind || plane.axes.col(2).dot(body.position - plane.position) < 0;
    }
    if (behind) ++result.lost;
  }
  for_each_near_pair(centre, radius, [&](std::size_t i, std::size_t j) {
    if (dynamic[i] || dynamic[j]) add(depth(placed[i], placed[j]));
  });

  result.l2 = std::sqrt(squares);
  if (result.count > 0) result.rms = std::sqrt(squares / static_cast<double>(result.count));
  if (dynamics > 0) {
    result.kinetic = kinetic / static_cast<double>(dynamics);
    result.height = height / static_cast<double>(dynamics);
    result.spread = std::sqrt(spread / static_cast<double>(dynamics));
  }
  return result;
}

RunErrors summarise(const std::vector<FrameErrors>& frames) {
  RunErrors result;
  result.frames = static_cast<long>(frames.size());
  for (const auto& f : frames) {
    result.peak_l2 = std::max(result.peak_l2, f.l2);
    result.peak_max = std::max(result.peak_max, f.max);
  }
  const std::size_t first = frames.size() > 100 ? frames.size() - 100 : 0;
  const auto settled = [&](auto member) {
    std::vector<double> values;
    for (std::size_t i = first; i < frames.size(); ++i) values.push_back(static_cast<double>(frames[i].*member));
    return median(values);
  };
  result.settled.rms = settled(&FrameErrors::rms);
  result.settled.l2 = settled(&FrameErrors::l2);
  result.settled.max = settled(&FrameErrors::max);
  result.settled.count = static_cast<long>(settled(&FrameErrors::count));
  result.settled.kinetic = settled(&FrameErrors::kinetic);
  result.settled.height = settled(&FrameErrors::height);
  result.settled.spread = settled(&FrameErrors::spread);
  if (!frames.empty()) result.settled.lost = frames.back().lost;
  return result;
}

}  // namespace rivals
