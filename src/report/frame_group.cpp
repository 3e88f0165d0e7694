#include "report/frame_group.hpp"

#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "core/checked.hpp"

namespace unibody {

namespace {

constexpr const char* group_name = "frames";
constexpr const char* whole = "=";

#if H5_VERSION_GE(1, 12, 0)
using ObjectInfo = H5O_info1_t;
#else
using ObjectInfo = H5O_info_t;
#endif

// The line of the list that says where in the file a frame lies.
std::string line_of(hid_t object, std::int64_t frame) {
  ObjectInfo info{};
  h5::check(H5Oget_info2(object, &info, H5O_INFO_BASIC), "find where a frame lies");
  return std::to_string(frame) + " " + std::to_string(info.addr) + "\n";
}

h5::Handle open_frame(hid_t group, std::int64_t frame) {
  return {H5Oopen(group, h5::numbered(frame).c_str(), H5P_DEFAULT), H5Oclose, "open frame " + std::to_string(frame)};
}

struct List {
  std::vector<std::pair<std::int64_t, haddr_t>> frames;
  bool is_whole = true;  // nothing was being changed
};

List read_list(const std::string& path) {
  List list;
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line) && !file.eof()) {  // a line without its end was being written, and nothing had followed it
    list.is_whole = line == whole;
    std::istringstream words(line);
    std::int64_t frame = 0;
    haddr_t address = 0;
    if (words >> frame >> address) list.frames.emplace_back(frame, address);
  }
  return list;
}

}  // namespace

bool FrameGroup::is_first() const {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm_, &rank));
  return rank == 0;
}

// One write: a kill leaves all of it or none.
bool FrameGroup::note(const std::string& text) {
  check_mpi(MPI_Barrier(comm_));  // what the list says of the file has come true on all ranks
  if (!is_first()) return true;
  std::FILE* list = std::fopen(list_.c_str(), "a");
  if (list == nullptr) return false;
  const bool good = std::fwrite(text.data(), 1, text.size(), list) == text.size();
  return std::fclose(list) == 0 && good;
}

void FrameGroup::create(MPI_Comm comm, hid_t file, const std::string& path) {
  comm_ = comm, file_ = file, list_ = path + ".links";
  if (is_first()) std::remove(list_.c_str());
  group_ = h5::create_group(file, group_name);
  h5::check(H5Fflush(file, H5F_SCOPE_GLOBAL), "write " + path);
  if (!note(std::string(whole) + "\n")) throw std::runtime_error("cannot write " + list_);
}

void FrameGroup::extend(MPI_Comm comm, hid_t file, const std::string& path, std::int64_t kept_to) {
  comm_ = comm, file_ = file, list_ = path + ".links";
  group_ = h5::Handle(H5Gopen2(file, group_name, H5P_DEFAULT), H5Gclose, "open group frames");
  std::vector<std::int64_t> left_out;
  std::string list;
  for (const std::int64_t frame : h5::member_numbers(file, group_name)) {
    (frame > kept_to ? left_out : kept_).push_back(frame);
    if (frame <= kept_to) list += line_of(open_frame(group_, frame), frame);
  }
  if (is_first()) {
    std::ofstream fresh(list_ + ".part");
    fresh << list << (left_out.empty() ? "=\n" : "");
    fresh.close();
    if (!fresh || std::rename((list_ + ".part").c_str(), list_.c_str()) != 0) throw std::runtime_error("cannot write " + list_);
  }
  check_mpi(MPI_Barrier(comm));
  for (const std::int64_t frame : left_out) h5::remove_link(group_, h5::numbered(frame));
  h5::check(H5Fflush(file, H5F_SCOPE_GLOBAL), "write " + path);
  if (!left_out.empty() && !note("=\n")) throw std::runtime_error("cannot write " + list_);
}

// All calls are collective: a rank on which one of them has failed makes the others too.
bool FrameGroup::add(hid_t object, std::int64_t frame) {
  const auto flush = [this] { return H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0; };
  bool good = flush();
  good = note(line_of(object, frame)) && good;
  check_mpi(MPI_Barrier(comm_));
  good = H5Olink(object, group_, h5::numbered(frame).c_str(), H5P_DEFAULT, H5P_DEFAULT) >= 0 && good;
  good = flush() && good;
  return note("=\n") && good;
}

bool FrameGroup::close() {
  if (comm_ == MPI_COMM_NULL) return true;
  const bool good = group_.close() >= 0 && H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0;
  check_mpi(MPI_Barrier(comm_));
  const bool removed = !is_first() || std::remove(list_.c_str()) == 0;
  comm_ = MPI_COMM_NULL;
  return good && removed;
}

bool FrameGroup::mend(const std::string& path) {
  const List list = read_list(path + ".links");
  if (list.is_whole) return false;
  const h5::Quiet quiet;
  const h5::Handle file = h5::open_file_to_mend(path);
  const h5::Handle group = h5::create_unlinked_group(file);
  for (const auto& [frame, address] : list.frames) {
    const h5::Handle object(H5Oopen_by_addr(file, address), H5Oclose, "open frame " + std::to_string(frame));
    h5::check(H5Olink(object, group, h5::numbered(frame).c_str(), H5P_DEFAULT, H5P_DEFAULT), "name a frame");
  }
  h5::check(H5Fflush(file, H5F_SCOPE_GLOBAL), "write " + path);
  {  // The old group stays without a name: to give back its room HDF5 would have to read it.
    const h5::Handle old(H5Gopen2(file, group_name, H5P_DEFAULT), H5Gclose, "open group frames");
    h5::check(H5Oincr_refcount(old), "keep the old group");
  }
  h5::remove_link(file, group_name);
  h5::check(H5Olink(group, file, group_name, H5P_DEFAULT, H5P_DEFAULT), "name the group");
  h5::check(H5Fflush(file, H5F_SCOPE_GLOBAL), "write " + path);
  return true;
}

}  // namespace unibody
