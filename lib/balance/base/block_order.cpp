#include "balance/base/block_order.hpp"

#include <algorithm>

namespace balance {

namespace {

/// A row whose columns are being gone through. Kept on a stack of our own: a path may be as long as the matrix is large.
struct SearchFrame {
  int row;
  std::size_t next;  ///< of its columns
};

/// Augmenting paths: a column for every row.
class MaximumMatching {
 public:
  explicit MaximumMatching(const SparsityPattern& pattern)
      : pattern_(pattern), column_of(pattern.size(), -1), row_of(pattern.size(), -1), seen_(pattern.size(), -1) {}

  bool run() {
    for (std::size_t row = 0; row < pattern_.size(); ++row)
      if (!augment(static_cast<int>(row))) return false;
    return true;
  }

 private:
  bool augment(int from) {
    path_.assign(1, {from, 0});
    while (!path_.empty()) {
      SearchFrame& last = path_.back();
      const std::vector<int>& columns = pattern_[last.row];
      if (last.next == columns.size()) {
        path_.pop_back();
        continue;
      }
      const int column = columns[last.next++];
      if (seen_[column] == from) continue;
      seen_[column] = from;
      if (row_of[column] >= 0) {
        path_.push_back({row_of[column], 0});
        continue;
      }
      for (const SearchFrame& visit : path_) {
        const int taken = pattern_[visit.row][visit.next - 1];
        row_of[taken] = visit.row;
        column_of[visit.row] = taken;
      }
      return true;
    }
    return false;
  }

  const SparsityPattern& pattern_;

 public:
  std::vector<int> column_of, row_of;

 private:
  std::vector<int> seen_;  ///< per column: the row that last looked for one
  std::vector<SearchFrame> path_;
};

/// Tarjan's strongly connected components of the graph row → row matched to a column that the row needs; they come out in the
/// order in which they must be solved.
class StronglyConnectedComponents {
 public:
  StronglyConnectedComponents(const SparsityPattern& pattern, const MaximumMatching& matching)
      : pattern_(pattern),
        matching_(matching),
        index_(pattern.size(), -1),
        low_(pattern.size()),
        open_(pattern.size()) {}

  std::vector<std::vector<int>> run() {
    for (std::size_t row = 0; row < pattern_.size(); ++row)
      if (index_[row] < 0) visit(static_cast<int>(row));
    return components_;
  }

 private:
  void enter(int row) {
    index_[row] = low_[row] = counter_++;
    stack_.push_back(row);
    open_[row] = true;
    search_stack_.push_back({row, 0});
  }

  void visit(int from) {
    enter(from);
    while (!search_stack_.empty()) {
      const int row = search_stack_.back().row;
      if (search_stack_.back().next < pattern_[row].size()) {
        const int next = matching_.row_of[pattern_[row][search_stack_.back().next++]];
        if (index_[next] < 0)
          enter(next);
        else if (open_[next])
          low_[row] = std::min(low_[row], index_[next]);
        continue;
      }
      search_stack_.pop_back();
      if (!search_stack_.empty()) low_[search_stack_.back().row] = std::min(low_[search_stack_.back().row], low_[row]);
      if (low_[row] == index_[row]) close(row);
    }
  }

  void close(int row) {
    std::vector<int> component;
    int member;
    do {
      member = stack_.back();
      stack_.pop_back();
      open_[member] = false;
      component.push_back(member);
    } while (member != row);
    std::sort(component.begin(), component.end());
    components_.push_back(component);
  }

  const SparsityPattern& pattern_;
  const MaximumMatching& matching_;
  std::vector<int> index_, low_;
  std::vector<bool> open_;
  std::vector<int> stack_;
  std::vector<SearchFrame> search_stack_;
  std::vector<std::vector<int>> components_;
  int counter_ = 0;
};

}  // namespace

std::size_t hash_pattern(const SparsityPattern& pattern) {
  std::size_t number = 0xcbf29ce484222325;
  const auto mix = [&number](int value) { number = (number ^ static_cast<unsigned>(value)) * 0x100000001b3; };
  for (const std::vector<int>& row : pattern) {
    mix(-1);
    for (const int column : row) mix(column);
  }
  return number | 1;
}

BlockTriangularForm find_block_triangular_form(const SparsityPattern& pattern) {
  BlockTriangularForm order;
  MaximumMatching matching(pattern);
  order.is_structurally_regular = matching.run();
  if (!order.is_structurally_regular) return order;
  order.blocks = StronglyConnectedComponents(pattern, matching).run();
  order.matched_column = matching.column_of;
  return order;
}

}  // namespace balance
