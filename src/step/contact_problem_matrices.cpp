#include <algorithm>
#include <limits>

#include "constraints/contact_batch.hpp"
#include "core/errors.hpp"
#include "partition/by_id.hpp"
#include "step/contact_problem.hpp"

namespace unibody {

namespace {

using Contact = ContactProblem::Contact;
using ProblemBody = ContactProblem::Body;
using Block6x3 = Eigen::Matrix<double, 6, 3>;
using Vec6 = Eigen::Matrix<double, 6, 1>;

Vec3 vector(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }
Vec6 vector(const std::array<double, 6>& a) { return Eigen::Map<const Vec6>(a.data()); }

Mat3 inverse_inertia(const ProblemBody& b) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(b.inverse_inertia.data());
}

// What impulses of the contact along its three axes do to a body: + on the first, - on the second.
Block6x3 impulses_on(const Contact& c, bool first) {
  const Vec3 n = vector(c.normal), s = first_tangent_of(n);
  const Vec3 axes[3] = {n, s, n.cross(s)}, arm = vector(first ? c.arm_a : c.arm_b);
  Block6x3 block;
  for (int k = 0; k < 3; ++k) block.col(k) << axes[k], arm.cross(axes[k]);
  return first ? block : Block6x3(-block);
}

Block6x3 times_inverse_mass(const ProblemBody& b, const Block6x3& block) {
  Block6x3 moved;
  moved << b.inverse_mass * block.topRows<3>(), inverse_inertia(b) * block.bottomRows<3>();
  return moved;
}

// One end of a contact that can move.
struct End {
  std::size_t body;
  Block6x3 block;
};

std::vector<End> ends_of(const ContactProblem& p, const Contact& c) {
  std::vector<End> ends;
  for (const bool first : {true, false}) {
    const Id id = first ? c.id_a : c.id_b;
    const auto it = std::lower_bound(p.bodies.begin(), p.bodies.end(), id, [](const ProblemBody& b, Id i) { return b.id < i; });
    if (it != p.bodies.end() && it->id == id)
      ends.push_back({static_cast<std::size_t>(it - p.bodies.begin()), impulses_on(c, first)});
  }
  return ends;  // ascending, since id_a < id_b
}

template <class Block>
void put_column(SparseMatrix& to, std::size_t first_row, const Block& block, Eigen::Index column) {
  for (Eigen::Index k = 0; k < block.rows(); ++k) {
    to.row.push_back(static_cast<std::int32_t>(first_row) + static_cast<std::int32_t>(k));
    to.value.push_back(block(k, column));
  }
}

void end_column(SparseMatrix& to) {
  if (to.row.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw RunError("the contact problem has more entries than its file format can count");
  to.begin.push_back(static_cast<std::int32_t>(to.row.size()));
}

}  // namespace

SparseMatrix ContactProblem::M() const {
  SparseMatrix m{static_cast<std::int64_t>(6 * bodies.size()), static_cast<std::int64_t>(6 * bodies.size()), {0}, {}, {}};
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Mat3 mass = Vec3::Constant(1 / bodies[b].inverse_mass).asDiagonal(), inertia = inverse_inertia(bodies[b]).inverse();
    for (Eigen::Index k = 0; k < 6; ++k) {
      if (k < 3)
        m.row.push_back(static_cast<std::int32_t>(6 * b) + static_cast<std::int32_t>(k)), m.value.push_back(mass(k, k));
      else
        put_column(m, 6 * b + 3, inertia, k - 3);
      end_column(m);
    }
  }
  return m;
}

SparseMatrix ContactProblem::H() const {
  SparseMatrix h{static_cast<std::int64_t>(6 * bodies.size()), static_cast<std::int64_t>(3 * contacts.size()), {0}, {}, {}};
  for (const Contact& c : contacts) {
    const auto ends = ends_of(*this, c);
    for (Eigen::Index k = 0; k < 3; ++k) {
      for (const End& end : ends) put_column(h, 6 * end.body, end.block, k);
      end_column(h);
    }
  }
  return h;
}

