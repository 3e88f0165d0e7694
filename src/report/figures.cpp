#include "report/figures.hpp"

#include <algorithm>
#include <cmath>

namespace unibody {

void Figures::add(double x) {
  most_ = count_ == 0 ? x : std::max(most_, x);
  total_ += x;
  if (count_++ % stride_ != 0) return;
  if (kept_.size() == most_kept) {  // count_ - 1 is a multiple of twice the stride as well
    for (std::size_t k = 0; 2 * k < kept_.size(); ++k) kept_[k] = kept_[2 * k];
    kept_.resize(most_kept / 2);
    stride_ *= 2;
  }
  kept_.push_back(x);
}

double Figures::within(double share) const {
  if (kept_.empty() || share >= 1) return most_;
  const double place = std::max(std::ceil(share * static_cast<double>(kept_.size())), 1.0);
  std::vector<double> sorted = kept_;
  const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(place) - 1;
  std::nth_element(sorted.begin(), at, sorted.end());
  return *at;
}

double Figures::median() const {
  if (kept_.empty()) return 0;
  std::vector<double> sorted = kept_;
  std::sort(sorted.begin(), sorted.end());
  return 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
}

}  // namespace unibody
