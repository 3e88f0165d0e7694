#pragma once

namespace unibody {

// What Open MPI is to do, told in its environment variables, which it reads in MPI_Init: to be called just before that, by
// whatever starts MPI. A variable that the user has set keeps his value.
//
// Files. Open MPI gives each file a pointer that all ranks share, which nothing here uses, but which it can't do without. Its
// usual way to keep such a pointer is a semaphore of the machine that is named after the file's base name: all runs write a
// `frames.h5`, and one that is killed while it holds the semaphore would stop every later run for ever. This way is turned off;
// what is left is a file beside the other one, which h5::create_file() removes.
//
// A process that no mpirun and no srun has started is the only rank of its run. Open MPI would start a daemon for it, which it
// has no use for, and make a folder for the user's runs in the machine's folder for temporary files, if there is none, and
// remove it, if it is empty: of two runs that start and end at the same moment, as they do in a study of many small runs, one
// then ends in MPI_Init, because the other has just removed its folder. Such a process does without both.
void choose_for_mpi();

}  // namespace unibody
