#include "balance/base/block_triangular.hpp"

#include "balance/base/small_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// Augmenting paths: a column for every row.
class Matching {
 public:
  explicit Matching(const Eigen::MatrixXi& pattern)
      : pattern_(pattern), column_of(pattern.rows(), -1), row_of(pattern.cols(), -1) {}

  bool run() {
    for (int row = 0; row < pattern_.rows(); ++row) {
      std::vector<bool> seen(pattern_.cols(), false);
      if (!augment(row, seen)) return false;
    }
    return true;
  }

 private:
  bool augment(int row, std::vector<bool>& seen) {
    for (int column = 0; column < pattern_.cols(); ++column) {
      if (!pattern_(row, column) || seen[column]) continue;
      seen[column] = true;
      if (row_of[column] >= 0 && !augment(row_of[column], seen)) continue;
      row_of[column] = row;
      column_of[row] = column;
      return true;
    }
    return false;
  }

  const Eigen::MatrixXi& pattern_;

 public:
  std::vector<int> column_of, row_of;
};

/// Tarjan's strongly connected components of the graph row → row matched to a column that the row needs; they come out in the
/// order in which they must be solved.
class Components {
 public:
  Components(const Eigen::MatrixXi& pattern, const Matching& matching)
      : pattern_(pattern),
        matching_(matching),
        index_(pattern.rows(), -1),
        low_(pattern.rows()),
        open_(pattern.rows()) {}

  std::vector<std::vector<int>> run() {
    for (int row = 0; row < pattern_.rows(); ++row)
      if (index_[row] < 0) visit(row);
    return components_;
  }

 private:
  void visit(int row) {
    index_[row] = low_[row] = counter_++;
    stack_.push_back(row);
    open_[row] = true;
    for (int column = 0; column < pattern_.cols(); ++column) {
      if (!pattern_(row, column)) continue;
      const int next = matching_.row_of[column];
      if (index_[next] < 0) {
        visit(next);
        low_[row] = std::min(low_[row], low_[next]);
      } else if (open_[next]) {
        low_[row] = std::min(low_[row], index_[next]);
      }
    }
    if (low_[row] != index_[row]) return;
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

  const Eigen::MatrixXi& pattern_;
  const Matching& matching_;
  std::vector<int> index_, low_;
  std::vector<bool> open_;
  std::vector<int> stack_;
  std::vector<std::vector<int>> components_;
  int counter_ = 0;
};

}  // namespace

using namespace small_blocks;

bool BlockTriangular::analyse(const Eigen::MatrixXi& pattern) {
  const int n = static_cast<int>(pattern.rows());
  row_position_.assign(n, 0);
  column_position_.assign(n, 0);
  blocks_.clear();
  Matching matching(pattern);
  if (!matching.run()) return false;
  int position = 0, offset = 0;
  for (const std::vector<int>& component : Components(pattern, matching).run()) {
    const int size = static_cast<int>(component.size());
    blocks_.push_back({position, size, offset, 0});
    offset += size * size;
    for (const int row : component) {
      row_position_[row] = position;
      column_position_[matching.column_of[row]] = position++;
    }
  }
  first_.assign(n, n);
  for (int row = 0; row < n; ++row)
    for (int column = 0; column < n; ++column)
      if (pattern(row, column))
        first_[row_position_[row]] = std::min(first_[row_position_[row]], column_position_[column]);
  values_.assign(static_cast<std::size_t>(n) * n, 0);
  factors_.assign(offset, 0);
  kept_.assign(offset, 0);
  pivots_.assign(n, 0);
  work_.assign(n, 0);
  sums_.assign(n, 0);
  pairs_.assign(n, {0, 0});
  return true;
}

double BlockTriangular::factorise() {
  const int n = size();
  double quality = 1;
  for (Block& block : blocks_) {
    double* factors = factors_.data() + block.offset;
    for (int i = 0; i < block.size; ++i) {
      const double* row = &values_[(block.begin + i) * n + block.begin];
      for (int j = 0; j < block.size; ++j) factors[i * block.size + j] = row[j];
    }
    block.quality = by_size(block.size, [&](auto block_size) {
      if constexpr (block_size > 0 && block_size <= inverted)
        return invert(block_size, factors);
      else
        return factorise_block<block_size>(factors, &pivots_[block.begin], block.size);
    });
    quality = std::min(quality, block.quality);
    if (quality == 0) return 0;
  }
  return quality;
}

