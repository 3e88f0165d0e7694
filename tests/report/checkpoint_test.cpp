#include "checkpoint/checkpoint.hpp"

#include "core/errors.hpp"
#include "partition/by_id.hpp"
#include "report/state_hash.hpp"
#include "report_worlds.hpp"

namespace unibody::checkpoint_test {
namespace {

History history_of(Multipliers multipliers) {
  History history;
  history.contacts() = std::move(multipliers);
  return history;
}

using namespace testing_worlds;

constexpr Id bodies = 60;
const std::string mark = fingerprint("scene");

RememberedPoint point(Id a, Id b, std::uint32_t k) {
  const auto x = static_cast<double>(a * 1000 + b * 10 + k);
  return {std::sqrt(x), Vec3(std::sin(x), 0, 1e-300 * x)};
}
Vec3 place(Id a, Id b, std::uint32_t k) {
  const auto x = static_cast<double>(a * 1000 + b * 10 + k);
  return {x, 1 / (x + 1), -x};
}

// Pairs (k, k + 1) and (k, k + 5) and each body with body 0, the ground; 1 to 4 points each, with places if there are more than
// one. Of all pairs with a home body here.
Multipliers multipliers(const World& w) {
  const auto home = [&](Id id) {
    return std::binary_search(w.id.begin(), w.id.begin() + static_cast<std::ptrdiff_t>(w.homes), id);
  };
  Multipliers m;
  for (Id a = 0; a < bodies; ++a)
    for (Id b = a + 1; b < bodies; ++b) {
      if ((a != 0 && b != a + 1 && b != a + 5) || (!home(a) && !home(b))) continue;
      const auto count = static_cast<std::uint32_t>(1 + (a + b) % 4);
      m.begin_manifold(a, b);
      for (std::uint32_t k = 0; k < count; ++k) {
        m.points.push_back(point(a, b, k));
        if (count > 1) m.places.push_back(place(a, b, k));
      }
    }
  return m;
}

void expect_equal(const Multipliers& a, const Multipliers& b) {
  ASSERT_EQ(a.manifolds.size(), b.manifolds.size());
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t k = 0; k < a.manifolds.size(); ++k) {
    const auto &x = a.manifolds[k], &y = b.manifolds[k];
    ASSERT_TRUE(x.id_a == y.id_a && x.id_b == y.id_b && x.first_point == y.first_point && x.first_place == y.first_place);
  }
  for (std::size_t k = 0; k < a.points.size(); ++k) {
    const auto &x = a.points[k], &y = b.points[k];
    ASSERT_TRUE(x.normal == y.normal && x.tangential == y.tangential);
  }
  ASSERT_TRUE(a.places == b.places);
}

void expect_equal(const Body& a, const Body& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.state.position, b.state.position);
  EXPECT_EQ(a.state.orientation.coeffs(), b.state.orientation.coeffs());
  EXPECT_EQ(a.state.velocity, b.state.velocity);
  EXPECT_EQ(a.state.angular_velocity, b.state.angular_velocity);
  EXPECT_EQ(a.properties.shape.kind, b.properties.shape.kind);
  EXPECT_EQ(a.properties.shape.size, b.properties.shape.size);
  EXPECT_EQ(a.properties.motion, b.properties.motion);
  EXPECT_EQ(a.properties.material, b.properties.material);
  EXPECT_EQ(a.properties.mass, b.properties.mass);
  EXPECT_EQ(a.properties.inertia, b.properties.inertia);
  EXPECT_EQ(a.properties.force, b.properties.force);
  EXPECT_EQ(a.properties.torque, b.properties.torque);
}

void write(MPI_Comm comm, const World& w, const std::string& path, std::int64_t frame = 17) {
  write_checkpoint(comm, path, mark, frame, 0.1 * static_cast<double>(frame), bodies, {w}, history_of(multipliers(w)));
}

TEST(RanksCheckpoint, RoundTripAcrossPartitions) {
  const Folder folder;
  const MPI_Comm comm = MPI_COMM_WORLD;
  std::string expected;
  for (std::size_t written = 0; written < 3; ++written) {
    const std::string path = folder / ("c" + std::to_string(written));
    const World from = world(comm, bodies, partitions(size_of(comm))[written]);
    write(comm, from, path);
    if (written == 0) expected = contents(path);
    EXPECT_TRUE(contents(path) == expected) << "the bytes depend on the partition";
    for (const auto& home : partitions(size_of(comm))) {
      const Checkpoint checkpoint(comm, path, mark);
      EXPECT_EQ(checkpoint.frame(), 17);
      EXPECT_EQ(checkpoint.time(), 0.1 * 17);
      ASSERT_EQ(checkpoint.body_count(), bodies);
      const Id first = std::min<Id>(bodies, 10 * rank_of(comm));
      const auto read = checkpoint.read_bodies(first, bodies);
      ASSERT_EQ(static_cast<Id>(read.size()), bodies - first);
      for (const Body& b : read) expect_equal(b, body(b.id));
      const World to = world(comm, bodies, home);
      expect_equal(checkpoint.read_multipliers(to), multipliers(to));
    }
  }
}

