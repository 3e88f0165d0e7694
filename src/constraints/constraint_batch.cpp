// The batches of all types of constraints between bodies' centres: their code is made here, and nowhere else.

#include "constraints/constraint_batch.hpp"

#include <numeric>

#include "constraints/constraint_kernels.hpp"
#include "constraints/constraint_layout.hpp"
#include "constraints/constraint_types.hpp"
#include "world/world.hpp"

namespace unibody {

namespace {

// A Jacobi sweep takes the constraints in runs of this many consecutive body ids, and within a run colour by colour. Constraints
// of one colour share no body, so that no addition to a body has to wait for the one before it; and the bodies of a run stay in
// the nearest cache.
constexpr Id ids_in_a_run = 64;

template <class C>
const ConstraintList<C>& list_of(const Elements& elements) {
  static const ConstraintList<C> none;
  return elements.constraints == nullptr ? none : std::get<ConstraintList<C>>(*elements.constraints);
}

template <class C>
std::array<Slot, C::stencil> slots_of(const World& world, const Constraint<C>& constraint) {
  std::array<Slot, C::stencil> ends;
  for (std::size_t e = 0; e < C::stencil; ++e) ends[e] = world.find(constraint.ids[e]);
  return ends;
}

}  // namespace

template <ConstraintType C>
void ConstraintBatch<C>::for_each_stencil(const BuildContext& context,
                                          const std::function<void(std::int32_t, std::span<const Slot>)>& f) {
  std::int32_t number = 0;
  for (const Constraint<C>& c : list_of<C>(context.elements)) {
    f(context.settings.order == Order::sequential ? number : c.colour, slots_of(context.world, c));
    ++number;
  }
}

template <ConstraintType C>
void ConstraintBatch<C>::for_each_element(const Elements& elements,
                                          const std::function<void(const Key&, std::span<const Id>)>& f) {
  for (const Constraint<C>& c : list_of<C>(elements)) f(c.ids, c.ids);
}

template <ConstraintType C>
void ConstraintBatch<C>::count(const BuildContext& context, std::span<std::int32_t> counts) {
  for (const Constraint<C>& c : list_of<C>(context.elements))
    for (const Slot s : slots_of(context.world, c)) ++counts[static_cast<std::size_t>(s)];
}

template <ConstraintType C>
void ConstraintBatch<C>::build(const BuildContext& context) {
  const ConstraintList<C>& list = list_of<C>(context.elements);
  const World& world = context.world;
  std::vector<std::uint32_t> numbers(list.size()), groups;
  std::iota(numbers.begin(), numbers.end(), 0);
  if (context.by_colour && context.settings.order == Order::sequential) {
    groups.resize(list.size());
    std::iota(groups.begin(), groups.end(), 1);
  } else if (context.by_colour) {
    const std::int32_t colours = context.constraint_colours[type_index<C>];
    groups.assign(static_cast<std::size_t>(colours) + 1, 0);
    for (const Constraint<C>& c : list) ++groups[static_cast<std::size_t>(c.colour) + 1];
    std::partial_sum(groups.begin(), groups.end(), groups.begin());
    for (std::uint32_t i = 0; i < list.size(); ++i) numbers[groups[static_cast<std::size_t>(list[i].colour)]++] = i;
    groups.resize(static_cast<std::size_t>(colours));
  } else {
    groups = {static_cast<std::uint32_t>(list.size())};
    const auto key = [&](std::uint32_t i) { return std::pair(list[i].ids[0] / ids_in_a_run, list[i].colour); };
    std::stable_sort(numbers.begin(), numbers.end(), [&](std::uint32_t i, std::uint32_t j) { return key(i) < key(j); });
  }
  const auto counted = [&](std::uint32_t i) {
    for (const Id id : list[i].ids) {
      const Slot s = world.find(id);
      if (!world.is_static(s)) return world.is_home(s);
    }
    return false;
  };
  lay_out(
      list, numbers, groups, static_cast<Slot>(world.size()), context.settings.form,
      [&](std::uint32_t i) { return slots_of(world, list[i]); }, counted);
}

namespace {

// Names every pass of a batch, so that the compiler makes it for each type of the list.
template <class C>
constexpr auto passes() {
  using B = ConstraintBatch<C>;
  using Add = void (B::*)(const StepStart&, std::span<const SolverBody>, std::span<Vec4d>, double);
  using AddState = void (B::*)(SolveState&, const WarmStart&, double);
  using Sweep = void (B::*)(const StepStart&, std::span<const SolverBody>, std::span<Vec4d>, const Extrapolation&, SweepSums&);
  using SweepState = void (B::*)(SolveState&, const Extrapolation&, SweepSums&);
  using Relax = double (B::*)(std::size_t, const StepStart&, std::span<SolverBody>);
  using RelaxState = double (B::*)(std::size_t, bool, SolveState&);
  using Residual = double (B::*)(const StepStart&, std::span<const SolverBody>, const typename B::BlockVisitor*) const;
  return std::tuple(&B::for_each_stencil, &B::for_each_element, &B::count, &B::build, &B::lay_out, &B::set_multipliers,
                    &B::get_multipliers, &B::start_from, &B::remember, static_cast<Add>(&B::add_impulses),
                    static_cast<AddState>(&B::add_impulses), &B::geometric_stiffness, static_cast<Sweep>(&B::sweep),
                    static_cast<SweepState>(&B::sweep), static_cast<Relax>(&B::relax), static_cast<RelaxState>(&B::relax),
                    static_cast<Residual>(&B::residual), &B::for_each_residual, &B::add_applied, &B::take_total_form,
                    &B::moves_beyond, &B::add_directions, &B::bytes);
}

template <class... C>
constexpr auto passes_of(TypeList<C...>) {
  return std::tuple(passes<C>()...);
}

[[gnu::used]] const auto all_passes = passes_of(ConstraintTypes{});

}  // namespace

}  // namespace unibody
