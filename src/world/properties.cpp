#include "world/properties.hpp"

#include <cstring>

#include "core/capacity.hpp"

namespace unibody {

namespace {

constexpr std::size_t tried = 8;  // kinds, the newest first: bodies of a group come one after the other

bool same_bits(const double* a, const double* b, std::size_t n) { return std::memcmp(a, b, n * sizeof(double)) == 0; }

bool same_bits(const BodyProperties& a, const BodyProperties& b) {
  const auto same = [](const Vec3& x, const Vec3& y) { return same_bits(x.data(), y.data(), 3); };
  return a.shape.kind == b.shape.kind && a.shape.data == b.shape.data && a.motion == b.motion && a.material == b.material &&
         a.group == b.group && same_bits(&a.mass, &b.mass, 1) && same(a.shape.size, b.shape.size) && same(a.inertia, b.inertia) &&
         same(a.force, b.force) && same(a.torque, b.torque);
}

}  // namespace

void PropertyTable::set(std::size_t slot, const BodyProperties& properties) {
  for (std::size_t k = kinds_.size(); k > 0 && k + tried > kinds_.size(); --k)
    if (same_bits(kinds_[k - 1], properties)) {
      kind_of_[slot] = static_cast<std::uint32_t>(k - 1);
      return;
    }
  if (kinds_.size() > kind_of_.size() + kind_of_.size() / 8 + tried) drop_unused();
  make_room(kinds_, kinds_.size() + 1);
  kind_of_[slot] = static_cast<std::uint32_t>(kinds_.size());
  kinds_.push_back(properties);
}

void PropertyTable::drop_unused() {
  std::vector<std::uint32_t> number(kinds_.size(), 0);
  for (const std::uint32_t k : kind_of_) number[k] = 1;
  std::uint32_t kept = 1;
  for (std::size_t k = 1; k < kinds_.size(); ++k) {
    if (number[k] == 0) continue;
    kinds_[kept] = kinds_[k];
    number[k] = kept++;
  }
  number[0] = 0;
  kinds_.resize(kept);
  for (std::uint32_t& k : kind_of_) k = number[k];
}

std::size_t PropertyTable::bytes() const { return bytes_of(kind_of_) + bytes_of(kinds_); }

}  // namespace unibody