SparseMatrix ContactProblem::W() const {
  std::vector<std::vector<End>> ends;
  std::vector<std::vector<std::size_t>> touching(bodies.size());  // contacts of each body, ascending
  for (const Contact& c : contacts) {
    for (const End& end : ends.emplace_back(ends_of(*this, c))) touching[end.body].push_back(ends.size() - 1);
  }
  const auto n = static_cast<std::int64_t>(3 * contacts.size());
  SparseMatrix w{n, n, {0}, {}, {}};
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    std::vector<std::size_t> others;
    for (const End& end : ends[i]) others.insert(others.end(), touching[end.body].begin(), touching[end.body].end());
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    std::vector<Mat3> blocks(others.size(), Mat3::Zero());
    for (const End& mine : ends[i]) {
      const Block6x3 moved = times_inverse_mass(bodies[mine.body], mine.block);
      for (std::size_t k = 0; k < others.size(); ++k)
        for (const End& theirs : ends[others[k]])
          if (theirs.body == mine.body) blocks[k] += theirs.block.transpose() * moved;
    }
    for (Eigen::Index column = 0; column < 3; ++column) {
      for (std::size_t k = 0; k < others.size(); ++k) put_column(w, 3 * others[k], blocks[k], column);
      end_column(w);
    }
  }
  return w;
}

std::vector<double> ContactProblem::f() const {
  std::vector<double> f;
  for (const ProblemBody& b : bodies) {
    const Vec6 predicted = vector(b.predicted);
    const Vec3 momentum = predicted.head<3>() / b.inverse_mass, spin = inverse_inertia(b).inverse() * predicted.tail<3>();
    f.insert(f.end(), momentum.begin(), momentum.end());
    f.insert(f.end(), spin.begin(), spin.end());
  }
  return f;
}

namespace {

// H^T of the velocities, + w.
std::vector<double> parting(const ContactProblem& p, std::array<double, 6> ProblemBody::*velocity) {
  std::vector<double> u;
  for (const Contact& c : p.contacts) {
    Vec3 parts = vector(c.offset);
    for (const End& end : ends_of(p, c)) parts += end.block.transpose() * vector(p.bodies[end.body].*velocity);
    u.insert(u.end(), parts.begin(), parts.end());
  }
  return u;
}

}  // namespace

std::vector<double> ContactProblem::q() const { return parting(*this, &ProblemBody::predicted); }
std::vector<double> ContactProblem::u() const { return parting(*this, &ProblemBody::solved); }

std::vector<double> ContactProblem::w() const {
  std::vector<double> w;
  for (const Contact& c : contacts) w.insert(w.end(), c.offset.begin(), c.offset.end());
  return w;
}

std::vector<double> ContactProblem::mu() const {
  std::vector<double> mu;
  for (const Contact& c : contacts) mu.push_back(c.friction);
  return mu;
}

std::vector<double> ContactProblem::v() const {
  std::vector<double> v;
  for (const ProblemBody& b : bodies) v.insert(v.end(), b.solved.begin(), b.solved.end());
  return v;
}

std::vector<double> ContactProblem::r() const {
  std::vector<double> r;
  for (const Contact& c : contacts) r.insert(r.end(), c.impulse.begin(), c.impulse.end());
  return r;
}

void ContactProblem::gather(MPI_Comm comm) {
  const auto to_rank_0 = [&](auto& records) {
    using Record = typename std::remove_reference_t<decltype(records)>::value_type;
    records = exchange<Record>(comm, std::vector<int>(records.size(), 0), records);
  };
  to_rank_0(bodies), to_rank_0(contacts);
  std::sort(bodies.begin(), bodies.end(), [](const ProblemBody& a, const ProblemBody& b) { return a.id < b.id; });
  // A pair's points come from one rank, in their order.
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const Contact& a, const Contact& b) { return std::pair(a.id_a, a.id_b) < std::pair(b.id_a, b.id_b); });
}

}  // namespace unibody
