// Errors that a user can act on. Each kind has its exit code; main prints what() once and every rank returns the code.
#pragma once

#include <stdexcept>
#include <string>

namespace unibody {

// Bad scene, option or file: the run never starts and nothing is written. Exit code 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The state became impossible (NaN, Inf) or the disk failed while running. Exit code 3; the last checkpoint is kept.
struct RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace unibody
