#include "balance/foundation/numerics/block_triangular.hpp"

#include <algorithm>
#include <cmath>

namespace balance::numerics {

namespace {

/// A row whose columns are being visited. An explicit stack holds them because a path may be as long as the matrix.
struct SearchFrame {
  int row;
  std::size_t next;  ///< index of the next column to visit
};

/// Finds a column for every row by augmenting paths.
class MaximumMatching {
 public:
  explicit MaximumMatching(const SparsityPattern& pattern)
      : pattern_(pattern),
        column_of(pattern.size(), -1),
        row_of(pattern.size(), -1),
        last_search_(pattern.size(), -1) {}

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
      if (last_search_[column] == from) continue;
      last_search_[column] = from;
      if (row_of[column] >= 0) {
        path_.push_back({row_of[column], 0});
        continue;
      }
      for (const SearchFrame& visit : path_) {
        const int matched = pattern_[visit.row][visit.next - 1];
        row_of[matched] = visit.row;
        column_of[visit.row] = matched;
      }
      return true;
    }
    return false;
  }

  const SparsityPattern& pattern_;

 public:
  std::vector<int> column_of, row_of;

 private:
  std::vector<int> last_search_;  ///< per column: the row whose search visited it last
  std::vector<SearchFrame> path_;
};

/// Tarjan's strongly connected components of the graph with edges from each row to the rows matched to its columns.
/// They come out in the order in which they must be solved.
class StronglyConnectedComponents {
 public:
  StronglyConnectedComponents(const SparsityPattern& pattern, const MaximumMatching& matching)
      : pattern_(pattern),
        matching_(matching),
        index_(pattern.size(), -1),
        low_link_(pattern.size()),
        on_stack_(pattern.size()) {}

  std::vector<std::vector<int>> run() {
    for (std::size_t row = 0; row < pattern_.size(); ++row)
      if (index_[row] < 0) visit(static_cast<int>(row));
    return components_;
  }

 private:
  void enter(int row) {
    index_[row] = low_link_[row] = counter_++;
    stack_.push_back(row);
    on_stack_[row] = true;
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
        else if (on_stack_[next])
          low_link_[row] = std::min(low_link_[row], index_[next]);
        continue;
      }
      search_stack_.pop_back();
      if (!search_stack_.empty())
        low_link_[search_stack_.back().row] = std::min(low_link_[search_stack_.back().row], low_link_[row]);
      if (low_link_[row] == index_[row]) pop_component(row);
    }
  }

  void pop_component(int row) {
    std::vector<int> component;
    int member;
    do {
      member = stack_.back();
      stack_.pop_back();
      on_stack_[member] = false;
      component.push_back(member);
    } while (member != row);
    std::sort(component.begin(), component.end());
    components_.push_back(component);
  }

  const SparsityPattern& pattern_;
  const MaximumMatching& matching_;
  std::vector<int> index_, low_link_;
  std::vector<bool> on_stack_;
  std::vector<int> stack_;
  std::vector<SearchFrame> search_stack_;
  std::vector<std::vector<int>> components_;
  int counter_ = 0;
};

}  // namespace

std::size_t hash_pattern(const SparsityPattern& pattern) {
  std::size_t hash = 0xcbf29ce484222325;
  const auto mix = [&hash](int value) { hash = (hash ^ static_cast<unsigned>(value)) * 0x100000001b3; };
  for (const std::vector<int>& row : pattern) {
    mix(-1);
    for (const int column : row) mix(column);
  }
  return hash | 1;
}

BlockTriangularForm find_block_triangular_form(const SparsityPattern& pattern) {
  BlockTriangularForm form;
  MaximumMatching matching(pattern);
  form.is_structurally_regular = matching.run();
  if (!form.is_structurally_regular) return form;
  form.blocks = StronglyConnectedComponents(pattern, matching).run();
  form.matched_column = matching.column_of;
  return form;
}

using namespace small_blocks;

bool BlockTriangular::analyse(const SparsityPattern& pattern) {
  const int n = static_cast<int>(pattern.size());
  row_position_.assign(n, 0);
  column_position_.assign(n, 0);
  blocks_.clear();
  const BlockTriangularForm form = find_block_triangular_form(pattern);
  if (!form.is_structurally_regular) return false;
  int position = 0;
  diagonal_value_count_ = 0;
  block_at_.clear();
  std::vector<int> rows;  // original rows in the new order
  for (const std::vector<int>& component : form.blocks) {
    const int size = static_cast<int>(component.size());
    block_at_.insert(block_at_.end(), size, static_cast<int>(blocks_.size()));
    blocks_.push_back({position, size, diagonal_value_count_, 0});
    diagonal_value_count_ += size * size;
    for (const int row : component) {
      rows.push_back(row);
      row_position_[row] = position;
      column_position_[form.matched_column[row]] = position++;
    }
  }
  row_begin_.assign(1, 0);
  column_index_.clear();
  for (int i = 0; i < n; ++i) {
    for (const int column : pattern[rows[i]])
      if (column_position_[column] < blocks_[block_at_[i]].begin) column_index_.push_back(column_position_[column]);
    std::sort(column_index_.begin() + row_begin_.back(), column_index_.end());
    row_begin_.push_back(static_cast<int>(column_index_.size()));
  }
  values_.assign(diagonal_value_count_ + column_index_.size(), 0);
  factors_.assign(diagonal_value_count_, 0);
  stored_.assign(diagonal_value_count_, 0);
  pivots_.resize(n);
  for (const Block& block : blocks_)
    for (int i = 0; i < block.size; ++i) pivots_[block.begin + i] = i;
  work_.assign(n, 0);
  sums_.assign(n, 0);
  pairs_.assign(n, {0, 0});
  return true;
}

