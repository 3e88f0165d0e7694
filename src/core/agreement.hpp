// What one rank finds wrong is an error of all: otherwise the others would wait for it.
#pragma once

#include <mpi.h>

#include <exception>
#include <string>

namespace unibody {

// Returns the first rank's non-empty fault, on every rank; empty when no rank has one. Collective. A rank that has a fault may
// have skipped a collective call in which the other ranks then wait for it. Such a rank waits ten seconds for the others to come
// here, and then ends the program on all ranks with exit code 3.
std::string first_fault(MPI_Comm comm, const std::string& fault);

// Runs `action` on every rank. Where it throws on any, throws Error(what + the first such rank's message) on every rank. `action`
// may only be collective where its collective parts cannot throw on some ranks alone. Collective.
template <class Error, class Action>
void agree(MPI_Comm comm, const std::string& what, Action&& action) {
  std::string fault;
  try {
    action();
  } catch (const std::exception& error) {
    fault = what + error.what();
  }
  fault = first_fault(comm, fault);
  if (!fault.empty()) throw Error(fault);
}

}  // namespace unibody
