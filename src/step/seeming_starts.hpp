// Where bodies that are hit within a step seem to have started it.
//
// The solve and the update of positions know one velocity a body and step. A body that is hit at a time t of the step goes on as
// if it had started the step elsewhere: so that with its new velocity it is at t where it was hit, in the attitude in which it
// was hit. Its place is corrected by -t times its change of velocity. Its attitude becomes the one from which its new momentum
// would have turned it to where it was hit: between impacts a body turns freely, with the energy and the angular momentum that
// the last one has left it.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

class SeemingStarts {
 public:
  // Nothing is hit yet: fills what state.impacts has by slot with zeros. `system` as predicted. Collective.
  SeemingStarts(RankState& state, System& system);

  bool moves(Slot s) const { return system_.bodies[static_cast<std::size_t>(s)].inverse_mass > 0; }
  bool is_round_body(Slot s) const { return is_round(world_.properties[static_cast<std::size_t>(s)].shape); }

  Vec3 velocity(Slot s) const { return Eigen::Map<const Vec3>(system_.bodies[static_cast<std::size_t>(s)].v); }  // m/s, mean
  Vec3 acceleration(Slot s) const;                                                                               // m/s^2
  Vec3 place(Slot s, double t) const;            // m, at a time of the step
  Vec3 spin(Slot s, double t) const;             // rad/s, to which energy and momentum belong
  Mat3 turn(Slot s, double t) const;             // from the attitude at the step's start; of round bodies the identity
  Mat3 inverse_inertia(Slot s, double t) const;  // 1/(kg m^2), world frame

  // An impulse (N s) and an angular impulse (N m s) on a body that moves, at a time (s).
  void push(Slot s, const Vec3& impulse, const Vec3& angular, double time);

  // Guests take what their homes have. Adds to `changed` those for which it is new. Collective.
  void tell_guests(std::vector<Slot>& changed);

 private:
  Quat attitude(std::size_t i, double t) const;
  Quat seeming_attitude(std::size_t i) const;
  void settle(std::size_t i);

  RankState& state_;
  World& world_;
  System& system_;
  double step_;
  std::vector<Vec3> start_velocity_;  // m/s, predicted
  bool any_uneven_;                   // on any rank: bodies whose moments of inertia differ
  std::vector<Vec3> momentum_;        // kg m^2/s, of these
  std::vector<Vec3> torque_gain_;     // rad/s, of the predicted spin: what torques in the step add
};

}  // namespace unibody
