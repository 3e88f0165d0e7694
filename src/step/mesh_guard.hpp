// The last resort against passing through a mesh shape.
//
// The contacts of a step are found along the way that a body goes if nothing turns it. A fast body that is turned aside or set
// spinning within the step may come to a triangle that has no contact with it, and nothing would tell afterwards on which side it
// was. So the way that each fast body's centre has gone, as the mesh sees it, is tried against the triangles. The centre of a body
// that has passed through one is put back in front of it, and its velocity is changed by as much as if the step had taken it
// there; what it does along the triangle is kept. Meshes are fixed or driven, so that no other body feels it.
#pragma once

#include <cstdint>
#include <vector>

#include "step/rank_state.hpp"

namespace unibody {

class MeshGuard {
 public:
  // Before bodies move.
  explicit MeshGuard(const RankState& state);

  // After that. Changes home bodies; returns how many of them, over all ranks. Collective where there is a mesh.
  std::int64_t hold(RankState& state) const;

 private:
  // A mesh before the step.
  struct Mesh {
    std::size_t slot;
    Vec3 centre;  // m
    Mat3 turn;    // from its axes to the world's
  };
  // The centre of a convex body, or of a part of a compound: of each it is the side that says where a mesh holds it.
  struct Centre {
    Vec3 from, to;     // m
    double half_size;  // m
  };
  std::vector<Centre> centres_of(const World& world, std::size_t body) const;
  Vec3 change_before(const Mesh& mesh, const World& world, std::size_t body, const std::vector<Centre>& centres) const;

  std::vector<Mesh> meshes_;
  std::vector<Vec3> places_;  // m, of home bodies before the step; empty where there is no mesh
  std::vector<Quat> turns_;   // the same where one of them is a compound
};

}  // namespace unibody
