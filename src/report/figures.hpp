// A figure of each frame of a run, of which shares and medians are told at its end: in memory that does not grow with the run.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <vector>

namespace unibody {

class Figures {
 public:
  static constexpr std::size_t most_kept = std::size_t{1} << 14;

  Figures() = default;
  Figures(std::initializer_list<double> figures) {
    for (const double x : figures) add(x);
  }

  void add(double x);

  std::int64_t count() const { return count_; }
  double total() const { return total_; }
  // The smallest value that at least this share (0 to 1) of all figures does not exceed; 0 where there are no figures. It is
  // exact for the share 1, and for any share while there are no more than `most_kept` figures. Of a longer run it is computed
  // from every second figure, later from every fourth, and so on.
  double within(double share) const;
  // The median of the same figures.
  double median() const;
  const std::vector<double>& kept() const { return kept_; }

 private:
  std::vector<double> kept_;
  std::int64_t count_ = 0, stride_ = 1;
  double total_ = 0, most_ = 0;
};

}  // namespace unibody
