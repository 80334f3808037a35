#include "balance/motion/study/different_numbers.hpp"

#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace balance::study {

namespace {

/// Matches rows of a bipartite graph with columns of their own by augmenting paths (Kuhn 1955).
class BipartiteMatching {
 public:
  BipartiteMatching(const std::vector<std::vector<std::size_t>>& columns_of, std::size_t column_count)
      : columns_of_(columns_of), row_of_(column_count, unmatched) {}

  /// Rows that together have fewer columns than there are of them; empty if all rows can be matched.
  std::vector<std::size_t> find_scarce_rows() {
    for (std::size_t row = 0; row < columns_of_.size(); ++row) {
      is_visited_.assign(row_of_.size(), false);
      if (augment(row)) continue;
      std::vector<std::size_t> rows{row};
      for (std::size_t column = 0; column < row_of_.size(); ++column)
        if (is_visited_[column]) rows.push_back(row_of_[column]);
      std::sort(rows.begin(), rows.end());
      return rows;
    }
    return {};
  }

 private:
  static constexpr std::size_t unmatched = static_cast<std::size_t>(-1);

  bool augment(std::size_t row) {
    for (const std::size_t column : columns_of_[row]) {
      if (is_visited_[column]) continue;
      is_visited_[column] = true;
      if (row_of_[column] != unmatched && !augment(row_of_[column])) continue;
      row_of_[column] = row;
      return true;
    }
    return false;
  }

  const std::vector<std::vector<std::size_t>>& columns_of_;
  std::vector<std::size_t> row_of_;
  std::vector<bool> is_visited_;
};

}  // namespace

bool is_same_size(double a, double b, double scale) {
  constexpr double size_tolerance = 1e-12;  // round-off of multiples of a step and of units
  return std::abs(a - b) <= size_tolerance * scale;
}

bool is_taken(const std::vector<double>& taken, double size, double scale) {
  return std::any_of(taken.begin(), taken.end(), [&](double other) { return is_same_size(other, size, scale); });
}

std::vector<double> merge_sizes(const std::vector<std::vector<double>>& domains, double scale) {
  std::vector<double> all, merged;
  for (const std::vector<double>& domain : domains) all.insert(all.end(), domain.begin(), domain.end());
  std::sort(all.begin(), all.end());
  for (const double size : all)
    if (merged.empty() || !is_same_size(merged.back(), size, scale)) merged.push_back(size);
  return merged;
}

std::vector<int> find_free_numbers(const std::vector<std::string>& paths, const std::vector<FreeNumber>& free) {
  std::vector<int> numbers;
  for (const std::string& path : paths)
    for (std::size_t i = 0; i < free.size(); ++i)
      if (free[i].key_path == path) numbers.push_back(static_cast<int>(i));
  return numbers;
}

std::vector<std::size_t> find_scarce_domains(const std::vector<std::vector<double>>& domains, double scale) {
  const std::vector<double> sizes = merge_sizes(domains, scale);
  std::vector<std::vector<std::size_t>> columns_of;
  for (const std::vector<double>& domain : domains) {
    columns_of.emplace_back();
    for (const double size : domain) {
      const auto above = std::upper_bound(sizes.begin(), sizes.end(), size);  // not the first: the size was merged
      columns_of.back().push_back(static_cast<std::size_t>(above - sizes.begin()) - 1);
    }
  }
  return BipartiteMatching(columns_of, sizes.size()).find_scarce_rows();
}

std::string find_size_shortage(const DifferentNumbers& different, const std::vector<FreeNumber>& free) {
  double scale = 0;
  std::vector<std::vector<double>> domains;
  for (const int i : different.numbers) {
    domains.push_back(free[static_cast<std::size_t>(i)].discrete_values);
    for (const double size : domains.back()) scale = std::max(scale, std::abs(size));
  }
  for (std::vector<double>& domain : domains)
    std::erase_if(domain, [&](double size) { return is_taken(different.taken, size, scale); });
  std::vector<std::string> names, sizes;
  std::vector<std::vector<double>> scarce;
  double unit = 1;
  for (const std::size_t k : find_scarce_domains(domains, scale)) {
    const FreeNumber& number = free[static_cast<std::size_t>(different.numbers[k])];
    names.push_back(number.key_path);
    scarce.push_back(domains[k]);
    unit = number.unit;
  }
  if (names.empty()) return "";
  for (const double size : merge_sizes(scarce, scale)) sizes.push_back(fmt::format("{:.6g}", size / unit));
  const std::string subject = join_with_conjunction(names, "and") + (names.size() == 1 ? " has" : " have");
  if (sizes.empty()) return subject + " no size that another number has not taken";
  return subject + " only " + count_noun(static_cast<long>(sizes.size()), "different size", "different sizes") + ": " +
         join_with_conjunction(sizes, "and");
}

}  // namespace balance::study
