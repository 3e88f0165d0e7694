#include "scene/size_distribution.hpp"

#include <algorithm>
#include <cmath>

namespace unibody {

namespace {

constexpr std::size_t cells = 2048;  // of a tabulated distribution: sizes lie right within a cell's 2,000th of the range

double per_mass(double factor) { return 1 / (factor * factor * factor); }

Key factor(const char* name, const char* about) { return keys::number(name, "", positive, needed, about); }

Keys bell_keys(const char* name, const char* about, const Key& middle, const char* deviation) {
  return {name,
          about,
          {middle, factor("deviation", deviation), factor("smallest", "the smallest factor that is drawn"),
           factor("largest", "the largest factor that is drawn, above the smallest")}};
}

const Keys& normal_keys() {
  static const Keys table = bell_keys("normal_sizes", "A normal distribution between two factors.",
                                      factor("mean", "mean of the whole distribution"), "its standard deviation");
  return table;
}

const Keys& log_normal_keys() {
  static const Keys table =
      bell_keys("log_normal_sizes", "A distribution between two factors of which the logarithm is normal.",
                factor("median", "median of the whole distribution"), "standard deviation of the factor's natural logarithm");
  return table;
}

const Keys& distribution_keys() {
  const auto two_numbers = [] { return keys::list_of(keys::of_range(positive), 2); };
  static const Keys table{
      "sizes",
      "A distribution of the factor by which a body is larger than its shape says.",
      {keys::other("uniform", "", "[smallest, largest]", "another", "uniform between two factors", two_numbers),
       keys::map("normal", normal_keys, "a map", "another", "a normal distribution between two factors"),
       keys::map("log_normal", log_normal_keys, "a map", "another", "a log-normal distribution between two factors"),
       keys::list("table", "", "rows [factor, share]", "another", "these factors alone, each with its share", two_numbers),
       keys::choice("by", {"number", "mass"}, "number",
                    "what of all bodies has this distribution: their number, or their mass")}};
  return table;
}

// Sums of the weights before each of them, then of all, over that of all.
std::vector<double> cumulative(const std::vector<double>& weights) {
  std::vector<double> below{0};
  for (const double weight : weights) below.push_back(below.back() + weight);
  const double all = below.back();
  for (double& share : below) share /= all;
  return below;
}

}  // namespace

template <class Density>
void SizeDistribution::tabulate(bool by_mass, Density&& density) {
  kind_ = Kind::tabulated;
  std::vector<double> weights(cells);
  for (std::size_t i = 0; i < cells; ++i) {
    const double factor = smallest_ + (largest_ - smallest_) * (static_cast<double>(i) + 0.5) / cells;
    weights[i] = density(factor) * (by_mass ? per_mass(factor) : 1);
  }
  below_ = cumulative(weights);
}

double SizeDistribution::at(double u) const {
  if (kind_ == Kind::one) return smallest_;
  if (kind_ == Kind::logarithmic) return smallest_ * std::exp(u * std::log(largest_ / smallest_));
  const auto after = std::upper_bound(below_.begin(), below_.end(), u);
  const auto cell = std::min(static_cast<std::size_t>(after - below_.begin()), below_.size() - 1) - 1;
  if (kind_ == Kind::stepped) return factors_[cell];
  const double width = below_[cell + 1] - below_[cell], within = width > 0 ? (u - below_[cell]) / width : 0;
  return smallest_ + (largest_ - smallest_) * (static_cast<double>(cell) + within) / cells;
}

void SizeDistribution::read_range(const Value& value) {
  const auto range = value.numbers(2, positive, "smallest and largest factor");
  if (range[1] < range[0]) value.fail_expected("the smaller of the two factors first");
  smallest_ = range[0], largest_ = range[1];
}

void SizeDistribution::read_bell(const Value& value, bool logarithmic, bool by_mass) {
  const KeyedMap map(value, logarithmic ? log_normal_keys() : normal_keys());
  const double middle = map.number(logarithmic ? "median" : "mean"), deviation = map.number("deviation");
  smallest_ = map.number("smallest"), largest_ = map.number("largest");
  if (!(largest_ > smallest_)) map.need("largest").fail_expected("a factor above the smallest");
  const auto density = [&](double factor) {
    const double away = (logarithmic ? std::log(factor / middle) : factor - middle) / deviation;
    return std::exp(-0.5 * away * away) / (logarithmic ? factor : 1);
  };
  tabulate(by_mass, density);
  if (!std::isfinite(below_.back())) value.fail("a range in which the distribution has nothing", "one nearer to its middle");
}

void SizeDistribution::read_table(const Value& value, bool by_mass) {
  kind_ = Kind::stepped;
  std::vector<double> weights;
  for (const Value& row : value.list("rows [factor, share]")) {
    if (row.kind != Value::Kind::list || row.entries.size() != 2) row.fail_expected("a row [factor, share]");
    const double factor = row.entries[0].number(positive, "");
    if (!factors_.empty() && !(factor > factors_.back())) row.entries[0].fail_expected("a factor above that of the row before");
    factors_.push_back(factor);
    weights.push_back(row.entries[1].number(positive, "") * (by_mass ? per_mass(factor) : 1));
  }
  smallest_ = factors_.front(), largest_ = factors_.back();
  below_ = cumulative(weights);
}

Key SizeDistribution::key() {
  const auto schema = [] {
    return keys::any_of({keys::list_of(keys::of_range(positive), 2), keys::reference_to(distribution_keys)});
  };
  return keys::other("scale", "", "[smallest, largest], or a map with uniform, normal, log_normal or table", "[1, 1]",
                     "factor on the size: of two numbers the range, uniform in its logarithm", schema, {distribution_keys});
}

SizeDistribution SizeDistribution::read(const Value& value) {
  SizeDistribution sizes;
  if (value.kind == Value::Kind::list) {
    sizes.read_range(value);
    if (sizes.largest_ > sizes.smallest_) sizes.kind_ = Kind::logarithmic;
    return sizes;
  }
  if (value.kind != Value::Kind::map)
    value.fail_expected("[smallest, largest], or a map with uniform, normal, log_normal or table");
  const KeyedMap map(value, distribution_keys());
  const bool by_mass = map.choice("by") == 1;
  map.only_one_of({"uniform", "normal", "log_normal", "table"});
  const Value* found = nullptr;
  for (const char* name : {"uniform", "normal", "log_normal", "table"})
    if (const Value* law = map.find(name)) found = law;
  if (!found) value.fail_missing("uniform", "[smallest, largest], or one of normal, log_normal, table");
  if (found == value.find("table")) {
    sizes.read_table(*found, by_mass);
  } else if (found != value.find("uniform")) {
    sizes.read_bell(*found, found == value.find("log_normal"), by_mass);
  } else {
    sizes.read_range(*found);
    sizes.tabulate(by_mass, [](double) { return 1.0; });
  }
  return sizes;
}

}  // namespace unibody
