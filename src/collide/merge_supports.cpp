#include "collide/merge_supports.hpp"

#include <algorithm>
#include <cmath>

namespace unibody {

namespace {

constexpr int directions = 8;

class Supports {
 public:
  Supports(const std::vector<ContactPoint>& points, const Vec3& normal, const Tilts& tilts)
      : points_(points), tilts_(tilts), turned_(normal.cross(tilts.turn)) {
    s_ = normal.unitOrthogonal(), t_ = normal.cross(s_);
    middle_ = Vec3::Zero();
    for (const ContactPoint& p : points) middle_ += p.position / static_cast<double>(points.size());
    for (const ContactPoint& p : points) reach_ = std::max(reach_, (p.position - middle_).norm());
  }

  std::vector<std::size_t> find() {
    for (const double share : {1.0, 0.5, 0.25})
      if (!turned_.isZero(0)) add(share * turned_);
    const std::size_t certain = chosen_.size();
    const double margin = reach_ > 0 ? tilts_.margin / reach_ : 0;
    double largest = 1;
    while (largest * tilts_.margin < tilts_.travel + turned_.norm() * reach_) largest *= 8;
    for (double tilt = largest; tilt > 0.1; tilt /= 8)
      for (int d = 0; d < directions; ++d) {
        const double angle = 2 * M_PI * d / directions;
        add(margin * Vec3(tilt * (std::cos(angle) * s_ + std::sin(angle) * t_)));
      }
    add(Vec3::Zero());
    while (chosen_.size() > PairManifold::kept) leave_out_one(certain);
    return chosen_;
  }

 private:
  // The lowest when the body is tilted so that its points sink by slope (rad) times their place: of several the furthest out.
  void add(const Vec3& slope) {
    const auto height = [&](std::size_t k) { return points_[k].gap + slope.dot(points_[k].position - middle_); };
    const auto distance2 = [&](std::size_t k) { return (points_[k].position - middle_).squaredNorm(); };
    double lowest = HUGE_VAL;
    for (std::size_t k = 0; k < points_.size(); ++k) lowest = std::min(lowest, height(k));
    const auto is_low = [&](std::size_t k) { return height(k) <= lowest + 1e-3 * tilts_.margin; };
    if (std::any_of(chosen_.begin(), chosen_.end(), is_low)) return;
    std::size_t best = points_.size();
    for (std::size_t k = 0; k < points_.size(); ++k)
      if (is_low(k) && (best == points_.size() || distance2(k) > (1 + alike_distances) * distance2(best))) best = k;
    chosen_.push_back(best);
  }

  // Of the two points that are nearest to each other, the shallower; the first so many stay, since the body is on its way to
  // them.
  void leave_out_one(std::size_t certain) {
    double nearest = HUGE_VAL;
    std::size_t out = chosen_.size() - 1;
    for (std::size_t i = 0; i < chosen_.size(); ++i)
      for (std::size_t j = std::max(i + 1, certain); j < chosen_.size(); ++j) {
        const ContactPoint &p = points_[chosen_[i]], &q = points_[chosen_[j]];
        const double distance2 = (p.position - q.position).squaredNorm();
        if (distance2 >= (1 - alike_distances) * nearest) continue;
        nearest = distance2, out = i < certain || q.gap >= p.gap ? j : i;
      }
    chosen_.erase(chosen_.begin() + static_cast<std::ptrdiff_t>(out));
  }

  const std::vector<ContactPoint>& points_;
  const Tilts& tilts_;
  Vec3 turned_;  // rad: the slope of what the step's turn lets the points sink by
  double reach_ = 0;
  Vec3 s_, t_, middle_;
  std::vector<std::size_t> chosen_;
};

}  // namespace

bool share_normal(const PairManifold& a, const PairManifold& b) {
  if (a.is_inner_ring || b.is_inner_ring) return false;
  return a.time == 0 && b.time == 0 && a.normal.dot(b.normal) > same_normal;
}

PairManifold support_of(const std::vector<ContactPoint>& points, const Vec3& normal, const Tilts& tilts) {
  PairManifold result;
  result.normal = normal;
  std::vector<std::size_t> chosen = Supports(points, normal, tilts).find();
  std::sort(chosen.begin(), chosen.end());
  for (const std::size_t k : chosen) result.add(points[k].position, points[k].gap, static_cast<std::uint32_t>(k));
  tidy(result, HUGE_VAL);
  return result;
}

void merge_supports(std::vector<PairManifold>& manifolds, const Tilts& tilts) {
  std::vector<ContactPoint> points;
  for (std::size_t i = 0; i < manifolds.size(); ++i) {
    PairManifold& first = manifolds[i];
    const auto joins = [&](const PairManifold& m) { return share_normal(first, m); };
    const auto rest = manifolds.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    if (std::none_of(rest, manifolds.end(), joins)) continue;
    points.assign(first.points, first.points + first.count);
    for (auto m = rest; m != manifolds.end(); ++m)
      if (joins(*m)) points.insert(points.end(), m->points, m->points + m->count);
    const Vec3 normal = first.normal;
    manifolds.erase(std::remove_if(rest, manifolds.end(), joins), manifolds.end());
    manifolds[i] = support_of(points, normal, tilts);
  }
}

}  // namespace unibody
