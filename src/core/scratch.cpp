#include "core/scratch.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <new>
#include <utility>

namespace unibody {

namespace {

constexpr std::size_t huge_page = std::size_t{1} << 21;

std::size_t round_up(std::size_t n, std::size_t unit) { return (n + unit - 1) / unit * unit; }

}  // namespace

Scratch::~Scratch() {
  rewind(0);
  ::operator delete (block_, std::align_val_t{huge_page});
}

void* Scratch::do_allocate(std::size_t bytes, std::size_t alignment) {
  const std::size_t place = round_up(used_, std::max(alignment, std::size_t{64}));
  used_ = place + bytes;
  most_ = std::max(most_, used_);
  if (used_ <= size_) return block_ + place;
  void* memory = ::operator new (bytes, std::align_val_t{alignment});
  spills_.push_back({place, memory, alignment});
  return memory;
}

void Scratch::rewind(std::size_t place) {
  used_ = place;
  while (!spills_.empty() && spills_.back().place >= place) {
    ::operator delete (spills_.back().memory, std::align_val_t{spills_.back().alignment});
    spills_.pop_back();
  }
  if (used_ == 0 && most_ > size_) grow();
}

// Addresses for twice the most that was ever needed: the system gives memory to what is used only. In huge pages, if it can:
// bodies and contacts are read in no order that a small page table cache could follow.
void Scratch::grow() {
  ::operator delete (std::exchange(block_, nullptr), std::align_val_t{huge_page});
  size_ = 2 * most_;
  block_ = static_cast<std::byte*>(::operator new (size_, std::align_val_t{huge_page}));
#ifdef MADV_HUGEPAGE
  if (size_ >= 4 * huge_page) madvise(block_, size_ / huge_page * huge_page, MADV_HUGEPAGE);
#endif
}

}  // namespace unibody