TEST(RanksCheckpoint, SameBytesAndReadableOnOneRank) {
  const Folder folder;
  write(MPI_COMM_WORLD, world(MPI_COMM_WORLD, bodies, partitions(size_of(MPI_COMM_WORLD))[0]), folder / "many");
  if (rank_of(MPI_COMM_WORLD) != 0) return;
  const World one = world(MPI_COMM_SELF, bodies, [](Id) { return 0; });
  write(MPI_COMM_SELF, one, folder / "one");
  EXPECT_TRUE(contents(folder / "one") == contents(folder / "many"));
  const Checkpoint checkpoint(MPI_COMM_SELF, folder / "many", mark);
  expect_equal(checkpoint.read_multipliers(one), multipliers(one));
}

TEST(RanksCheckpoint, NoContactsAndFewBodies) {
  const Folder folder;
  const MPI_Comm comm = MPI_COMM_WORLD;
  const World w = world(comm, 2, [](Id) { return 0; });
  write_checkpoint(comm, folder / "c", mark, 0, 0, 2, {w}, {});
  const Checkpoint checkpoint(comm, folder / "c", mark);
  EXPECT_EQ(checkpoint.read_bodies(0, 2).size(), 2u);
  EXPECT_TRUE(checkpoint.read_multipliers(w).manifolds.empty());
  EXPECT_THROW(checkpoint.read_bodies(1, 3), InputError);
}

// Opening must fail on every rank with an InputError that contains `part`.
void expect_refused(const std::string& path, const std::string& part) {
  MPI_Barrier(MPI_COMM_WORLD);
  try {
    const Checkpoint checkpoint(MPI_COMM_WORLD, path, mark);
    ADD_FAILURE() << path << " was read";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
  }
}

TEST(RanksCheckpoint, RefusesWhatItCannotContinue) {
  const Folder folder;
  const MPI_Comm comm = MPI_COMM_WORLD;
  const World w = world(comm, bodies, [](Id) { return 0; });
  write(comm, w, folder / "good");
  write_checkpoint(comm, folder / "other", fingerprint("scene "), 1, 0, bodies, {w}, {});
  if (rank_of(comm) == 0) {
    const std::string bytes = contents(folder / "good");
    put(folder / "half", bytes.substr(0, bytes.size() / 2));
    put(folder / "short", bytes.substr(0, bytes.size() - 1));
    put(folder / "empty", "");
    put(folder / "text", "bodies: []\n");
    const h5::Handle foreign = h5::create_file(MPI_COMM_SELF, folder / "foreign");
    const h5::Handle group = h5::create_group(foreign, "frames");
  }
  expect_refused(folder / "none", "there is no checkpoint");
  expect_refused(folder.path(), "there is no checkpoint");
  expect_refused(folder / "other", "another scene");
  for (const char* name : {"half", "short", "empty", "text", "foreign"})
    expect_refused(folder / name, "damaged or no checkpoint");
  MPI_Barrier(comm);
}

// Wherever one bit changes: either the file is refused, or it is where nothing is stored and all is read as it was written.
TEST(RanksCheckpoint, RefusesChangedBits) {
  const Folder folder;
  const MPI_Comm comm = MPI_COMM_WORLD;
  const std::string good = folder / "good", bad = folder / "bad";
  const World w = world(comm, bodies, partitions(size_of(comm))[0]);
  write(comm, w, good);
  MPI_Barrier(comm);
  const std::string bytes = contents(good);
  std::size_t refused = 0, tried = 0;
  for (std::size_t at = 13; at < bytes.size(); at += bytes.size() / 100, ++tried) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ (1 << at % 8));
    if (rank_of(comm) == 0) put(bad, changed);
    MPI_Barrier(comm);
    try {
      const Checkpoint checkpoint(comm, bad, mark);
      EXPECT_EQ(checkpoint.frame(), 17);
      EXPECT_EQ(checkpoint.time(), 0.1 * 17);
      for (const Body& b : checkpoint.read_bodies(0, bodies)) expect_equal(b, body(b.id));
      expect_equal(checkpoint.read_multipliers(w), multipliers(w));
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("'" + bad + "' is damaged"), std::string::npos) << e.what();
      ++refused;
    }
    MPI_Barrier(comm);
  }
  EXPECT_GT(refused, tried * 8 / 10);
}

TEST(RanksCheckpoint, AFailedWriteKeepsTheOldOne) {
  const Folder folder;
  const MPI_Comm comm = MPI_COMM_WORLD;
  const World w = world(comm, bodies, partitions(size_of(comm))[0]);
  const std::string path = folder / "checkpoint.h5";
  write(comm, w, path);
  const std::string old = contents(path);
  MPI_Barrier(comm);

  if (rank_of(comm) == 0) std::filesystem::create_directory(path + ".part");
  MPI_Barrier(comm);
  EXPECT_THROW(write(comm, w, path, 18), RunError);
  EXPECT_TRUE(contents(path) == old);
  MPI_Barrier(comm);
  if (rank_of(comm) == 0) std::filesystem::remove(path + ".part");
  MPI_Barrier(comm);

  {
    const FileSizeLimit limit(4000);
    EXPECT_THROW(write(comm, w, path, 18), RunError);
  }
  EXPECT_TRUE(contents(path) == old);
  MPI_Barrier(comm);
  write(comm, w, path, 19);  // and the next one succeeds
  EXPECT_EQ(Checkpoint(comm, path, mark).frame(), 19);
}

}  // namespace
}  // namespace unibody::checkpoint_test
