#include "report/frame_group.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "report_worlds.hpp"

namespace unibody::frame_group_test {
namespace {

namespace fs = std::filesystem;

constexpr int frames = 40;  // so many that HDF5 keeps their names in a heap and a tree

// A file with the frames 0 to 39, frame k a group that holds k; `cut`: as a run leaves it that is killed while it names the last.
void write_file(const std::string& path, bool cut) {
  const h5::Handle file = h5::create_file(MPI_COMM_SELF, path);
  FrameGroup group;
  group.create(MPI_COMM_SELF, file, path);
  for (int k = 0; k < frames; ++k) {
    const h5::Handle frame = h5::create_unlinked_group(file);
    h5::write_attribute(frame, "time", 0.5 * k);
    ASSERT_TRUE(group.add(frame, k));
  }
  const std::string list = path + ".links";
  if (cut) fs::copy_file(list, path + ".kept");
  ASSERT_TRUE(group.close());
  EXPECT_FALSE(fs::exists(list));
  if (!cut) return;
  fs::rename(path + ".kept", list);
  fs::resize_file(list, fs::file_size(list) - 2);  // without the last "="
}

// Zeros over each block of the file that begins with one of these signatures of HDF5's heaps and trees.
int spoil(const std::string& path, std::initializer_list<std::string> signatures) {
  std::ifstream in(path, std::ios::binary);
  std::string data((std::istreambuf_iterator<char>(in)), {});
  int spoilt = 0;
  for (const std::string& signature : signatures)
    for (auto at = data.find(signature); at != std::string::npos; at = data.find(signature, at + 1), ++spoilt)
      data.replace(at, 16, 16, '\0');
  std::ofstream(path, std::ios::binary) << data;
  return spoilt;
}

std::vector<double> times_in(const std::string& path) {
  const h5::Quiet quiet;
  const h5::Handle file = h5::open_file(path);
  std::vector<double> times;
  for (const std::int64_t k : h5::member_numbers(file, "frames")) {
    const h5::Handle frame(H5Gopen2(file, ("frames/" + h5::numbered(k)).c_str(), H5P_DEFAULT), H5Gclose, "open a frame");
    times.push_back(h5::read_double(frame, "time"));
  }
  return times;
}

std::vector<double> all_times(int count = frames) {
  std::vector<double> times;
  for (int k = 0; k < count; ++k) times.push_back(0.5 * k);
  return times;
}

TEST(FrameGroup, IsMadeAnewFromItsListWhereARunWasKilledWhileItChangedIt) {
  const testing_worlds::Folder folder;
  const std::string path = folder / "frames.h5";
  write_file(path, true);
  EXPECT_EQ(times_in(path), all_times());
  ASSERT_GT(spoil(path, {"FRHP", "FHDB", "BTHD", "BTLF"}), 3);
  EXPECT_THROW(times_in(path), std::runtime_error);
  EXPECT_TRUE(FrameGroup::mend(path));
  EXPECT_EQ(times_in(path), all_times());

  const h5::Handle file = h5::open_file_to_extend(MPI_COMM_SELF, path);
  FrameGroup group;
  group.extend(MPI_COMM_SELF, file, path, 29);
  EXPECT_FALSE(FrameGroup::mend(path));  // the list is whole again
  EXPECT_TRUE(group.holds(29));
  EXPECT_FALSE(group.holds(30));
  const h5::Handle frame = h5::create_unlinked_group(file);
  h5::write_attribute(frame, "time", 15.0);
  EXPECT_TRUE(group.add(frame, 30));
  EXPECT_TRUE(group.close());
  EXPECT_EQ(times_in(path), all_times(31));
}

TEST(FrameGroup, OfAFileWithoutAListOrWithAWholeOneIsLeftAlone) {
  const testing_worlds::Folder folder;
  const std::string path = folder / "frames.h5";
  write_file(path, false);
  EXPECT_FALSE(FrameGroup::mend(path));
  std::ofstream(path + ".links") << "0 999\n=\n";
  EXPECT_FALSE(FrameGroup::mend(path));
  std::ofstream(path + ".links") << "0 999\n=\n1 99";  // the rest of the line never came: nothing was changed
  EXPECT_FALSE(FrameGroup::mend(path));
  EXPECT_EQ(times_in(path), all_times());
  std::ofstream(path + ".links") << "0 999\n";  // where no frame lies
  EXPECT_THROW(FrameGroup::mend(path), std::runtime_error);
  EXPECT_EQ(times_in(path), all_times());
}

}  // namespace
}  // namespace unibody::frame_group_test
