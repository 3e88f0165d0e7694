// What a batch is: all constraints of one kind on this rank, laid out for the passes that solvers make over them.
//
// Solvers, residuals, warm starts, the exchange between ranks, migration, checkpoints and the counts of memory know a batch by
// this interface alone, and reach all batches by for_each_batch() (solve/batches.hpp). A new kind of constraint is a class that
// satisfies the concept Batch, and its name in the list there. BatchDefaults holds the members that few kinds have to define
// themselves.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <functional>
#include <memory_resource>
#include <span>
#include <string_view>
#include <vector>

#include "collide/contacts.hpp"
#include "collide/restitution.hpp"
#include "constraints/pair_history.hpp"
#include "constraints/solve_state.hpp"
#include "constraints/solver_settings.hpp"
#include "constraints/stage.hpp"
#include "constraints/sweep.hpp"
#include "world/material_pairs.hpp"

namespace unibody {

class ContactBatch;
struct Multipliers;
class Surfaces;
struct AttachedNode;
struct ConstraintSet;
struct JointInput;
struct World;

// The constraints of each kind that touch this rank's home bodies, as ids name them.
struct Elements {
  const World& world;
  const ConstraintSet* constraints = nullptr;           // null: none
  const JointInput* joints = nullptr;                   // null: the scene has none
  std::span<const std::array<Id, 2>> attachments = {};  // of nodes to dynamic bodies: ids of node and body, ascending
};

// What a step has found, for batches to be built from. Of batches that last (see BatchDefaults) only what does not change from
// step to step is given: the world, the settings, the constraints and the joints.
struct BuildContext {
  Elements elements;
  const World& world;       // the elements'
  const SolveState& state;  // predicted velocities, masses, counts
  const SolverSettings& settings;
  bool by_colour = false;  // laid out by colour, for Gauss-Seidel; else in one group
  double time = 0;         // s, at the start of the step

  const Contacts* contacts = nullptr;                     // of bodies and of surfaces
  std::span<const std::uint32_t> contact_order = {};      // numbers of manifolds, in the order of the layout
  std::span<const std::uint32_t> contact_groups = {};     // where in that order each group ends
  const ContactBatch* contact_batch = nullptr;            // built before the others
  const MaterialPairs* pairs = nullptr;                   // null: of nothing but friction
  bool has_surfaces = false;                              // the scene has surfaces that may touch something
  std::span<const AttachedNode> attached = {};            // to dynamic bodies, in this step
  bool has_attachments = false;                           // the scene has any
  std::span<const std::int32_t> constraint_colours = {};  // of each type of constraint between centres, over all ranks
  std::pmr::memory_resource* memory = std::pmr::get_default_resource();
  std::function<void(std::span<std::int32_t>)> exchange{};  // values of guests from their homes, one a slot
  std::span<const Vec3> displaced{};                        // m, by slot: where bodies seem to start the step; empty: nowhere
  std::span<const BounceStart> bounce_starts{};             // by slot: from where they bounce; empty: nothing does
  const Multipliers* contact_history = nullptr;             // of the last step
  double least_creep = 0;                                   // m, what is less is not taken back (creep.hpp)
  std::function<bool(bool)> any_over_ranks{};               // collective
};

// Which of the last step's multipliers a step starts from.
struct WarmStart {
  double contacts_share = 0;              // of contacts
  double free_contacts_share = 0;         // of those in free islands, where these are solved apart; else the same
  double share = 0;                       // of all others; 0 too where the scene has none
  double setting = -1;                    // the scene's own share; negative: left open, nothing of types that start cold
  const Surfaces* cold_solids = nullptr;  // contacts of these solids start from nothing; null: none do

  bool has_contacts() const { return contacts_share > 0 || free_contacts_share > 0; }
};

// Is called with the natural residual of a constraint (m) and the bodies that it ties.
using ResidualVisitor = std::function<void(double, std::span<const Slot>)>;

// A batch without history.
struct NoHistory {};

// The hooks of which most batches need none, as they then are.
struct BatchDefaults {
  using History = NoHistory;  // what the next step starts from

  static constexpr bool lasts = false;              // laid out when slots move, not in each step
  static constexpr bool stencils_last = false;      // which bodies it ties changes only when slots move
  static constexpr bool in_velocity_stage = false;  // acts in the velocity stage too
  static constexpr bool in_free_islands = false;    // has rows in islands without constraints, and tells them from others
  static constexpr bool alternates = false;         // every second sweep of Gauss-Seidel takes its colours backwards
  static constexpr bool follows = false;            // each of its colours is relaxed right after that of the batch before it
  static constexpr bool pushes_wrenches = false;    // relax() acts by way of SolveState::wrenches
  // How many of the numbers of a constraint's history, the first ones, are impulses, which follow the length of the step.
  static constexpr std::size_t remembered_impulses = static_cast<std::size_t>(-1);
  static constexpr int relaxations = 1;  // of each colour, in an iteration of Gauss-Seidel

