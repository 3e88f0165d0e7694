// Faults of solids in a scene file: one message each.
#include "scene/scene_text.hpp"

namespace unibody::bad_solid_test {
namespace {

std::string with_solid(const std::string& rest, const std::string& cells = "[1, 1, 1]") {
  return "solids:\n  - block: {size: [1, 1, 1], cells: " + cells +
         "}\n    density: 1\n    youngs_modulus: 1\n    thickness: 0.1\n    " + rest + "\n";
}

struct Fault {
  const char* name;
  std::string text, message;  // the message ends so
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class SolidRefuses : public testing::TestWithParam<Fault> {};

TEST_P(SolidRefuses, WithThisMessage) {
  const std::string found = fault_of(GetParam().text), &expected = GetParam().message;
  ASSERT_GE(found.size(), expected.size()) << found;
  EXPECT_EQ(found.substr(found.size() - expected.size()), expected) << found;
}

const std::vector<Fault> faults{
    {"without_shape", "solids:\n  - density: 1\n    youngs_modulus: 1\n    poissons_ratio: 0\n    thickness: 1\n",
     "FILE:2: key 'solids[0].block': found nothing, expected a map with size and cells, or mesh: a .msh or .vtu file"},
    {"without_density", "solids:\n  - block: {size: [1, 1, 1], cells: [1, 1, 1]}\n    thickness: 1\n",
     "FILE:2: key 'solids[0].density': found nothing, expected a number > 0 (kg/m^3)"},
    {"incompressible", with_solid("poissons_ratio: 0.5"),
     "FILE:6: key 'solids[0].poissons_ratio': found 0.5, expected a number in (-1, 0.5)"},
    {"block_of_no_cells", with_solid("poissons_ratio: 0.3", "[1, 0, 1]"),
     "FILE:2: key 'solids[0].block.cells[1]': found 0, expected an integer >= 1"},
    {"block_and_mesh", with_solid("poissons_ratio: 0.3\n    mesh: a.msh"),
     "FILE:7: key 'solids[0].mesh': found mesh beside block, expected only one of block and mesh"},
    {"mesh_that_is_not_there",
     "solids:\n  - mesh: nothing.msh\n    density: 1\n    youngs_modulus: 1\n    poissons_ratio: 0\n    thickness: 1\n",
     "nothing.msh, which isn't there, expected a .msh or .vtu file, its path from the scene's folder"},
    {"mesh_that_is_a_folder",
     "solids:\n  - mesh: .\n    density: 1\n    youngs_modulus: 1\n    poissons_ratio: 0\n    thickness: 1\n",
     "., which isn't a file, expected a .msh or .vtu file, its path from the scene's folder"},
    {"least_volume_of_one", with_solid("poissons_ratio: 0.3\n    least_volume: 1"),
     "FILE:7: key 'solids[0].least_volume': found 1, expected a number in (0, 1)"},
    {"load_on_nothing",
     with_solid("poissons_ratio: 0.3\n    loads: [{within: {min: [2, 2, 2], max: [3, 3, 3]}, force: [0, 0, 1]}]"),
     "FILE:7: key 'solids[0].loads[0]': found a part without a triangle of the surface, expected a box (m, world axes) with some "
     "in it"},
    {"part_upside_down", with_solid("poissons_ratio: 0.3\n    pins: [{within: {min: [0, 0, 1], max: [1, 1, 0]}}]"),
     "FILE:7: key 'solids[0].pins[0].within': found max below min, expected a box from min to max"},
    {"part_without_nodes", with_solid("poissons_ratio: 0.3\n    pins: [{within: {min: [2, 2, 2], max: [3, 3, 3]}}]"),
     "FILE:7: key 'solids[0].pins[0].within': found a part without a node, expected a box (m, world axes) with some in it"},
    {"node_outside_the_block", with_solid("poissons_ratio: 0.3\n    pins: [{node: [0, 2, 0]}]"),
     "FILE:7: key 'solids[0].pins[0].node[1]': found 2, expected an integer <= 1"},
    {"solid_in_the_plane", "planar: true\n" + with_solid("poissons_ratio: 0.3"),
     "FILE:2: key 'solids': found solids in a planar scene, expected planar: false: a solid needs all three directions"},
    {"total_form_of_stiff_links",
     "solver: {form: total}\ncloths:\n  - grid: {size: [1, 1], nodes: [4, 5]}\n    mass: 1\n    thickness: 0.01\n",
     "FILE:1: key 'solver.form': found total with accelerated_jacobi and constraints of stiffness number inf, expected at most "
     "30, "
     "where it is known to converge: form: incremental, name: gauss_seidel, or more substeps"},
    // The number is h^2 times the largest sum of w_n |D_n|^2 / E, by hand for one cube of five tetrahedra: 8 K h^2, K the bulk
    // modulus.
    {"total_form_of_stiff_tetrahedra",
     "solver: {form: total, name: jacobi}\nsolids:\n  - block: {size: [1, 1, 1], cells: [1, 1, 1]}\n    density: 1\n"
     "    youngs_modulus: 5.0e+8\n    poissons_ratio: 0.2\n    thickness: 0.1\n",
     "FILE:1: key 'solver.form': found total with jacobi and constraints of stiffness number 568889, expected at most 30, "
     "where it is known to converge: form: incremental, name: gauss_seidel, or more substeps"},
    // 50 rad/s in steps of 16 ms, about the middle of a cube at rest; a face that is held while the rest falls at 40 m/s.
    {"total_form_of_a_fast_spin",
     "solver: {form: total, name: gauss_seidel}\n" + with_solid("poissons_ratio: 0.3\n    angular_velocity: [0, 0, 50]"),
     "FILE:1: key 'solver.form': found total with gauss_seidel and edges whose ends move in a step, as a share of their length, "
     "by 0.8, expected at most 0.5, where it is known to converge: form: incremental, or more substeps"},
    {"total_form_of_a_fast_fall",
     "gravity: [0, 0, 0]\nsolver: {form: total}\n" +
         with_solid("poissons_ratio: 0.3\n    velocity: [0, 0, -40]\n    pins: [{within: {min: [-1, -1, 0.5], max: [1, 1, 1]}}]"),
     "FILE:2: key 'solver.form': found total with accelerated_jacobi and edges whose ends move in a step, as a share of their "
     "length, by 0.64, expected at most 0.5, where it is known to converge: form: incremental, or more substeps"},
};

INSTANTIATE_TEST_SUITE_P(Faults, SolidRefuses, testing::ValuesIn(faults),
                         [](const auto& fault) { return std::string(fault.param.name); });

TEST(SolidRefuses, NoTotalFormThatConverges) {
  EXPECT_EQ(fault_of("solver: {form: total, name: gauss_seidel}\ncloths:\n  - grid: {size: [1, 1], nodes: [4, 5]}\n    mass: 1\n"
                     "    thickness: 0.01\n"),
            "");
  EXPECT_EQ(fault_of("solver: {form: total}\n" + with_solid("poissons_ratio: 0.3")), "");
  // 5e8 Pa in a cube of 1 m and 1 kg/m^3: 568889 in steps of 16 ms, and 30.3 in a 137th of it.
  const std::string hard =
      "solids:\n  - block: {size: [1, 1, 1], cells: [1, 1, 1]}\n    density: 1\n    youngs_modulus: 5.0e+8\n"
      "    poissons_ratio: 0.2\n    thickness: 0.1\n";
  EXPECT_EQ(fault_of("solver: {form: total, name: gauss_seidel}\n" + hard), "");
  EXPECT_EQ(fault_of("time: {substeps: 147}\nsolver: {form: total}\n" + hard), "");
  EXPECT_NE(fault_of("time: {substeps: 137}\nsolver: {form: total}\n" + hard), "");
  // However fast all moves together, and slower turns.
  EXPECT_EQ(fault_of("solver: {form: total}\n" + with_solid("poissons_ratio: 0.3\n    velocity: [0, 0, -400]")), "");
  EXPECT_EQ(fault_of("solver: {form: total}\n" + with_solid("poissons_ratio: 0.3\n    angular_velocity: [0, 0, 31]")), "");
}

}  // namespace
}  // namespace unibody::bad_solid_test
