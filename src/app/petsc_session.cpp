#include "app/petsc_session.hpp"

#include <petscsf.h>
#include <petscvec.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>

#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"

namespace unibody {

namespace {

// Keeps what PETSc says of the first fault, in place of printing it with a list of calls.
PetscErrorCode keep_message(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType type,
                            const char* message, void* text) {
  if (type == PETSC_ERROR_INITIAL && message != nullptr) *static_cast<std::string*>(text) = message;
  return code;
}

// A vector of one number a rank with the next rank's number as its guest, made and updated as the halo does.
class GuestTrial {
 public:
  explicit GuestTrial(MPI_Comm comm) : comm_(comm) {
    check_mpi(MPI_Comm_rank(comm, &rank_)), check_mpi(MPI_Comm_size(comm, &ranks_));
    next_ = {(rank_ + 1) % ranks_, 0}, values_ = {static_cast<double>(rank_), -1};
  }
  PetscErrorCode make() {
    PetscErrorCode code = VecCreateMPIWithArray(comm_, 1, 1, PETSC_DECIDE, values_.data(), &vec_);
    if (code == 0) code = PetscSFCreate(comm_, &forest_);
    if (code == 0) code = PetscSFSetFromOptions(forest_);
    if (code == 0) code = PetscSFSetGraph(forest_, 1, 1, nullptr, PETSC_COPY_VALUES, &next_, PETSC_COPY_VALUES);
    return code == 0 ? PetscSFSetUp(forest_) : code;
  }
  PetscErrorCode update() {
    PetscErrorCode code = PetscSFBcastBegin(forest_, MPI_DOUBLE, &values_[0], &values_[1], MPI_REPLACE);
    if (code == 0) code = PetscSFBcastEnd(forest_, MPI_DOUBLE, &values_[0], &values_[1], MPI_REPLACE);
    if (code == 0) code = PetscSFDestroy(&forest_);
    if (code == 0) code = VecDestroy(&vec_);
    return code == 0 && values_[1] != static_cast<double>(next_.rank) ? PETSC_ERR_PLIB : code;
  }

 private:
  MPI_Comm comm_;
  int rank_ = 0, ranks_ = 1;
  PetscSFNode next_{};
  std::array<double, 2> values_{};
  Vec vec_ = nullptr;
  PetscSF forest_ = nullptr;
};

// Whoever reads what the run says may leave: it goes on, as under mpirun. PETSc would end it, and at its own end takes what
// cannot be written for an error.
void ignore_closed_pipes() { std::signal(SIGPIPE, SIG_IGN); }
void drop_what_nobody_reads() {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  const bool nobody = poll(&out, 1, 0) > 0 && (out.revents & POLLERR) != 0;
  if (nobody && std::freopen("/dev/null", "w", stdout) == nullptr) std::fputs("unibody: nobody reads what it says\n", stderr);
}

}  // namespace

PetscSession::PetscSession(MPI_Comm comm, const std::vector<std::string>& options) : comm_(comm) {
  words_ = {"unibody"};
  words_.insert(words_.end(), options.begin(), options.end());
  for (std::string& word : words_) argv_.push_back(word.data());
  argv_.push_back(nullptr);
  int argc = static_cast<int>(words_.size());
  char** argv = argv_.data();
  PetscBool runs = PETSC_FALSE;
  check_petsc(PetscInitialized(&runs));
  starts_ = runs == PETSC_FALSE;
  const PetscErrorCode code =
      starts_ ? PetscInitialize(&argc, &argv, nullptr, nullptr) : PetscOptionsInsert(nullptr, &argc, &argv, nullptr);
  if (code != 0) throw InputError("PETSc does not take its options: see above");
  if (starts_) ignore_closed_pipes();
  try_options();
}

PetscSession::~PetscSession() {
  if (!starts_) return;
  drop_what_nobody_reads();
  check_petsc(PetscFinalize());
}

void PetscSession::try_options() const {
  std::string options;
  for (std::size_t k = 1; k < words_.size(); ++k) options += " " + words_[k];
  GuestTrial trial(comm_);
  for (const auto part : {&GuestTrial::make, &GuestTrial::update}) {
    std::string message;
    check_petsc(PetscPushErrorHandler(keep_message, &message));
    const PetscErrorCode code = (trial.*part)();
    check_petsc(PetscPopErrorHandler());
    const char* general = nullptr;
    if (message.empty() && PetscErrorMessage(code, &general, nullptr) == 0 && general != nullptr) message = general;
    const std::string fault =
        first_fault(comm_, code == 0 ? "" : "PETSc does not work with its options" + options + ": " + message);
    if (!fault.empty()) throw InputError(fault);
  }
}

void PetscSession::name_unused_options() const {
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  check_petsc(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm_, &rank));
  for (PetscInt k = 0; k < count && rank == 0; ++k)
    std::fprintf(stderr, "unibody: PETSc made no use of its option -%s: is it spelled right?\n", names[k]);
  check_petsc(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
}

}  // namespace unibody
