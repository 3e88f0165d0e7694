// The coarse level: rigid motions of aggregates, V + W x (x - centre), and the matrix that they see, P^T H P.
//
// The matrix is summed on all ranks alike and factorised on each. Its sums have the same bits on any number of ranks, since each
// addend is first rounded to a multiple of a common unit, of which a double holds the sum exactly. What is rounded off is less
// than what a preconditioner tells from noise.
#pragma once

#include <mpi.h>

#include <Eigen/SparseCholesky>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "coarse/block_matrix.hpp"
#include "core/types.hpp"

namespace unibody {

class CoarseSpace {
 public:
  // `aggregate` of each slot, -1: of none. Collective.
  void set(MPI_Comm comm, const BlockMatrix& matrix, std::vector<std::int32_t> aggregate, std::int32_t count, std::size_t homes,
           std::span<const Id> ids);

  // Sums the coarse matrix P^T H P, with the bodies at these places (m), and factorises it. Slots for which `moves` is 0 are left
  // out of the aggregates. Collective.
  void factorise(const BlockMatrix& matrix, std::span<const Vec3> places, std::span<const std::uint8_t> moves);

  // z += P (P^T H P)^-1 P^T r, of all slots that move; r by slot, of homes. `largest`: of the entries of all r to come.
  // Collective.
  void correct(std::span<const Vec3> r, double largest, std::span<Vec3> z) const;

  std::int32_t count() const { return count_; }
  std::size_t bytes() const;

 private:
  using Six = Eigen::Matrix<double, 6, 1>;
  using Block = Eigen::Matrix<double, 6, 6>;

  void find_centres(std::span<const Vec3> places);
  void find_arms(std::span<const Vec3> places, std::span<const std::uint8_t> moves);
  void add_row(const BlockMatrix& matrix, std::size_t row, double unit, std::span<const std::uint8_t> moves);
  std::size_t pair_of(std::int32_t row, std::int32_t column) const;

  MPI_Comm comm_ = MPI_COMM_SELF;
  std::int32_t count_ = 0;
  std::size_t homes_ = 0;
  std::vector<std::int32_t> aggregate_;                       // of each slot
  std::vector<Slot> first_member_;                            // of each aggregate whose first body is home here; else -1
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs_;  // row >= column, ascending; the same on all ranks
  std::vector<std::size_t> first_pair_;                       // of each row
  std::vector<double> sums_;                                  // 36 of each pair, by columns
  std::vector<Vec3> centre_;                                  // m, of each aggregate
  std::vector<Vec3> arm_;                                     // of each slot, from the centre, over scale_
  std::vector<std::uint8_t> moves_;
  double scale_ = 1;  // m
  using Factor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>;
  std::shared_ptr<Factor> factor_;
  bool is_analysed_ = false;
  mutable Eigen::VectorXd right_;
};

}  // namespace unibody
