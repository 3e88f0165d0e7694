// scripts/render on a file that output wrote.
#include <cstdlib>

#include "report/output.hpp"
#include "report_worlds.hpp"

namespace unibody::render_test {
namespace {

using namespace testing_worlds;

TEST(Render, DrawsWithoutADisplay) {
  ASSERT_EQ(std::system("command -v xvfb-run >/dev/null && /usr/bin/python3 -c 'import vtk, h5py' 2>/dev/null"), 0)
      << "needs xvfb and Python's VTK and h5py: scripts/install";
  const Folder folder;
  const World w = world(MPI_COMM_SELF, 30, [](Id) { return 0; });
  {
    Output output(MPI_COMM_SELF, folder.path(), {}, 30, w);
    output.write(0, 0, w);
    output.write(5, 0.08, w);
  }
  const std::string program = "env -u DISPLAY " UNIBODY_SOURCE_DIR "/scripts/render " + folder.path();
  EXPECT_EQ(std::system((program + " --frame all --size 320x200").c_str()), 0);
  EXPECT_EQ(contents(folder / "frame_000005.png").substr(1, 3), "PNG");
  EXPECT_GT(contents(folder / "frame_000000.png").size(), 5000u) << "an empty picture?";
  EXPECT_NE(std::system((program + " --frame 3 2>/dev/null").c_str()), 0);
}

}  // namespace
}  // namespace unibody::render_test
