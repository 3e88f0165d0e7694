// Halo: who shares which body (design: home computes).
//
// Each body has one home rank, which alone moves it. A rank keeps copies, "guests", of the bodies of other ranks whose swept
// bounds may meet those of its own; with them it evaluates every constraint of its home bodies, so that nothing but the bodies'
// states ever travels. Two ranks find the bodies that they share by comparing the cells of space that their bodies touch
// (neighbours.hpp). The bounds of the bodies are taken somewhat too large, so that the list of guests serves for several steps.
// The price of this is that guests which never touch anything are refreshed as well.
//
// The global state lives in four PETSc Vecs over the World's own arrays, two where nothing rotates. A star forest of PETSc brings
// the guests' values from them: it is made of pairs of a rank and a place there, so that a new list of guests asks nothing of
// ranks that share none.
#pragma once

#include <petscsf.h>
#include <petscvec.h>

#include <initializer_list>
#include <map>
#include <span>
#include <vector>

#include "collide/collide.hpp"
#include "collide/surfaces.hpp"
#include "core/capacity.hpp"
#include "partition/messages.hpp"
#include "world/world.hpp"

namespace unibody {

class Halo {
 public:
  explicit Halo(MPI_Comm comm);
  ~Halo();
  Halo(const Halo&) = delete;
  Halo& operator=(const Halo&) = delete;

  // Collective. Brings the guests' states up to date; finds the guests anew where bodies have left the bounds that the present
  // list was made for, or after reset(). The World's slots of guests and statics may move; `surfaces`, where there are any to
  // touch, are made again then.
  void refresh_guests(World& world, const CollideSettings& settings, Surfaces* surfaces = nullptr);

  // The same where no body touches another: guests are the wanted ones alone.
  void refresh_partners(World& world);

  // The home bodies have changed: the next refresh finds the guests anew. Bodies `wanted` (ascending ids, none home or static)
  // become guests wherever they are: constraints tie home bodies to them. Wanting must be mutual: where a rank wants a body of
  // another, that one wants one of its own. Collective.
  void reset(const World& world, const std::vector<Id>& wanted);

  // Grows whenever slots may have moved.
  std::int64_t version() const { return version_; }

  MPI_Comm comm() const { return comm_; }
  int rank() const { return rank_; }
  int size() const { return size_; }
  int home_rank_of_guest(std::size_t guest) const { return guest_rank_[guest]; }

  std::size_t bytes() const { return bytes_of(registered_) + bytes_of(guest_rank_) + bytes_of(guest_slot_); }

  // Of the home bodies: position (block 3), orientation (4: x, y, z, w), velocity (3), angular velocity (3).
  enum Field { position, orientation, velocity, angular_velocity, field_count };

  // These fields of the guests from their homes, in between. Collective.
  void update(World& world, std::initializer_list<Field> fields);

  // Sets the guests' values to those that their homes have for them; values: one a slot. Collective, and meant for what is rare:
  // all ranks talk with all.
  void tell_guests(const World& world, std::span<std::int32_t> values) const;

 private:
  struct Guest;
  std::vector<Bounds> reach(const World& world, const CollideSettings& settings, const Surfaces* surfaces, bool skin) const;
  bool still_valid(const World& world, const CollideSettings& settings, const Surfaces* surfaces) const;
  void find_guests(World& world, const CollideSettings& settings, Surfaces* surfaces);
  void make_vecs(World& world);
  void destroy_vecs();
  void make_forest(const World& world);
  void follow_arrays(World& world);
  void update_guests(World& world);
  std::vector<Guest> guests_of(const World& world, const ListsByRank<Slot>& near) const;
  void place_guests(World& world, std::vector<Guest> guests);
  void put_guests(World& world, std::span<const Guest> guests);

  MPI_Comm comm_;
  int rank_ = 0, size_ = 1;
  bool valid_ = false;   // the guest list is good for the present state
  bool placed_ = false;  // there is a guest list, of the present home bodies
  std::int64_t version_ = 0;
  std::map<int, std::vector<Slot>> subscribed_;  // by rank: home bodies that it wants, ascending
  std::vector<Bounds> registered_;               // of each home body: the bounds that the guest list is good for
  std::vector<int> guest_rank_;
  std::vector<Slot> guest_slot_;  // of each guest, at home
  Vec vec_[field_count] = {};     // null where nothing rotates
  PetscSF forest_ = nullptr;      // roots: homes; leaves: guests
  RecordType three_{3 * sizeof(double)}, four_{4 * sizeof(double)};
};

}  // namespace unibody
