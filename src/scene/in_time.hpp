// Values of a scene that may change in time.
#pragma once

#include "core/time_value.hpp"
#include "scene/key.hpp"

namespace unibody {

struct Scene;

// Reads a value in time: a number, a table [[time (s), value], ...], or a map. The map has the key `table`, perhaps with
// `between` and `periodic`, or the key `sine`, or the key `expression`. The value is multiplied by `factor`, which turns degrees
// to radians. An expression is tried at the times of the scene's run, so the section `time` must have been read.
TimeValue read_in_time(const Value& value, const Scene& scene, const Range& range, const std::string& unit, double factor = 1);

// The value of a key that must be there, of the range and unit that its table says.
TimeValue read_in_time(const KeyedMap& map, std::string_view name, const Scene& scene, double factor = 1);

// A list of three of these, or a map whose `table` has rows [time (s), x, y, z].
TimeVector read_vector_in_time(const Value& value, const Scene& scene, const std::string& unit);

// The same; in a planar scene no component may leave the plane at any time. rotation: the vector is an axis of turning.
TimeVector read_planar_in_time(const Value& value, const Scene& scene, const std::string& unit, bool rotation);
TimeVector read_planar_in_time(const KeyedMap& map, std::string_view name, const Scene& scene, bool rotation);

// Whether a value is a vector that changes in time (a table, a sine), rather than three numbers.
bool is_vector_in_time(const Value& value);

namespace keys {

Key number_in_time(const char* name, const char* unit, const Range& range, const Without& without, const char* about);
Key vector_in_time(const char* name, const char* unit, const Without& without, const char* about);  // three of them

}  // namespace keys

}  // namespace unibody
