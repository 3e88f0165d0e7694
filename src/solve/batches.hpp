// The list of all kinds of constraints that a step solves: here, and nowhere else. Solvers, residuals, warm starts, the exchange
// between ranks, counts of memory, migration and checkpoints go through it by for_each_batch().
//
// The order matters: the sums at each body follow it, and so do the passes of Gauss-Seidel. What follows another batch (see
// BatchDefaults) stands right behind it.
#pragma once

#include <memory_resource>
#include <tuple>
#include <type_traits>
#include <utility>

#include "constraints/attachment_batch.hpp"
#include "constraints/constraint_batch.hpp"
#include "constraints/constraint_types.hpp"
#include "constraints/contact_batch.hpp"
#include "constraints/liquid_batch.hpp"
#include "constraints/rolling_batch.hpp"
#include "constraints/surface_batch.hpp"
#include "joints/coupling_batch.hpp"
#include "joints/joint_batch.hpp"

// A header that defines UNIBODY_MORE_BATCHES, the names of further batches: for programs that add kinds of their own.
#ifdef UNIBODY_MORE_BATCHES_HEADER
#include UNIBODY_MORE_BATCHES_HEADER
#endif

namespace unibody {

template <Batch... B>
struct BatchList {
  static constexpr std::size_t size = sizeof...(B);
  using Tuple = std::tuple<B...>;
  using Histories = std::tuple<typename B::History...>;
};

template <class... Lists>
struct JoinedLists;
template <class... B>
struct JoinedLists<BatchList<B...>> {
  using List = BatchList<B...>;
};
template <class... B, class... C, class... More>
struct JoinedLists<BatchList<B...>, BatchList<C...>, More...> : JoinedLists<BatchList<B..., C...>, More...> {};

template <class Types>
struct BatchesOfTypes;
template <class... C>
struct BatchesOfTypes<TypeList<C...>> {
  using List = BatchList<ConstraintBatch<C>...>;
};

// clang-format off
using BatchTypes = JoinedLists<
    BatchList<ContactBatch, RollingBatch, SurfaceBatch, AttachmentBatch>,
    BatchesOfTypes<ConstraintTypes>::List,
    BatchList<JointBatch, CouplingBatch, LiquidBatch>
#ifdef UNIBODY_MORE_BATCHES
    , BatchList<UNIBODY_MORE_BATCHES>
#endif
    >::List;
// clang-format on

// Batches that do not last live in the given memory.
struct Batches : BatchTypes::Tuple {
  explicit Batches(std::pmr::memory_resource* memory) : BatchTypes::Tuple(make(memory, BatchTypes{})) {}

  template <class B>
  static constexpr bool is_in_memory = !B::lasts && std::is_constructible_v<B, std::pmr::memory_resource*>;

 private:
  template <class B>
  static B make_one(std::pmr::memory_resource* memory) {
    if constexpr (is_in_memory<B>)
      return B(memory);
    else
      return B();
  }
  template <class... B>
  static BatchTypes::Tuple make(std::pmr::memory_resource* memory, BatchList<B...>) {
    return BatchTypes::Tuple(make_one<B>(memory)...);
  }
};

// Calls f(place in the list, batch) for each; batches: Batches, or a tuple with an entry for each of them.
template <class Tuple, typename F>
void for_each_batch(Tuple&& batches, F&& f) {
  [&]<std::size_t... k>(std::index_sequence<k...>) { (f(std::integral_constant<std::size_t, k>{}, std::get<k>(batches)), ...); }
  (std::make_index_sequence<BatchTypes::size>{});
}

// Calls f(place in the list, std::type_identity<batch>) for each.
template <typename F>
void for_each_batch_type(F&& f) {
  [&]<std::size_t... k>(std::index_sequence<k...>) {
    (f(std::integral_constant<std::size_t, k>{}, std::type_identity<std::tuple_element_t<k, BatchTypes::Tuple>>{}), ...);
  }
  (std::make_index_sequence<BatchTypes::size>{});
}

template <class B>
inline constexpr bool is_constraint_batch = false;
template <class C>
inline constexpr bool is_constraint_batch<ConstraintBatch<C>> = true;

// Calls f(place in the list of constraint types, batch) for those of constraints between centres.
template <class Tuple, typename F>
void for_each_constraint_batch(Tuple&& batches, F&& f) {
  for_each_batch(batches, [&]<class B>(auto, B& batch) {
    if constexpr (is_constraint_batch<std::remove_const_t<B>>) {
      using C = typename std::remove_const_t<B>::Type;
      f(std::integral_constant<std::size_t, type_index<C>>{}, batch);
    }
  });
}

// The place of a batch in the list.
template <class B>
inline constexpr std::size_t batch_place = []<std::size_t... k>(std::index_sequence<k...>) {
  std::size_t place = 0;
  const bool found = ((std::is_same_v<B, std::tuple_element_t<k, BatchTypes::Tuple>> || (++place, false)) || ...);
  return found ? place : sizeof...(k);
}
(std::make_index_sequence<BatchTypes::size>{});

// What the next step starts from, of each batch.
struct BatchHistories : BatchTypes::Histories {
  template <class B>
  typename B::History& of() {
    return std::get<batch_place<B>>(*this);
  }
  template <class B>
  const typename B::History& of() const {
    return std::get<batch_place<B>>(*this);
  }
};

}  // namespace unibody
