// Bodies and frames as every program measured here records them: the layout of Unibody's frames.h5, read and written anew so
// that nothing of the simulator takes part in judging it.
#pragma once

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

namespace rivals {

using Vec3 = Eigen::Vector3d;
using Quat = Eigen::Quaterniond;

enum class Shape : std::int8_t { sphere = 0, box = 1, plane = 2, disc = 3 };
enum class Motion : std::int8_t { dynamic = 0, fixed = 1, kinematic = 2 };

// What does not change during a run. All arrays have one entry per body.
struct Bodies {
  std::vector<Shape> shape;
  std::vector<Vec3> size;  // m; sphere, disc: radius in x; box: half edges; plane: unused
  std::vector<double> mass;
  std::vector<Vec3> inertia;  // kg m^2, principal, body frame
  std::vector<Motion> motion;

  std::size_t count() const { return shape.size(); }
  bool is_dynamic(std::size_t i) const { return motion[i] == Motion::dynamic; }
};

struct Frame {
  std::vector<Vec3> position;          // m; for a plane any point of it
  std::vector<Quat> orientation;       // body -> world; a plane's normal is its local z
  std::vector<Vec3> velocity;          // m/s
  std::vector<Vec3> angular_velocity;  // rad/s, world frame

  void resize(std::size_t n) { position.resize(n), orientation.resize(n), velocity.resize(n), angular_velocity.resize(n); }
};

// A frames.h5 open for reading. Errors are std::runtime_error that name the file.
class FrameReader {
 public:
  explicit FrameReader(const std::string& path);
  ~FrameReader();
  FrameReader(const FrameReader&) = delete;
  FrameReader& operator=(const FrameReader&) = delete;

  Bodies bodies() const;
  const std::vector<long>& frames() const { return numbers_; }  // ascending
  void read(long number, Frame& frame) const;

 private:
  template <typename T>
  void read_array(const std::string& name, std::size_t columns, std::vector<T>& values) const;

  std::string path_;
  std::int64_t file_;
  std::vector<long> numbers_;
};

// A new frames.h5. `single` stores floats.
class FrameWriter {
 public:
  FrameWriter(const std::string& path, const Bodies& bodies, bool single);
  ~FrameWriter();
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  void write(long number, const Frame& frame);

 private:
  std::int64_t file_;
  bool single_;
};

}  // namespace rivals
