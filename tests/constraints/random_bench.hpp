// A small random contact problem: spheres and boxes of all masses and attitudes, contacts of 1 to 4 points where chance puts
// them.
#pragma once

#include <memory>

#include "collide/bodies.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds {

inline std::unique_ptr<Bench> random_bench(std::uint64_t seed, FrictionModel model, int bodies = 9, int manifolds = 14) {
  unibody::samples::Random random(seed);
  auto bench = std::make_unique<Bench>();
  bench->settings.friction = model;
  bench->gravity = Vec3(0, 0, -9.81);
  bench->world.homes = static_cast<std::size_t>(bodies);
  bench->world.resize(static_cast<std::size_t>(bodies) + 1);
  for (int k = 0; k < bodies; ++k) {
    const double mass = std::pow(10, random(-1, 1));
    Body b = k % 3 == 0 ? ball(mass, random(0.1, 0.3), random.vector(-1, 1))
                        : block(mass, Vec3(random(.1, .5), random(.1, .5), random(.1, .5)), random.vector(-1, 1), random.turn());
    b.id = k;
    b.state.velocity = random.vector(-1, 1);
    if (k % 3 == 0) b.state.angular_velocity = random.vector(-2, 2);
    bench->world.set(static_cast<std::size_t>(k), b);
  }
  Body floor = ground();
  floor.id = bodies;
  bench->world.set(static_cast<std::size_t>(bodies), floor);

  for (Slot i = 0; i < bodies; ++i)
    for (Slot j = i + 1; j <= bodies; ++j) {
      if (random(0, 1) > 2.0 * manifolds / (bodies * (bodies + 1))) continue;
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const Vec3 n = random.vector(-1, 1).normalized();
      const auto count = static_cast<std::uint32_t>(random(1, 5));
      const double mu = random(0, 1) < 0.2 ? 0 : random(0.1, 1);
      bench->contacts.manifolds.push_back({i, j, i, j, n, mu, static_cast<std::uint32_t>(bench->contacts.points.size()), count});
      for (std::uint32_t p = 0; p < count; ++p)
        bench->contacts.points.push_back(
            {0.5 * (bench->world.position[a] + bench->world.position[b]) + random.vector(-.2, .2), random(-.01, .02), p});
    }
  return bench;
}

}  // namespace unibody::small_worlds
