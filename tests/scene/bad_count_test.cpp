// More bodies than there is room for are refused, before any is made, with the value that says how many.
#include "scene/bad_input.hpp"

namespace unibody::bad_count_test {
namespace {

// Three ranks, with memory for 1000 bodies each.
constexpr Room small_room{1000.5 * Room::least_bytes_of_body, 3};

std::string fault_in(const Room& room, const std::string& text) {
  const TextFile file(text);
  try {
    read_scene(file.path(), {}, room);
  } catch (const InputError& error) {
    std::string message = error.what();
    return message.replace(0, file.path().size(), "FILE");
  }
  return "";
}

const std::string sphere = "shape: {sphere: {radius: 1}}, mass: 1}\n", no_more = ": the memory of 3 ranks has room for no more";

class ReadSceneHasNoRoomFor : public testing::TestWithParam<BadInput> {};

TEST_P(ReadSceneHasNoRoomFor, WithThisMessage) {
  EXPECT_EQ(fault_in(small_room, GetParam().text), GetParam().message + no_more);
  const Room large{std::numeric_limits<double>::infinity(), 1'000'000};
  EXPECT_EQ(fault_in(large, GetParam().text), "") << "where there is room it is a scene";
}

INSTANTIATE_TEST_SUITE_P(
    Counts, ReadSceneHasNoRoomFor,
    testing::Values(
        BadInput{"lattice", "bodies:\n  - {lattice: {count: 1000000000000, columns: [1000, 1000], spacing: [1, 1, 1]}, " + sphere,
                 "FILE:2: key 'bodies[0].lattice.count': found 1000000000000, expected at most 3000 bodies"},
        BadInput{"one_body_too_many", "bodies:\n  - {stack: {count: 3001}, " + sphere,
                 "FILE:2: key 'bodies[0].stack.count': found 3001, expected at most 3000 bodies"},
        BadInput{"beside_others", "bodies:\n  - {stack: {count: 1100}, " + sphere + "  - {stack: {count: 1901}, " + sphere,
                 "FILE:3: key 'bodies[1].stack.count': found 1901, expected at most 1900 bodies"},
        BadInput{"static_ones_on_every_rank",
                 "bodies:\n  - {stack: {count: 1001}, shape: {sphere: {radius: 1}}, motion: fixed}\n",
                 "FILE:2: key 'bodies[0].stack.count': found 1001, expected at most 1000 bodies"},
        BadInput{
            "beside_static_ones",
            "bodies:\n  - {stack: {count: 990}, shape: {sphere: {radius: 1}}, motion: fixed}\n  - {stack: {count: 31}, " + sphere,
            "FILE:3: key 'bodies[1].stack.count': found 31, expected at most 30 bodies"},
        BadInput{"pile",
                 "bodies:\n  - density: 1\n    pile: {count: 100000, columns: [9, 9], mix: [{shape: {sphere: {radius: 1}}}]}\n",
                 "FILE:3: key 'bodies[0].pile.count': found 100000, expected at most 3000 bodies"},
        BadInput{"wall", "bodies:\n  - {shape: {box: {size: [1, 1, 1]}}, mass: 1, wall: {bricks: 1000000, courses: 1000000}}\n",
                 "FILE:2: key 'bodies[0].wall.courses': found 1000000, 1000000500000 bodies, expected at most 3000 bodies"},
        BadInput{"chain", "bodies:\n  - {chain: {count: 4000, from: [0, 0, 0], to: [1, 0, 0], joint: {type: ball}}, " + sphere,
                 "FILE:2: key 'bodies[0].chain.count': found 4000, expected at most 3000 bodies"},
        BadInput{"tree", "bodies:\n  - {tree: {levels: 12, length: 1, joint: {type: ball}}, density: 1}\n",
                 "FILE:2: key 'bodies[0].tree.levels': found 12, 4095 bodies, expected at most 3000 bodies"},
        BadInput{"ragdolls", "bodies:\n  - {ragdolls: {count: 300, spacing: [2, 2, 2]}, density: 1}\n",
                 "FILE:2: key 'bodies[0].ragdolls.count': found 300, 3300 bodies, expected at most 3000 bodies"},
        BadInput{"cloth", "cloths:\n  - {grid: {size: [1, 1], nodes: [1000000, 1000000]}, mass: 1, thickness: 0.01}\n",
                 "FILE:2: key 'cloths[0].grid.nodes': found [1000000, 1000000], 1000000000000 bodies, expected at most 3000 "
                 "bodies"},
        BadInput{"thread", "threads:\n  - {points: [[0, 0, 0], [1, 0, 0]], segments: 1000000000, radius: 0.01, mass: 1}\n",
                 "FILE:2: key 'threads[0].segments': found 1000000000, 1000000001 bodies, expected at most 3000 bodies"},
        BadInput{"solid",
                 "solids:\n  - {block: {size: [1, 1, 1], cells: [99999, 99999, 99999]}, density: 1, youngs_modulus: 1,\n"
                 "     poissons_ratio: 0.3, thickness: 0.01}\n",
                 "FILE:2: key 'solids[0].block.cells': found [99999, 99999, 99999], 1000000000000000 bodies, expected at most "
                 "3000 bodies"}),
    case_name);

// As many as there is room for are none too many; what is listed one by one counts as well.
TEST(ReadScene, FillsTheRoomThereIs) {
  EXPECT_EQ(fault_in(small_room, "bodies:\n  - {stack: {count: 3000}, " + sphere), "");
  EXPECT_EQ(fault_in(small_room, "bodies:\n  - {" + sphere + "  - {stack: {count: 2999}, " + sphere), "");
  EXPECT_EQ(fault_in(small_room, "bodies:\n  - {" + sphere + "  - {stack: {count: 3000}, " + sphere),
            "FILE:3: key 'bodies[1].stack.count': found 3000, expected at most 2999 bodies" + no_more);
}

}  // namespace
}  // namespace unibody::bad_count_test
