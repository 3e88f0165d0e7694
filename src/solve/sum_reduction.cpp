#include "solve/sum_reduction.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/checked.hpp"

namespace unibody {

namespace {

void add(const SweepSums& a, SweepSums& b) {
  b.gradient += a.gradient, b.progress += a.progress;
  b.largest = std::max(b.largest, a.largest), b.change = std::max(b.change, a.change);
}

void combine(void* in, void* inout, int* length, MPI_Datatype*) {
  for (int i = 0; i < *length; ++i) add(static_cast<const SweepSums*>(in)[i], static_cast<SweepSums*>(inout)[i]);
}

}  // namespace

SumReduction::SumReduction(const Exchange& exchange) : comm_(exchange.comm()), boxes_(exchange.boxes_of_sums()) {
  check_mpi(MPI_Comm_size(comm_, &ranks_)), check_mpi(MPI_Comm_rank(comm_, &rank_));
  way_ = boxes_.reach_all() && ranks_ <= most_by_mail ? Way::mail : ranks_ <= most_by_messages ? Way::messages : Way::reduction;
  if (way_ != Way::reduction) return;
  check_mpi(MPI_Type_contiguous(sizeof(SweepSums), MPI_BYTE, &type_));
  check_mpi(MPI_Type_commit(&type_));
  check_mpi(MPI_Op_create(combine, 1, &op_));
}

SumReduction::~SumReduction() {
  wait();
  if (way_ != Way::reduction) return;
  check_mpi(MPI_Type_free(&type_));
  check_mpi(MPI_Op_free(&op_));
}

void SumReduction::start(const SweepSums& sums) {
  own_ = sums_ = sums;
  under_way_ = true;
  if (way_ == Way::reduction) {
    check_mpi(MPI_Iallreduce(MPI_IN_PLACE, &sums_, 1, type_, op_, comm_, requests_.data()));
    return;
  }
  MPI_Request* request = requests_.data();
  for_each_other([&](int other, SweepSums& told) {
    if (way_ == Way::mail) {
      std::memcpy(boxes_.letter(other), &own_, sizeof own_);
      boxes_.send(other);
    } else {
      check_mpi(MPI_Irecv(&told, sizeof told, MPI_BYTE, other, tag_sums, comm_, request++));
      check_mpi(MPI_Isend(&own_, sizeof own_, MPI_BYTE, other, tag_sums, comm_, request++));
    }
  });
}

const SweepSums& SumReduction::wait() {
  if (!under_way_) return sums_;
  under_way_ = false;
  const int requests = way_ == Way::reduction ? 1 : way_ == Way::messages ? 2 * (ranks_ - 1) : 0;
  check_mpi(MPI_Waitall(requests, requests_.data(), MPI_STATUSES_IGNORE));
  if (way_ == Way::reduction) return sums_;
  for_each_other([&](int other, SweepSums& told) {
    if (way_ == Way::mail) std::memcpy(&told, boxes_.receive(other), sizeof told);
    add(told, sums_);
  });
  return sums_;
}

double unit_for(double largest) {
  constexpr double least = 0x1p-900;  // terms so small are sums of nothing; their unit's inverse would be infinite
  return largest > least && std::isfinite(largest) ? std::ldexp(1, std::ilogb(largest) - 30) : 1;
}

}  // namespace unibody
