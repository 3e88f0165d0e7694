// The Python module `unibody`: its functions, classes and their documentation.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <filesystem>
#include <set>

#include "core/checked.hpp"
#include "core/errors.hpp"
#include "library/live_simulation.hpp"
#include "python/errors.hpp"
#include "python/mpi_session.hpp"
#include "python/scene_text.hpp"
#include "report/version.hpp"
#include "step/mesh_sides.hpp"

namespace unibody {

namespace {

namespace py = pybind11;
using Field = LiveSimulation::Field;

// A scene as Python holds it. It is shared with no simulation: each has a copy.
struct PythonScene {
  Scene scene;
  bool knows_mesh_sides = false;  // which the first simulation finds out for the process (mesh_sides.hpp)
};

std::vector<Override> overrides_of(const py::dict& changes) {
  std::vector<Override> list;
  for (const auto& [path, value] : changes)
    list.push_back({py::str(path).cast<std::string>(), value_text(value, py::str(path).cast<std::string>())});
  return list;
}

// Simulations that are open; they end before MPI does.
std::set<LiveSimulation*>& open_simulations() {
  static std::set<LiveSimulation*> set;
  return set;
}

struct CloseAndForget {
  void operator()(LiveSimulation* simulation) const {
    open_simulations().erase(simulation);
    delete simulation;
  }
};
using Holder = std::unique_ptr<LiveSimulation, CloseAndForget>;

Holder make_simulation(PythonScene& scene, const py::object& comm, const std::string& checkpoint,
                       const std::string& continue_from) {
  start_mpi(py::cpp_function([] {
    for (LiveSimulation* simulation : open_simulations()) simulation->close();
  }));
  const MPI_Comm over = communicator_of(comm);
  const py::gil_scoped_release free;
  if (!scene.knows_mesh_sides) decide_mesh_sides(over, scene.scene, scene.scene.notes);
  scene.knows_mesh_sides = true;
  Holder simulation(new LiveSimulation(over, scene.scene, checkpoint, continue_from));
  open_simulations().insert(simulation.get());
  return simulation;
}

// Ctrl-C: Python only notes the signal, and on some of the processes perhaps after others.
void stop_if_interrupted(MPI_Comm comm) {
  int interrupted = PyErr_CheckSignals() != 0 ? 1 : 0;
  const bool here = interrupted != 0;
  int ranks = 1;
  check_mpi(MPI_Comm_size(comm, &ranks));
  if (ranks > 1) check_mpi(MPI_Allreduce(MPI_IN_PLACE, &interrupted, 1, MPI_INT, MPI_MAX, comm));
  if (interrupted == 0) return;
  if (!here) PyErr_SetNone(PyExc_KeyboardInterrupt);
  throw py::error_already_set();
}

void take_steps(LiveSimulation& simulation, std::int64_t count) {
  if (count < 0) throw InputError("found " + std::to_string(count) + " steps, expected 0 or more");
  for (std::int64_t k = 0; k < count; ++k) {
    {
      const py::gil_scoped_release free;
      simulation.step();
    }
    stop_if_interrupted(simulation.comm());
  }
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Ids = py::array_t<std::int64_t, py::array::c_style>;

Numbers table(const std::vector<double>& numbers, std::size_t width) {
  Numbers array({static_cast<py::ssize_t>(numbers.size() / width), static_cast<py::ssize_t>(width)});
  std::copy(numbers.begin(), numbers.end(), array.mutable_data());
  return array;
}

template <class T>
py::array_t<T> list(const std::vector<T>& values) {
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

Field field_of(const std::string& name) {
  if (name == "positions") return Field::position;
  if (name == "orientations") return Field::orientation;
  if (name == "velocities") return Field::velocity;
  if (name == "angular_velocities") return Field::angular_velocity;
  throw InputError("found field '" + name + "', expected positions, orientations, velocities or angular_velocities");
}

std::vector<Id> ids_of(const py::object& ids) {
  const Ids array = Ids::ensure(py::module_::import("numpy").attr("atleast_1d")(ids));
  if (!array || array.ndim() != 1) {
    PyErr_Clear();
    throw InputError("ids: found no whole number, nor a list of them, expected the id of a body, or several");
  }
  return {array.data(), array.data() + array.size()};
}

// Reads three numbers for each of `count` bodies. An array of the shape (3,) holds for all of them, one of the shape (count, 3)
// has a row for each; None gives no numbers.
std::vector<double> vectors_of(const py::object& values, std::size_t count, const char* what) {
  if (values.is_none()) return {};
  const Numbers array = Numbers::ensure(values);
  if (!array) PyErr_Clear();
  const auto n = static_cast<py::ssize_t>(count);
  const bool one = array && array.ndim() == 1 && array.shape(0) == 3;
  const bool many = array && array.ndim() == 2 && array.shape(0) == n && array.shape(1) == 3;
  if (!one && !many)
    throw InputError(std::string(what) + ": found another shape, expected (3,) or (" + std::to_string(count) + ", 3) numbers");
  std::vector<double> numbers;
  for (std::size_t k = 0; k < (one ? count : 1); ++k) numbers.insert(numbers.end(), array.data(), array.data() + array.size());
  return numbers;
}

struct JointRow {
  double coordinate, drift, turn;
  double force[3], torque[3];
  double limit, motor, friction, spring;
  bool broken;
};

py::array_t<JointRow> joint_rows(LiveSimulation& simulation) {
  std::vector<JointRow> rows;
  for (const JointState& s : simulation.joint_states()) {
    JointRow row{s.coordinate, s.drift, s.turn, {}, {}, s.limit, s.motor, s.friction, s.spring, s.broken};
    std::copy_n(s.force.data(), 3, row.force), std::copy_n(s.torque.data(), 3, row.torque);
    rows.push_back(row);
  }
  return list(rows);
}

py::dict measures_of(LiveSimulation& simulation) {
  const Measures m = simulation.measures();
  const auto vector = [](const Vec3& v) { return Numbers(3, v.data()); };
  py::dict values;
  values["penetration_max"] = m.penetration_max, values["penetration_rms"] = m.penetration_rms;
  values["contact_pairs"] = m.pairs, values["contacts"] = m.contacts;
  values["kinetic_energy"] = m.kinetic_energy, values["potential_energy"] = m.potential_energy;
  values["linear_momentum"] = vector(m.linear_momentum), values["angular_momentum"] = vector(m.angular_momentum);
  return values;
}

std::string hash_text(const LiveSimulation& simulation) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(simulation.state_hash()));
  return text.data();
}

void add_scene(py::module_& m) {
  py::class_<PythonScene>(m, "Scene", R"(A scene: bodies, joints and settings, in SI units, as a scene file says them.

Scene(dict, folder='.', set={}) reads a scene from a dict whose keys are those of the file's sections. Mesh files are looked for in
`folder`. Scene.load(path, set={}) reads a scene file. `set` maps paths such as 'time.frames' or 'bodies[0].mass' to values that
take the place of those in the scene. Both raise InputError, which names the key, what was found and what was expected.)")
      .def(py::init([](const py::dict& scene, const std::string& folder, const py::dict& set) {
             const std::string path = folder == "." ? "scene" : (std::filesystem::path(folder) / "scene").string();
             return PythonScene{read_scene_text(scene_text(scene), path, overrides_of(set))};
           }),
           py::arg("scene"), py::arg("folder") = ".", py::arg("set") = py::dict())
      .def_static(
          "load", [](const std::string& path, const py::dict& set) { return PythonScene{read_scene(path, overrides_of(set))}; },
          py::arg("path"), py::arg("set") = py::dict(),
          "Reads a scene file. Raises InputError with the attributes file and line.")
      .def_property_readonly("title", [](const PythonScene& s) { return s.scene.title; })
      .def_property_readonly(
          "body_count", [](const PythonScene& s) { return s.scene.body_count(); },
          "Number of all bodies, fixed ones and nodes of cloths, threads and solids among them: ids run from 0.")
      .def_property_readonly("joint_count", [](const PythonScene& s) { return s.scene.joints.size(); })
      .def_property_readonly(
          "joint_names", [](const PythonScene& s) { return s.scene.joints_named; },
          "The places of joints in the scene, from 0, by their names: a dict of lists, since several may have one name. A "
          "robot's "
          "joint is called robot/elbow.")
      .def_property_readonly(
          "frames", [](const PythonScene& s) { return s.scene.time.frames; }, "time.frames of the scene.")
      .def_property_readonly(
          "substeps", [](const PythonScene& s) { return s.scene.time.substeps; }, "Steps of a frame.")
      .def_property_readonly(
          "probes",
          [](const PythonScene& s) {
            std::vector<std::string> names;
            for (const Probe& probe : s.scene.probes) names.push_back(probe.name);
            return names;
          },
          "Names of the scene's probes.")
      .def_property_readonly(
          "notes", [](const PythonScene& s) { return s.scene.notes; },
          "What a person should know of what was read: a list of str.")
      .def(
          "ids", [](const PythonScene& s, const std::string& name) { return list(ids_named(s.scene, name)); }, py::arg("name"),
          "Ids, int64 (n,), of the bodies of the entries of that name. Raises InputError where there are none.")
      .def(
          "body_name", [](const PythonScene& s, Id id) { return s.scene.body_name(id); }, py::arg("id"));
}

void add_state(py::class_<LiveSimulation, Holder>& simulation) {
  const auto field = [&](const char* name, Field which, const char* text) {
    simulation.def_property_readonly(
        name,
        [which](const LiveSimulation& s) {
          const std::vector<double> numbers = s.gathered(which);
          return table(numbers, LiveSimulation::width(which));
        },
        text);
  };
  field("positions", Field::position,
        "m, float64 (bodies, 3): places of the centres of mass of all bodies, by id. Collective; a copy.");
  field("orientations", Field::orientation,
        "float64 (bodies, 4): unit quaternions w, x, y, z, body to world, by id. Collective; a copy.");
  field("velocities", Field::velocity, "m/s, float64 (bodies, 3), by id. Collective; a copy.");
  field("angular_velocities", Field::angular_velocity, "rad/s in world axes, float64 (bodies, 3), by id. Collective; a copy.");
  simulation
      .def_property_readonly(
          "home_ids", [](const LiveSimulation& s) { return list(s.home_ids()); },
          "Ids, int64 (n,), ascending, of the dynamic bodies that this process moves. They change between frames.")
      .def(
          "home",
          [](const LiveSimulation& s, const std::string& name) {
            return table(s.of_homes(field_of(name)), LiveSimulation::width(field_of(name)));
          },
          py::arg("field"), "The field ('positions', ...) of the bodies of home_ids, in that order. Not collective; a copy.")
      .def(
          "contacts", [](LiveSimulation& s) { return list(s.contacts()); },
          "Contacts between bodies at the present state, of the pairs of this process: a structured array with body_a, body_b, "
          "point (m), normal (from body_b to body_a), gap (m, negative: penetration) and friction. Contacts of cloths and of "
          "faces "
          "of solids are not among them. Collective.")
      .def(
          "contact_forces", [](const LiveSimulation& s) { return list(s.contact_forces()); },
          "What contacts did in the last step, of the pairs of this process: a structured array with bodies (4, -1: none), "
          "shares "
          "(of the force, of each body), point (m), normal, force (N, on the first side, the mean over the step) and friction. "
          "Contacts of cloths, threads and solids are among them. Not collective.")
      .def("joints", joint_rows,
           "Each joint's state, with the forces of the last step, in the order of the scene: a structured array with coordinate "
           "(rad or m), drift (m), "
           "turn (rad), force (N), torque (N m), what limit, motor, friction and spring give (N m or N), and "
           "whether it has broken. Collective.")
      .def("measures", measures_of,
           "A dict: penetration_max and penetration_rms (m), contact_pairs, contacts, kinetic_energy and potential_energy (J), "
           "linear_momentum (kg m/s), angular_momentum (kg m^2/s, about the origin). The same bits on any number of processes. "
           "Collective.")
      .def(
          "probe",
          [](const LiveSimulation& s, const std::string& name) {
            py::dict values;
            for (const auto& [column, value] : s.probe(name)) values[py::str(column)] = value;
            return values;
          },
          py::arg("name"),
          "What the scene's probe tells: a dict of its columns, with their units. Of a flow what has passed since the simulation "
          "was "
          "made or restored, of a box what is in it now, of a force or stress its mean over the last step. Collective. Raises "
          "InputError "
          "for another name.")
      .def_property_readonly(
          "report", [](const LiveSimulation& s) { return list(s.report()); },
          "One row a step since the simulation was made or restored: a structured array with step, iterations, "
          "sliding_contacts, impacts, time (s), natural_residual (m) and converged.")
      .def("state_hash", hash_text,
           "16 hex digits, as the program's last line has them: equal hashes mean equal states, bit for bit. Collective.");
}

void add_simulation(py::module_& m) {
  py::class_<LiveSimulation, Holder> simulation(m, "Simulation", R"(A scene in motion.

Simulation(scene, comm=None, checkpoint='', continue_from='') starts a scene, or goes on from a checkpoint of it, or starts it with
the bodies of another scene's checkpoint, by name and number. comm is a communicator of mpi4py; None means all processes that mpirun started. The same script runs in each of these: members that are called collective must be
called by all of them, in the same order and with the same arguments. Results are the same bits on any number of processes, and
those of the program. Raises InputError.)");
  simulation
      .def(py::init(&make_simulation), py::arg("scene"), py::arg("comm") = py::none(), py::arg("checkpoint") = "",
           py::arg("continue_from") = "")
      .def("step", take_steps, py::arg("n") = 1,
           "Takes n steps of time.frame / time.substeps each. Collective. Raises RunError where a step leads to a state that "
           "cannot "
           "be, and KeyboardInterrupt after the step in which ctrl-C was pressed.")
      .def_property_readonly("rank", &LiveSimulation::rank, "Which of the communicator's processes this is, from 0.")
      .def_property_readonly("ranks", &LiveSimulation::ranks, "How many these are.")
      .def_property_readonly("time", &LiveSimulation::time, "s, since the scene's start.")
      .def_property_readonly("steps_done", &LiveSimulation::steps_done, "Steps since the scene's start.")
      .def_property_readonly("step_length", &LiveSimulation::step_length, "s.")
      .def(
          "set_velocity",
          [](LiveSimulation& s, const py::object& ids, const py::object& velocity, const py::object& angular) {
            const std::vector<Id> bodies = ids_of(ids);
            s.set_velocities(bodies, vectors_of(velocity, bodies.size(), "velocity"),
                             vectors_of(angular, bodies.size(), "angular_velocity"));
          },
          py::arg("ids"), py::arg("velocity") = py::none(), py::arg("angular_velocity") = py::none(),
          "Sets velocities (m/s) and angular velocities (rad/s, world axes) of dynamic or kinematic bodies: (3,) for all of "
          "them, or "
          "(n, 3). None leaves them. Collective. Raises InputError for fixed bodies and those whose motion the scene gives in "
          "time.")
      .def(
          "apply_force",
          [](LiveSimulation& s, const py::object& ids, const py::object& force, const py::object& torque) {
            const std::vector<Id> bodies = ids_of(ids);
            s.apply_forces(bodies, vectors_of(force, bodies.size(), "force"), vectors_of(torque, bodies.size(), "torque"));
          },
          py::arg("ids"), py::arg("force") = py::none(), py::arg("torque") = py::none(),
          "Lets forces (N, at the centres of mass) and torques (N m, world axes) act on dynamic bodies throughout the next step: "
          "(3,) "
          "for each of them, or (n, 3). Collective. Raises InputError for bodies that no force moves.")
      .def("set_motor", &LiveSimulation::set_motor, py::arg("joint"), py::arg("target"),
           "From now on the motor of that joint (its place in the scene, from 0) has this target: rad/s, m/s, rad or m. "
           "Checkpoints "
           "don't hold it. Collective. Raises InputError for a joint without a motor.")
      .def("checkpoint", &LiveSimulation::write_checkpoint, py::arg("path"),
           "Writes a checkpoint, from which the program's -restart goes on as well. At the end of a frame only. Collective.")
      .def("restore", &LiveSimulation::restore, py::arg("path"),
           "Goes back, or on, to the state of a checkpoint of this scene. Collective. Raises InputError, and then nothing "
           "changes.")
      .def("close", &LiveSimulation::close, "Ends the simulation and frees what it holds. Collective.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__", [](LiveSimulation& s, const py::args&) { s.close(); });
  add_state(simulation);
}

}  // namespace

}  // namespace unibody

PYBIND11_MODULE(unibody, m) {
  using namespace unibody;
  m.doc() = "Unibody: rigid and flexible bodies in one solver, on as many processes as mpirun starts. Units are SI.";
  PYBIND11_NUMPY_DTYPE(StepRow, step, iterations, sliding_contacts, impacts, time, natural_residual, converged);
  PYBIND11_NUMPY_DTYPE(ContactRow, body_a, body_b, point, normal, gap, friction);
  PYBIND11_NUMPY_DTYPE(ForceRow, bodies, shares, point, normal, force, friction);
  PYBIND11_NUMPY_DTYPE(JointRow, coordinate, drift, turn, force, torque, limit, motor, friction, spring, broken);
  add_errors(m);
  m.def(
      "version", [] { return version_text(); }, "Version and commit, compiler, and the versions of PETSc, MPI, HDF5 and METIS.");
  add_scene(m);
  add_simulation(m);
}
