#include "report/contact_file.hpp"

#include <filesystem>
#include <stdexcept>

#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "partition/messages.hpp"
#include "report/loaded_bodies.hpp"

namespace unibody {

namespace {

constexpr int tag_contacts = 182;

// Writes arrays of one row a point of contact, and remembers whether all went well.
struct ArrayWriter {
  hid_t group;
  const std::vector<ContactImpulse>& contacts;
  bool good = true;

  // numbers(contact): a list of `columns` numbers.
  template <class T, class F>
  void write(const char* name, hid_t file_type, hid_t memory_type, std::size_t columns, std::size_t rows_each, F&& numbers) {
    std::vector<T> all;
    all.reserve(contacts.size() * columns * rows_each);
    for (const ContactImpulse& contact : contacts)
      for (const T x : numbers(contact)) all.push_back(x);
    const auto rows = static_cast<hsize_t>(contacts.size() * rows_each);
    const auto dataset = h5::create_dataset(group, name, file_type, rows, columns == 1 ? 0 : columns);
    good = h5::write_rows(dataset, memory_type, 0, rows, all.data()) && good;
  }
  template <class F>
  void reals(const char* name, std::size_t columns, F&& numbers) {
    write<double>(name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, columns, 1, numbers);
  }
};

std::array<double, 3> list(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

bool write_bodies(hid_t group, const std::vector<LoadedBody>& bodies) {
  std::vector<std::int64_t> ids;
  std::vector<std::int32_t> coordination;
  std::vector<double> stress;
  for (const LoadedBody& body : bodies) {
    ids.push_back(body.id), coordination.push_back(body.coordination);
    stress.insert(stress.end(), body.stress.begin(), body.stress.end());
  }
  const auto rows = static_cast<hsize_t>(bodies.size());
  const auto a = h5::create_dataset(group, "body_ids", H5T_STD_I64LE, rows, 0);
  const auto b = h5::create_dataset(group, "coordination", H5T_STD_I32LE, rows, 0);
  const auto c = h5::create_dataset(group, "body_stress", H5T_IEEE_F64LE, rows, 6);
  bool good = h5::write_rows(a, H5T_NATIVE_INT64, 0, rows, ids.data());
  good = h5::write_rows(b, H5T_NATIVE_INT32, 0, rows, coordination.data()) && good;
  return h5::write_rows(c, H5T_NATIVE_DOUBLE, 0, rows, stress.data()) && good;
}

}  // namespace

template <class F>
void ContactFile::on_first_rank(F&& f) {
  std::string fault;
  if (rank_ == 0) try {
      const h5::Quiet quiet;
      f();
    } catch (const std::runtime_error& e) {
      fault = "cannot write contacts in '" + directory_ + "': " + e.what();
    }
  fault = first_fault(comm_, fault);
  if (!fault.empty()) throw RunError(fault);
}

ContactFile::ContactFile(MPI_Comm comm, const std::string& directory, const Scene& scene, std::int64_t kept_to)
    : comm_(comm), directory_(directory), scene_(scene) {
  check_mpi(MPI_Comm_rank(comm, &rank_));
  on_first_rank([&] { open(kept_to); });
  std::int64_t count = static_cast<std::int64_t>(kept_.size());
  check_mpi(MPI_Bcast(&count, 1, MPI_INT64_T, 0, comm));
  kept_.resize(static_cast<std::size_t>(count));
  check_mpi(MPI_Bcast(kept_.data(), static_cast<int>(count), MPI_INT64_T, 0, comm));
}

void ContactFile::open(std::int64_t kept_to) {
  const std::string path = directory_ + "/contacts.h5";
  if (!xdmf_.start(directory_ + "/contacts.xdmf")) throw std::runtime_error("contacts.xdmf");
  if (kept_to < 0 || !std::filesystem::exists(path)) {
    file_ = h5::create_file(MPI_COMM_SELF, path);
    h5::write_attribute(file_, "format", std::string("unibody contacts 1"));
    frames_.create(MPI_COMM_SELF, file_, path);
    return;
  }
  file_ = h5::open_file_to_extend(MPI_COMM_SELF, path);
  frames_.extend(MPI_COMM_SELF, file_, path, kept_to);
  kept_ = frames_.kept();
  for (const std::int64_t frame : kept_) {
    const h5::Handle group(H5Gopen2(frames_, h5::numbered(frame).c_str(), H5P_DEFAULT), H5Gclose, "open a frame");
    const auto count = h5::dimensions(h5::open_dataset(group, "ids"))[0];
    if (!draw(frame, h5::read_double(group, "time"), static_cast<Id>(count))) throw std::runtime_error("contacts.xdmf");
  }
}

void ContactFile::close() {
  on_first_rank([&] {
    bool good = frames_.close();
    good = file_.close() >= 0 && good;
    if (!xdmf_.close() || !good) throw std::runtime_error("is the disk full?");
  });
}

void ContactFile::write(std::int64_t frame, double time, std::span<const ContactImpulse> impulses, double step) {
  const ListsByRank<ContactImpulse> to{{0, {impulses.begin(), impulses.end()}}};
  std::vector<ContactImpulse> contacts = joined(exchange_lists(comm_, to, tag_contacts));
  // All points of the same bodies come from one rank, in their order.
  std::ranges::stable_sort(contacts, {}, &ContactImpulse::ids);
  on_first_rank([&] { write_rows(frame, time, contacts, step); });
}

void ContactFile::write_rows(std::int64_t frame, double time, const std::vector<ContactImpulse>& contacts, double step) {
  const auto group = h5::create_unlinked_group(file_);
  ArrayWriter out{group, contacts};
  out.write<std::int64_t>("ids", H5T_STD_I64LE, H5T_NATIVE_INT64, 4, 1, [](const auto& c) { return c.ids; });
  out.reals("shares", 4, [](const auto& c) { return c.shares; });
  out.reals("point", 3, [](const auto& c) { return list(c.point); });
  out.reals("normal", 3, [](const auto& c) { return list(c.normal); });
  out.reals("force", 3, [&](const auto& c) { return list(c.impulse / step); });
  out.reals("normal_force", 1, [&](const auto& c) { return std::array{c.normal.dot(c.impulse) / step}; });
  out.reals("friction", 1, [](const auto& c) { return std::array{c.friction}; });
  out.write<double>("places", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 3, 2, [](const auto& c) {
    const Vec3 &a = c.sides[0], &b = c.sides[1];
    return std::array{a.x(), a.y(), a.z(), b.x(), b.y(), b.z()};
  });
  std::int64_t next = 0;
  out.write<std::int64_t>("lines", H5T_STD_I64LE, H5T_NATIVE_INT64, 2, 1, [&](const auto&) {
    next += 2;
    return std::array{next - 2, next - 1};
  });
  const auto bodies = loaded_bodies(contacts, scene_, step);
  out.good = write_bodies(group, bodies) && out.good;
  h5::write_attribute(group, "time", time);
  h5::write_attribute(group, "frame", frame);
  const bool written = out.good && frames_.add(group, frame);
  if (!written || !draw(frame, time, static_cast<Id>(contacts.size()))) throw std::runtime_error("is the disk full?");
}

// A frame in which nothing touches is not drawn: readers take arrays without rows for faults.
bool ContactFile::draw(std::int64_t frame, double time, Id count) {
  if (count == 0) return true;
  const auto item = [&](const char* name, Id rows, int columns, const char* type) {
    return xdmf_item("contacts.h5", "/frames/" + h5::numbered(frame) + "/" + name, rows, columns, type, 8);
  };
  std::string grid = "    <Grid Name=\"contacts\" GridType=\"Uniform\">\n" + xdmf_time(time);
  grid += "      <Topology TopologyType=\"Polyline\" NodesPerElement=\"2\" NumberOfElements=\"" + std::to_string(count) + "\">" +
          item("lines", count, 2, "Int") + "</Topology>\n";
  grid += "      <Geometry GeometryType=\"XYZ\">" + item("places", 2 * count, 3, "Float") + "</Geometry>\n";
  grid += xdmf_attribute("force", "Vector", "Cell", item("force", count, 3, "Float"));
  grid += xdmf_attribute("normal", "Vector", "Cell", item("normal", count, 3, "Float"));
  grid += xdmf_attribute("normal_force", "Scalar", "Cell", item("normal_force", count, 1, "Float"));
  grid += "    </Grid>\n";
  return xdmf_.append(grid);
}

}  // namespace unibody