int BlockTriangular::index(int row, int column) const {
  const int i = row_position_[row], j = column_position_[column];
  const Block& block = blocks_[block_at_[i]];
  if (j >= block.begin)
    return j < block.begin + block.size ? block.offset + (i - block.begin) * block.size + j - block.begin : -1;
  const auto begin = column_index_.begin() + row_begin_[i], end = column_index_.begin() + row_begin_[i + 1];
  const auto entry = std::lower_bound(begin, end, j);
  return entry != end && *entry == j ? diagonal_value_count_ + static_cast<int>(entry - column_index_.begin()) : -1;
}

void BlockTriangular::write_normal_matrix(double* normal) const {
  const auto n = static_cast<std::size_t>(size());
  std::fill_n(normal, n * n, 0);
  const double* off_diagonal = values_.data() + diagonal_value_count_;
  for (const Block& block : blocks_) {
    const double* block_row = values_.data() + block.offset;
    for (int i = block.begin; i < block.begin + block.size; ++i, block_row += block.size) {
      for (int k = row_begin_[i]; k < row_begin_[i + 1]; ++k) {
        double* row = normal + static_cast<std::size_t>(column_index_[k]) * n;
        for (int l = k; l < row_begin_[i + 1]; ++l) row[column_index_[l]] += off_diagonal[k] * off_diagonal[l];
        for (int j = 0; j < block.size; ++j) row[block.begin + j] += off_diagonal[k] * block_row[j];
      }
      for (int j = 0; j < block.size; ++j) {
        double* row = normal + static_cast<std::size_t>(block.begin + j) * n + block.begin;
        for (int l = j; l < block.size; ++l) row[l] += block_row[j] * block_row[l];
      }
    }
  }
}

double BlockTriangular::factorise() {
  std::copy_n(values_.begin(), diagonal_value_count_, factors_.begin());
  double quality = 1;
  for (Block& block : blocks_) {
    double* factors = factors_.data() + block.offset;
    block.min_pivot = dispatch_by_size(block.size, [&](auto block_size) {
      if constexpr (block_size > 0 && block_size <= max_inverted_size)
        return invert(block_size, factors);
      else
        return factorise_block<block_size>(factors, &pivots_[block.begin], block.size);
    });
    quality = std::min(quality, block.min_pivot);
    if (quality == 0) return 0;
  }
  return quality;
}

void BlockTriangular::store() { std::copy_n(values_.begin(), diagonal_value_count_, stored_.begin()); }

bool BlockTriangular::is_near_stored(double limit) {
  for (const Block& block : blocks_) {
    const double *current = values_.data() + block.offset, *stored = stored_.data() + block.offset;
    double max_row_sum = 0;
    for (int i = 0; i < block.size; ++i) {
      double sum = 0;
      for (int j = 0; j < block.size; ++j) sum += std::abs(*current++ - *stored++);
      max_row_sum = std::max(max_row_sum, sum);
    }
    // ‖A⁻¹‖ hardly ever exceeds size / pivot, so most steps pass this cheap test.
    const bool passes_cheap_test = 4 * block.size * max_row_sum <= limit * block.min_pivot;
    if (!passes_cheap_test && !is_block_near_stored(block, limit)) return false;
  }
  return true;
}

bool BlockTriangular::is_block_near_stored(const Block& block, double limit) {
  const double *current = values_.data() + block.offset, *stored = stored_.data() + block.offset;
  std::fill_n(sums_.begin(), block.size, 0);
  for (int j = 0; j < block.size; ++j) {
    for (int i = 0; i < block.size; ++i) work_[i] = current[i * block.size + j] - stored[i * block.size + j];
    solve_block(block, work_.data());
    for (int i = 0; i < block.size; ++i) sums_[i] += std::abs(work_[i]);
  }
  const auto within = [limit](double sum) { return sum <= limit; };  // false for NaN
  return std::all_of(sums_.begin(), sums_.begin() + block.size, within);
}

void BlockTriangular::solve_pair(double* x, double* z) {
  const int n = size();
  for (int row = 0; row < n; ++row) pairs_[row_position_[row]] = {x[row], z[row]};
  substitute(pairs_.data());
  for (int column = 0; column < n; ++column) {
    const Pair& pair = pairs_[column_position_[column]];
    x[column] = pair.x;
    z[column] = pair.z;
  }
}

}  // namespace balance::numerics
