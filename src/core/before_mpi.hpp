#pragma once

namespace unibody {

// Tells Open MPI how to treat files and how to start: by its environment variables, which it reads in MPI_Init. Whatever starts
// MPI calls this just before. A variable that the user has set keeps its value.
//
// Files. Open MPI gives each file a pointer that all ranks share, which nothing here uses, but which it can't do without. Its
// usual way to keep such a pointer is a semaphore of the machine that is named after the file's base name: all runs write a
// `frames.h5`, and one that is killed while it holds the semaphore would stop every later run for ever. This way is turned off;
// what is left is a file beside the other one, which h5::create_file() removes.
//
// Start. A process that no mpirun and no srun has started is the only rank of its run. Open MPI would start a daemon for it,
// which this process has no use for, and would make a folder among the machine's temporary files, which all runs of the user
// share and the last one removes. Where one run ends at the moment at which another starts, as happens in a study of many small
// runs, the second one then fails in MPI_Init, because the first has just removed the folder. Such a process does without both.
void choose_for_mpi();

}  // namespace unibody
