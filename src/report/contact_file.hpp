// contacts.h5 and contacts.xdmf: what touches and how hard it pushes, in frames of which the scene asks for it.
//
//   /frames/000000, attributes time (s) and frame; row k of each array is point of contact k, in ascending order of ids:
//     ids            bodies at the ends of the contact; -1: none. Of two bodies that touch the first two
//     shares         of the force that each end takes: of the first side positive, of the second negative (contact_impulse.hpp)
//     point          m, where they touched at the start of the frame's last step
//     normal         from the second side to the first
//     force          N, on the first side, the mean over that step
//     normal_force   N, its part along the normal
//     friction       Coulomb's mu of the pair
//     places, lines  m, of each point of contact two places between which a line of force may be drawn; their numbers
//   and, a row each, of the dynamic bodies (not nodes) on which a contact pushes, in ascending order:
//     body_ids, coordination   with how many other bodies (not nodes) they share such a contact
//     body_stress    Pa, the sum over their contacts of force times the way from the point of contact to the centre, over the
//                    body's volume: the symmetric part xx, yy, zz, yz, xz, xy, positive in compression
#pragma once

#include <mpi.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "core/hdf5.hpp"
#include "report/frame_group.hpp"
#include "report/xdmf_file.hpp"
#include "scene/scene.hpp"
#include "step/contact_impulse.hpp"

namespace unibody {

// Members are collective, but for holds(), and throw RunError on every rank where the disk fails; rank 0 writes, and holds all
// contacts of a frame for it. The same bytes on any number of ranks.
class ContactFile {
 public:
  // Opens or makes the file. Of a file that is there, the frames up to `kept_to` stay; with -1 none does. Collective.
  ContactFile(MPI_Comm comm, const std::string& directory, const Scene& scene, std::int64_t kept_to = -1);

  // step: s, in which the impulses acted. Of contacts that this rank counts.
  void write(std::int64_t frame, double time, std::span<const ContactImpulse> impulses, double step);
  void close();                                                                              // nothing may follow
  bool holds(std::int64_t frame) const { return std::ranges::binary_search(kept_, frame); }  // since before this run

 private:
  void open(std::int64_t kept_to);
  void write_rows(std::int64_t frame, double time, const std::vector<ContactImpulse>& contacts, double step);
  bool draw(std::int64_t frame, double time, Id count);
  template <class F>
  void on_first_rank(F&& f);

  MPI_Comm comm_;
  int rank_ = 0;
  std::string directory_;
  const Scene& scene_;
  std::vector<std::int64_t> kept_;  // frames, ascending
  h5::Handle file_;
  FrameGroup frames_;
  XdmfFile xdmf_;
};

}  // namespace unibody
