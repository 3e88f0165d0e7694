// SurfaceCollider: edges across edges.
#include <algorithm>
#include <cmath>

#include "collide/surface_contacts.hpp"

namespace unibody {

// Whether the two sides of an edge's pair stand out to each other in a direction, from the second to the first.
bool SurfaceCollider::stand_out(const SurfaceEdge& first, const SurfaceEdge& second, const Vec3& towards) const {
  return is_ridge(second, towards) && is_ridge(first, -towards);
}

void SurfaceCollider::edge_edge(std::int32_t first, std::int32_t second) {
  const SurfaceEdge *e = &surfaces_.edges[static_cast<std::size_t>(first)],
                    *f = &surfaces_.edges[static_cast<std::size_t>(second)];
  const auto ids = [&](const SurfaceEdge& edge) {
    return std::pair(world_.id[static_cast<std::size_t>(edge.nodes[0])], world_.id[static_cast<std::size_t>(edge.nodes[1])]);
  };
  if (std::find_first_of(e->nodes.begin(), e->nodes.end(), f->nodes.begin(), f->nodes.end()) != e->nodes.end()) return;
  if (ids(*f) < ids(*e)) std::swap(e, f);
  Pair pair;
  pair.slots = {e->nodes[0], e->nodes[1], f->nodes[0], f->nodes[1]}, pair.edges = true;
  pair.radii = radius(e->nodes[0]) + radius(f->nodes[0]);
  const double travelled = travel(e->nodes, f->nodes);
  if (travelled > pair.radii) {
    const ContinuousHit hit =
        edge_meets_edge(path(e->nodes[0]), path(e->nodes[1]), path(f->nodes[0]), path(f->nodes[1]), continuous(pair.radii));
    pair.watched = !hit.hit;
    if (hit.hit && hit.time > 0) {
      pair.weights = {hit.weights[0], hit.weights[1], -hit.weights[2], -hit.weights[3]};
      const bool inside = hit.weights[0] > 0 && hit.weights[1] > 0 && hit.weights[2] > 0 && hit.weights[3] > 0;
      const bool leaves = may_be_inside(*e, *f) && !stand_out(*e, *f, apart(pair, 0));
      if (inside && !leaves) add_meeting(pair, hit.time);  // ends of edges meet faces
      if (!leaves) return;
    }
  }
  const SegmentPoints near = nearest_of_edges(pair, 0);
  if (!may_be_inside(*e, *f) && travelled > least_approach * pair.radii) time_ = passes_edge(pair, near);
  const bool says = time_ > 0 && stand_across(pair, *e, *f, nearest_of_edges(pair, time_));
  time_ = 0;
  if (!says) stand_across(pair, *e, *f, near);
}

SegmentPoints SurfaceCollider::nearest_of_edges(const Pair& pair, double time) const {
  const auto& [a, b, c, d] = pair.slots;
  return closest_of_segments(place(a, time), place(b, time), place(c, time), place(d, time));
}

double SurfaceCollider::passes_edge(Pair pair, const SegmentPoints& near) const {
  const auto separation_of = [&](const SegmentPoints& nearest) {
    pair.weights = {1 - nearest.s, nearest.s, nearest.t - 1, -nearest.t};
    const Vec3 between = nearest.first - nearest.second;
    return Separation{nearest.distance - pair.radii, -between.dot(parting(pair)) / nearest.distance};
  };
  if (!(near.distance > pair.radii)) return 0;
  const Separation now = separation_of(near);
  if (!(now.gap < settings_.step * now.closing)) return 0;
  pair.within = true;
  if (has_passed(pair, near.first - near.second)) return 0;
  const auto separation_at = [&](double seconds, Separation& separation) {
    const SegmentPoints nearest = nearest_of_edges(pair, seconds / settings_.step);
    separation = separation_of(nearest);
    return nearest.distance > 0;
  };
  const Encounter encounter = encounter_of(settings_.step, 1e-6 * pair.radii, separation_at);
  return encounter.passes() ? encounter.time / settings_.step : 0;
}

// Of a closed surface what is inside is told by its sides.
bool SurfaceCollider::may_be_inside(const SurfaceEdge& first, const SurfaceEdge& second) const {
  return first.surface != second.surface && (surfaces_.is_closed(first.surface) || surfaces_.is_closed(second.surface));
}

bool SurfaceCollider::stand_across(Pair pair, const SurfaceEdge& first, const SurfaceEdge& second, const SegmentPoints& near) {
  if (!(near.s > 0 && near.s < 1 && near.t > 0 && near.t < 1)) return false;  // nodes on faces say it
  pair.weights = {1 - near.s, near.s, near.t - 1, -near.t};
  pair.within = true;
  const Vec3 between = near.first - near.second;
  const Vec3 towards = between / near.distance;
  if (may_be_inside(first, second)) pair.within = false, pair.inside = !stand_out(first, second, towards);
  // it is on the other side that they stand out to each other
  const bool other = pair.inside || (time_ == 0 && has_passed(pair, between));
  if (near.distance > 0 && !stand_out(first, second, other ? Vec3(-towards) : towards)) return false;
  return add_standing(pair);
}

}  // namespace unibody
