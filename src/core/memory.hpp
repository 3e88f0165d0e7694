// The memory that there is to run in.
#pragma once

namespace unibody {

// Bytes of main memory of this machine, or of the control group that the process is in where that has less.
double bytes_of_machine();

// Bytes that this process may take in all (ulimit -v); infinite where nothing bounds them.
double bytes_of_process();

// Lets the process give memory that it has freed back to the machine. Libraries that PETSc may be linked with forbid that as they
// are loaded (SuperLU_DIST asks malloc for it), and a run would keep for good what its start alone needs.
void give_freed_memory_back();

}  // namespace unibody