void BlockTriangular::keep() {
  const int n = size();
  double* kept = kept_.data();
  for (const Block& block : blocks_)
    for (int i = 0; i < block.size; ++i)
      kept = std::copy_n(&values_[(block.begin + i) * n + block.begin], block.size, kept);
}

bool BlockTriangular::near_kept(double limit) {
  const int n = size();
  for (const Block& block : blocks_) {
    const double* kept = kept_.data() + block.offset;
    double widest = 0;
    for (int i = 0; i < block.size; ++i) {
      const double* row = &values_[(block.begin + i) * n + block.begin];
      double sum = 0;
      for (int j = 0; j < block.size; ++j) sum += std::abs(row[j] - *kept++);
      widest = std::max(widest, sum);
    }
    // The inverse is hardly ever larger than size / quality: most steps need no more than this.
    const bool plain = 4 * block.size * widest <= limit * block.quality;
    if (!plain && !block_near_kept(block, limit)) return false;
  }
  return true;
}

bool BlockTriangular::block_near_kept(const Block& block, double limit) {
  const int n = size();
  const double* kept = kept_.data() + block.offset;
  std::fill_n(sums_.begin(), block.size, 0);
  for (int j = 0; j < block.size; ++j) {
    for (int i = 0; i < block.size; ++i)
      work_[i] = values_[(block.begin + i) * n + block.begin + j] - kept[i * block.size + j];
    solve_block(block, work_.data());
    for (int i = 0; i < block.size; ++i) sums_[i] += std::abs(work_[i]);
  }
  const auto within = [limit](double sum) { return sum <= limit; };  // false for NaN
  return std::all_of(sums_.begin(), sums_.begin() + block.size, within);
}

template <class X>
void BlockTriangular::solve_block(const Block& block, X* x) const {
  by_size(block.size, [&](auto block_size) {
    const double* factors = factors_.data() + block.offset;
    if constexpr (block_size > 0 && block_size <= inverted)
      multiply<block_size>(factors, x);
    else
      small_blocks::solve_block<block_size>(factors, &pivots_[block.begin], block.size, x);
  });
}

template <class X>
void BlockTriangular::substitute(X* work) const {
  const int n = size();
  for (const Block& block : blocks_) {
    for (int i = block.begin; i < block.begin + block.size; ++i) {
      const double* values = &values_[i * n];
      X sum = work[i];
      for (int j = first_[i]; j < block.begin; ++j) subtract(sum, values[j], work[j]);
      work[i] = sum;
    }
    solve_block(block, work + block.begin);
  }
}

void BlockTriangular::solve(double* x) {
  const int n = size();
  for (int row = 0; row < n; ++row) work_[row_position_[row]] = x[row];
  substitute(work_.data());
  for (int column = 0; column < n; ++column) x[column] = work_[column_position_[column]];
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

void BlockTriangular::solve_transposed(double* x) {
  const int n = size();
  for (int column = 0; column < n; ++column) work_[column_position_[column]] = x[column];
  for (auto block = blocks_.rbegin(); block != blocks_.rend(); ++block) {
    by_size(block->size, [&](auto block_size) {
      const double* factors = factors_.data() + block->offset;
      if constexpr (block_size > 0 && block_size <= inverted)
        multiply_transposed<block_size>(factors, &work_[block->begin]);
      else
        solve_block_transposed<block_size>(factors, &pivots_[block->begin], block->size, &work_[block->begin]);
    });
    for (int i = block->begin; i < block->begin + block->size; ++i) {
      const double* values = &values_[i * n];
      for (int j = first_[i]; j < block->begin; ++j) work_[j] -= values[j] * work_[i];
    }
  }
  for (int row = 0; row < n; ++row) x[row] = work_[row_position_[row]];
}

}  // namespace balance
