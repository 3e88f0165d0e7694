// The functions of the table in narrowphase.cpp. Normal and points as PairManifold says, "first" being the first argument;
// gaps above the margin may be left in, the caller drops them.
#pragma once

#include "collide/narrowphase.hpp"

namespace unibody {

void round_round(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out);  // sphere or disc
void round_box(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out);
void round_plane(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out);
void box_plane(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out);
void box_box(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out);
void box_box_planar(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out);
void convex_convex(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out);
void convex_plane(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out);

}  // namespace unibody
