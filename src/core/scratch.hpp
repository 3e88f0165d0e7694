// Memory for arrays that live for one phase of a step: collision detection and the solve take it in turn, so that a rank needs
// room for the larger of the two only. A stack: what was taken last goes first.
#pragma once

#include <cstddef>
#include <memory_resource>
#include <vector>

namespace unibody {

class Scratch : public std::pmr::memory_resource {
 public:
  Scratch() = default;
  ~Scratch() override;
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  // Gives back, at its end, all that was taken during its life. Containers must not outlive it.
  class Frame {
   public:
    explicit Frame(Scratch& scratch) : scratch_(scratch), start_(scratch.used_) {}
    ~Frame() { scratch_.rewind(start_); }
    Frame(const Frame&) = delete;
    Frame& operator=(const Frame&) = delete;

   private:
    Scratch& scratch_;
    std::size_t start_;
  };

  std::size_t bytes() const { return most_; }  // of the block what was ever used: the rest is addresses without memory

 private:
  struct Spill {
    std::size_t place;
    void* memory;
    std::size_t alignment;
  };

  void* do_allocate(std::size_t bytes, std::size_t alignment) override;
  void do_deallocate(void*, std::size_t, std::size_t) override {}
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }
  void rewind(std::size_t place);
  void grow();

  std::byte* block_ = nullptr;
  std::size_t size_ = 0, used_ = 0, most_ = 0;
  std::vector<Spill> spills_;  // what the block had no room for; the next time it has
};

}  // namespace unibody
