// A body that lies on one face of a fixed or moving ground comes to another face within a step: in a bowl, or a half pipe. This
// corrects its predicted velocity for the time in which it still lies on the first.
//
// The rows of a step act as if their contacts lasted for all of it. So a face to which a body comes would bear its weight from
// the start of the step, on a slope that the body has not reached. At an edge of angle a it would brake the body by g h sin a on
// average, and a ball in a smooth bowl by g h a radian, however fine the faces are.
//
// The velocity that a step ends with is that of its middle. A face that a body reaches after the share f of a step therefore
// bears no weight for the time of f + 1/2 steps, in which the faces on which the body lies bear it. The predicted velocity gets
// the difference of the two: what those faces give to the weight, less what the new one will give, along the new one.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

// Of round home bodies that move freely, touch nothing else that moves, and go on along the face that they reach. What is added
// is told as StepRows::crossings, so that the forces of contacts remain those that change the bodies' momenta: of the manifold
// that bore the body. Where there are some on any rank, guests have to be renewed. After impacts.
void correct_crossings(RankState& state, System& system);

}  // namespace unibody
