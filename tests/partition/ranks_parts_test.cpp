// The parts of the distribution, one by one: guests, the message of an iteration, colours, migration, the partition.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <tuple>

#include "partition/balance.hpp"
#include "partition/migrate.hpp"
#include "partition/partition.hpp"
#include "partition/ranks.hpp"
#include "small_worlds.hpp"
#include "solve/colouring.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::ranks_parts_test {

namespace {

// With no constraints but the contacts.
void start_step(Exchange& exchange, const World& world, const Contacts& contacts) {
  exchange.start_step(world, contacts);
  exchange.share(world, [&](const auto& f) {
    for (const Manifold& m : contacts.manifolds) f(0, std::span<const Slot>(std::array{m.slot_a, m.slot_b}));
  });
  exchange.finish_step();
}

const std::string crowd = R"(
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
  - pile:
      count: 120
      columns: [5, 5]
      mix:
        - {shape: {sphere: {radius: 0.1}}, scale: [0.5, 1]}
        - {shape: {box: {size: [0.2, 0.15, 0.1]}}, scale: [0.5, 2]}
    density: 1000
    velocity: [0.5, 0, -4]
  - shape: {box: {size: [3, 0.1, 0.1]}}
    mass: 5
    position: [0, 0, 0.8]
    velocity: [0, 0, -2]
solver: {iterations: 6}
)";

// Every body of the run, on every rank, by id.
std::map<Id, Body> everyone(const World& world) {
  std::vector<Body> mine, all;
  for (std::size_t i = 0; i < world.homes; ++i) mine.push_back(world.body(i));
  std::vector<int> counts(static_cast<std::size_t>(rank_count())), at(counts.size() + 1, 0);
  const int bytes = static_cast<int>(mine.size() * sizeof(Body));
  MPI_Allgather(&bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, MPI_COMM_WORLD);
  for (std::size_t r = 0; r < counts.size(); ++r) at[r + 1] = at[r] + counts[r];
  all.resize(static_cast<std::size_t>(at.back()) / sizeof(Body));
  MPI_Allgatherv(mine.data(), bytes, MPI_BYTE, all.data(), counts.data(), at.data(), MPI_BYTE, MPI_COMM_WORLD);
  std::map<Id, Body> by_id;
  for (const Body& b : all) EXPECT_TRUE(by_id.emplace(b.id, b).second) << "body " << b.id << " has two homes";
  return by_id;
}

bool same_state(const BodyState& a, const BodyState& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs() && a.velocity == b.velocity &&
         a.angular_velocity == b.angular_velocity;
}

CollideSettings settings_of(const Scene& scene) {
  CollideSettings s;
  s.step = scene.time.frame, s.gravity = scene.gravity;
  s.friction = scene.friction, s.material_count = scene.materials.size();
  return s;
}

std::unique_ptr<Experiment> scattered(const std::string& text, std::uint64_t seed) {
  auto run = std::make_unique<Experiment>(scene_from_text(text), MPI_COMM_WORLD);
  run->simulation->move_homes(Balance(MPI_COMM_WORLD, seed, false).homes(parts_of(*run->simulation)));
  return run;
}

}  // namespace

TEST(RanksHalo, GuestsHaveTheBitsOfTheirHomesAndNoneIsMissing) {
  const auto run = scattered(crowd, 3);
  const CollideSettings settings = settings_of(*run->scene);
  for (int k = 0; k < 25; ++k) {
    run->simulation->detect();
    const auto all = everyone(run->world());
    ASSERT_EQ(all.size(), 121u);
    const World& w = run->world();
    World whole;  // of all bodies, to ask for their bounds
    whole.homes = all.size();
    whole.resize(all.size());
    std::size_t at = 0;
    for (const auto& [id, body] : all) whole.set(at++, body);
    std::set<Id> here;
    for (std::size_t i = 0; i < w.first_static(); ++i) {
      here.insert(w.id[i]);
      ASSERT_TRUE(same_state(w.state(i), all.at(w.id[i]).state)) << "body " << w.id[i] << ", step " << k;
      if (i > 0 && i != w.homes) {
        ASSERT_LT(w.id[i - 1], w.id[i]);
      }
    }
    for (std::size_t i = 0; i < w.homes; ++i) {
      const Bounds mine = swept_bounds(w, i, settings);
      for (std::size_t j = 0; j < whole.size(); ++j) {
        const Bounds other = swept_bounds(whole, j, settings);
        const bool meet = (mine.lower.array() <= other.upper.array()).all() && (other.lower.array() <= mine.upper.array()).all();
        if (meet) {
          ASSERT_TRUE(here.contains(whole.id[j])) << "body " << whole.id[j] << " may touch " << w.id[i] << ", step " << k;
        }
      }
    }
    run->step();
  }
}

