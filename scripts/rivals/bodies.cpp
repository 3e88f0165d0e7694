#include "bodies.hpp"

#include <hdf5.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace rivals {

namespace {

template <typename T>
hid_t memory_type();
template <>
hid_t memory_type<double>() {
  return H5T_NATIVE_DOUBLE;
}
template <>
hid_t memory_type<std::int8_t>() {
  return H5T_NATIVE_INT8;
}

std::string group_of(long number) {
  char name[32];
  std::snprintf(name, sizeof name, "/frames/%06ld/", number);
  return name;
}

herr_t collect_number(hid_t, const char* name, const H5L_info_t*, void* numbers) {
  static_cast<std::vector<long>*>(numbers)->push_back(std::strtol(name, nullptr, 10));
  return 0;
}

std::vector<Vec3> to_vectors(const std::vector<double>& values) {
  std::vector<Vec3> result(values.size() / 3);
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
  return result;
}

std::vector<double> to_values(const std::vector<Vec3>& vectors) {
  std::vector<double> result;
  result.reserve(3 * vectors.size());
  for (const auto& v : vectors) result.insert(result.end(), v.data(), v.data() + 3);
  return result;
}

template <typename T>
void write_array(hid_t place, const char* name, hid_t stored, hsize_t columns, const std::vector<T>& values) {
  const hsize_t dims[2] = {values.size() / columns, columns};
  const hid_t space = H5Screate_simple(columns == 1 ? 1 : 2, dims, nullptr);
  const hid_t set = H5Dcreate2(place, name, stored, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const herr_t status = set < 0 ? -1 : H5Dwrite(set, memory_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  if (set >= 0) H5Dclose(set);
  H5Sclose(space);
  if (status < 0) throw std::runtime_error(std::string("cannot write '") + name + "' (disk full?)");
}

}  // namespace

FrameReader::FrameReader(const std::string& path) : path_(path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  file_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file_ < 0) throw std::runtime_error("cannot open '" + path + "' as an HDF5 file");
  H5Literate_by_name(file_, "/frames", H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, collect_number, &numbers_, H5P_DEFAULT);
  std::sort(numbers_.begin(), numbers_.end());
  if (numbers_.empty()) {
    H5Fclose(file_);
    throw std::runtime_error("no frames in '" + path + "'");
  }
}

FrameReader::~FrameReader() { H5Fclose(file_); }

template <typename T>
void FrameReader::read_array(const std::string& name, std::size_t columns, std::vector<T>& values) const {
  const hid_t set = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
  if (set < 0) throw std::runtime_error("no dataset '" + name + "' in '" + path_ + "'");
  const hid_t space = H5Dget_space(set);
  const hssize_t points = H5Sget_simple_extent_npoints(space);
  values.resize(static_cast<std::size_t>(points));
  const herr_t status = H5Dread(set, memory_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Sclose(space);
  H5Dclose(set);
  if (status < 0 || values.size() % columns != 0) throw std::runtime_error("cannot read '" + name + "' in '" + path_ + "'");
}

Bodies FrameReader::bodies() const {
  Bodies result;
  std::vector<std::int8_t> bytes;
  std::vector<double> values;
  read_array("/bodies/shape", 1, bytes);
  for (const auto b : bytes) result.shape.push_back(static_cast<Shape>(b));
  read_array("/bodies/motion", 1, bytes);
  for (const auto b : bytes) result.motion.push_back(static_cast<Motion>(b));
  read_array("/bodies/size", 3, values);
  result.size = to_vectors(values);
  read_array("/bodies/inertia", 3, values);
  result.inertia = to_vectors(values);
  read_array("/bodies/mass", 1, result.mass);
  const std::size_t n = result.count();
  if (result.motion.size() != n || result.size.size() != n || result.inertia.size() != n || result.mass.size() != n)
    throw std::runtime_error("the arrays of /bodies in '" + path_ + "' differ in length");
  return result;
}

void FrameReader::read(long number, Frame& frame) const {
  const std::string group = group_of(number);
  std::vector<double> values;
  read_array(group + "position", 3, values);
  frame.position = to_vectors(values);
  read_array(group + "velocity", 3, values);
  frame.velocity = to_vectors(values);
  read_array(group + "angular_velocity", 3, values);
  frame.angular_velocity = to_vectors(values);
  read_array(group + "orientation", 4, values);
  frame.orientation.clear();
  for (std::size_t i = 0; i + 3 < values.size(); i += 4)
    frame.orientation.emplace_back(Quat(values[i], values[i + 1], values[i + 2], values[i + 3]).normalized());
  const std::size_t n = frame.position.size();
  if (frame.velocity.size() != n || frame.angular_velocity.size() != n || frame.orientation.size() != n)
    throw std::runtime_error("the arrays of " + group + " in '" + path_ + "' differ in length");
}

FrameWriter::FrameWriter(const std::string& path, const Bodies& bodies, bool single) : single_(single) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  if (file_ < 0) throw std::runtime_error("cannot create '" + path + "'");
  for (const char* name : {"/bodies", "/frames"}) H5Gclose(H5Gcreate2(file_, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  std::vector<std::int8_t> bytes;
  for (const auto s : bodies.shape) bytes.push_back(static_cast<std::int8_t>(s));
  write_array(file_, "/bodies/shape", H5T_STD_I8LE, 1, bytes);
  bytes.clear();
  for (const auto m : bodies.motion) bytes.push_back(static_cast<std::int8_t>(m));
  write_array(file_, "/bodies/motion", H5T_STD_I8LE, 1, bytes);
  write_array(file_, "/bodies/size", H5T_IEEE_F64LE, 3, to_values(bodies.size));
  write_array(file_, "/bodies/inertia", H5T_IEEE_F64LE, 3, to_values(bodies.inertia));
  write_array(file_, "/bodies/mass", H5T_IEEE_F64LE, 1, bodies.mass);
}

FrameWriter::~FrameWriter() { H5Fclose(file_); }

void FrameWriter::write(long number, const Frame& frame) {
  const hid_t stored = single_ ? H5T_IEEE_F32LE : H5T_IEEE_F64LE;
  const hid_t group = H5Gcreate2(file_, group_of(number).c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  if (group < 0) throw std::runtime_error("cannot write frame " + std::to_string(number));
  std::vector<double> orientation;
  for (const auto& q : frame.orientation) orientation.insert(orientation.end(), {q.w(), q.x(), q.y(), q.z()});
  write_array(group, "position", stored, 3, to_values(frame.position));
  write_array(group, "orientation", stored, 4, orientation);
  write_array(group, "velocity", stored, 3, to_values(frame.velocity));
  write_array(group, "angular_velocity", stored, 3, to_values(frame.angular_velocity));
  H5Gclose(group);
}

}  // namespace rivals
