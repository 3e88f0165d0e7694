// What a scene wants to happen when something else has happened.
#pragma once

#include <string>

namespace unibody {

// Ends the run after the first frame in which a column of report.csv is below, or above, a value.
struct EndEvent {
  std::string column;  // with or without its unit
  double value = 0;    // in the column's unit
  bool above = false;  // else below
  double after = 0;    // s: frames up to this time do not count
  std::string place;   // "FILE:LINE: key 'events[0].when.column'", for errors

  bool holds(double time, double of_column) const { return time > after && (above ? of_column > value : of_column < value); }
};

}  // namespace unibody