// Each home writes a pattern of its id; after the exchange every guest of a shared contact has it, and nothing else has changed.
void expect_guests_told(std::size_t longest_letter) {
  const auto run = scattered(crowd, 4);
  run->steps(15);
  run->simulation->detect();
  const World& w = run->world();
  const Contacts& contacts = run->simulation->contacts;
  PhaseClock clock;
  Exchange exchange(run->simulation->halo, clock, longest_letter);
  start_step(exchange, w, contacts);
  std::set<std::size_t> shared;
  for (const Manifold& m : contacts.manifolds)
    for (const Slot s : {m.slot_a, m.slot_b})
      if (!w.is_home(s) && !w.is_static(s)) shared.insert(static_cast<std::size_t>(s));
  if (rank_count() > 1) {
    EXPECT_FALSE(exchange.neighbours().empty());
  }
  std::vector<SolverBody> bodies(w.size() + 1, SolverBody{});
  std::vector<std::int32_t> values(w.size() + 1, -7);
  const auto pattern = [&](std::size_t i, int d, int round) { return static_cast<double>(w.id[i]) + 0.1 * d + round; };
  for (int round = 0; round < 5; ++round) {
    for (std::size_t i = 0; i < w.homes; ++i) {
      for (int d = 0; d < 3; ++d) bodies[i].v[d] = pattern(i, d, round), bodies[i].w[d] = -bodies[i].v[d];
      values[i] = static_cast<std::int32_t>(w.id[i]) + round;
    }
    exchange.refresh(bodies);
    exchange.refresh(std::span(values));
    for (std::size_t i = w.homes; i < w.size(); ++i) {
      const bool is_shared = shared.contains(i);
      EXPECT_EQ(values[i], is_shared ? static_cast<std::int32_t>(w.id[i]) + round : -7);
      for (int d = 0; d < 3; ++d) {
        const double expected = is_shared ? pattern(i, d, round) : 0;
        EXPECT_EQ(bodies[i].v[d], expected);
        EXPECT_EQ(bodies[i].w[d], -expected);
      }
    }
  }
}

TEST(RanksExchange, ExchangeBringsEveryGuestItsHomesValues) { expect_guests_told(Exchange::usual_letter); }
TEST(RanksExchange, ExchangeByMessagesDoesTheSame) { expect_guests_told(0); }
TEST(RanksExchange, LongOnesByMessagesAndShortOnesByMailDoTheSame) { expect_guests_told(512); }

TEST(RanksColouring, IsValidAndThatOfOneRank) {
  const auto run = scattered(crowd, 5);
  Experiment single(scene_from_text(crowd));
  run->steps(15), single.steps(15);
  run->simulation->detect(), single.simulation->detect();
  const auto colours = [](Simulation& s) {
    PhaseClock clock;
    Exchange exchange(s.halo, clock);
    start_step(exchange, s.world, s.contacts);
    const Colouring found = colour_manifolds(s.world, s.contacts, exchange);
    std::map<std::tuple<Id, Id, int>, std::int32_t>
        by_key;  // the third: which of the pair's manifolds; a fast body's core has its own
    for (std::size_t m = 0; m < s.contacts.manifolds.size(); ++m) {
      const Manifold& manifold = s.contacts.manifolds[m];
      int which = 0;
      while (by_key.contains({manifold.id_a, manifold.id_b, which})) ++which;
      by_key[{manifold.id_a, manifold.id_b, which}] = found.colour[m];
    }
    return by_key;
  };
  const auto mine = colours(*run->simulation), reference = colours(*single.simulation);
  ASSERT_GT(reference.size(), 90u);
  for (const auto& [key, colour] : mine) {
    ASSERT_TRUE(reference.contains(key));
    EXPECT_EQ(colour, reference.at(key)) << std::get<0>(key) << ", " << std::get<1>(key);
  }
  // Every contact is on some rank.
  std::vector<std::int64_t> owned(1, 0);
  const World& w = run->world();
  for (const Manifold& m : run->simulation->contacts.manifolds)
    owned[0] += w.is_home(w.is_static(m.slot_a) ? m.slot_b : m.slot_a);
  MPI_Allreduce(MPI_IN_PLACE, owned.data(), 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_EQ(owned[0], static_cast<std::int64_t>(reference.size()));
  std::set<std::pair<Id, std::int32_t>> taken;
  for (const auto& [key, colour] : reference)
    for (const Id id : {std::get<0>(key), std::get<1>(key)}) {
      EXPECT_GE(colour, 0);
      if (id != 0) {
        EXPECT_TRUE(taken.emplace(id, colour).second) << "body " << id << " has two contacts of colour " << colour;
      }
    }
}

TEST(RanksMigration, KeepsEveryBodyAndItsMultipliersOnce) {
  const auto run = scattered(crowd, 6);
  run->steps(20);
  Simulation& s = *run->simulation;
  const auto before = everyone(s.world);
  // All multipliers by key, from the ranks that hold them.
  const auto forces = [](const Multipliers& m) {
    std::map<std::pair<Id, Id>, std::vector<double>> list;
    for (std::size_t k = 0; k < m.manifolds.size(); ++k)
      for (const RememberedPoint& p : m.points_of(k)) list[{m.manifolds[k].id_a, m.manifolds[k].id_b}].push_back(p.normal);
    return list;
  };
  Experiment single(scene_from_text(crowd));
  single.steps(20);
  const auto reference = forces(single.simulation->history.contacts());
  ASSERT_GT(reference.size(), 50u);
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    s.move_homes(Balance(MPI_COMM_WORLD, seed, false).homes(parts_of(s)));
    EXPECT_TRUE(std::is_sorted(s.world.id.begin(), s.world.id.begin() + static_cast<std::ptrdiff_t>(s.world.homes)));
    for (std::size_t i = 0; i < s.world.homes; ++i) EXPECT_EQ(random_home(s.world.id[i], seed, rank_count()), rank_here());
    const auto after = everyone(s.world);
    ASSERT_EQ(after.size(), before.size());
    for (const auto& [id, body] : before) {
      EXPECT_TRUE(same_state(after.at(id).state, body.state));
      EXPECT_EQ(std::memcmp(&after.at(id).properties.mass, &body.properties.mass, sizeof(double)), 0);
    }
    const auto mine = forces(s.history.contacts());
    std::set<Id> homes(s.world.id.begin(), s.world.id.begin() + static_cast<std::ptrdiff_t>(s.world.homes));
    for (const auto& [key, list] : reference) {
      const bool wanted = homes.contains(key.first) || homes.contains(key.second);
      ASSERT_EQ(mine.contains(key), wanted) << key.first << ", " << key.second;
      if (wanted) {
        EXPECT_EQ(mine.at(key), list);
      }
    }
  }
}

