// A chain solved directly: what Newton's method with the block-tridiagonal Schur complement of its ball joints costs, and gains.
//   direct_chain LINKS BALL    BALL: mass of the last body, in links
// One step of 16 ms of a chain of links of 0.1 kg and 0.1 m that lies at 30 degrees and starts to swing, as scenes/
// chain_heavy_ball.yaml. Prints ms of one Newton iteration (assembly, factorisation, solution), the number of iterations until
// the joints are closed to 1e-12 m, and what the largest is open by then (m).
#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;

constexpr double h = 0.016, half = 0.05;

struct Body {
  Vec3 x, v = Vec3::Zero(), w = Vec3::Zero();
  Quat q;
  double inverse_mass;
  Mat3 inverse_inertia;  // of the step's start
  Vec3 end_x(double side) const { return q * Vec3(side * half, 0, 0); }
};

Mat3 cross(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

// Where the bodies are after the step; centres, and arms to their two ends.
struct Pose {
  Vec3 x, start, end;
};
Pose after(const Body& b) {
  const Vec3 turn = 0.5 * h * b.w;
  const Quat q = (Quat(1, turn.x(), turn.y(), turn.z()) * b.q).normalized();
  return {b.x + h * b.v, q * Vec3(-half, 0, 0), q * Vec3(half, 0, 0)};
}

// One Newton iteration on the velocities; returns how far the joints were open before it (m).
double newton(std::vector<Body>& bodies) {
  const std::size_t n = bodies.size();
  std::vector<Pose> pose(n);
  for (std::size_t i = 0; i < n; ++i) pose[i] = after(bodies[i]);
  std::vector<Mat3> diagonal(n), below(n);  // joint i: from body i - 1 (or the world) to body i
  std::vector<Vec3> right(n);
  double open = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Mat3 r = cross(pose[i].start);
    diagonal[i] = bodies[i].inverse_mass * Mat3::Identity() - r * bodies[i].inverse_inertia * r;
    Vec3 c = pose[i].x + pose[i].start;
    if (i > 0) {
      const Body& before = bodies[i - 1];
      const Mat3 s = cross(pose[i - 1].end), t = cross(pose[i - 1].start);
      diagonal[i] += before.inverse_mass * Mat3::Identity() - s * before.inverse_inertia * s;
      below[i] = -(before.inverse_mass * Mat3::Identity() - s * before.inverse_inertia * t);
      c -= pose[i - 1].x + pose[i - 1].end;
    }
    open = std::max(open, c.norm());
    right[i] = -c / h;
  }
  for (std::size_t i = 1; i < n; ++i) {
    const Mat3 l = below[i] * diagonal[i - 1].inverse();
    diagonal[i] -= l * below[i].transpose(), right[i] -= l * right[i - 1];
  }
  for (std::size_t i = n; i-- > 0;) {
    if (i + 1 < n) right[i] -= below[i + 1].transpose() * right[i + 1];
    right[i] = diagonal[i].inverse() * right[i];
  }
  for (std::size_t i = 0; i < n; ++i) {
    Body& b = bodies[i];
    b.v += b.inverse_mass * right[i], b.w += b.inverse_inertia * pose[i].start.cross(right[i]);
    if (i + 1 == n) continue;
    b.v -= b.inverse_mass * right[i + 1], b.w -= b.inverse_inertia * pose[i].end.cross(right[i + 1]);
  }
  return open;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: direct_chain LINKS BALL\n"), 2;
  const auto n = static_cast<std::size_t>(std::atol(argv[1]));
  const double ball = std::atof(argv[2]);
  const Quat turn = Quat::FromTwoVectors(Vec3::UnitX(), Vec3(0.5, 0, -std::sqrt(0.75)));
  std::vector<Body> bodies(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double mass = i + 1 == n ? 0.1 * ball : 0.1;
    const Vec3 moments = mass / 12 * Vec3(2 * .03 * .03, .09 * .09 + .03 * .03, .09 * .09 + .03 * .03);
    bodies[i].q = turn, bodies[i].x = turn * Vec3((2 * static_cast<double>(i) + 1) * half, 0, 0);
    bodies[i].inverse_mass = 1 / mass;
    bodies[i].inverse_inertia =
        turn.toRotationMatrix() * moments.cwiseInverse().asDiagonal() * turn.toRotationMatrix().transpose();
    bodies[i].v = Vec3(0, 0, -9.81 * h);
  }
  const auto before = std::chrono::steady_clock::now();
  int iterations = 0;
  double open = 1;
  while (open > 1e-12 && iterations < 20) open = newton(bodies), ++iterations;
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - before;
  std::printf("%.4g %d %.2g\n", spent.count() / iterations, iterations, open);
}
