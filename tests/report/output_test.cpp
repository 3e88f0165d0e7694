#include "report/output.hpp"

#include "core/errors.hpp"
#include "partition/by_id.hpp"
#include "report/state_hash.hpp"
#include "report_worlds.hpp"

namespace unibody::output_test {
namespace {

using namespace testing_worlds;

TEST(IdBlocks, CoverAllIdsOnce) {
  for (Id count : {0, 1, 2, 3, 7, 8, 100, 101})
    for (int ranks : {1, 2, 3, 4, 7, 150}) {
      const IdBlocks blocks{count, ranks};
      EXPECT_EQ(blocks.first(0), 0);
      EXPECT_EQ(blocks.first(ranks), count);
      for (Id id = 0; id < count; ++id) {
        const int owner = blocks.owner(id);
        ASSERT_GE(id, blocks.first(owner));
        ASSERT_LT(id, blocks.first(owner + 1));
      }
    }
  const IdBlocks large{10'000'000'000, 3};
  EXPECT_EQ(large.owner(9'999'999'999), 2);
}

TEST(RanksById, RowsComeInOrderFromAnyPartition) {
  const MPI_Comm comm = MPI_COMM_WORLD;
  for (Id count : {0, 1, 2, 40})
    for (const auto& home : partitions(size_of(comm))) {
      const World w = world(comm, count, home);
      const auto rows = rows_by_id(comm, w, count, [&](std::size_t slot) { return w.position[slot][2]; });
      const IdBlocks blocks = id_blocks(comm, count);
      ASSERT_EQ(rows.size(), static_cast<std::size_t>(blocks.size(rank_of(comm))));
      for (std::size_t k = 0; k < rows.size(); ++k)
        EXPECT_EQ(rows[k], body(blocks.first(rank_of(comm)) + static_cast<Id>(k)).state.position[2]);
    }
}

TEST(RanksById, MissingAndDoubleBodiesAreErrorsOnEveryRank) {
  const MPI_Comm comm = MPI_COMM_WORLD;
  const auto position = [](const World& w) { return [&w](std::size_t slot) { return w.position[slot][0]; }; };
  World missing = world(comm, 20, [](Id k) { return k == 11 ? -1 : 0; });
  EXPECT_THROW(rows_by_id(comm, missing, 20, position(missing)), RunError);
  World twice = world(comm, 20, [](Id k) { return k == 11 ? -1 : 0; });
  if (rank_of(comm) == 0) twice.id[3] = twice.id[4];
  EXPECT_THROW(rows_by_id(comm, twice, 20, position(twice)), RunError);
}

// Writes two frames on the first `ranks` ranks with one of the partitions.
void write_frames(int ranks, std::size_t partition, const std::string& directory, Id count, bool single,
                  const std::vector<Surface>& surfaces = {}) {
  MPI_Comm comm;
  const bool in = rank_of(MPI_COMM_WORLD) < ranks;
  MPI_Comm_split(MPI_COMM_WORLD, in ? 0 : MPI_UNDEFINED, 0, &comm);
  if (in) {
    World w = world(comm, count, partitions(ranks)[partition]);
    OutputSettings settings;
    settings.single_precision = single;
    prepare_output_directory(comm, directory, false);
    {
      Output output(comm, directory, settings, count, w, surfaces);
      output.write(0, 0, w);
      for (auto& x : w.position) x += Vec3(1, 2, 3);
      output.write(5, 0.08, w);
    }
    MPI_Comm_free(&comm);
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST(RanksOutput, SameBytesOnAnyNumberOfRanks) {
  const Folder folder;
  for (const bool single : {false, true})
    for (const Id count : {2, 333}) {
      const std::string name = std::to_string(count) + (single ? "s" : "d");
      write_frames(1, 0, folder / (name + "one"), count, single);
      const auto expected = contents(folder / (name + "one/frames.h5")), xdmf = contents(folder / (name + "one/frames.xdmf"));
      ASSERT_GT(expected.size(), static_cast<std::size_t>(count) * 26 * (single ? 4 : 8));
      for (int ranks = 1; ranks <= size_of(MPI_COMM_WORLD); ++ranks)
        for (std::size_t p = 0; p < 3; ++p) {
          const std::string other = folder / (name + std::to_string(ranks) + "_" + std::to_string(p));
          write_frames(ranks, p, other, count, single);
          EXPECT_TRUE(contents(other + "/frames.h5") == expected) << other;
          EXPECT_EQ(contents(other + "/frames.xdmf"), xdmf);
        }
    }
}

TEST(RanksOutput, SurfacesToo) {
  const Folder folder;
  std::vector<Surface> surfaces(2);
  surfaces[0].name = "sheet", surfaces[0].count = 200;
  surfaces[0].cell = [](Id k) { return std::array<Id, 3>{k, k + 1, k + 2}; };
  surfaces[1].corners = 2, surfaces[1].count = 1;
  surfaces[1].cell = [](Id k) { return std::array<Id, 3>{k + 250, k + 251, 0}; };
  write_frames(1, 0, folder / "one", 333, false, surfaces);
  write_frames(size_of(MPI_COMM_WORLD), 1, folder / "all", 333, false, surfaces);
  for (const char* file : {"/frames.h5", "/frames.xdmf"})
    EXPECT_TRUE(contents((folder / "one") + file) == contents((folder / "all") + file)) << file;
  const h5::Handle file = h5::open_file(folder / "all/frames.h5");
  std::array<std::int64_t, 3> last{};
  const h5::Handle cells = h5::open_dataset(file, "surfaces/000000/cells");
  h5::read_rows(cells, H5T_NATIVE_INT64, 199, 1, last.data());
  EXPECT_EQ(last, (std::array<std::int64_t, 3>{199, 200, 201}));
  EXPECT_EQ(h5::dimensions(h5::open_dataset(file, "surfaces/000001/cells")), (std::vector<hsize_t>{1, 2}));
  EXPECT_NE(contents(folder / "all/frames.xdmf").find("TopologyType=\"Triangle\" NumberOfElements=\"200\""), std::string::npos);
}

TEST(RanksOutput, ReadsBackInPython) {
  const Folder folder;
  write_frames(size_of(MPI_COMM_WORLD), 0, folder / "d", 333, false);
  write_frames(size_of(MPI_COMM_WORLD), 0, folder / "s", 333, true);
  if (rank_of(MPI_COMM_WORLD) != 0) return;
  for (const char* kind : {"d", "s"}) {
    const std::string command =
        "/usr/bin/python3 " UNIBODY_SOURCE_DIR "/tests/report/check_frames.py " + (folder / kind) + " 333";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
  }
}

TEST(RanksOutput, NoBodiesAtAll) {
  const Folder folder;
  write_frames(size_of(MPI_COMM_WORLD), 0, folder.path(), 0, false);
  EXPECT_FALSE(contents(folder / "frames.h5").empty());
}

// A run that dies between frames: the object is never destroyed.
TEST(RanksOutput, FilesAreWholeBetweenFrames) {
  const Folder folder;
  const MPI_Comm comm = MPI_COMM_WORLD;
  const World w = world(comm, 333, partitions(size_of(comm))[0]);
  Output output(comm, folder.path(), {}, 333, w);
  output.write(0, 0, w);
  World moved = w;
  for (auto& x : moved.position) x += Vec3(1, 2, 3);
  output.write(5, 0.08, moved);
  if (rank_of(comm) == 0) {
    std::filesystem::create_directory(folder / "copy");
    for (const char* name : {"frames.h5", "frames.xdmf"}) std::filesystem::copy_file(folder / name, folder / "copy/" + name);
    const std::string command =
        "/usr/bin/python3 " UNIBODY_SOURCE_DIR "/tests/report/check_frames.py " + (folder / "copy") + " 333";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
  }
  MPI_Barrier(comm);
}

TEST(RanksOutput, AFullDiskLeavesTheEarlierFrames) {
  const Folder folder;
  const MPI_Comm comm = MPI_COMM_WORLD;
  const World w = world(comm, 333, partitions(size_of(comm))[0]);
  {
    Output output(comm, folder.path(), {}, 333, w);
    output.write(0, 0, w);
    output.write(1, 0.1, w);
    const std::string xdmf = contents(folder / "frames.xdmf");
    MPI_Barrier(comm);
    const FileSizeLimit limit(100'000);
    EXPECT_THROW(output.write(2, 0.2, w), RunError);
    EXPECT_EQ(contents(folder / "frames.xdmf"), xdmf);
  }
  MPI_Barrier(comm);
  const h5::Handle file = h5::open_file(folder / "frames.h5");
  EXPECT_NO_THROW(h5::open_dataset(file, "frames/000001/velocity"));
  const h5::Quiet quiet;
  EXPECT_THROW(h5::open_dataset(file, "frames/000002/velocity"), std::runtime_error);
}

TEST(RanksOutput, ExistingResultsAreKept) {
  const Folder folder;
  const MPI_Comm comm = MPI_COMM_WORLD;
  EXPECT_NO_THROW(prepare_output_directory(comm, folder / "a/b", false));
  EXPECT_NO_THROW(prepare_output_directory(comm, folder / "a/b", false));  // empty: nothing to lose
  for (const char* name : {"frames.h5", "frames.xdmf", "report.csv", "summary.json", "checkpoint.h5"}) {
    const std::string path = folder / "a/b/" + name;
    if (rank_of(comm) == 0) put(path, "old");
    MPI_Barrier(comm);
    try {
      prepare_output_directory(comm, folder / "a/b", false);
      ADD_FAILURE() << name << " would be overwritten";
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
    }
    EXPECT_EQ(contents(path), "old");
    MPI_Barrier(comm);
    EXPECT_NO_THROW(prepare_output_directory(comm, folder / "a/b", true));
    EXPECT_FALSE(std::filesystem::exists(path));
    MPI_Barrier(comm);
  }
  if (rank_of(comm) == 0) put(folder / "a/b/checkpoint.h5", "old"), put(folder / "a/file", "");
  MPI_Barrier(comm);
  prepare_output_directory(comm, folder / "a/b", true, folder / "a/../a/b/checkpoint.h5");
  EXPECT_EQ(contents(folder / "a/b/checkpoint.h5"), "old");
  EXPECT_THROW(prepare_output_directory(comm, folder / "a/file", true), InputError);
  EXPECT_THROW(prepare_output_directory(comm, "/proc/nothing", false), InputError);
}

TEST(RanksStateHash, SameForEveryPartitionAndTellsOneBit) {
  const MPI_Comm comm = MPI_COMM_WORLD;
  const auto one = state_hash(MPI_COMM_SELF, world(MPI_COMM_SELF, 100, [](Id) { return 0; }));
  for (const auto& home : partitions(size_of(comm))) EXPECT_EQ(state_hash(comm, world(comm, 100, home)), one);
  World w = world(comm, 100, partitions(size_of(comm))[0]);
  for (std::size_t slot = 0; slot < w.size(); ++slot)
    if (w.id[slot] == 42 || w.id[slot] == 41) {
      auto& x = w.angular_velocity[slot][1];
      if (w.id[slot] == 41) x = std::nextafter(x, 1.0);
    }
  EXPECT_NE(state_hash(comm, w), one);
  World swapped = world(MPI_COMM_SELF, 100, [](Id) { return 0; });
  std::swap(swapped.position[3], swapped.position[4]);
  EXPECT_NE(state_hash(MPI_COMM_SELF, swapped), one);
}

}  // namespace
}  // namespace unibody::output_test