  // A colour that needs all shared bodies up to date, not those of its own constraints alone.
  bool needs_all(std::size_t) const { return true; }

  void start_step() {}  // of batches that last: masses and their shares have changed
  void start_stage(const Stage&) {}
  void keep_impulses(bool) {}                 // between the stages; together: the second goes on from the first's multipliers
  void join_stages() {}                       // what follows goes on from the multipliers of all stages together
  bool bounces() const { return false; }      // in this stage, on this rank
  void renew(const SolveState&) {}            // before an iteration, where rows follow the velocities
  void give_back_gains(SolveState&) {}        // after a stage in which something bounced
  void end_stage(SolveState&) {}              // after the last iteration of a stage
  std::int64_t sliding() const { return 0; }  // counted contacts at the limit of friction

  // Adds to the particles what the batch has done to them in the step (N s), of all stages together, after any iteration: of a
  // batch that ties any.
  void add_applied(const SolveState&, std::span<Vec4d>) const {}

  // History. A warm start's share of it, into the multipliers; their impulses, onto the bodies; and back.
  void start_from(const NoHistory&, const WarmStart&) {}
  void add_impulses(SolveState&, const WarmStart&, double) {}
  void remember(NoHistory&, double) const {}
};

// The numbers of which the elements of an array consist: doubles, or vectors of them.
template <class Array>
std::span<double> numbers_of(Array& array) {
  return {reinterpret_cast<double*>(array.data()), array.size() * (sizeof(*array.data()) / sizeof(double))};
}

template <class B>
concept Batch = std::movable<B> &&
    requires(B& b, const B& c, const BuildContext& context, SolveState& state, const SolveState& seen, SweepSums& sums,
             std::span<std::int32_t> counts, typename B::History& history, const WarmStart& warm) {
  { B::name } -> std::convertible_to<std::string_view>;

  // Calls f(colour, slots) for each constraint that there is to build, with the bodies that it ties; a colour of -1: of none.
  B::for_each_stencil(context, [](std::int32_t, std::span<const Slot>) {});
  // Adds to each body how many constraints share its mass there, all of one step taken at once (Jacobi). Before build().
  B::count(context, counts);
  b.build(context);

  // One Jacobi sweep: evaluate, step, project, extrapolate; impulses onto state.wrenches or state.impulses.
  b.sweep(state, Extrapolation{}, sums);
  // Gauss-Seidel: one pass over the constraints of a colour, which act on state.bodies at once. Returns the largest change (m).
  { c.colours() } -> std::same_as<std::size_t>;
  { b.relax(std::size_t{}, bool{}, state) } -> std::same_as<double>;
  // Calls f(std::span<double>) for all numbers that relax() changes beside the bodies: the multipliers, and impulses kept with
  // them. Gauss-Seidel extrapolates them from sweep to sweep, as it does the bodies' velocities.
  b.for_each_unknown([](std::span<double>) {});
  // Natural residual (m), zero exactly at a solution.
  { c.residual(seen) } -> std::same_as<double>;
  // The residual of each constraint that acts, of which residual() is the largest; for reports, not for the solvers' loops.
  c.for_each_residual(seen, ResidualVisitor{});

  // N s; most_stiffness: a bound of the geometric stiffness of links (solver_settings.hpp).
  b.start_from(history, warm);
  b.add_impulses(state, warm, double{});
  // leak: the share of the position stage's multipliers that the velocity stage of the next step starts from.
  c.remember(history, double{});
  { c.bytes() } -> std::same_as<std::size_t>;
};

// Whose history is one value (doubles) for each constraint that is here, in the order in which for_each_element() calls
// f(key, ids of the bodies); the key, of whole numbers, tells the constraints of the kind apart.
template <class B>
concept KeyedBatch = Batch<B> && requires(const Elements& elements) {
  typename B::Key;
  typename B::History::value_type;
  B::for_each_element(elements, [](const typename B::Key&, std::span<const Id>) {});
};

// Whose history is a PairHistory, since its constraints come and go with contacts.
template <class B>
concept PairedBatch = Batch<B> && pair_width<typename B::History> >
0 && requires {
  { B::history_columns } -> std::convertible_to<std::string_view>;
};

// Adds one for each constraint to the counts of its bodies.
template <class B>
void count_stencils(const BuildContext& context, std::span<std::int32_t> counts) {
  B::for_each_stencil(context, [&](std::int32_t, std::span<const Slot> ends) {
    for (const Slot s : ends)
      if (s >= 0) ++counts[static_cast<std::size_t>(s)];
  });
}

}  // namespace unibody
