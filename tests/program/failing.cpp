// Preloaded into the program, makes one call of a library fail: UNIBODY_FAIL="NAME RANK N" is the N-th call (from 1) of NAME on
// that rank (-1: on all). The call is not made, and returns an error.
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <dlfcn.h>
#include <hdf5.h>
#include <metis.h>
#include <petscsf.h>
#include <petscvec.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

#undef MPI_Allreduce  // PETSc counts calls by macros
#undef MPI_Issend

namespace {

bool fails(const char* name) {
  static const char* const wish = std::getenv("UNIBODY_FAIL");
  static char function[64];
  static int rank = -1, number = 0, seen = 0;
  static const bool wished = wish != nullptr && std::sscanf(wish, "%63s %d %d", function, &rank, &number) == 3;
  if (!wished || std::strcmp(function, name) != 0) return false;
  const char* here = std::getenv("OMPI_COMM_WORLD_RANK");
  if (here == nullptr) here = std::getenv("PMI_RANK");  // of MPICH
  if (rank >= 0 && (here == nullptr || std::atoi(here) != rank)) return false;
  return ++seen == number;
}

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

#define PASS(name, failure, ...)                         \
  if (fails(#name)) return failure;                      \
  static auto* const next = real<decltype(name)>(#name); \
  return next(__VA_ARGS__)

extern "C" {

PetscErrorCode VecCreateMPIWithArray(MPI_Comm comm, PetscInt block, PetscInt n, PetscInt all, const PetscScalar array[], Vec* v) {
  PASS(VecCreateMPIWithArray, PETSC_ERR_MEM, comm, block, n, all, array, v);
}
PetscErrorCode PetscSFSetGraph(PetscSF forest, PetscInt roots, PetscInt leaves, PetscInt* local, PetscCopyMode local_mode,
                               PetscSFNode* remote, PetscCopyMode remote_mode) {
  PASS(PetscSFSetGraph, PETSC_ERR_MEM, forest, roots, leaves, local, local_mode, remote, remote_mode);
}
PetscErrorCode PetscSFBcastBegin(PetscSF forest, MPI_Datatype unit, const void* roots, void* leaves, MPI_Op op) {
  PASS(PetscSFBcastBegin, PETSC_ERR_PLIB, forest, unit, roots, leaves, op);
}
PetscErrorCode PetscSFBcastEnd(PetscSF forest, MPI_Datatype unit, const void* roots, void* leaves, MPI_Op op) {
  PASS(PetscSFBcastEnd, PETSC_ERR_PLIB, forest, unit, roots, leaves, op);
}
PetscErrorCode VecGetArrayRead(Vec v, const PetscScalar** array) { PASS(VecGetArrayRead, PETSC_ERR_PLIB, v, array); }
PetscErrorCode VecDestroy(Vec* v) { PASS(VecDestroy, PETSC_ERR_PLIB, v); }
int MPI_Allreduce(const void* from, void* to, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  PASS(MPI_Allreduce, MPI_ERR_OTHER, from, to, count, type, op, comm);
}
int MPI_Issend(const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  PASS(MPI_Issend, MPI_ERR_OTHER, data, n, type, to, tag, comm, request);
}
int MPI_Win_allocate_shared(MPI_Aint size, int unit, MPI_Info info, MPI_Comm comm, void* base, MPI_Win* window) {
  if (std::getenv("UNIBODY_TELL_WINDOWS") != nullptr) std::fprintf(stderr, "a shared window\n");
  PASS(MPI_Win_allocate_shared, MPI_ERR_OTHER, size, unit, info, comm, base, window);
}
int METIS_PartGraphRecursive(idx_t* n, idx_t* constraints, idx_t* begin, idx_t* neighbour, idx_t* weight, idx_t* size,
                             idx_t* edge, idx_t* parts, real_t* target, real_t* balance, idx_t* options, idx_t* cut,
                             idx_t* part) {
  PASS(METIS_PartGraphRecursive, METIS_ERROR_MEMORY, n, constraints, begin, neighbour, weight, size, edge, parts, target, balance,
       options, cut, part);
}
herr_t H5Dwrite(hid_t set, hid_t memory, hid_t space, hid_t file_space, hid_t list, const void* data) {
  PASS(H5Dwrite, -1, set, memory, space, file_space, list, data);
}
herr_t H5Fclose(hid_t file) { PASS(H5Fclose, -1, file); }
herr_t H5Fflush(hid_t object, H5F_scope_t scope) { PASS(H5Fflush, -1, object, scope); }

}  // extern "C"
