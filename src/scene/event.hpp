// What a scene wants to happen, at a time or when something else has happened.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/time_value.hpp"

namespace unibody {

// A column of report.csv is below, or above, a value.
struct ColumnCondition {
  std::string column;  // with or without its unit
  double value = 0;    // in the column's unit
  bool above = false;  // else below
  double after = 0;    // s: frames up to this time do not count
  std::string place;   // "FILE:LINE: key 'events[0].when.column'", for errors

  bool holds(double time, double of_column) const { return time > after && (above ? of_column > value : of_column < value); }
};

// Happens once: at the start of the first frame that begins at its time or later, or of the one after the first frame at whose
// end its condition holds. Values in time count from there.
struct Event {
  enum class Action : std::uint8_t {
    end,       // ends the run
    add,       // of bodies that are absent: they are there, as they were at the start
    remove,    // of bodies: they are absent
    fix,       // of dynamic bodies: they are held where they are
    release,   // of bodies that are held: they move freely, from rest; of joints: they do nothing any more
    motor,     // of joints: gives their motors another target
    friction,  // of two materials: gives them another coefficient
  };
  Action action = Action::end;
  double time = std::numeric_limits<double>::infinity();  // s; unused beside a condition
  std::optional<ColumnCondition> when;
  std::vector<std::size_t> groups;  // of Scene::groups: whose bodies it is about
  std::vector<std::size_t> joints;  // of Scene::joints
  std::array<int, 2> materials{};   // two different ones
  TimeValue value;                  // the motors' target (rad/s, m/s, rad or m), or the coefficient
};

}  // namespace unibody
