// A run that is asked to stop ends at the next frame with a checkpoint, and can go on from there.
#pragma once

#include <mpi.h>

#include <string>

namespace unibody {

class StopRequest {
 public:
  // wall_limit: s from now on; 0: none. From now on the signals TERM, INT and USR1 ask the run to stop, and nothing else; a
  // second INT ends the program at once. One object at a time.
  StopRequest(MPI_Comm comm, double wall_limit);
  ~StopRequest();
  StopRequest(const StopRequest&) = delete;
  StopRequest& operator=(const StopRequest&) = delete;

  // After a frame: why the run should stop, empty where it should go on. Some rank was sent a signal, or a frame as long as the
  // longest so far would pass the limit. The same on every rank. Collective.
  std::string reason();

 private:
  MPI_Comm comm_;
  double start_ = 0, limit_ = 0, before_ = 0, longest_ = 0;  // s
};

// The wall time (s) that "3h55m", "90m", "45s", "1h2m3s" or a number of seconds stands for. Throws InputError.
double wall_time_of(const std::string& option, const std::string& text);

}  // namespace unibody
