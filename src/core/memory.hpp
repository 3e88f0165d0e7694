// The memory that there is to run in.
#pragma once

namespace unibody {

// Bytes of main memory of this machine, or of the control group that the process is in where that has less.
double bytes_of_machine();

// Bytes that this process may take in all (ulimit -v); infinite where nothing bounds them.
double bytes_of_process();

}  // namespace unibody
