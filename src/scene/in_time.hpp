// Values of a scene that may change in time.
#pragma once

#include "core/time_value.hpp"
#include "scene/key.hpp"

namespace unibody {

struct Scene;

// A number; a table [[time (s), value], ...]; a map with `table` and perhaps `between` and `periodic`; a map with `sine`; or one
// with `expression`. Values are multiplied by `factor` (degrees). An expression is tried at all times of the scene's run, whose
// section `time` has been read.
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
