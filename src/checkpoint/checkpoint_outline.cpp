#include "checkpoint/checkpoint_outline.hpp"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "core/checked.hpp"

namespace unibody {

namespace {

constexpr const char* outline_table = "scene";  // a text, byte by byte: attributes are too small for many names

std::string text_of(const SceneOutline& outline) {
  std::ostringstream text;
  text << "planar " << outline.planar << "\nlacks " << outline.lacks_bodies << '\n';
  for (const std::string& material : outline.materials) text << "material " << material << '\n';
  for (const auto& entry : outline.entries) text << "entry " << entry.first << ' ' << entry.count << ' ' << entry.name << '\n';
  for (const auto& joint : outline.broken) text << "broken " << joint.ids[0] << ' ' << joint.ids[1] << ' ' << joint.kind << '\n';
  return text.str();
}

}  // namespace

bool write_outline(MPI_Comm comm, hid_t file, const SceneOutline& outline) {
  const std::string text = text_of(outline);
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  const auto dataset = h5::create_dataset(file, outline_table, H5T_STD_U8LE, text.size(), 1);
  return h5::write_rows(dataset, H5T_NATIVE_UINT8, 0, rank == 0 ? text.size() : 0, text.data());
}

SceneOutline read_outline(hid_t file, Id bodies) {
  if (!h5::has_link(file, outline_table)) throw std::runtime_error("it does not name its bodies (an earlier version wrote it)");
  const auto dataset = h5::open_table(file, outline_table, {}, 1, H5T_STD_U8LE);
  std::string text(h5::rows_of(dataset), '\0');
  h5::read_rows(dataset, H5T_NATIVE_UINT8, 0, text.size(), text.data());
  SceneOutline outline;
  std::istringstream lines(text);
  Id next = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "planar") {
      words >> outline.planar;
    } else if (kind == "lacks") {
      words >> outline.lacks_bodies;
    } else if (kind == "material") {
      std::getline(words >> std::ws, outline.materials.emplace_back());
    } else if (kind == "broken") {
      SceneOutline::BrokenJoint& joint = outline.broken.emplace_back();
      words >> joint.ids[0] >> joint.ids[1] >> joint.kind;
      if (!words || std::ranges::any_of(joint.ids, [&](Id id) { return id < -1 || id >= bodies; }))
        throw std::runtime_error("its broken joints are none");
    } else {
      SceneOutline::Entry& entry = outline.entries.emplace_back();
      words >> entry.first >> entry.count;
      if (kind != "entry" || !words || entry.first != next || entry.count < 0 || entry.count > bodies - next)
        throw std::runtime_error("its entries of bodies are none");
      words.get();
      std::getline(words, entry.name);
      next = entry.first + entry.count;
    }
  }
  if (next != bodies) throw std::runtime_error("its entries of bodies are none");
  return outline;
}

}  // namespace unibody
