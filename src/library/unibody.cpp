#include "library/unibody.hpp"

#include <petscsys.h>

#include <algorithm>
#include <filesystem>

#include "app/petsc_session.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "core/hash.hpp"
#include "core/hdf5.hpp"
#include "library/live_simulation.hpp"
#include "library/session.hpp"
#include "report/version.hpp"
#include "step/mesh_sides.hpp"

namespace unibody::api {

namespace {

// The errors of the program as those of the library.
template <class F>
auto translated(F&& f) {
  try {
    return f();
  } catch (const unibody::InputError& error) {
    throw InputError(error.what());
  } catch (const unibody::RunError& error) {
    throw RunError(error.what());
  }
}

std::vector<Override> overrides_of(const Scene::Settings& set) {
  std::vector<Override> list;
  for (const auto& [path, value] : set) list.push_back({path, value});
  return list;
}

void copy(const Vec3& from, double* to) { std::copy_n(from.data(), 3, to); }

}  // namespace

struct Session::Data {
  Data(int* argc, char*** argv) : session(argc, argv) {}
  unibody::LibrarySession session;
};

Session::Session(int* argc, char*** argv) : data_(translated([&] { return std::make_unique<Data>(argc, argv); })) {}
Session::~Session() = default;

struct Scene::Data {
  unibody::Scene scene;
  bool knows_mesh_sides = false;  // which the first simulation finds out for the process (mesh_sides.hpp)
};

Scene Scene::from_file(const std::string& path, const Settings& set) {
  Scene scene;
  scene.data_ = std::make_shared<Data>(translated([&] { return Data{read_scene(path, overrides_of(set))}; }));
  return scene;
}

Scene Scene::from_text(const std::string& yaml, const std::string& folder, const Settings& set) {
  const std::string path = folder == "." ? "scene" : (std::filesystem::path(folder) / "scene").string();
  Scene scene;
  scene.data_ = std::make_shared<Data>(translated([&] { return Data{read_scene_text(yaml, path, overrides_of(set))}; }));
  return scene;
}

const std::string& Scene::title() const { return data_->scene.title; }
std::int64_t Scene::body_count() const { return data_->scene.body_count(); }
std::int64_t Scene::frames() const { return data_->scene.time.frames; }
int Scene::substeps() const { return data_->scene.time.substeps; }

std::vector<std::int64_t> Scene::ids(const std::string& name) const {
  return translated([&] { return ids_named(data_->scene, name); });
}

std::string Scene::body_name(std::int64_t id) const {
  if (id < 0 || id >= body_count())
    throw InputError("found body " + std::to_string(id) + ", expected an id from 0 to " + std::to_string(body_count() - 1));
  return data_->scene.body_name(id);
}

struct Simulation::Data {
  Data(MPI_Comm comm, const unibody::Scene& scene, const std::string& checkpoint, const std::string& continue_from)
      : live(comm, scene, checkpoint, continue_from) {}
  LiveSimulation live;
};

Simulation::Simulation(MPI_Comm comm, const Scene& scene, const std::string& checkpoint, const std::string& continue_from)
    : data_(translated([&] {
        Scene::Data& read = *scene.data_;
        if (!read.knows_mesh_sides) decide_mesh_sides(comm, read.scene, read.scene.notes);
        read.knows_mesh_sides = true;
        return std::make_unique<Data>(comm, read.scene, checkpoint, continue_from);
      })) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

void Simulation::step(int count) {
  if (count < 0) throw InputError("step: found " + std::to_string(count) + " steps, expected 0 or more");
  translated([&] {
    for (int k = 0; k < count; ++k) data_->live.step();
  });
}

double Simulation::time() const { return data_->live.time(); }
double Simulation::step_length() const { return data_->live.step_length(); }
std::int64_t Simulation::steps_done() const { return data_->live.steps_done(); }
const std::vector<StepReport>& Simulation::report() const { return data_->live.report(); }

std::vector<double> Simulation::all(Field field) const {
  return translated([&] { return data_->live.gathered(field); });
}
std::vector<std::int64_t> Simulation::home_ids() const { return data_->live.home_ids(); }
std::vector<double> Simulation::home(Field field) const { return data_->live.of_homes(field); }

std::vector<Contact> Simulation::contacts() {
  return translated([&] { return data_->live.contacts(); });
}
std::vector<ContactForce> Simulation::contact_forces() const { return data_->live.contact_forces(); }

std::vector<JointForce> Simulation::joints() const {
  return translated([&] {
    std::vector<JointForce> list;
    for (const JointState& s : data_->live.joint_states()) {
      JointForce& joint =
          list.emplace_back(JointForce{s.coordinate, s.drift, s.turn, {}, {}, s.limit, s.motor, s.friction, s.spring, s.broken});
      copy(s.force, joint.force), copy(s.torque, joint.torque);
    }
    return list;
  });
}

Energies Simulation::energies() {
  const Measures m = translated([&] { return data_->live.measures(); });
  Energies energies{m.kinetic_energy, m.potential_energy, {}, {}, m.penetration_max, m.penetration_rms, m.pairs, m.contacts};
  copy(m.linear_momentum, energies.linear_momentum.data()), copy(m.angular_momentum, energies.angular_momentum.data());
  return energies;
}

std::vector<std::pair<std::string, double>> Simulation::probe(const std::string& name) const {
  return translated([&] { return data_->live.probe(name); });
}

void Simulation::set_velocities(std::span<const std::int64_t> ids, std::span<const double> linear,
                                std::span<const double> angular) {
  translated([&] { data_->live.set_velocities(ids, linear, angular); });
}

void Simulation::apply_forces(std::span<const std::int64_t> ids, std::span<const double> forces,
                              std::span<const double> torques) {
  translated([&] { data_->live.apply_forces(ids, forces, torques); });
}

void Simulation::set_motor(std::int64_t joint, double target) {
  translated([&] { data_->live.set_motor(joint, target); });
}

void Simulation::write_checkpoint(const std::string& path) const {
  translated([&] { data_->live.write_checkpoint(path); });
}

void Simulation::restore(const std::string& checkpoint) {
  translated([&] { data_->live.restore(checkpoint); });
}

std::string Simulation::state_hash() const {
  return hex(translated([&] { return data_->live.state_hash(); }));
}

std::string version() { return version_text(); }

}  // namespace unibody::api
