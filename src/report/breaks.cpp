#include "report/breaks.hpp"

#include <utility>

#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "core/text.hpp"

namespace unibody {

namespace {

std::vector<std::string> joint_texts(const Scene& scene) {
  std::vector<std::string> names(scene.joints.size());
  for (const auto& [name, joints] : scene.joints_named)
    for (const std::size_t joint : joints) names[joint] = name;
  return names;
}

std::string end_text(const Scene& scene, const Joint& joint, std::size_t end) {
  return joint.ids[end] < 0 ? "world" : scene.body_name(joint.ids[end]);
}

// A cell of a table: in quotes where it holds what would end it.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string told_breaks(const Scene& scene, const Past& past) {
  if (!scene.joints_break()) return {};
  const std::size_t count = past.breaks.size();
  std::string text = "joints: " + std::to_string(count) + " of " + std::to_string(scene.joints.size()) +
                     (count == 1 ? " has" : " have") + " broken";
  if (count > 0) {
    const Joint& first = scene.joints[static_cast<std::size_t>(past.breaks.front().joint)];
    text += ", the first at " + number_text(past.breaks.front().time, 4) + " s, between " + end_text(scene, first, 0) + " and " +
            end_text(scene, first, 1);
  }
  return text + "\n";
}

std::vector<NamedValue> break_columns(const Scene& scene, const Past& past) {
  if (!scene.joints_break()) return {};
  return {{"broken_joints (1)", static_cast<double>(past.breaks.size())}};
}

BreakFile::BreakFile(MPI_Comm comm, const std::string& directory, const Scene& scene)
    : comm_(comm), path_(directory + "/breaks.csv"), scene_(scene), names_(joint_texts(scene)) {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  bool bad = false;
  if (rank == 0) {
    csv_ = std::fopen(path_.c_str(), "w");
    bad = csv_ == nullptr || std::fputs("time (s),joint,name,type,body_a,body_b,force (N),torque (N m)\n", csv_) < 0;
  }
  fail_where(bad);
}

BreakFile::~BreakFile() {
  if (csv_ != nullptr) std::fclose(csv_);
}

void BreakFile::fail_where(bool bad) const {
  const std::string fault = first_fault(comm_, bad ? "cannot write '" + path_ + "': is the disk full?" : "");
  if (!fault.empty()) throw RunError(fault);
}

void BreakFile::write(const std::vector<Break>& breaks) {
  if (breaks.size() == written_) return;
  bool bad = false;
  for (; written_ < breaks.size(); ++written_) {
    if (csv_ == nullptr) continue;
    const Break& one = breaks[written_];
    const auto number = static_cast<std::size_t>(one.joint);
    const Joint& joint = scene_.joints[number];
    bad = std::fprintf(csv_, "%.17g,%zu,%s,%s,%s,%s,%.17g,%.17g\n", one.time, number, cell(names_[number]).c_str(),
                       joint_names[static_cast<std::size_t>(joint.kind)].data(), cell(end_text(scene_, joint, 0)).c_str(),
                       cell(end_text(scene_, joint, 1)).c_str(), one.force, one.torque) < 0 ||
          bad;
  }
  if (csv_ != nullptr) bad = std::fflush(csv_) != 0 || bad;
  fail_where(bad);
}

void BreakFile::close() { fail_where(csv_ != nullptr && std::fclose(std::exchange(csv_, nullptr)) != 0); }

}  // namespace unibody
