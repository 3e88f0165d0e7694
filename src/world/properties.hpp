// What bodies are, by slot. Bodies that are alike, as those of one group mostly are, share one copy.
#pragma once

#include <vector>

#include "world/body.hpp"

namespace unibody {

class PropertyTable {
 public:
  const BodyProperties& operator[](std::size_t slot) const { return kinds_[kind_of_[slot]]; }
  void set(std::size_t slot, const BodyProperties& properties);
  void resize(std::size_t n) { kind_of_.resize(n, 0); }
  std::size_t bytes() const;

 private:
  void drop_unused();

  std::vector<std::uint32_t> kind_of_;                   // of each slot
  std::vector<BodyProperties> kinds_{BodyProperties{}};  // the first is that of slots not set yet
};

}  // namespace unibody