TEST(RanksPartition, BalancesALattice) {
  const auto run = std::make_unique<Experiment>(
      scene_from_text("bodies:\n  - lattice: {count: 4096, columns: [16, 16], spacing: [0.2, 0.2, 0.2]}\n"
                      "    shape: {sphere: {radius: 0.1}}\n    mass: 1\n"),
      MPI_COMM_WORLD);
  Simulation& s = *run->simulation;
  Balance balance(MPI_COMM_WORLD, std::nullopt, true);
  s.move_homes(balance.homes(parts_of(s)));
  s.detect();
  EXPECT_LT(balance.imbalance(parts_of(s)), 1.3);
  EXPECT_GE(balance.imbalance(parts_of(s)), 1.0);
  std::int64_t most = static_cast<std::int64_t>(s.world.homes), all = most;
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT64_T, MPI_MAX, MPI_COMM_WORLD);
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_EQ(all, 4096);
  EXPECT_LT(static_cast<double>(most) * rank_count() / 4096, 1.3);
  // Cut into blocks rather than thrown about: fewer guests than homes.
  EXPECT_LT(s.world.guests, rank_count() == 1 ? 1 : s.world.homes);
}

// Fewer bodies than ranks, all bodies in one place, no body at all, and all work on one rank.
TEST(RanksPartition, EmptyRanksAreLegal) {
  const std::string ball = "    shape: {sphere: {radius: 0.1}}\n    mass: 1\n",
                    floor = "bodies:\n  - shape: {plane: {normal: [0, 0, 1]}}\n";
  const std::string scenes[] = {floor, floor + "  - points: [[0, 0, 0.3]]\n" + ball,
                                floor + "  - points: [[0, 0, 0.3], [0.01, 0, 0.49], [0.01, 0.01, 0.7]]\n" + ball};
  const std::int64_t counts[] = {0, 1, 3};
  for (int k = 0; k < 3; ++k) {
    Experiment run(scene_from_text(scenes[k]), MPI_COMM_WORLD), single(scene_from_text(scenes[k]));
    Simulation& s = *run.simulation;
    const Balance balance(MPI_COMM_WORLD, std::nullopt, true);
    s.move_homes(balance.homes(parts_of(s)));
    single.steps(30);
    for (int i = 0; i < 30; ++i) {
      run.step();
      if (i == 10) s.move_homes(std::vector<int>(s.world.homes, rank_count() - 1));
      if (i == 20) s.detect(), s.move_homes(balance.homes(parts_of(s)));
    }
    const auto all = everyone(s.world);
    ASSERT_EQ(static_cast<std::int64_t>(all.size()), counts[k]);
    for (const auto& [id, body] : all) EXPECT_TRUE(same_state(body.state, single.state(id)));
  }
}

TEST(RanksPartition, RandomHomesAreEvenAndDependOnTheSeed) {
  const int ranks = 8;
  int count[ranks] = {}, moved = 0;
  for (Id id = 0; id < 8000; ++id) {
    ++count[random_home(id, 1, ranks)];
    moved += random_home(id, 1, ranks) != random_home(id, 2, ranks);
  }
  for (const int c : count) EXPECT_NEAR(c, 1000, 150);  // 5 standard deviations of a binomial
  EXPECT_NEAR(moved, 7000, 150);
}

}  // namespace unibody::small_worlds::ranks_parts_test
